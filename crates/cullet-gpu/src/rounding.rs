//! How far a renderer may move a vertex from where it is.

use cullet::bounds::Sphere;
use cullet::{Transform, View};
use glam::{DMat3, DMat4, DVec3, DVec4};

use super::ids::EyeUniform;

/// A device puts a vertex on a grid of 8 bits below the pixel, at most 0.6 steps from where it is:
/// Direct3D's rule, and what others do.
const SNAP_PX: f64 = 0.6 / 256.0;
/// Half an epsilon: what an operation in f32 is off by, of its result.
const U: f64 = f32::EPSILON as f64 / 2.0;
/// From a vertex to its place relative to the eye: three products, three sums, and a difference of
/// two halves each.
const TO_EYE: f64 = 6.0 * U;
/// From there to clip coordinates: what the matrix was rounded by, three products and three sums.
const TO_CLIP: f64 = 6.0 * U;
/// From there to pixels: a division, of which two and a half epsilons are allowed, a product and a
/// sum.
const TO_SCREEN: f64 = 8.0 * U;
/// A place as the sum of two f32 numbers holds so much of it.
const HALVES: f64 = 1.0 / (1_u64 << 46) as f64;

/// How far a renderer that works in f32, relative to the eye, moves the vertices of instances in
/// one view.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rounding {
    eye: DVec3,
    /// Rows x, y and w of the clip matrix.
    rows: [DVec4; 3],
    /// How far the world moves for one unit of clip x, y and w.
    moves: [f64; 3],
    /// The cosine of the angle between those for x and y.
    skew: f64,
    /// Rounding of w.
    snap: [f64; 2],
}

impl Rounding {
    /// Returns the rounding of a view; `None` where it is not known.
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
        let skew = inverse.x_axis.dot(inverse.y_axis).abs() / (moves[0] * moves[1]);
        let snap = view.viewport().map(|side| 2.0 * SNAP_PX / f64::from(side.max(1)));
        let known = moves.iter().chain(&eye.to_array()).all(|v| v.is_finite()) && skew.is_finite();
        known.then_some(Self { eye, rows, moves, skew, snap })
    }

    /// The most that a vertex of an instance is moved by, in units of its mesh; `None` where that
    /// is not known. `sphere` is around the mesh.
    pub(crate) fn of(&self, transform: &Transform, sphere: &Sphere) -> Option<f64> {
        let linear = DMat3::from_cols_array_2d(&transform.linear.map(|c| c.map(f64::from)));
        let inverse = linear.inverse();
        let to = DVec3::from(transform.translation);
        let centre = DVec3::from(sphere.center.map(f64::from));
        let stretch = norm(&linear);
        let radius = stretch * f64::from(sphere.radius);
        // Of the coordinates relative to the eye, and of the terms that they are the sums of.
        let size = (to - self.eye).length() + stretch * centre.length() + radius;
        let lost = (TO_EYE + TO_CLIP) * size + HALVES * (to.abs() + self.eye.abs()).element_sum();
        let in_world = (linear * centre + to).extend(1.0);
        let clip = self.rows.map(|row| row.dot(in_world).abs() + row.truncate().length() * radius);
        let off = |k: usize| self.rows[k].truncate().length() * lost;
        let on_screen =
            |k: usize| off(k) + TO_SCREEN * (clip[k] + clip[2]) + self.snap[k] * clip[2];
        let [x, y] = [0, 1].map(|k| self.moves[k] * on_screen(k));
        let world = (x * x + y * y + 2.0 * self.skew * x * y).sqrt();
        let object = (world + self.moves[2] * off(2)) * norm(&inverse);
        object.is_finite().then_some(object)
    }
}

/// No vector becomes longer by more than this factor; of a rotation it is 1. The square of the
/// longest is the largest eigenvalue of the product with the transpose, at most the largest sum of
/// a row's absolute values.
fn norm(m: &DMat3) -> f64 {
    let squares = m.transpose() * *m;
    let sums = [squares.x_axis, squares.y_axis, squares.z_axis].map(|c| c.abs().element_sum());
    // A sum that is NaN must not be passed over.
    sums.into_iter().fold(0.0, |most: f64, sum| if sum <= most { most } else { sum }).sqrt()
}
