//! How large and how small the boxes below a node are, each by itself: a node of small boxes may be
//! large.

use alloc::vec::Vec;

use fearless_simd::f32x4;
use fearless_simd::prelude::*;

use crate::array::{self, Each};
use crate::bounds::{BoxBlock, Boxes, LANES};

/// Sizes along each axis between which those of all boxes below a node are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Span {
    /// Not below 0, and without empty boxes.
    pub(crate) most: [f32; 3],
    /// Below 0 where a box is empty.
    pub(crate) least: [f32; 3],
}

impl Span {
    /// The span of no boxes.
    const NONE: Self = Self { most: [0.0; 3], least: [f32::INFINITY; 3] };

    fn of<'a>(some: impl Iterator<Item = &'a Self>) -> Self {
        some.fold(Self::NONE, |all, own| Self {
            most: array::from_fn(|a| all.most[a].max(own.most[a])),
            least: array::from_fn(|a| all.least[a].min(own.least[a])),
        })
    }
}

/// Returns the largest size along each axis below some nodes; 0 if there are none.
pub(super) fn largest_of<'a>(some: impl Iterator<Item = &'a Span>) -> [f32; 3] {
    Span::of(some).most
}

/// The spans of sizes of the boxes below the nodes of the two lowest levels.
#[derive(Clone, Debug, Default)]
pub(super) struct Sizes {
    levels: [Vec<Span>; 2],
}

impl Sizes {
    /// For so many boxes, of which each block of sixteen is to be [fitted](Self::fit).
    pub(super) fn resize(&mut self, boxes: usize) {
        let mut count = boxes;
        for level in &mut self.levels {
            count = count.div_ceil(LANES);
            level.clear();
            level.resize(count, Span::NONE);
        }
    }

    /// Measures a block of sixteen boxes again.
    #[inline(always)]
    pub(super) fn fit<S: Simd>(&mut self, simd: S, boxes: &Boxes, block: usize) {
        self.levels[0][block] = span_of(simd, &boxes.blocks()[block]);
    }

    /// Measures again what is above the blocks of sixteen that are bits of a word.
    pub(super) fn fit_above(&mut self, word: usize, blocks: u64) {
        let [lowest, above] = &mut self.levels;
        for part in (0..4).filter(|part| blocks >> (16 * part) & 0xffff != 0) {
            let node = word * 4 + part;
            let below = &lowest[node * LANES..((node + 1) * LANES).min(lowest.len())];
            above[node] = Span::of(below.iter());
        }
    }

    /// Lets the spans of the nodes above a box grow to hold its rows, −min and max.
    pub(super) fn grow(&mut self, index: usize, rows: [f32; 6]) {
        let size = [0, 1, 2].each(|a| rows[a] + rows[a + 3]);
        let own = Span { most: size.each(|v| v.max(0.0)), least: size };
        let mut node = index;
        for level in &mut self.levels {
            node /= LANES;
            level[node] = Span::of([&level[node], &own].into_iter());
        }
    }

    pub(super) fn bytes(&self) -> usize {
        self.levels.iter().map(|level| size_of_val(&level[..])).sum()
    }

    /// The spans of the nodes of a level, 0 or 1; none of others.
    pub(super) fn of(&self, level: usize) -> &[Span] {
        self.levels.get(level).map_or(&[], |level| level)
    }
}

/// The span of a block of boxes.
#[inline(always)]
fn span_of<S: Simd>(simd: S, BoxBlock(rows): &BoxBlock) -> Span {
    let [x, y, z] = [
        between(simd, &rows[0], &rows[3]),
        between(simd, &rows[1], &rows[4]),
        between(simd, &rows[2], &rows[5]),
    ];
    // Transposed by interleaving, as nodes are fitted.
    let most = |[x, y, z]: [f32x4<S>; 3]| -> [[f32; 4]; 2] {
        [x.zip_low(y).max(x.zip_high(y)).into(), z.zip_low(z).max(z.zip_high(z)).into()]
    };
    // The least are the most of what is below 0.
    let [least_xy, least_z] = most([-x.0, -y.0, -z.0]);
    let [most_xy, most_z] = most([x.1, y.1, z.1]);
    let three = |xy: [f32; 4], z: [f32; 4]| [xy[0].max(xy[2]), xy[1].max(xy[3]), z[0].max(z[2])];
    Span {
        // An empty box has no size, which is below 0.
        most: three(most_xy, most_z).each(|v| v.max(0.0)),
        least: three(least_xy, least_z).each(|v| -v),
    }
}

/// The smallest and largest sums of sixteen of −min and max, in four parts.
#[inline(always)]
fn between<S: Simd>(simd: S, low: &[f32; LANES], high: &[f32; LANES]) -> (f32x4<S>, f32x4<S>) {
    let size = |at: usize| {
        f32x4::from_slice(simd, &low[at..at + 4]) + f32x4::from_slice(simd, &high[at..at + 4])
    };
    let [a, b, c, d] = [size(0), size(4), size(8), size(12)];
    (a.min(b).min(c.min(d)), a.max(b).max(c.max(d)))
}

#[cfg(test)]
mod tests {

    use crate::bounds::{Aabb, Boxes};
    use crate::hierarchy::Nodes;

    #[test]
    fn each_node_knows_its_largest_and_least_however_it_was_fitted() {
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
                    let (mut most, mut least) = ([0.0_f32; 3], [f32::INFINITY; 3]);
                    for i in first..first + width {
                        let b = if i < boxes.len() { boxes.get(i) } else { Aabb::EMPTY };
                        for a in 0..3 {
                            most[a] = most[a].max(b.max[a] - b.min[a]);
                            least[a] = least[a].min(b.max[a] - b.min[a]);
                        }
                    }
                    let found = nodes.spans_below(above)[node];
                    assert_eq!(found.most, most, "{above} {node}");
                    // Of an empty box it only counts that it is below 0.
                    for a in 0..3 {
                        let own = found.least[a];
                        assert!(own == least[a] || own < 0.0 && least[a] < 0.0, "{above} {node}");
                    }
                }
            }
            assert!(nodes.spans_below(2).is_empty());
        };
        check(&nodes, &boxes);
        boxes.set(300, &Aabb::new([0.0; 3], [500.0, 2.0, 1.0]));
        nodes.grow(&boxes, 300);
        for (above, node) in [(0, 300 / 16), (1, 300 / 256)] {
            assert!(nodes.spans_below(above)[node].most[0] >= 500.0);
        }
        boxes.set(301, &Aabb::new([1.0; 3], [1.0, 0.5, 1.0].map(|v| v + 1e-3)));
        nodes.grow(&boxes, 301);
        assert!(nodes.spans_below(0)[301 / 16].least[2] <= 0.01);
        nodes.refit_range(level, &boxes, 300..302);
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
