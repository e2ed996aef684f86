//! Several views of one scene: in one pass, as one mask a box, and what changed from one to the next.

use fearless_simd::Level;
use thiserror::Error;

use super::super::batch::{Planes, classify_boxes};
use super::Cut;
use super::walk::Walk;
use crate::bits;
use crate::bounds::Boxes;
use crate::hierarchy::Nodes;

/// Why several views cannot be taken at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ViewsError {
    /// One result a view.
    #[error("{views} views, but {cuts} results")]
    Counts {
        /// How many views.
        views: usize,
        /// How many results.
        cuts: usize,
    },
    /// A mask has a bit for each view.
    #[error("{0} views, but a mask holds 32: take them in several passes")]
    TooMany(usize),
    /// The results are not of the same boxes.
    #[error("result {index} is of {len} boxes, the first of {first}")]
    Boxes {
        /// Which result.
        index: usize,
        /// Of how many boxes it is.
        len: usize,
        /// Of how many the first is.
        first: usize,
    },
}

/// Culls for several views, one result for each set of planes: each as [`Cut::cull`] would. All views are taken down
/// the tree level by level together, so that the nodes of a level are near when the next view asks them.
/// No view at all is no work.
///
/// One list of nodes with a mask of views each was thought through and left: what a node costs is its
/// tests, sixteen children at once, and those are other planes for every view.
///
/// # Errors
/// If there is not one result a view.
///
/// # Panics
/// If the nodes are over more boxes than there are.
pub fn cull_views(
    level: Level,
    planes: &[Planes],
    nodes: &Nodes,
    boxes: &Boxes,
    cuts: &mut [Cut],
) -> Result<(), ViewsError> {
    if planes.len() != cuts.len() {
        return Err(ViewsError::Counts { views: planes.len(), cuts: cuts.len() });
    }
    cull_together(level, nodes, boxes, |each| {
        planes.iter().zip(&mut *cuts).for_each(|(planes, cut)| each(planes, cut));
    });
    Ok(())
}

/// The same for views that are kept elsewhere: `views` shows each of them to what it is given.
fn cull_together(
    level: Level,
    nodes: &Nodes,
    boxes: &Boxes,
    mut views: impl FnMut(&mut dyn FnMut(&Planes, &mut Cut)),
) {
    views(&mut |planes, cut| {
        cut.begin(level, planes, nodes, boxes);
        cut.fronts[0].set_root(planes.len(), nodes.len());
    });
    for at in (0..=nodes.levels().len()).rev() {
        views(&mut |planes, cut| {
            let mut fronts = std::mem::take(&mut cut.fronts);
            let walk = Walk { level, planes, nodes, boxes };
            if at == 0 && walk.is_vain(&fronts[0]) {
                cut.sweep(level, planes, boxes, 0);
            } else {
                let mut target = cut.target(nodes.len());
                walk.step(at, &mut fronts, &mut target);
                let counts = target.counts;
                cut.counts.add(counts);
            }
            cut.fronts = fronts;
        });
    }
    views(&mut |planes, cut| cut.finish(planes, nodes.holes()));
}

/// The boxes that any of several views sees, each with a mask of those that do. Keeps its memory.
#[derive(Clone, Debug, Default)]
pub struct ViewMasks {
    slots: Vec<u32>,
    masks: Vec<u32>,
}

impl ViewMasks {
    /// Of nothing.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Gathers what the views see.
    ///
    /// # Errors
    /// If there are more than 32, or they are of different boxes.
    pub fn gather(&mut self, cuts: &[Cut]) -> Result<(), ViewsError> {
        self.slots.clear();
        self.masks.clear();
        if cuts.len() > 32 {
            return Err(ViewsError::TooMany(cuts.len()));
        }
        let Some(first) = cuts.first() else { return Ok(()) };
        if let Some(index) = cuts.iter().position(|c| c.len != first.len) {
            return Err(ViewsError::Boxes { index, len: cuts[index].len, first: first.len });
        }
        for block in 0..first.touched.len() {
            let touched = cuts.iter().fold(0, |all, cut| all | cut.touched[block]);
            for word in bits::ones(touched).map(|bit| block * 64 + bit) {
                let seen = cuts.iter().fold(0, |all, cut| all | cut.visible[word]);
                for bit in bits::ones(seen) {
                    let by = cuts.iter().map(|cut| (cut.visible[word] >> bit & 1) as u32);
                    let mask = (0..).zip(by).fold(0, |mask, (view, seen)| mask | seen << view);
                    self.slots.push((word * 64 + bit) as u32);
                    self.masks.push(mask);
                }
            }
        }
        Ok(())
    }

    /// The boxes that some view sees, ascending.
    #[must_use]
    pub fn slots(&self) -> &[u32] {
        &self.slots
    }

    /// For each of [`slots`](Self::slots): bit v is set if view v sees it.
    #[must_use]
    pub fn masks(&self) -> &[u32] {
        &self.masks
    }
}

impl Cut {
    /// Of what `wider` sees, keeps what these planes see too: for views that share most of what they see,
    /// such as two eyes, after one cull with [`Frustum::around`](crate::Frustum::around) them. Costs the
    /// sweep of the words that `wider` touched.
    ///
    /// Conservative; at the very border it may keep less than a cull of its own would by rounding.
    ///
    /// # Panics
    /// If `wider` is not of these boxes.
    pub fn refine(&mut self, level: Level, planes: &Planes, boxes: &Boxes, wider: &Self) {
        assert_eq!(wider.len, boxes.len(), "a result of so many boxes");
        self.clear(boxes.len());
        for (index, &touched) in wider.touched.iter().enumerate() {
            for run in bits::runs(touched) {
                let words = index * 64 + run.start..index * 64 + run.end;
                let (visible, inside) =
                    (&mut self.visible[words.clone()], &mut self.inside[words.clone()]);
                classify_boxes(level, planes, boxes, words.start, visible, inside);
                for word in words {
                    self.visible[word] &= wider.visible[word];
                    self.inside[word] &= self.visible[word];
                    bits::set(&mut self.touched, word, self.visible[word] != 0);
                }
            }
        }
    }

    /// Lists what is visible here and was not in `earlier`, and what was and is no more, both ascending.
    /// Boxes beyond the end of one of the two are not visible there. The lists are cleared first.
    pub fn changes_since(&self, earlier: &Self, added: &mut Vec<u32>, removed: &mut Vec<u32>) {
        added.clear();
        removed.clear();
        for block in 0..self.touched.len().max(earlier.touched.len()) {
            let at = |words: &[u64], i: usize| words.get(i).copied().unwrap_or(0);
            let touched = at(&self.touched, block) | at(&earlier.touched, block);
            for word in bits::ones(touched).map(|bit| block * 64 + bit) {
                let (now, then) = (at(&self.visible, word), at(&earlier.visible, word));
                let number = |bit: usize| (word * 64 + bit) as u32;
                added.extend(bits::ones(now & !then).map(number));
                removed.extend(bits::ones(then & !now).map(number));
            }
        }
    }
}
