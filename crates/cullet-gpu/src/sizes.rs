//! Boxes that are too small in a picture: the test in integers, on the grids of blocks.
//!
//! For points Q and R of a box, with pictures τ = x / w in pixels, τ(R) − τ(Q) = (R − Q)·(X − τ(Q)
//! W) / w(R), where X and W are the rows of x and w. So no picture of a box is wider than Σ eₐ Gₐ /
//! w₀ with its extents e, the least w of its corners w₀, and Gₐ the most of
//! |Xₐ − τ Wₐ| over all τ that its points may have: those of its block, and those of the picture, widened by the threshold, since a
//! box without any point there is beyond a plane, and one of which not all points are there is
//! wide. What is compared, Σ eₐ Gₐ < threshold · w₀, is linear on both sides.

use cullet::bounds::{Aabb, Plane};
use cullet::{Depth, View};
use glam::{DMat4, DVec3, DVec4};

use super::grid::{Grid, GridBox, MOST};
use super::grid_plane::GridPlane;

/// Rows of a test: of the threshold times w, of the near plane, of G for x and for y.
pub(crate) const ROWS: usize = 4;
/// Components of rows reach so far: three times this and the largest extent fit 31 bits.
const ROW: f64 = 8191.0;
/// Offsets reach so far; beyond it they decide by themselves.
const OFFSET: f64 = 1.3e9;
/// More than all that f64 rounds here and where the engine projects a box, as a share.
const ROUNDING: f64 = 1e-6;

/// Rule that makes the rows of blocks in one view.
#[derive(Clone, Copy, Debug)]
pub struct SizeRule {
    /// Rows of x and y in pixels from the middle of the picture, and of w.
    rows: [DVec4; 3],
    /// Near plane; what is beyond it can be drawn.
    near: Plane,
    /// How far the picture reaches from its middle.
    half: [f64; 2],
    threshold_px: f64,
}

/// The test of the boxes of one block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SizeRows(pub [GridPlane; ROWS]);

impl SizeRule {
    /// The rule of a view of a scene with some origin: boxes narrower and lower than so many pixels
    /// are small, as with [`Measure::WidthAndHeight`](cullet::cull::detail::Measure). `None` where
    /// none is.
    #[must_use]
    pub fn new(view: &View, origin: [f64; 3], threshold_px: f32) -> Option<Self> {
        let clip = DMat4::from_cols_array(&view.clip_from_world())
            * DMat4::from_translation(DVec3::from(origin));
        let [x, y, z, w] = [0, 1, 2, 3].map(|r| clip.row(r));
        let depth = match view.depth() {
            Depth::Standard => z,
            Depth::Reversed => w - z,
        };
        let half = view.viewport().map(|v| f64::from(v) * 0.5);
        let rows = [x * half[0], y * half[1], w];
        let is_finite = rows.iter().all(|r| r.is_finite());
        let near = Plane::new(depth.truncate().to_array(), -depth.w);
        let threshold_px = f64::from(threshold_px);
        (is_finite && threshold_px > 0.0).then_some(Self { rows, near, half, threshold_px })
    }

    /// The rows of a block with a grid, whose boxes are within `bounds`, of things whose size
    /// counts up to `weight` times. `None` where none is small.
    pub(crate) fn on(&self, grid: &Grid, bounds: &Aabb, weight: f32) -> Option<SizeRows> {
        let threshold = self.threshold_px / f64::from(weight.max(1.0)) * (1.0 - ROUNDING);
        let origin = DVec3::from(grid.origin);
        let [x, y, w] = self.rows;
        let across = [(x, self.half[0]), (y, self.half[1])].map(|(row, half)| {
            let [from, to] = of_block(row, w, bounds, half + threshold + 1.0);
            let most = |a: usize| (row[a] - from * w[a]).abs().max((row[a] - to * w[a]).abs());
            DVec3::new(most(0), most(1), most(2)) * (1.0 + ROUNDING)
        });
        let widest = across[0].max(across[1]).max_element();
        let ahead = w.truncate();
        let away = ahead.dot(origin) + w.w;
        let size = ahead.abs().dot(origin.abs()) + w.w.abs();
        // One factor for G, and one that is larger by a power of two for w, of which the threshold
        // leaves little.
        let scale = ROW / widest;
        let largest = (ROW / ahead.abs().max_element()).min(OFFSET * grid.step / size) / threshold;
        let shift = (largest / scale).log2().floor().clamp(0.0, 20.0);
        let scale = scale.min(largest * (1.0 - ROUNDING));
        let of_w = ahead * (scale * shift.exp2() * threshold);
        let rounded = of_w.round();
        let lost = (of_w - rounded).abs().element_sum() * MOST;
        let offset = (away - size * (8.0 * f64::EPSILON)) / grid.step;
        let offset = (offset * scale * shift.exp2() * threshold - lost).floor() - 2.0;
        // Written so that NaN is of no test.
        let is_sound = threshold > 0.0 && scale > 0.0 && offset.is_finite();
        if !(is_sound && rounded.is_finite() && across.iter().all(|g| g.is_finite())) {
            return None;
        }
        let ints = |v: DVec3| v.to_array().map(|v| v as i32);
        let offset = offset.clamp(-OFFSET, OFFSET) as i32;
        let [x, y] =
            across.map(|g| GridPlane { normal: ints((g * scale).ceil()), offset: shift as i32 });
        let of_w = GridPlane { normal: ints(rounded), offset };
        Some(SizeRows([of_w, GridPlane::new(&self.near, grid), x, y]))
    }
}

/// Where points of a block may be in the picture, along x or y: no farther from its middle than
/// `most`.
fn of_block(row: DVec4, w: DVec4, bounds: &Aabb, most: f64) -> [f64; 2] {
    let [centre, half] = [bounds.center(), bounds.half_extent()].map(DVec3::from);
    let span = |row: DVec4| {
        let (middle, reach) = (row.truncate().dot(centre) + row.w, row.truncate().abs().dot(half));
        let slack = (row.truncate().abs().dot(centre.abs() + half) + row.w.abs()) * 1e-14;
        [middle - reach - slack, middle + reach + slack]
    };
    let ([low, high], [near, far]) = (span(row), span(w));
    let [from, to] =
        [(low / near).min(low / far).max(-most), (high / near).max(high / far).min(most)];
    // Also where the block is not finite; one that is beyond the picture is in no view.
    if near > 0.0 && from <= to { [from, to] } else { [-most, most] }
}

impl SizeRows {
    /// Whether a box is small. The device's shader does the same.
    pub(crate) fn is_small(&self, of: &GridBox) -> bool {
        let [of_w, near, x, y] = &self.0;
        let least = of_w.lowest(of) >> x.offset;
        let wide = |row: &GridPlane| {
            let extent = |a: usize| i32::from(of.high[a]) - i32::from(of.low[a]);
            (0..3).map(|a| row.normal[a] * extent(a)).sum::<i32>()
        };
        near.rejects(of) && wide(x) < least && wide(y) < least
    }
}
