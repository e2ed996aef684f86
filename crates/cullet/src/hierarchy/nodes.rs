//! The nodes above a batch of boxes: sixteen children each, at places that need no pointers.

use alloc::vec::Vec;
use core::ops::Range;

use crate::array;
use crate::simd::dispatch_256;
use fearless_simd::f32x4;
use fearless_simd::prelude::*;
use thiserror::Error;

use super::sizes::{Sizes, Span, largest_of};
use crate::bits;
use crate::bounds::{Aabb, Boxes, LANES};

/// Sixteen-fold levels of nodes over a batch of boxes, whatever their order.
///
/// Node i of level 0 bounds the boxes 16 i to 16 i + 15, node i of the next level the nodes 16 i to
/// 16 i + 15, and so on up to a level of at most sixteen. The boxes stay where they are: a flat
/// sweep and a walk of the tree read the same array. All sixteen children of a node are one block,
/// tested at once. An eighth of the boxes' memory, with the sizes of the largest and the smallest
/// box below each node of the lowest two levels.
///
/// Boxes that are appended later lie under no node until nodes are made [anew](Self::over): a walk
/// takes them one by one.
///
/// A good order of the boxes ([`spatial_order`](super::spatial_order)) makes it fast; any order is
/// right.
#[derive(Clone, Debug, Default)]
pub struct Nodes {
    levels: Vec<Boxes>,
    leaves: usize,
    /// One bit a box: it is empty. A node is inside a frustum whether it has such a child or not,
    /// but the child is not.
    holes: Vec<u64>,
    /// Whether there may be any.
    any_holes: bool,
    sizes: Sizes,
}

/// A fault that [`Nodes::validate`] found.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum NodesError {
    /// There are fewer boxes than the nodes were built for.
    #[error("the nodes are over {nodes} boxes, but there are {boxes}: build them again")]
    Len {
        /// How many boxes the nodes are over.
        nodes: usize,
        /// How many there are.
        boxes: usize,
    },
    /// A node does not hold one of its children: the child was changed and the node not refitted.
    #[error("node {node} of level {level} does not hold child {child}: refit it")]
    Loose {
        /// The level of the node, 0 next to the boxes.
        level: usize,
        /// Number of the node in its level.
        node: usize,
        /// Number of the child: a node of the level below, or a box below level 0.
        child: usize,
    },
}

/// Measurements of [`Nodes::validate`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NodeStatistics {
    /// How many nodes each level has, from the one next to the boxes up.
    pub nodes: Vec<usize>,
    /// Surface of all nodes of a level over the surface of the box around everything: how many of
    /// them a random ray meets, so the lower the better. 0 where everything is a point or nothing
    /// is finite.
    pub surface: Vec<f64>,
    /// Bytes of all nodes.
    pub bytes: usize,
}

impl Nodes {
    /// Nodes over `boxes`.
    #[must_use]
    pub fn over(simd: crate::Simd, boxes: &Boxes) -> Self {
        let mut nodes = Self::default();
        nodes.rebuild(simd, boxes);
        nodes
    }

    /// Lets the nodes above box `index` grow until they hold it. Mostly the lowest does already.
    pub(super) fn grow(&mut self, boxes: &Boxes, index: usize) {
        if index >= self.leaves {
            return;
        }
        let block = &boxes.blocks()[index / LANES].0;
        let rows: [f32; 6] = array::from_fn(|r| block[r][index % LANES]);
        let hole = rows[HOLE_ROW] == -Boxes::LIMIT;
        self.any_holes |= hole;
        bits::set(&mut self.holes, index, hole);
        self.sizes.grow(index, rows);
        let mut node = index;
        for here in &mut self.levels {
            node /= LANES;
            let block = &mut here.blocks_mut()[node / LANES].0;
            let mut grew = false;
            for (row, v) in block.iter_mut().zip(rows) {
                let held = &mut row[node % LANES];
                grew |= v > *held;
                *held = if v > *held { v } else { *held };
            }
            if !grew {
                break;
            }
        }
    }

    /// Makes the nodes again, for whatever `boxes` are now. Allocates only if there are more than
    /// ever before. Streams through the boxes once.
    pub(crate) fn rebuild(&mut self, simd: crate::Simd, boxes: &Boxes) {
        self.leaves = boxes.len();
        let mut below = boxes.len();
        let mut count = 0;
        while below > LANES {
            below = below.div_ceil(LANES);
            if self.levels.len() == count {
                self.levels.push(Boxes::new());
            }
            self.levels[count].resize(below);
            count += 1;
        }
        self.levels.truncate(count);
        self.holes.clear();
        self.holes.resize(boxes.len().div_ceil(64), 0);
        self.any_holes = false;
        self.sizes.resize(boxes.len());
        self.refit(simd, boxes);
    }

    /// Fits all nodes to their boxes, after any of them changed.
    ///
    /// # Panics
    /// If there are fewer boxes than the nodes were built for.
    pub fn refit(&mut self, simd: crate::Simd, boxes: &Boxes) {
        self.refit_range(simd, boxes, 0..self.leaves);
    }

    /// Fits the nodes above some of the boxes, after only those changed. The cost is that of the
    /// range.
    ///
    /// # Panics
    /// If there are fewer boxes than the nodes were built for, or the range leaves those.
    pub(crate) fn refit_range(&mut self, simd: crate::Simd, boxes: &Boxes, changed: Range<usize>) {
        assert!(
            boxes.len() >= self.leaves,
            "{} boxes under nodes over {}",
            boxes.len(),
            self.leaves
        );
        assert!(changed.end <= self.leaves, "boxes {changed:?} of {}", self.leaves);
        if changed.is_empty() {
            return;
        }
        let mut changed = changed;
        let blocks = changed.start / LANES..changed.end.div_ceil(LANES);
        for (word, bits) in bits::words_of(blocks.clone()) {
            self.fit_lowest(simd, boxes, word, bits);
        }
        changed = blocks;
        if let Some(lowest) = self.levels.first_mut() {
            close(lowest);
        }
        for at in 1..self.levels.len() {
            let (below, here) = self.levels.split_at_mut(at);
            let below = &below[at - 1];
            changed = changed.start / LANES..changed.end.div_ceil(LANES);
            fit(simd, (below, below.len()), &mut here[0], changed.clone());
        }
    }

    /// Fits the nodes above the blocks of sixteen boxes whose bits are set, and clears the bits:
    /// bit b of word w is block 64 w + b. The cost is that of the blocks that are set, and of the
    /// words.
    ///
    /// # Panics
    /// If there are fewer boxes than the nodes were built for, or `blocks` has a bit beyond those.
    pub(crate) fn refit_blocks(&mut self, simd: crate::Simd, boxes: &Boxes, blocks: &mut [u64]) {
        assert!(
            boxes.len() >= self.leaves,
            "{} boxes under nodes over {}",
            boxes.len(),
            self.leaves
        );
        // Of the simd above, which is a sixteenth as long, the bits overwrite the words that were
        // read.
        let mut used = blocks.len();
        for at in 0..self.levels.len().max(1) {
            for i in 0..used {
                let word = core::mem::take(&mut blocks[i]);
                if word == 0 {
                    continue;
                }
                if at == 0 {
                    self.fit_lowest(simd, boxes, i, word);
                } else {
                    let (below, here) = self.levels.split_at_mut(at);
                    let below = &below[at - 1];
                    fit_some(simd, (below, below.len()), &mut here[0], i * 64, word);
                }
                for part in 0..4 {
                    if word >> (16 * part) & 0xffff != 0 {
                        let node = i * 4 + part;
                        blocks[node / 64] |= 1 << (node % 64);
                    }
                }
            }
            used = used.div_ceil(LANES);
        }
        blocks[..used].fill(0);
    }

    /// Fits the nodes above the blocks of sixteen boxes that are bits of a word, and notes which
    /// boxes are empty and how large they are: all at once, while they are in the cache.
    fn fit_lowest(&mut self, simd: crate::Simd, boxes: &Boxes, word: usize, blocks: u64) {
        let Self { levels, leaves, holes, any_holes, sizes } = self;
        dispatch_256!(simd, simd => {
            let mut lowest = levels.first_mut();
            for block in bits::ones(blocks).map(|b| word * 64 + b) {
                find_holes(holes, any_holes, boxes, block);
                sizes.fit(simd, boxes, block);
                if let Some(lowest) = &mut lowest {
                    fit_one(simd, (boxes, *leaves), lowest, block);
                }
            }
        });
        self.sizes.fit_above(word, blocks);
    }

    /// No box below a node of a level, 0 to 2, is larger along any axis; infinite where that is not
    /// known.
    pub(crate) fn largest_below(&self, level: usize, node: usize) -> [f32; 3] {
        if level == 2 {
            // Needed of few, so that it is not kept.
            let below = self.sizes.of(1).get(node * LANES..).filter(|below| !below.is_empty());
            return below.map_or([f32::INFINITY; 3], |all| largest_of(all.iter().take(LANES)));
        }
        self.sizes.of(level).get(node).map_or([f32::INFINITY; 3], |span| span.most)
    }

    /// Returns the spans of sizes of the boxes below the nodes of a level, 0 or 1; none of others.
    pub(crate) fn spans_below(&self, level: usize) -> &[Span] {
        self.sizes.of(level)
    }

    /// One bit a box: it is empty. `None` if no box is.
    pub(crate) fn holes(&self) -> Option<&[u64]> {
        self.any_holes.then_some(&self.holes)
    }

    /// The levels, from the one next to the boxes up. None if there are at most sixteen boxes.
    #[must_use]
    pub fn levels(&self) -> &[Boxes] {
        &self.levels
    }

    /// Over how many boxes the nodes are: the first so many.
    #[must_use]
    pub fn len(&self) -> usize {
        self.leaves
    }

    /// Whether there are no boxes.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.leaves == 0
    }

    /// Checks that every node holds its children, and measures the tree.
    ///
    /// # Errors
    /// If some node does not, or there are fewer boxes than the nodes were built for.
    pub fn validate(&self, boxes: &Boxes) -> Result<NodeStatistics, NodesError> {
        if boxes.len() < self.leaves {
            return Err(NodesError::Len { nodes: self.leaves, boxes: boxes.len() });
        }
        let mut statistics =
            NodeStatistics { bytes: self.sizes.bytes(), ..NodeStatistics::default() };
        let mut below = boxes;
        for (level, here) in self.levels.iter().enumerate() {
            let mut surface = 0.0;
            for node in 0..here.len() {
                let held = here.get(node);
                let children =
                    node * LANES..((node + 1) * LANES).min(of(below, self.leaves, level));
                for child in children {
                    let b = below.get(child);
                    let inside = (0..3).all(|a| held.min[a] <= b.min[a] && b.max[a] <= held.max[a]);
                    if !inside {
                        return Err(NodesError::Loose { level, node, child });
                    }
                }
                surface += if held.is_empty() { 0.0 } else { held.surface_area() };
            }
            statistics.nodes.push(here.len());
            statistics.surface.push(surface);
            statistics.bytes += here.as_floats().len() * 4;
            below = here;
        }
        let around = (0..below.len()).fold(Aabb::EMPTY, |a, i| a.union(&below.get(i)));
        let whole = if around.is_empty() { 0.0 } else { around.surface_area() };
        for surface in &mut statistics.surface {
            *surface = if whole > 0.0 { *surface / whole } else { 0.0 };
        }
        Ok(statistics)
    }
}

/// How many of the boxes `below` level `at` have a node.
fn of(below: &Boxes, leaves: usize, at: usize) -> usize {
    if at == 0 { leaves } else { below.len() }
}

/// The row that tells an empty box, which is stored as −[`Boxes::LIMIT`] in every row: no other box
/// has its maximum there.
const HOLE_ROW: usize = 3;

/// Notes which boxes of a block are empty.
fn find_holes(holes: &mut [u64], any: &mut bool, boxes: &Boxes, block: usize) {
    let row = &boxes.blocks()[block].0[HOLE_ROW];
    let mut found = 0;
    for (lane, &v) in row.iter().enumerate() {
        found |= u64::from(v == -Boxes::LIMIT) << lane;
    }
    let (word, shift) = (block / 4, block % 4 * LANES);
    holes[word] = holes[word] & !(0xffff << shift) | found << shift;
    *any |= found != 0;
}

/// Fits nodes `nodes` to the boxes below.
fn fit(simd: crate::Simd, below: (&Boxes, usize), here: &mut Boxes, nodes: Range<usize>) {
    dispatch_256!(simd, simd => {
        fit_range(simd, below, here, nodes);
    });
    close(here);
}

/// Fits the nodes `first` + b for each bit b of `word`.
fn fit_some(simd: crate::Simd, below: (&Boxes, usize), here: &mut Boxes, first: usize, word: u64) {
    dispatch_256!(simd, simd => {
        fit_bits(simd, below, here, first, word);
    });
}

#[inline(always)]
fn fit_range<S: Simd>(simd: S, below: (&Boxes, usize), here: &mut Boxes, nodes: Range<usize>) {
    for node in nodes {
        fit_one(simd, below, here, node);
    }
}

#[inline(always)]
fn fit_bits<S: Simd>(simd: S, below: (&Boxes, usize), here: &mut Boxes, first: usize, word: u64) {
    for bit in bits::ones(word) {
        fit_one(simd, below, here, first + bit);
    }
}

/// The largest of each row of a block, which is −min and max of all.
#[inline(always)]
fn fit_one<S: Simd>(simd: S, (below, len): (&Boxes, usize), here: &mut Boxes, node: usize) {
    let rows = &below.blocks()[node].0;
    let to = &mut here.blocks_mut()[node / LANES].0;
    // Lanes past the last box are of boxes that no node holds, or of none.
    let count = (len - node * LANES).min(LANES);
    if count < LANES {
        for (row, to) in rows.iter().zip(to) {
            let largest =
                row[..count].iter().fold(f32::NEG_INFINITY, |a, &v| if v > a { v } else { a });
            to[node % LANES] = largest;
        }
        return;
    }
    // Three rows of four at a time: transposed by interleaving, then the largest of the columns.
    for half in 0..2 {
        let [x, y, z] = [
            largest_of_four(simd, &rows[3 * half]),
            largest_of_four(simd, &rows[3 * half + 1]),
            largest_of_four(simd, &rows[3 * half + 2]),
        ];
        let low = x.zip_low(y).max(x.zip_high(y));
        let high = z.zip_low(z).max(z.zip_high(z));
        let (low, high): ([f32; 4], [f32; 4]) = (low.into(), high.into());
        let larger = |a: f32, b: f32| if a > b { a } else { b };
        to[3 * half][node % LANES] = larger(low[0], low[2]);
        to[3 * half + 1][node % LANES] = larger(low[1], low[3]);
        to[3 * half + 2][node % LANES] = larger(high[0], high[2]);
    }
}

#[inline(always)]
fn largest_of_four<S: Simd>(simd: S, row: &[f32; LANES]) -> f32x4<S> {
    let a = f32x4::from_slice(simd, &row[..4]);
    let b = f32x4::from_slice(simd, &row[4..8]);
    let c = f32x4::from_slice(simd, &row[8..12]);
    let d = f32x4::from_slice(simd, &row[12..]);
    a.max(b).max(c.max(d))
}

/// Makes the lanes past the last node empty, so that whoever reads whole blocks finds nothing
/// there.
fn close(here: &mut Boxes) {
    let used = here.len() % LANES;
    if used != 0
        && let Some(block) = here.blocks_mut().last_mut()
    {
        block.0.iter_mut().for_each(|row| row[used..].fill(-Boxes::LIMIT));
    }
}
