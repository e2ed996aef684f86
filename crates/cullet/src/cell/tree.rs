//! A small tree over the pieces of cells: which of them may hold a point, or touch a box.

use crate::bounds::{round_down, round_up};

/// The most pieces of a leaf.
const LEAF: usize = 4;

/// A box of pieces. Nodes stand in the order in which they are visited.
#[derive(Clone, Copy, Debug)]
struct Node {
    /// Rounded outward.
    min: [f32; 3],
    max: [f32; 3],
    /// The node to go on with where this one is not met.
    skip: u32,
    /// Its pieces among the order; none of one that has children, which follow it.
    first: u32,
    count: u32,
}

/// A box in f64.
pub(super) type Bounds = [[f64; 3]; 2];

/// A tree of boxes, halved at the middle piece along their longest side.
#[derive(Clone, Debug, Default)]
pub(super) struct PieceTree {
    nodes: Vec<Node>,
    /// Numbers of pieces, leaf after leaf.
    order: Vec<u32>,
}

impl PieceTree {
    /// Over boxes, by their numbers. O(n·log² n).
    pub(super) fn new(boxes: &[Bounds]) -> Self {
        let mut tree = Self { nodes: Vec::new(), order: (0..boxes.len() as u32).collect() };
        if !boxes.is_empty() {
            let mut order = std::mem::take(&mut tree.order);
            tree.build(boxes, &mut order, 0);
            tree.order = order;
        }
        tree
    }

    fn build(&mut self, boxes: &[Bounds], order: &mut [u32], first: usize) {
        let mut all = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        for &piece in order.iter() {
            let [min, max] = &boxes[piece as usize];
            for a in 0..3 {
                all[0][a] = all[0][a].min(min[a]);
                all[1][a] = all[1][a].max(max[a]);
            }
        }
        let at = self.nodes.len();
        let is_leaf = order.len() <= LEAF;
        self.nodes.push(Node {
            min: all[0].map(round_down),
            max: all[1].map(round_up),
            skip: 0,
            first: first as u32,
            count: if is_leaf { order.len() as u32 } else { 0 },
        });
        if is_leaf {
            // Ascending: the first that holds a point is then often the lowest.
            order.sort_unstable();
        } else {
            let side = |a: usize| all[1][a] - all[0][a];
            let axis =
                (1..3).fold(0, |longest, a| if side(a) > side(longest) { a } else { longest });
            let middle =
                |piece: u32| boxes[piece as usize][0][axis] + boxes[piece as usize][1][axis];
            let half = order.len() / 2;
            order.select_nth_unstable_by(half, |a, b| {
                middle(*a).total_cmp(&middle(*b)).then(a.cmp(b))
            });
            let (low, high) = order.split_at_mut(half);
            self.build(boxes, low, first);
            self.build(boxes, high, first + half);
        }
        self.nodes[at].skip = self.nodes.len() as u32;
    }

    /// Visits the pieces whose nodes touch a box.
    pub(super) fn visit(&self, [min, max]: &Bounds, mut each: impl FnMut(u32)) {
        let mut at = 0;
        while let Some(node) = self.nodes.get(at) {
            let touched = (0..3)
                .all(|a| f64::from(node.min[a]) <= max[a] && f64::from(node.max[a]) >= min[a]);
            if touched {
                let pieces = &self.order[node.first as usize..][..node.count as usize];
                pieces.iter().for_each(|&piece| each(piece));
                at += 1;
            } else {
                at = node.skip as usize;
            }
        }
    }
}
