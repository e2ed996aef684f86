//! Bounds of the sizes of sixteen boxes on the screen at once.
//!
//! With g = x − q w, where x and w are rows of the matrix and q = x/w at the middle of a box, a
//! corner at d from the middle is at g·d / w beside it, so that the picture is at most 2G/w wide, G
//! being the sum of |g| times half the box, and w the least of the box. For a box that is small for
//! its distance the bound is hardly wider than the picture. Tried: projecting the corners of boxes
//! just above the threshold changed no answer in some hundreds.

use crate::array::Each;
use crate::simd::dispatch_256;
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, mask32x16};

use super::{Detail, Measure};
use crate::bounds::{Aabb, Block, BoxBlock, LANES};
use crate::simd::Simd;

/// 2⁻¹⁹: more than stored boxes are [wider](crate::bounds::Boxes) than what they are of, and f32
/// rounds.
pub(super) const STEP: f32 = 1.0 / (1 << 19) as f32;

/// Test of the sizes of boxes in one view against the threshold of detail culling.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SizeTest {
    /// Rows of x, y, depth beyond the near plane, and w.
    pub(super) rows: [[f32; 4]; 4],
    /// Size of the viewport, in pixels.
    pub(super) size: [f32; 2],
    measure: Measure,
    pub(super) threshold: f32,
}

impl SizeTest {
    /// Creates the test from the [rows](crate::View::depth_rows) of a view and its viewport.
    pub(crate) fn new(rows: [[f64; 4]; 4], viewport: [u32; 2], detail: &Detail) -> Self {
        let threshold = match detail.measure {
            // Squares are compared.
            Measure::Diameter => detail.threshold_px * detail.threshold_px.abs(),
            _ => detail.threshold_px,
        };
        let rows = rows.each(|row| row.each(|v| v as f32));
        let size = viewport.each(|v| v as f32);
        Self { rows, size, measure: detail.measure, threshold: threshold as f32 }
    }

    /// Returns one bit for each box that is surely small, of up to four blocks; blocks whose bits
    /// in `wanted` are clear are left out. `weights` multiply sizes; a box with a weight that is
    /// negative, infinite or NaN is never small.
    ///
    /// Several at once, for most of the time is that of memory: no decision stands between the
    /// blocks that are read.
    pub(crate) fn small(
        &self,
        simd: Simd,
        blocks: &[BoxBlock],
        wanted: u8,
        weights: Option<&[[f32; LANES]; 4]>,
    ) -> u64 {
        dispatch_256!(simd, simd => self.small_blocks(simd, blocks, wanted, weights))
    }

    // Plain functions and loops all through: a closure that is not inlined has no vector
    // instructions, and made this six times as slow.
    #[inline(always)]
    pub(super) fn small_blocks<S: fearless_simd::Simd>(
        &self,
        simd: S,
        blocks: &[BoxBlock],
        wanted: u8,
        weights: Option<&[[f32; LANES]; 4]>,
    ) -> u64 {
        let (mut small, mut rest) = (0, wanted);
        while rest != 0 {
            let part = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            let Some(block) = blocks.get(part) else { break };
            let lanes = Lanes::new(simd, block);
            let bounds = self.bounds(&lanes);
            let own = weights.map(|weights| &weights[part]);
            small |= u64::from(self.below(&bounds, own)) << (part * LANES);
        }
        small
    }

    /// Returns the bounds of width and height in pixels of one box; `None` where there are none.
    pub(crate) fn bound(&self, simd: Simd, b: &Aabb) -> Option<[f64; 2]> {
        let mut block: BoxBlock = bytemuck::Zeroable::zeroed();
        block.set(0, b);
        let (mut known, mut sizes) = (0, [[0.0; LANES]; 2]);
        dispatch_256!(simd, simd => {
            let lanes = Lanes::new(simd, &block);
            let bounds = self.bounds(&lanes);
            known = bounds.known.to_bitmask();
            bounds.width.store_slice(&mut sizes[0]);
            bounds.height.store_slice(&mut sizes[1]);
        });
        (known & 1 == 1).then(|| sizes.each(|of| f64::from(of[0])))
    }

    /// Bounds sixteen boxes.
    #[inline(always)]
    pub(super) fn bounds<S: fearless_simd::Simd>(&self, lanes: &Lanes<S>) -> Bounds<S> {
        let [row_x, row_y, ..] = &self.rows;
        let (deep, known) = self.deep(lanes, false);
        Bounds {
            simd: lanes.simd,
            known,
            width: lanes.side(row_x, &deep, self.size[0]),
            height: lanes.side(row_y, &deep, self.size[1]),
        }
    }

    /// Returns what w is in sixteen lanes, at their middles or all `within` them, and which of them
    /// are all beyond the near plane.
    #[inline(always)]
    pub(super) fn deep<S: fearless_simd::Simd>(
        &self,
        lanes: &Lanes<S>,
        within: bool,
    ) -> (Deep<'_, S>, mask32x16<S>) {
        let [_, _, row_z, row_w] = &self.rows;
        let (zero, one) = (lanes.splat(0.0), lanes.splat(1.0));
        let (w, w_off, w_half) = (lanes.at(row_w), lanes.off(row_w), lanes.half(row_w));
        let nearest = w - w_half - w_off;
        let depth = lanes.at(row_z) - lanes.half(row_z) - lanes.off(row_z) - w_off;
        // What reciprocals are rounded by is far below the slack of what they are used for.
        let deep = Deep {
            row: row_w,
            per_w: one / w,
            spread: if within { w_half + w_off } else { w_off },
            per_nearest: one / nearest,
            farthest: w + w_half + w_off + w_off,
        };
        (deep, nearest.simd_gt(zero) & depth.simd_ge(zero))
    }

    /// Returns what is compared with the threshold.
    #[inline(always)]
    pub(super) fn measured<S: fearless_simd::Simd>(
        &self,
        width: f32x16<S>,
        height: f32x16<S>,
    ) -> f32x16<S> {
        match self.measure {
            Measure::WidthAndHeight => width.max(height),
            Measure::Area => width * height,
            Measure::Diameter => width * width + height * height,
        }
    }

    /// The bits of lanes whose bounds are below the threshold.
    #[inline(always)]
    pub(super) fn below<S: fearless_simd::Simd>(
        &self,
        bounds: &Bounds<S>,
        weights: Option<&[f32; LANES]>,
    ) -> u16 {
        let Bounds { simd, mut known, mut width, mut height } = *bounds;
        if let Some(weights) = weights {
            let weight = f32x16::from_slice(simd, weights);
            known = known
                & weight.simd_ge(f32x16::splat(simd, 0.0))
                & weight.simd_lt(f32x16::splat(simd, f32::INFINITY));
            (width, height) = (width * weight, height * weight);
        }
        let most = self.measured(width, height);
        let margin = f32x16::splat(simd, self.threshold.abs() * (4.0 * STEP));
        let small = (most + margin).simd_lt(f32x16::splat(simd, self.threshold));
        (known & small).to_bitmask() as u16
    }
}

/// Widths and heights in pixels that the pictures of sixteen boxes do not exceed, where they are
/// known.
#[derive(Clone, Copy)]
pub(super) struct Bounds<S: fearless_simd::Simd> {
    pub(super) simd: S,
    pub(super) known: mask32x16<S>,
    pub(super) width: f32x16<S>,
    pub(super) height: f32x16<S>,
}

/// Sixteen boxes: middles, halves, and the largest coordinates along each axis.
pub(super) struct Lanes<S: fearless_simd::Simd> {
    simd: S,
    middle: [f32x16<S>; 3],
    pub(super) reach: [f32x16<S>; 3],
    pub(super) most: [f32x16<S>; 3],
}

/// Row of w, and what it is of sixteen boxes: one over that of their middles, by how much it may be
/// off of the middle of a box, one over the least there is of it, and the most.
pub(super) struct Deep<'a, S: fearless_simd::Simd> {
    pub(super) row: &'a [f32; 4],
    per_w: f32x16<S>,
    spread: f32x16<S>,
    pub(super) per_nearest: f32x16<S>,
    pub(super) farthest: f32x16<S>,
}

impl<S: fearless_simd::Simd> Lanes<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, BoxBlock(rows): &BoxBlock) -> Self {
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
    pub(super) fn splat(&self, v: f32) -> f32x16<S> {
        f32x16::splat(self.simd, v)
    }

    #[inline(always)]
    pub(super) fn load(&self, v: &[f32; LANES]) -> f32x16<S> {
        f32x16::from_slice(self.simd, v)
    }

    #[inline(always)]
    pub(super) fn mask(&self, bits: u16) -> mask32x16<S> {
        mask32x16::from_bitmask(self.simd, bits.into())
    }

    /// The bits of boxes that are not empty.
    #[inline(always)]
    pub(super) fn not_empty(&self) -> u16 {
        let [x, y, z] = self.reach;
        x.min(y).min(z).simd_ge(self.splat(0.0)).to_bitmask() as u16
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

    /// Bounds how wide the boxes look along one axis of a screen with so many pixels.
    #[inline(always)]
    fn side(&self, row: &[f32; 4], deep: &Deep<'_, S>, pixels: f32) -> f32x16<S> {
        let (q, q_off) = self.quotient(row, deep, false);
        let mut most = self.splat(0.0);
        for a in 0..3 {
            let (g, g_off) = self.gradient(row[a], deep.row[a], q, q_off);
            most += (g + g_off) * (self.reach[a] + self.most[a] * self.splat(STEP));
        }
        // What x/w itself is rounded by where corners are projected is far below this. Twice half
        // the box, times half of the viewport.
        let slack = (q.abs() + self.splat(1.0)) * self.splat(1e-9 * pixels);
        most * deep.per_nearest * self.splat(pixels * (1.0 + 8.0 * STEP)) + slack
    }

    /// Returns `row` over w at the middle, and by how much that of a box may be off.
    #[inline(always)]
    pub(super) fn quotient(
        &self,
        row: &[f32; 4],
        deep: &Deep<'_, S>,
        within: bool,
    ) -> (f32x16<S>, f32x16<S>) {
        let q = self.at(row) * deep.per_w;
        let steep = q.abs();
        let mut off = self.off(row);
        if within {
            off += self.half(row);
        }
        let rounded = (steep + self.splat(1.0)) * self.splat(STEP);
        (q, (off + steep * deep.spread) * deep.per_nearest + rounded)
    }

    /// Returns how much the picture moves along an axis whose numbers in the two rows are these,
    /// and by how much that may be off.
    #[inline(always)]
    pub(super) fn gradient(
        &self,
        of_row: f32,
        of_w: f32,
        q: f32x16<S>,
        q_off: f32x16<S>,
    ) -> (f32x16<S>, f32x16<S>) {
        let (most_row, most_w) = (self.splat(of_row.abs()), self.splat(of_w.abs()));
        let g = (self.splat(of_row) - q * self.splat(of_w)).abs();
        let g_off = most_w * q_off + (most_row + q.abs() * most_w) * self.splat(STEP);
        (g, g_off)
    }
}
