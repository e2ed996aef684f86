//! Bounds of the sizes of sixteen boxes on the screen at once.
//!
//! With g = x − q w, where x and w are rows of the matrix and q = x/w at the middle of a box, a
//! corner at d from the middle is at g·d / w beside it, so that the picture is at most 2G/w wide, G
//! being the sum of |g| times half the box, and w the least of the box. For a box that is small for
//! its distance the bound is hardly wider than the picture. Tried: projecting the corners of boxes
//! just above the threshold changed no answer in some hundreds.
//!
//! A node decides all its boxes at once, sixteen nodes at a time: q is then known only as a range,
//! which widens |g|, and the box is taken as large as the largest below the node.

use crate::array::Each;
use crate::simd::dispatch_256;
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, mask32x16};

use super::{Detail, Measure};
use crate::bounds::{Aabb, Block, BoxBlock, LANES};
use crate::simd::Simd;

/// 2⁻¹⁹: more than stored boxes are [wider](crate::bounds::Boxes) than what they are of, and f32
/// rounds.
const STEP: f32 = 1.0 / (1 << 19) as f32;

/// Test of the sizes of boxes in one view against the threshold of detail culling.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SizeTest {
    /// Rows of x, y, depth beyond the near plane, and w.
    rows: [[f32; 4]; 4],
    /// Size of the viewport, in pixels.
    size: [f32; 2],
    measure: Measure,
    threshold: f32,
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
    fn small_blocks<S: fearless_simd::Simd>(
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
            let bounds = self.bounds(&lanes, &lanes.reach, false);
            let own = weights.map(|weights| &weights[part]);
            small |= u64::from(self.below(&bounds, own)) << (part * LANES);
        }
        small
    }

    /// Returns one bit for each node of a block below which all boxes are surely small. `largest`
    /// are the sizes that no box below each exceeds along any axis, and `weights` those of the
    /// heaviest.
    pub(crate) fn small_nodes(
        &self,
        simd: Simd,
        block: &BoxBlock,
        largest: &[[f32; 3]],
        weights: Option<&[f32; LANES]>,
    ) -> u16 {
        let mut halves = [[0.0; LANES]; 3];
        for (lane, own) in largest.iter().take(LANES).enumerate() {
            (0..3).for_each(|a| halves[a][lane] = own[a] * 0.5);
        }
        dispatch_256!(simd, simd => {
            let lanes = Lanes::new(simd, block);
            let mut own = lanes.reach;
            for a in 0..3 {
                own[a] = f32x16::from_slice(simd, &halves[a]);
            }
            self.below(&self.bounds(&lanes, &own, true), weights)
        })
    }

    /// Returns the bounds of width and height in pixels of one box; `None` where there are none.
    pub(crate) fn bound(&self, simd: Simd, b: &Aabb) -> Option<[f64; 2]> {
        let mut block: BoxBlock = bytemuck::Zeroable::zeroed();
        block.set(0, b);
        let (mut known, mut sizes) = (0, [[0.0; LANES]; 2]);
        dispatch_256!(simd, simd => {
            let lanes = Lanes::new(simd, &block);
            let bounds = self.bounds(&lanes, &lanes.reach, false);
            known = bounds.known.to_bitmask();
            bounds.width.store_slice(&mut sizes[0]);
            bounds.height.store_slice(&mut sizes[1]);
        });
        (known & 1 == 1).then(|| sizes.each(|of| f64::from(of[0])))
    }

    /// Bounds sixteen lanes: boxes with these halves, which are the lanes or, where `within`, lie
    /// in them.
    #[inline(always)]
    fn bounds<S: fearless_simd::Simd>(
        &self,
        lanes: &Lanes<S>,
        halves: &[f32x16<S>; 3],
        within: bool,
    ) -> Bounds<S> {
        let [row_x, row_y, row_z, row_w] = &self.rows;
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
        };
        Bounds {
            simd: lanes.simd,
            known: nearest.simd_gt(zero) & depth.simd_ge(zero),
            width: lanes.side(row_x, &deep, halves, within, self.size[0]),
            height: lanes.side(row_y, &deep, halves, within, self.size[1]),
        }
    }

    /// The bits of lanes whose bounds are below the threshold.
    #[inline(always)]
    fn below<S: fearless_simd::Simd>(
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
        let most = match self.measure {
            Measure::WidthAndHeight => width.max(height),
            Measure::Area => width * height,
            Measure::Diameter => width * width + height * height,
        };
        let margin = f32x16::splat(simd, self.threshold.abs() * (4.0 * STEP));
        let small = (most + margin).simd_lt(f32x16::splat(simd, self.threshold));
        (known & small).to_bitmask() as u16
    }
}

/// Widths and heights in pixels that the pictures of sixteen boxes do not exceed, where they are
/// known.
#[derive(Clone, Copy)]
struct Bounds<S: fearless_simd::Simd> {
    simd: S,
    known: mask32x16<S>,
    width: f32x16<S>,
    height: f32x16<S>,
}

/// Sixteen boxes: middles, halves, and the largest coordinates along each axis.
struct Lanes<S: fearless_simd::Simd> {
    simd: S,
    middle: [f32x16<S>; 3],
    reach: [f32x16<S>; 3],
    most: [f32x16<S>; 3],
}

/// Row of w, and what it is of sixteen boxes: one over that of their middles, by how much it may be
/// off of the middle of a box, and one over the least there is of it.
struct Deep<'a, S: fearless_simd::Simd> {
    row: &'a [f32; 4],
    per_w: f32x16<S>,
    spread: f32x16<S>,
    per_nearest: f32x16<S>,
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

    /// Bounds how wide boxes with these halves look along one axis of a screen with so many pixels.
    #[inline(always)]
    fn side(
        &self,
        row: &[f32; 4],
        deep: &Deep<'_, S>,
        halves: &[f32x16<S>; 3],
        within: bool,
        pixels: f32,
    ) -> f32x16<S> {
        let step = self.splat(STEP);
        let Deep { row: row_w, per_w, spread, per_nearest } = *deep;
        let q = self.at(row) * per_w;
        let steep = q.abs();
        let mut off = self.off(row);
        if within {
            off += self.half(row);
        }
        let q_off = (off + steep * spread) * per_nearest + (steep + self.splat(1.0)) * step;
        let mut most = self.splat(0.0);
        for a in 0..3 {
            let (of_row, of_w) = (self.splat(row[a].abs()), self.splat(row_w[a].abs()));
            let g = (self.splat(row[a]) - q * self.splat(row_w[a])).abs();
            let g_off = of_w * q_off + (of_row + steep * of_w) * step;
            most += (g + g_off) * (halves[a] + self.most[a] * step);
        }
        // What x/w itself is rounded by where corners are projected is far below this. Twice half
        // the box, times half of the viewport.
        let slack = (steep + self.splat(1.0)) * self.splat(1e-9 * pixels);
        most * per_nearest * self.splat(pixels * (1.0 + 8.0 * STEP)) + slack
    }
}
