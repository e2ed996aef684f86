//! Eyes that levels are chosen for, and how large an error looks from there.

use glam::{DMat3, DMat4, DVec3};

use crate::array::{self, Each};
use crate::math;
#[cfg(not(feature = "std"))]
use crate::math::Float as _;
use crate::transform::Transform;
use crate::view::{EyeBall, View};

/// How much of its original what is drawn may lose.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
#[non_exhaustive]
pub struct Lod {
    /// Number of pixels that the drawn surface may be off, from 0. The limit holds as far as the
    /// errors of the levels are bounds. A value that is not above 0, or NaN, draws everything in
    /// full.
    pub pixels: f64,
    /// Whether that holds in the corners of the image too, where a pixel is a smaller angle than at
    /// its centre. Then it is held everywhere as in the farthest corner, by 1/cos² of its angle to
    /// the centre: 2.4 times as fine at 60 degrees and 16:9. Default off: it holds at the centre.
    pub at_corners: bool,
    /// A budget: where more triangles than this would be drawn, `pixels` are raised for all until
    /// they are not, in steps of a quarter of an octave;
    /// [`Visible::lod_pixels`](crate::Visible::lod_pixels) tells to how many. What is counted is
    /// the instances that are left when levels are chosen: before occlusion, which needs to know
    /// what is drawn, and before any of their clusters is culled. Those without levels count in
    /// full, and where the coarsest of all are still too many, they are drawn. Default none. Cost:
    /// for each of those instances a choice of its levels at the finest threshold, `pixels`, before
    /// that at the threshold which is drawn.
    pub triangles: Option<u64>,
    /// Whether instances that [stand for others](crate::Scene::stand_for) are drawn in their place.
    /// Default on.
    pub stand_ins: bool,
    /// Whether [impostors](crate::Scene::add_impostor) are chosen among the levels: off for a
    /// renderer that would draw their boxes, and to see what they save. Default on.
    pub impostors: bool,
}

impl Default for Lod {
    /// A pixel at the centre of the image.
    fn default() -> Self {
        Self { pixels: 1.0, at_corners: false, triangles: None, stand_ins: true, impostors: true }
    }
}

impl Lod {
    /// These settings with another [threshold](Self::pixels), in pixels.
    #[must_use]
    pub fn with_pixels(self, pixels: f64) -> Self {
        Self { pixels, ..self }
    }

    /// These settings with the threshold held [in the corners](Self::at_corners) of the image too,
    /// or not.
    #[must_use]
    pub fn with_at_corners(self, at_corners: bool) -> Self {
        Self { at_corners, ..self }
    }

    /// These settings with a [budget of triangles](Self::triangles), or without.
    #[must_use]
    pub fn with_triangles(self, triangles: impl Into<Option<u64>>) -> Self {
        Self { triangles: triangles.into(), ..self }
    }

    /// These settings with [stand-ins](Self::stand_ins) on or off.
    #[must_use]
    pub fn with_stand_ins(self, stand_ins: bool) -> Self {
        Self { stand_ins, ..self }
    }

    /// These settings with [impostors](Self::impostors) on or off.
    #[must_use]
    pub fn with_impostors(self, impostors: bool) -> Self {
        Self { impostors, ..self }
    }
}

/// Size on the screen of what is small, in a view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelScale {
    /// The eye in world space; none for parallel lines of sight.
    pub eye: Option<[f64; 3]>,
    /// Pixels of a length of 1 at distance 1 from the eye; with parallel lines of sight at any
    /// distance.
    pub pixels: f64,
    /// The nearest distance that is drawn: errors before it count as if they were there.
    pub near: f64,
}

impl PixelScale {
    /// Returns the scale of `view` at the centre of its image, or with `at_corners` in its farthest
    /// corner.
    #[must_use]
    pub fn of(view: &View, at_corners: bool) -> Self {
        // Columns of four: row r of the matrix is m[r], m[r + 4], m[r + 8] and, of the translation,
        // m[r + 12].
        let m = view.clip_from_world();
        let row = |r: usize| DVec3::new(m[r], m[r + 4], m[r + 8]);
        let (w, viewport) = (row(3), view.viewport());
        let is_parallel = view.is_orthographic();
        let ahead = if is_parallel { 0.0 } else { w.length() };
        let mut pixels: f64 = 0.0;
        for (axis, size) in viewport.into_iter().enumerate() {
            let mut side = row(axis);
            let mut unit = m[15].abs();
            if !is_parallel {
                // An image off the centre leans along the axis; that part turns no point aside.
                side -= w * (side.dot(w) / w.dot(w));
                unit = ahead;
            }
            pixels = pixels.max(f64::from(size) * 0.5 * side.length() / unit);
        }
        if is_parallel {
            return Self { eye: None, pixels, near: 0.0 };
        }
        let [x, y, z, _] = view.eye();
        let eye = DVec3::new(x, y, z);
        let inverse = DMat4::from_cols_array(&view.world_from_clip());
        // Points on the edges of the image at two depths; either lies on the near plane.
        let mut near = f64::INFINITY;
        let mut least_cosine: f64 = 1.0;
        for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
            for z in [0.0, 1.0] {
                let to = inverse.project_point3(DVec3::new(x, y, z)) - eye;
                let depth = to.dot(w) / ahead;
                if depth.is_finite() && depth > 0.0 {
                    near = near.min(depth);
                    least_cosine = least_cosine.min(depth / to.length());
                }
            }
        }
        if at_corners && least_cosine > 0.0 {
            pixels /= least_cosine * least_cosine;
        }
        Self { eye: Some(eye.into()), pixels, near: if near.is_finite() { near } else { 0.0 } }
    }
}

/// An eye in the space of a mesh, with the threshold: what
/// [`Levels::select`](super::Levels::select) needs of a view.
///
/// A group is over the threshold iff its error is above `nearest`, and the eye nearer to its centre
/// than radius, error times `reach` and `ball` together. All is rounded to the side of what is
/// finer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelEye {
    /// Where the eye is, in the space of the mesh.
    pub eye: [f32; 3],
    /// From how far an error of 1 is as large as the threshold.
    pub reach: f32,
    /// The radius of the ball of eyes.
    pub ball: f32,
    /// The error that is just as large as the threshold at the near plane, and with parallel lines
    /// of sight everywhere.
    pub nearest: f32,
}

/// More than all roundings of f32 on the way to a decision, as a share.
const ROUNDING_F32: f64 = 1e-5;

impl LevelEye {
    /// An eye that draws everything in full.
    const FULL: Self = Self { eye: [0.0; 3], reach: f32::INFINITY, ball: 0.0, nearest: -1.0 };

    /// Makes the eye of `lod` in a view with `scale`, for an instance with `transform`. A `ball`
    /// takes the place of the view's eye; parallel lines of sight have no eye and ignore it.
    ///
    /// Where the transform stretches unevenly, distances are scaled by its least factor and errors
    /// by its largest. The choice is then finer than needed and never coarser. A transform that is
    /// flat or not finite draws everything in full. So does a threshold that is not above 0.
    #[must_use]
    pub fn new(
        lod: &Lod,
        scale: &PixelScale,
        transform: &Transform,
        ball: Option<EyeBall>,
    ) -> Self {
        let Some((least, largest)) = stretch(transform) else { return Self::FULL };
        let pixels = scale.pixels * largest * (1.0 + ROUNDING_F32);
        let reach = pixels / lod.pixels;
        let Some(eye) = scale.eye else {
            let nearest = (1.0 / reach) as f32;
            let full = !(reach.is_finite() && reach > 0.0);
            return if full {
                Self::FULL
            } else {
                Self { reach: f32::INFINITY, nearest, ..Self::FULL }
            };
        };
        let ball = ball.unwrap_or(EyeBall { centre: eye, radius: 0.0 });
        let Some(own) = inverse_point(transform, ball.centre) else { return Self::FULL };
        // In units of the mesh along the direction that is stretched least.
        let reach = reach / least * (1.0 + ROUNDING_F32);
        let shift = own.iter().map(|v| v.abs()).fold(0.0, f64::max) * 2.0 * f64::from(f32::EPSILON);
        let ball = ball.radius.max(0.0) / least + shift;
        let nearest = scale.near * lod.pixels / (scale.pixels * largest) * (1.0 - ROUNDING_F32);
        let made = Self {
            eye: own.each(|v| v as f32),
            reach: reach as f32,
            ball: ball as f32,
            nearest: nearest as f32,
        };
        let is_sound = lod.pixels > 0.0
            && made.eye.iter().all(|v| v.is_finite())
            && [made.reach, made.ball, made.nearest].iter().all(|v| v.is_finite());
        if is_sound { made } else { Self::FULL }
    }

    /// Whether a group is over the threshold.
    #[must_use]
    pub fn is_over(&self, group: &super::Group) -> bool {
        let to: [f32; 3] = array::from_fn(|a| group.centre[a] - self.eye[a]);
        let far = (group.error * self.reach + group.radius) + self.ball;
        let away = (to[0] * to[0] + to[1] * to[1]) + to[2] * to[2];
        // Not beyond: also where a number is NaN, as 0 times infinity is.
        let beyond = away > far * far;
        group.error > self.nearest && !beyond
    }

    /// The largest error of which a group in such a sphere is not over the threshold, from 0: how
    /// far all that is in the sphere may be off.
    #[must_use]
    pub fn allowed(&self, centre: [f32; 3], radius: f32) -> f32 {
        let [centre, eye] = [centre, self.eye].each(|p| DVec3::from(p.each(f64::from)));
        let far = (centre - eye).length() * (1.0 - ROUNDING_F32);
        let free = far - (f64::from(radius) + f64::from(self.ball)) * (1.0 + ROUNDING_F32);
        let beyond = free / f64::from(self.reach);
        // NaN is no allowance either.
        (beyond as f32).max(self.nearest).max(0.0)
    }
}

/// Returns the least and the largest factor by which a transform stretches; none if it flattens, or
/// is not finite.
fn stretch(transform: &Transform) -> Option<(f64, f64)> {
    let linear = transform.linear_f64();
    let g = linear.transpose() * linear;
    let squares = [g.x_axis.x, g.y_axis.y, g.z_axis.z];
    let (least, largest) =
        squares.into_iter().fold((f64::INFINITY, 0.0_f64), |(a, b), v| (a.min(v), b.max(v)));
    let [xy, yz, zx] = [g.x_axis.y, g.y_axis.z, g.z_axis.x].each(f64::abs);
    // Gershgorin's discs around the squares of the factors: exact for a rotation with a scale along
    // the axes.
    let skew = (xy + zx).max(xy + yz).max(yz + zx);
    let (least, largest) =
        if skew <= largest * 1e-6 { (least - skew, largest + skew) } else { eigenvalues(g) };
    (least > 0.0 && largest.is_finite()).then(|| (least.sqrt(), largest.sqrt()))
}

/// Returns the least and the largest eigenvalue of a symmetric matrix, a little outward.
///
/// A plain bound, the Frobenius norm and what the determinant leaves for the least factor, is 1.7
/// times as wide in the median of uneven scales between 0.5 and 2 in random directions, and levels
/// would be so much finer.
fn eigenvalues(g: DMat3) -> (f64, f64) {
    let mean = (g.x_axis.x + g.y_axis.y + g.z_axis.z) / 3.0;
    let b = g - DMat3::from_diagonal(DVec3::splat(mean));
    let spread = (b.to_cols_array().into_iter().map(|v| v * v).sum::<f64>() / 6.0).sqrt();
    let angle = math::acos((b.determinant() / (2.0 * spread.powi(3))).clamp(-1.0, 1.0)) / 3.0;
    let third = core::f64::consts::TAU / 3.0;
    let (largest, least) =
        (mean + 2.0 * spread * math::cos(angle), mean + 2.0 * spread * math::cos(angle + third));
    let slack = largest * 1e-9;
    (least - slack, largest + slack)
}

fn inverse_point(transform: &Transform, p: [f64; 3]) -> Option<[f64; 3]> {
    let q = DMat4::from_cols_array(&transform.to_matrix()).inverse().transform_point3(p.into());
    q.is_finite().then(|| q.into())
}
