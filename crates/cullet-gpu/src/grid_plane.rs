//! Planes in steps of grids, rounded so that what they reject is outside.

use bytemuck::{Pod, Zeroable};
use cullet::bounds::Plane;

use super::grid::{Grid, GridBox, MOST};

/// Components of normals reach so far, and 3 · 8191 · 32767 fits 30 bits.
const NORMAL: f64 = 8191.0;
/// Offsets beyond this decide by themselves; with it the sum stays below 2³¹.
const OFFSET: f64 = 1.3e9;

/// A plane in steps of a [`Grid`]: a box is outside where N·q + offset is above 0 at its lowest
/// corner along N. 16 bytes, as they lie on the device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct GridPlane {
    /// The normal, outward.
    pub normal: [i32; 3],
    /// Constant that is added.
    pub offset: i32,
}

impl GridPlane {
    /// A plane that points out, on a grid. Rejects nothing that the plane does not, whatever lies
    /// within the grid; nothing at all where the plane is not finite.
    ///
    /// With x = o + s q the plane n·x > d is K n·q > K (d − n·o) / s for any K > 0. N is K n
    /// rounded, and K n·q is at least N·q − Σ |N − K n| 32767.
    #[must_use]
    pub fn new(plane: &Plane, grid: &Grid) -> Self {
        let most = plane.normal.iter().fold(0.0, |m: f64, n| m.max(n.abs()));
        if !plane.is_finite() || most < 1e-300 {
            return Self::default();
        }
        let scale = NORMAL / most;
        let mut normal = [0; 3];
        let (mut away, mut size, mut lost) = (-plane.d, plane.d.abs(), 0.0);
        for a in 0..3 {
            let exact = plane.normal[a] * scale;
            let rounded = exact.round();
            normal[a] = rounded as i32;
            lost += (exact - rounded).abs() * MOST;
            let part = plane.normal[a] * grid.origin[a];
            away += part;
            size += part.abs();
        }
        // Four operations, each off by half an ulp of what has come together.
        let away = away - size * (8.0 * f64::EPSILON);
        // One for what the sums above were rounded by.
        let offset = (away / grid.step * scale - lost).floor() - 1.0;
        // Not a number where sizes overflow: then nothing is rejected.
        let offset = if offset.is_nan() { -OFFSET } else { offset.clamp(-OFFSET, OFFSET) };
        Self { normal, offset: offset as i32 }
    }

    /// Whether a box is outside. The device's shader does the same.
    #[must_use]
    pub fn rejects(&self, of: &GridBox) -> bool {
        self.lowest(of) > 0
    }

    /// N·q + offset at the lowest corner of a box along N.
    pub(crate) fn lowest(&self, of: &GridBox) -> i32 {
        let mut sum = self.offset;
        for a in 0..3 {
            let n = self.normal[a];
            sum += n * i32::from(if n >= 0 { of.low[a] } else { of.high[a] });
        }
        sum
    }
}
