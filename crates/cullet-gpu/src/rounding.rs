//! How far a renderer may move a vertex from where it is.

use cullet::bounds::Sphere;
use cullet::{Transform, View};
use glam::{DMat3, DMat4, DVec3, DVec4};

use super::ids::EyeUniform;

/// A device may put a vertex one step of the finest grid of all away from where it is on the screen: 8 bits below the pixel, which
/// Direct3D demands and others have.
const SNAP_PX: f64 = 1.0 / 256.0;
/// A vertex shader in f32 has some twenty operations from the vertex to its clip coordinates, each off by half an epsilon of
/// what it handles.
const OPERATIONS: f64 = 24.0 * (f32::EPSILON as f64) / 2.0;
/// A place as the sum of two f32 numbers holds so much of it.
const HALVES: f64 = 1.0 / (1_u64 << 46) as f64;

/// How far a renderer that works in f32, relative to the eye, moves the vertices of instances in one view.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rounding {
    eye: DVec3,
    /// Rows x, y and w of the clip matrix: their lengths, and what they add at the eye.
    rows: [f64; 3],
    at_eye: [f64; 3],
    /// How far the world moves for one unit of clip x, y and w.
    moves: [f64; 3],
    /// Of w.
    snap: [f64; 2],
}

impl Rounding {
    /// Of a view; `None` where it is not known.
    pub(crate) fn new(view: &View) -> Option<Self> {
        let m = DMat4::from_cols_array(&view.clip_from_world());
        let EyeUniform { high, low, .. } = EyeUniform::new(view);
        let half = |v: [f32; 4]| DVec3::new(v[0].into(), v[1].into(), v[2].into());
        let eye = half(high) + half(low);
        let rows = [m.row(0), m.row(1), m.row(3)];
        let [x, y, w] = rows.map(DVec4::truncate);
        let parallel = w == DVec3::ZERO;
        // Where lines of sight are parallel, what moves along them does not move on the screen.
        let along = if parallel { x.cross(y).normalize_or_zero() } else { w };
        let inverse = DMat3::from_cols(x, y, along).transpose().inverse();
        // There w is the same everywhere.
        let by_w = if parallel { DVec3::ZERO } else { inverse.z_axis };
        let moves = [inverse.x_axis, inverse.y_axis, by_w].map(DVec3::length);
        let made = Self {
            eye,
            rows: [x, y, w].map(DVec3::length),
            at_eye: rows.map(|row| row.dot(eye.extend(1.0)).abs()),
            moves,
            snap: view.viewport().map(|side| 2.0 * SNAP_PX / f64::from(side.max(1))),
        };
        let known = made.moves.iter().chain(&made.rows).all(|v| v.is_finite()) && eye.is_finite();
        known.then_some(made)
    }

    /// The most that a vertex of an instance is moved by, in units of its mesh; `None` where that is not known. `sphere` is around the
    /// mesh.
    pub(crate) fn of(&self, transform: &Transform, sphere: &Sphere) -> Option<f64> {
        let linear = DMat3::from_cols_array_2d(&transform.linear.map(|c| c.map(f64::from)));
        let inverse = linear.inverse();
        let to = DVec3::from(transform.translation);
        let reach = DVec3::from(sphere.center.map(f64::from)).length() + f64::from(sphere.radius);
        // Of the coordinates relative to the eye, and of the terms that they are the sums of.
        let size = (to - self.eye).length() + norm(&linear) * reach;
        let lost = OPERATIONS * size + HALVES * (to.abs() + self.eye.abs()).element_sum();
        let most = |row: usize| self.rows[row] * size + self.at_eye[row];
        let off = |row: usize| OPERATIONS * most(row) + self.rows[row] * lost;
        let on_screen = |row: usize| off(row) + (self.snap[row] + OPERATIONS) * most(2);
        let world = self.moves[0] * on_screen(0) + self.moves[1] * on_screen(1);
        let object = (world + self.moves[2] * off(2)) * norm(&inverse);
        object.is_finite().then_some(object)
    }
}

/// No vector becomes longer by more than this factor.
fn norm(m: &DMat3) -> f64 {
    let squares = [m.x_axis, m.y_axis, m.z_axis].map(DVec3::length_squared);
    squares.into_iter().sum::<f64>().sqrt()
}
