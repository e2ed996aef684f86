//! Trace of a walk, node by node: the oracle of the walk, and the source of pictures of it.

use cullet::bounds::{Boxes, Side};
use cullet::cull::frustum::batch::Planes;
use cullet::hierarchy::Nodes;

/// Children of a node.
const WIDTH: usize = 16;

/// Every node that a walk tests, with the result, level by level.
///
/// `levels[0]` is the boxes themselves, `levels[k]` level k − 1 of the nodes: entry i is `None`
/// where the walk never came to it, because something above it was dropped or taken whole.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Trace {
    /// Answers by level, from the boxes up.
    pub levels: Vec<Vec<Option<Side>>>,
}

impl Trace {
    /// Walks `nodes`, which are over `boxes` or the first of them, one after the other, each
    /// against all planes. Boxes that lie under no node are tested each.
    ///
    /// The slow twin of [`Cut::cull`](cullet::cull::frustum::tree::Cut::cull): the same nodes, the
    /// same answers.
    ///
    /// # Panics
    /// If the nodes are over more boxes than there are.
    #[must_use]
    pub fn new(planes: &Planes, nodes: &Nodes, boxes: &Boxes) -> Self {
        assert!(nodes.len() <= boxes.len(), "nodes over {} of {}", nodes.len(), boxes.len());
        let all: Vec<&Boxes> = std::iter::once(boxes).chain(nodes.levels()).collect();
        let mut levels: Vec<_> = all.iter().map(|level| vec![None; level.len()]).collect();
        let side = |level: &Boxes, i: usize| planes.classify_stored(level, i);
        for (at, level) in all.into_iter().enumerate().rev() {
            for i in 0..level.len() {
                let above = levels.get(at + 1).filter(|_| at > 0 || i < nodes.len());
                if above.is_none_or(|above| above[i / WIDTH] == Some(Side::Straddling)) {
                    levels[at][i] = Some(side(level, i));
                }
            }
        }
        Self { levels }
    }

    /// The boxes that it keeps, ascending: those that it tested and found not outside, and all
    /// below a node that is inside, empty ones apart where planes reject those.
    #[must_use]
    pub fn visible(&self, planes: &Planes, boxes: &Boxes) -> Vec<u32> {
        let outside = planes.classify_box(&cullet::bounds::Aabb::EMPTY) == Side::Outside;
        let keeps = |i: usize| {
            let mut index = i;
            // The first level, going up, at which the walk was.
            let found = self.levels.iter().find_map(|level| {
                let side = level[index];
                index /= WIDTH;
                side
            });
            let hole = outside && boxes.get(i).is_empty();
            !hole && found.is_some_and(|side| side != Side::Outside)
        };
        (0..boxes.len()).filter(|&i| keeps(i)).map(|i| i as u32).collect()
    }
}
