//! Rows of a screen in f32: affine functions of points, with bounds on what rounding does to them.
//!
//! A row of the screen takes a point to a number, k · p + c. It is worked out from p − e, where e
//! is a point of f32 numbers near the eye, so that what is far from the origin but near the eye
//! loses nothing: p − e is rounded once, and what e leaves is in the constant, which is summed in
//! f64. With u = 2⁻²⁴: k and p − e are off by u each, the product by u and its sum by at most 3 u,
//! so that the number is off by less than 7 u (Σ
//! |k||p − e| + |c|). [`Row`] takes 9 u, of which the rest pays for the rounding of the bound itself, and adds
//! what f64 did to the rows.

use crate::array::Each;
use crate::bounds::Boxes;

/// Error of rounding a row, as a share of the sizes of its terms: 9 u.
const SHARE: f64 = 9.0 / (1 << 24) as f64;

/// How far rows and their constants may be off in f64: twice what the test of single boxes takes.
const SHARE64: f64 = 64.0 * f64::EPSILON;

/// A coefficient beyond this could overflow on a box that is stored as the whole of space.
const STEEPEST: f64 = 1e18;

/// An affine function of points, and how far its value may be off.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    pub(crate) k: [f32; 3],
    pub(crate) c: f32,
    /// The error is at most that of these, taken of the absolute coordinates.
    pub(crate) k_error: [f32; 3],
    pub(crate) c_error: f32,
}

impl Row {
    /// A row for points relative to `e`, of which each number was summed from terms of the sizes
    /// `of`, and which is off by `apart` beside its rounding; `None` where a number may overflow.
    pub(crate) fn new(r: [f64; 4], of: [f64; 4], e: [f32; 3], apart: f64) -> Option<Self> {
        let at = |r: [f64; 4], a: usize| r[a] * f64::from(e[a]);
        let c = r[3] + at(r, 0) + at(r, 1) + at(r, 2);
        let size = of[3] + at(of, 0).abs() + at(of, 1).abs() + at(of, 2).abs();
        if !(of[..3].iter().all(|&k| k < STEEPEST) && size < STEEPEST * 1e18) {
            return None;
        }
        // The smallest normal number is for coefficients and products that underflow.
        let up = |v: f64| (v as f32).next_up() + f32::MIN_POSITIVE;
        Some(Self {
            k: [r[0] as f32, r[1] as f32, r[2] as f32],
            c: c as f32,
            k_error: [0, 1, 2].each(|a| up(r[a].abs() * SHARE + of[a] * SHARE64)),
            c_error: up(c.abs() * SHARE + size * SHARE64 + apart),
        })
    }
}

/// The point where three rows are zero, the eye where they are those of a perspective view, as near
/// as f32 has it.
pub(crate) fn meet(rows: [[f64; 4]; 3]) -> Option<[f32; 3]> {
    let [a, b, c] = rows.each(|r| glam::DVec3::new(r[0], r[1], r[2]));
    let d = [rows[0][3], rows[1][3], rows[2][3]];
    let determinant = a.dot(b.cross(c));
    let p = -(b.cross(c) * d[0] + c.cross(a) * d[1] + a.cross(b) * d[2]) / determinant;
    let p = p.to_array().each(|v| v as f32);
    p.iter().all(|v| v.abs() < Boxes::LIMIT).then_some(p)
}
