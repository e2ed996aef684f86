//! How large the boxes below a node are, each by itself: a node of small boxes may be large.

use alloc::vec::Vec;

use fearless_simd::f32x4;
use fearless_simd::prelude::*;

use crate::array::{self, Each};
use crate::bounds::{BoxBlock, Boxes, LANES};

/// Returns the largest size along each axis of some; 0 if there are none.
pub(super) fn largest_of<'a>(some: impl Iterator<Item = &'a [f32; 3]>) -> [f32; 3] {
    some.fold([0.0; 3], |most, own| array::from_fn(|a| most[a].max(own[a])))
}

/// The largest sizes along each axis of the boxes below the nodes of the two lowest levels, apart
/// from empty ones.
#[derive(Clone, Debug, Default)]
pub(super) struct Sizes {
    levels: [Vec<[f32; 3]>; 2],
}

impl Sizes {
    /// For so many boxes, of which each block of sixteen is to be [fitted](Self::fit).
    pub(super) fn resize(&mut self, boxes: usize) {
        let mut count = boxes;
        for level in &mut self.levels {
            count = count.div_ceil(LANES);
            level.clear();
            level.resize(count, [0.0; 3]);
        }
    }

    /// Measures a block of sixteen boxes again.
    #[inline(always)]
    pub(super) fn fit<S: Simd>(&mut self, simd: S, boxes: &Boxes, block: usize) {
        self.levels[0][block] = largest_in(simd, &boxes.blocks()[block]);
    }

    /// Measures again what is above the blocks of sixteen that are bits of a word.
    pub(super) fn fit_above(&mut self, word: usize, blocks: u64) {
        let [lowest, above] = &mut self.levels;
        for part in (0..4).filter(|part| blocks >> (16 * part) & 0xffff != 0) {
            let node = word * 4 + part;
            let below = &lowest[node * LANES..((node + 1) * LANES).min(lowest.len())];
            above[node] = largest_of(below.iter());
        }
    }

    /// Lets the nodes above a box grow to hold its rows, −min and max.
    pub(super) fn grow(&mut self, index: usize, rows: [f32; 6]) {
        let size = [0, 1, 2].each(|a| rows[a] + rows[a + 3]);
        if !size.iter().all(|v| *v >= 0.0) {
            return;
        }
        let mut node = index;
        for level in &mut self.levels {
            node /= LANES;
            level[node] = largest_of([&level[node], &size].into_iter());
        }
    }

    pub(super) fn bytes(&self) -> usize {
        self.levels.iter().map(|level| size_of_val(&level[..])).sum()
    }

    /// The sizes of the boxes below the nodes of a level, 0 or 1; none of others.
    pub(super) fn of(&self, level: usize) -> &[[f32; 3]] {
        self.levels.get(level).map_or(&[], |level| level)
    }
}

/// The largest sizes of a block of boxes.
#[inline(always)]
fn largest_in<S: Simd>(simd: S, BoxBlock(rows): &BoxBlock) -> [f32; 3] {
    let [x, y, z] = [
        largest(simd, &rows[0], &rows[3]),
        largest(simd, &rows[1], &rows[4]),
        largest(simd, &rows[2], &rows[5]),
    ];
    // Transposed by interleaving, as nodes are fitted.
    let (low, high) = (x.zip_low(y).max(x.zip_high(y)), z.zip_low(z).max(z.zip_high(z)));
    let (low, high): ([f32; 4], [f32; 4]) = (low.into(), high.into());
    // An empty box has no size, which is below 0.
    [low[0].max(low[2]).max(0.0), low[1].max(low[3]).max(0.0), high[0].max(high[2]).max(0.0)]
}

/// The largest sums of sixteen of −min and max, in four parts.
#[inline(always)]
fn largest<S: Simd>(simd: S, low: &[f32; LANES], high: &[f32; LANES]) -> f32x4<S> {
    let mut most = f32x4::splat(simd, f32::NEG_INFINITY);
    for at in [0, 4, 8, 12] {
        let low = f32x4::from_slice(simd, &low[at..at + 4]);
        most = most.max(low + f32x4::from_slice(simd, &high[at..at + 4]));
    }
    most
}

#[cfg(test)]
mod tests {

    use crate::bounds::{Aabb, Boxes};
    use crate::hierarchy::Nodes;

    #[test]
    fn each_node_knows_its_largest_however_it_was_fitted() {
        let at = |i: usize| {
            let min = [(i * 37 % 101) as f32, (i * 11 % 13) as f32, i as f32];
            let size = [(i * 7 % 19) as f32, (i * 5 % 23) as f32, (i % 3) as f32];
            if i % 31 == 7 {
                return Aabb::EMPTY;
            }
            Aabb::new(min, core::array::from_fn(|a| min[a] + size[a]))
        };
        let mut boxes = Boxes::from_slice(&(0..700).map(at).collect::<Vec<_>>());
        let level = crate::Simd::best();
        let mut nodes = Nodes::over(level, &boxes);
        let check = |nodes: &Nodes, boxes: &Boxes| {
            for (above, width) in [(0, 16), (1, 256)] {
                for (node, first) in (0..boxes.len()).step_by(width).enumerate() {
                    let mut largest = [0.0_f32; 3];
                    for i in first..(first + width).min(boxes.len()) {
                        let b = boxes.get(i);
                        if !b.is_empty() {
                            largest = core::array::from_fn(|a| largest[a].max(b.max[a] - b.min[a]));
                        }
                    }
                    assert_eq!(nodes.sizes_below(above)[node], largest, "{above} {node}");
                }
            }
            assert!(nodes.sizes_below(2).is_empty());
        };
        check(&nodes, &boxes);
        boxes.set(300, &Aabb::new([0.0; 3], [500.0, 2.0, 1.0]));
        nodes.grow(&boxes, 300);
        for (above, node) in [(0, 300 / 16), (1, 300 / 256)] {
            assert!(nodes.sizes_below(above)[node][0] >= 500.0);
        }
        nodes.refit_range(level, &boxes, 300..301);
        check(&nodes, &boxes);
        // Smaller again, of which only fitting tells.
        boxes.set(300, &at(300));
        boxes.set(699, &Aabb::new([0.0; 3], [1.0, 77.0, 1.0]));
        nodes.refit_range(level, &boxes, 300..301);
        let mut blocks = [1 << (699 / 16)];
        nodes.refit_blocks(level, &boxes, &mut blocks);
        check(&nodes, &boxes);
        nodes.refit(level, &boxes);
        check(&nodes, &boxes);
    }
}
