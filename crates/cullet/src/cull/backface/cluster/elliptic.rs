//! The elliptic cone: the default bound of a cluster.

use alloc::vec::Vec;

use glam::{DMat3, DVec2, DVec3};

use super::ellipse::best_ellipse;
use super::{Apex, ClusterEye, ClusterPlanes};
use crate::array::Each;
use crate::math;
#[cfg(not(feature = "std"))]
use crate::math::Float as _;

/// The region {e : z < 0 and z² > (s·w)² + (t·w)²} with w = e − apex and z = axis·w: no square
/// root, 48 bytes.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct EllipticCone {
    /// A point behind every plane.
    pub apex: [f32; 3],
    /// The middle of the cone of normals; not of unit length.
    pub axis: [f32; 3],
    /// One half-axis of the ellipse that the normals lie in, at the end of `axis`.
    pub s: [f32; 3],
    /// The other one.
    pub t: [f32; 3],
}

impl EllipticCone {
    /// The cone of a cluster with these planes. `None` where no eye can be proved behind all of
    /// them: see [`ClusterPlanes::apex`].
    ///
    /// An eye that passes is behind every plane by at least `doubt` times its distance from any
    /// point of the triangle, and times the cluster's radius: room for what a renderer's rounding
    /// may do to eye and vertices. `doubt` is an angle in radians, from 0 to 0.01; 1e-4 costs
    /// nearly nothing.
    ///
    /// The apex is lowered by that much of its own distance, and every normal is widened by the
    /// angle; the two add up to it by the triangle inequality.
    #[must_use]
    pub fn fit_doubting(planes: &ClusterPlanes, doubt: f64) -> Option<Self> {
        let fit = planes.apex(doubt)?;
        let farthest =
            fit.hull.iter().map(|p| DVec2::from(*p).length_squared()).fold(0.0, f64::max);
        // Distance that a turn by the angle moves a point of the plane at distance 1, and a little
        // more.
        let wide = doubt * (1.0 + farthest) * 1.1;
        let shape = Shape::around(&fit).widened(wide);
        let fit = if doubt > 0.0 { fit.widened(wide) } else { fit };
        let mut grow = 1.0;
        // A flat ellipse needs a per cent, hardly any other more than one step.
        for _ in 0..200 {
            let [axis, s, t] = [shape.axis, shape.s * grow, shape.t * grow];
            let f32s = |v: DVec3| v.as_vec3().to_array();
            let apex = DVec3::from(fit.point).as_vec3().to_array();
            let cone = Self { apex, axis: f32s(axis), s: f32s(s), t: f32s(t) };
            if cone.holds(&fit) {
                return Some(cone);
            }
            grow *= 1.0005;
        }
        None
    }

    /// Whether the eye is proved behind every plane.
    #[must_use]
    pub fn is_behind_eye(&self, eye: &ClusterEye) -> bool {
        let w = eye.way_from(self.apex);
        let [z, s, t] =
            [self.axis, self.s, self.t].each(|v| v[0] * w[0] + v[1] * w[1] + v[2] * w[2]);
        z < 0.0 && z * z - (s * s + t * t) > ClusterEye::LEAST_SQUARE
    }

    /// Whether all normals are in the cone, by the slack that its test in f32 needs.
    ///
    /// The test finds the numbers z, s·w and t·w each off by at most 7 roundings of the sizes of
    /// axis, s and t, and |w|. For a normal n = α axis + β s + γ t with ρ = |(β, γ)|/α, passing the
    /// test makes n·w/α at most −|z|(1 − ρ) and that error; and |z| is at least 0.7 times the least
    /// that |(z, s·w, t·w)| can be, which is |w| over the norm of the inverse matrix. A normal's
    /// own doubt moves ρ as much.
    #[must_use]
    pub fn holds(&self, fit: &Apex) -> bool {
        const ROUNDING: f64 = 2e-6;
        let [axis, s, t] = [self.axis, self.s, self.t].each(|v| DVec3::from(v.each(f64::from)));
        let inverse = DMat3::from_cols(axis, s, t).inverse();
        let norm = inverse.to_cols_array().iter().map(|v| v * v).sum::<f64>().sqrt();
        let keep = 1.0 - ROUNDING * norm * (axis.length() + s.length() + t.length());
        let inside = |p: &[f64; 2]| {
            let c = inverse * DVec3::from(fit.lift(*p));
            c.x > 0.0 && math::hypot(c.y, c.z) <= c.x * keep
        };
        // Written so that the NaN of vectors in a plane is refused.
        keep > 0.0 && fit.hull.iter().all(inside)
    }
}

/// An ellipse of normals in space, before it is rounded.
#[derive(Clone, Copy, Debug)]
struct Shape {
    axis: DVec3,
    s: DVec3,
    t: DVec3,
}

impl Shape {
    /// The ellipse around the hull of a cluster's normals, with some width in both directions.
    fn around(fit: &Apex) -> Self {
        // Narrower, the slack for the test's rounding (see `Inside`) would cost more than it gains.
        const NARROWEST: f64 = 1e-3;
        let hull: Vec<DVec2> = fit.hull.iter().map(|p| DVec2::from(*p)).collect();
        let (centre, half) = best_ellipse(&hull);
        let [u, v] = fit.across.each(DVec3::from);
        let flat = |p: DVec2| u * p.x + v * p.y;
        let axis = DVec3::from(fit.lift(centre.into()));
        let floor = axis.length().max(half[0].length()) * NARROWEST;
        let along = half[0].normalize_or(DVec2::X);
        let [s, t] = [(half[0], along), (half[1], along.perp())]
            .each(|(v, d)| flat(d * v.length().max(floor)));
        Self { axis, s, t }
    }

    /// Returns the ellipse with both half-axes lengthened by `2 * by`.
    fn widened(self, by: f64) -> Self {
        let longer = |v: DVec3| v * (1.0 + 2.0 * by / v.length());
        Self { s: longer(self.s), t: longer(self.t), ..self }
    }
}
