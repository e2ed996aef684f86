//! Sizes of sixteen boxes on the screen at once, as far as bounds decide.
//!
//! With g = x − q w, where x and w are rows of the matrix and q = x/w at the middle of a box, a corner at d from the middle
//! is at g·d / w beside it, so that the picture is 2G/w wide, G being the sum of |g| times half the box: at least with the w
//! of the middle, at the most with the least w. Far away both are nearly the same, and only a box whose size is just at the
//! threshold is left to its corners.
//!
//! Of boxes anywhere in a node q is not known but to be in a range, by which |g| may be off. With the sizes of the largest and
//! the smallest of them the node is decided as a whole, sixteen nodes at once.

use crate::array::Each;
use crate::simd::dispatch_256;
use fearless_simd::f32x16;
use fearless_simd::prelude::*;

use super::{Detail, Measure};
use crate::bounds::{BoxBlock, LANES};
use crate::hierarchy::SizeRange;
use crate::simd::Simd;
use crate::view::View;

/// 2⁻¹⁹: more than stored boxes are [wider](crate::bounds::Boxes) than what they are of, and f32 rounds.
const STEP: f32 = 1.0 / (1 << 19) as f32;

/// Test of the sizes of boxes in one view against the threshold of detail culling.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BatchSizes {
    /// Rows of x, y, depth and w.
    rows: [[f32; 4]; 4],
    /// Size of the viewport, in pixels.
    size: [f32; 2],
    measure: Measure,
    threshold: f32,
}

impl BatchSizes {
    /// Creates the test for boxes given relative to `origin`.
    pub(crate) fn new(view: &View, origin: [f64; 3], detail: &Detail) -> Self {
        let rows = view.depth_rows(origin).each(|row| row.each(|v| v as f32));
        let threshold = match detail.measure {
            // Squares are compared.
            Measure::Diameter => detail.threshold_px * detail.threshold_px.abs(),
            _ => detail.threshold_px,
        };
        let size = view.viewport().each(|v| v as f32);
        Self { rows, size, measure: detail.measure, threshold: threshold as f32 }
    }

    /// One bit each for the boxes of some blocks that are surely small, and for those that surely are not; of up to four
    /// blocks, those whose bits are set in `wanted`. `weights` multiply sizes; nothing is said of one that is negative, infinite
    /// or NaN.
    ///
    /// Several at once, for most of the time is that of memory: no decision stands between the blocks that are read.
    pub(crate) fn decide(
        &self,
        level: Simd,
        blocks: &[BoxBlock],
        wanted: u8,
        weights: Option<&[[f32; LANES]; 4]>,
    ) -> (u64, u64) {
        let weights = weights.map(|weights| &weights[..]);
        dispatch_256!(level, simd => self.decide_some(simd, blocks, wanted, None, weights))
    }

    /// One bit each for the nodes of a block below which all boxes are surely small, and surely none is. `sizes` are of the
    /// boxes below each, and `weights` of the heaviest of them: of a node with others than 1 it is not said that none is small.
    pub(crate) fn decide_nodes(
        &self,
        level: Simd,
        block: &BoxBlock,
        sizes: &[SizeRange],
        weights: Option<&[f32; LANES]>,
    ) -> (u16, u16) {
        let mut halves = [[[0.0; LANES]; 3]; 2];
        for (lane, own) in sizes.iter().take(LANES).enumerate() {
            for a in 0..3 {
                halves[0][a][lane] = own.smallest[a] * 0.5;
                halves[1][a][lane] = own.largest[a] * 0.5;
            }
        }
        let (blocks, halves) = (std::slice::from_ref(block), Some(&halves));
        let own = weights.map(std::slice::from_ref);
        let (small, large) =
            dispatch_256!(level, simd => self.decide_some(simd, blocks, 1, halves, own));
        (small as u16, if weights.is_some() { 0 } else { large as u16 })
    }

    // Plain functions and loops all through: a closure that is not inlined has no vector instructions, and made this six
    // times as slow.
    #[inline(always)]
    fn decide_some<S: fearless_simd::Simd>(
        &self,
        simd: S,
        blocks: &[BoxBlock],
        wanted: u8,
        halves: Option<&[[[f32; LANES]; 3]; 2]>,
        weights: Option<&[[f32; LANES]]>,
    ) -> (u64, u64) {
        let (mut small, mut large) = (0, 0);
        let mut rest = wanted;
        while rest != 0 {
            let part = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            let Some(block) = blocks.get(part) else { break };
            let own = weights.map(|weights| &weights[part]);
            let lanes = Lanes::new(simd, block);
            let (mut smallest, mut largest) = (lanes.reach, lanes.reach);
            if let Some(halves) = halves {
                for a in 0..3 {
                    smallest[a] = f32x16::from_slice(simd, &halves[0][a]);
                    largest[a] = f32x16::from_slice(simd, &halves[1][a]);
                }
            }
            let within = halves.is_some();
            let (own_small, own_large) =
                self.decide_lanes(&lanes, [&smallest, &largest], within, own);
            small |= u64::from(own_small) << (part * LANES);
            large |= u64::from(own_large) << (part * LANES);
        }
        (small, large)
    }

    /// Decides sixteen lanes. Returns one bit each for the lanes whose boxes are all surely small,
    /// and for those of which surely none is. The half extents of the boxes lie between the two of
    /// `halves`. The lanes are the boxes themselves, or, where `within` is set, nodes that hold
    /// them.
    #[inline(always)]
    fn decide_lanes<S: fearless_simd::Simd>(
        &self,
        lanes: &Lanes<S>,
        halves: [&[f32x16<S>; 3]; 2],
        within: bool,
        weights: Option<&[f32; LANES]>,
    ) -> (u16, u16) {
        let simd = lanes.simd;
        let [row_x, row_y, row_z, row_w] = &self.rows;
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        let (w, w_off, w_half) = (lanes.at(row_w), lanes.off(row_w), lanes.half(row_w));
        let nearest = w - w_half - w_off;
        let depth = lanes.at(row_z) - lanes.half(row_z) - lanes.off(row_z) - w_off;
        let mut decided = nearest.simd_gt(zero) & depth.simd_ge(zero);
        let (w_spread, farthest) =
            if within { (w_half + w_off, w + w_half + w_off) } else { (w_off, w + w_off) };
        // What reciprocals are rounded by is far below the slack of what they are used for.
        let deep = Deep {
            row: row_w,
            per_w: one / w,
            spread: w_spread,
            per_nearest: one / nearest,
            per_farthest: one / farthest,
        };
        let (mut least_x, mut most_x) = lanes.side(row_x, &deep, halves, within, self.size[0]);
        let (mut least_y, mut most_y) = lanes.side(row_y, &deep, halves, within, self.size[1]);
        if let Some(weights) = weights {
            let weight = f32x16::from_slice(simd, weights);
            decided =
                decided & weight.simd_ge(zero) & weight.simd_lt(f32x16::splat(simd, f32::INFINITY));
            (least_x, most_x) = (least_x * weight, most_x * weight);
            (least_y, most_y) = (least_y * weight, most_y * weight);
        }
        let (least, most) = match self.measure {
            Measure::WidthAndHeight => (least_x.max(least_y), most_x.max(most_y)),
            Measure::Area => (least_x * least_y, most_x * most_y),
            Measure::Diameter => {
                (least_x * least_x + least_y * least_y, most_x * most_x + most_y * most_y)
            }
        };
        let limit = f32x16::splat(simd, self.threshold);
        let margin = f32x16::splat(simd, self.threshold.abs() * (4.0 * STEP));
        let small = decided & (most + margin).simd_lt(limit);
        let large = decided & (least - margin).simd_ge(limit);
        (small.to_bitmask() as u16, large.to_bitmask() as u16)
    }
}

/// Sixteen boxes: middles, halves, and the largest coordinates along each axis.
struct Lanes<S: fearless_simd::Simd> {
    simd: S,
    middle: [f32x16<S>; 3],
    reach: [f32x16<S>; 3],
    most: [f32x16<S>; 3],
}

/// Row of w, and what it is of sixteen boxes: one over that of their middles, by how much it may be off of the middle of a box, and one
/// over the least there is of it and the most of a middle.
struct Deep<'a, S: fearless_simd::Simd> {
    row: &'a [f32; 4],
    per_w: f32x16<S>,
    spread: f32x16<S>,
    per_nearest: f32x16<S>,
    per_farthest: f32x16<S>,
}

impl<S: fearless_simd::Simd> Lanes<S> {
    #[inline(always)]
    fn new(simd: S, BoxBlock(rows): &BoxBlock) -> Self {
        let (x, p) = (f32x16::from_slice(simd, &rows[0]), f32x16::from_slice(simd, &rows[3]));
        let (y, q) = (f32x16::from_slice(simd, &rows[1]), f32x16::from_slice(simd, &rows[4]));
        let (z, r) = (f32x16::from_slice(simd, &rows[2]), f32x16::from_slice(simd, &rows[5]));
        let half = f32x16::splat(simd, 0.5);
        // The first three rows are of −min.
        Self {
            simd,
            middle: [(p - x) * half, (q - y) * half, (r - z) * half],
            reach: [(p + x) * half, (q + y) * half, (r + z) * half],
            most: [x.abs().max(p.abs()), y.abs().max(q.abs()), z.abs().max(r.abs())],
        }
    }

    #[inline(always)]
    fn splat(&self, v: f32) -> f32x16<S> {
        f32x16::splat(self.simd, v)
    }

    /// A row at the middles.
    #[inline(always)]
    fn at(&self, row: &[f32; 4]) -> f32x16<S> {
        let [x, y, z] = self.middle;
        ((self.splat(row[0]) * x + self.splat(row[1]) * y) + self.splat(row[2]) * z)
            + self.splat(row[3])
    }

    /// Returns the most by which `row` changes from the middle of each box to its sides.
    #[inline(always)]
    fn half(&self, row: &[f32; 4]) -> f32x16<S> {
        let [x, y, z] = self.reach;
        (self.splat(row[0].abs()) * x + self.splat(row[1].abs()) * y) + self.splat(row[2].abs()) * z
    }

    /// Returns the most by which rounding may put `row` off, for each box.
    #[inline(always)]
    fn off(&self, row: &[f32; 4]) -> f32x16<S> {
        let [x, y, z] = self.most;
        let sum = (self.splat(row[0].abs()) * x + self.splat(row[1].abs()) * y)
            + (self.splat(row[2].abs()) * z + self.splat(row[3].abs()));
        sum * self.splat(STEP)
    }

    /// How wide boxes with halves between two look along one axis of a screen with so many pixels: at the least and at the
    /// most. The lanes are those boxes, or where `within` hold them.
    #[inline(always)]
    fn side(
        &self,
        row: &[f32; 4],
        deep: &Deep<'_, S>,
        [smallest, largest]: [&[f32x16<S>; 3]; 2],
        within: bool,
        pixels: f32,
    ) -> (f32x16<S>, f32x16<S>) {
        let (zero, step) = (self.splat(0.0), self.splat(STEP));
        let Deep { row: row_w, per_w, spread, per_nearest, per_farthest } = *deep;
        let q = self.at(row) * per_w;
        let steep = q.abs();
        let mut off = self.off(row);
        if within {
            off += self.half(row);
        }
        let q_off = (off + steep * spread) * per_nearest + (steep + self.splat(1.0)) * step;
        let (mut least, mut most) = (zero, zero);
        for a in 0..3 {
            let (of_row, of_w) = (self.splat(row[a].abs()), self.splat(row_w[a].abs()));
            let g = (self.splat(row[a]) - q * self.splat(row_w[a])).abs();
            let g_off = of_w * q_off + (of_row + steep * of_w) * step;
            let slack = self.most[a] * step;
            least += (g - g_off).max(zero) * (smallest[a] - slack).max(zero);
            most += (g + g_off) * (largest[a] + slack);
        }
        // What x/w itself is rounded by where corners are projected is far below this. Twice half the box, times half of the
        // viewport.
        let slack = (steep + self.splat(1.0)) * self.splat(1e-9 * pixels);
        (
            least * per_farthest * self.splat(pixels * (1.0 - 8.0 * STEP)),
            most * per_nearest * self.splat(pixels * (1.0 + 8.0 * STEP)) + slack,
        )
    }
}
