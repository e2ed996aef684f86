//! How large the boxes below a node are, each by itself: a node of small boxes may be large.

use fearless_simd::f32x4;
use fearless_simd::prelude::*;

use crate::array::{self, Each};
use crate::bounds::{BoxBlock, Boxes, LANES};

/// The largest and the smallest sizes along each axis of the boxes below a node, apart from empty ones: of such alone from 0 to
/// infinity. Below the last node of a level the smallest may be smaller than any box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SizeRange {
    pub(crate) largest: [f32; 3],
    pub(crate) smallest: [f32; 3],
}

impl SizeRange {
    /// Range of no box. Its union with another range is that range.
    const NONE: Self = Self { largest: [0.0; 3], smallest: [f32::INFINITY; 3] };

    /// Returns the union of `some`, or [`NONE`](Self::NONE) if there are none.
    pub(super) fn of_all<'a>(some: impl Iterator<Item = &'a Self>) -> Self {
        some.fold(Self::NONE, Self::union)
    }

    fn union(self, o: &Self) -> Self {
        Self {
            largest: array::from_fn(|a| self.largest[a].max(o.largest[a])),
            smallest: array::from_fn(|a| self.smallest[a].min(o.smallest[a])),
        }
    }
}

/// Sizes of the boxes below the nodes of the two lowest levels.
#[derive(Clone, Debug, Default)]
pub(super) struct Sizes {
    levels: [Vec<SizeRange>; 2],
}

impl Sizes {
    /// For so many boxes, of which each block of sixteen is to be [fitted](Self::fit).
    pub(super) fn resize(&mut self, boxes: usize) {
        let mut count = boxes;
        for level in &mut self.levels {
            count = count.div_ceil(LANES);
            level.clear();
            level.resize(count, SizeRange::NONE);
        }
    }

    /// Measures a block of sixteen boxes again.
    #[inline(always)]
    pub(super) fn fit<S: Simd>(&mut self, simd: S, boxes: &Boxes, block: usize) {
        self.levels[0][block] = range_of(simd, &boxes.blocks()[block]);
    }

    /// Measures again what is above the blocks of sixteen that are bits of a word.
    pub(super) fn fit_above(&mut self, word: usize, blocks: u64) {
        let [lowest, above] = &mut self.levels;
        for part in (0..4).filter(|part| blocks >> (16 * part) & 0xffff != 0) {
            let node = word * 4 + part;
            let below = &lowest[node * LANES..((node + 1) * LANES).min(lowest.len())];
            above[node] = SizeRange::of_all(below.iter());
        }
    }

    /// Lets the nodes above a box grow to hold its rows, −min and max.
    pub(super) fn grow(&mut self, index: usize, rows: [f32; 6]) {
        let size = [0, 1, 2].each(|a| rows[a] + rows[a + 3]);
        if !size.iter().all(|v| *v >= 0.0) {
            return;
        }
        let own = SizeRange { largest: size, smallest: size };
        let mut node = index;
        for level in &mut self.levels {
            node /= LANES;
            level[node] = level[node].union(&own);
        }
    }

    pub(super) fn bytes(&self) -> usize {
        self.levels.iter().map(|level| size_of_val(&level[..])).sum()
    }

    /// The sizes of the boxes below the nodes of a level, 0 or 1; none of others.
    pub(super) fn of(&self, level: usize) -> &[SizeRange] {
        self.levels.get(level).map_or(&[], |level| level)
    }
}

/// The sizes of a block of boxes.
#[inline(always)]
fn range_of<S: Simd>(simd: S, BoxBlock(rows): &BoxBlock) -> SizeRange {
    let [x, y, z] = [
        sizes(simd, &rows[0], &rows[3]),
        sizes(simd, &rows[1], &rows[4]),
        sizes(simd, &rows[2], &rows[5]),
    ];
    // Transposed by interleaving, as nodes are fitted.
    let low = x.0.zip_low(y.0).max(x.0.zip_high(y.0));
    let high = z.0.zip_low(z.0).max(z.0.zip_high(z.0));
    let (low, high): ([f32; 4], [f32; 4]) = (low.into(), high.into());
    // An empty box has no size, which is below 0.
    let largest =
        [low[0].max(low[2]).max(0.0), low[1].max(low[3]).max(0.0), high[0].max(high[2]).max(0.0)];
    let low = x.1.zip_low(y.1).min(x.1.zip_high(y.1));
    let high = z.1.zip_low(z.1).min(z.1.zip_high(z.1));
    let (low, high): ([f32; 4], [f32; 4]) = (low.into(), high.into());
    let smallest = [low[0].min(low[2]), low[1].min(low[3]), high[0].min(high[2])];
    SizeRange { largest, smallest }
}

/// The largest sums of sixteen of −min and max, in four parts, and the smallest of those that are not below 0.
#[inline(always)]
fn sizes<S: Simd>(simd: S, low: &[f32; LANES], high: &[f32; LANES]) -> (f32x4<S>, f32x4<S>) {
    let mut most = f32x4::splat(simd, f32::NEG_INFINITY);
    let mut least = f32x4::splat(simd, f32::INFINITY);
    let (zero, none) = (f32x4::splat(simd, 0.0), least);
    for at in [0, 4, 8, 12] {
        let own =
            f32x4::from_slice(simd, &low[at..at + 4]) + f32x4::from_slice(simd, &high[at..at + 4]);
        most = most.max(own);
        least = least.min(own.simd_ge(zero).select(own, none));
    }
    (most, least)
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
            Aabb::new(min, std::array::from_fn(|a| min[a] + size[a]))
        };
        let mut boxes = Boxes::from_slice(&(0..700).map(at).collect::<Vec<_>>());
        let level = crate::Simd::best();
        let mut nodes = Nodes::over(level, &boxes);
        let check = |nodes: &Nodes, boxes: &Boxes| {
            for (above, width) in [(0, 16), (1, 256)] {
                for (node, first) in (0..boxes.len()).step_by(width).enumerate() {
                    let (mut largest, mut smallest) = ([0.0_f32; 3], [f32::INFINITY; 3]);
                    for i in first..(first + width).min(boxes.len()) {
                        let b = boxes.get(i);
                        if !b.is_empty() {
                            largest = std::array::from_fn(|a| largest[a].max(b.max[a] - b.min[a]));
                            smallest =
                                std::array::from_fn(|a| smallest[a].min(b.max[a] - b.min[a]));
                        }
                    }
                    let found = nodes.sizes_below(above)[node];
                    assert_eq!(found.largest, largest, "{above} {node}");
                    if first + width <= boxes.len() {
                        assert_eq!(found.smallest, smallest, "{above} {node}");
                    } else {
                        // Blocks are filled up with boxes of no size.
                        assert!((0..3).all(|a| found.smallest[a] <= smallest[a]), "{found:?}");
                    }
                }
            }
            assert!(nodes.sizes_below(2).is_empty());
        };
        check(&nodes, &boxes);
        boxes.set(300, &Aabb::new([0.0; 3], [500.0, 2.0, 1.0]));
        nodes.grow(&boxes, 300);
        // What was there may have been the smallest: that is known only when it is fitted again.
        for (above, node) in [(0, 300 / 16), (1, 300 / 256)] {
            let found = nodes.sizes_below(above)[node];
            assert!(found.largest[0] >= 500.0 && found.smallest[2] <= 1.01, "{found:?}");
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
