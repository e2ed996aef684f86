//! The elliptic cone: the default bound of a cluster.

use glam::{DMat3, DVec2, DVec3};

use super::ellipse::best_ellipse;
use super::eye::{TINY, dot};
use super::{ApexFit, Bound, ClusterEye, ClusterPlanes};

/// The region {e : z < 0 and z² > (s·w)² + (t·w)²} with w = e − apex and z = axis·w: no square root, 48
/// bytes.
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
    /// As [`Bound::fit`], and so that an eye which passes is behind every plane by at least `doubt` times
    /// its distance from any point of the triangle, and times the cluster's radius: room for what a
    /// renderer's rounding may do to eye and vertices. `doubt` is an angle in radians, from 0 to 0.01;
    /// 1e-4 costs nearly nothing.
    ///
    /// The apex is lowered by that much of its own distance, and every normal is widened by the angle; the
    /// two add up to it by the triangle inequality.
    #[must_use]
    pub fn fit_doubting(planes: &ClusterPlanes, doubt: f64) -> Option<Self> {
        let fit = ApexFit::doubting(planes, doubt).ok()?;
        let farthest = fit.hull.iter().map(|p| p.length_squared()).fold(0.0, f64::max);
        // What a turn by the angle moves a point of the plane at distance 1, and a little more.
        let wide = doubt * (1.0 + farthest) * 1.1;
        let shape = Shape::around(&fit).widened(wide);
        let lift = |p: &DVec2| fit.lift(*p);
        let normals: Vec<DVec3> = if doubt > 0.0 {
            let corners = [(wide, wide), (-wide, wide), (-wide, -wide), (wide, -wide)];
            let moved = |p: &DVec2| corners.map(|(x, y)| fit.lift(*p + DVec2::new(x, y)));
            fit.hull.iter().flat_map(moved).collect()
        } else {
            fit.hull.iter().map(lift).collect()
        };
        let mut grow = 1.0;
        // A flat ellipse needs a per cent, hardly any other more than one step.
        for _ in 0..200 {
            let [axis, s, t] = [shape.axis, shape.s * grow, shape.t * grow];
            let f32s = |v: DVec3| v.as_vec3().to_array();
            let cone = Self { apex: f32s(fit.apex), axis: f32s(axis), s: f32s(s), t: f32s(t) };
            if Inside::of([cone.axis, cone.s, cone.t]).is_some_and(|i| i.holds_all(&normals)) {
                return Some(cone);
            }
            grow *= 1.0005;
        }
        None
    }
}

impl Bound for EllipticCone {
    fn fit(planes: &ClusterPlanes) -> Option<Self> {
        Self::fit_doubting(planes, 0.0)
    }

    fn is_behind_eye(&self, eye: &ClusterEye) -> bool {
        let w = eye.from(self.apex);
        let (z, s, t) = (dot(self.axis, w), dot(self.s, w), dot(self.t, w));
        z < 0.0 && z * z - (s * s + t * t) > TINY
    }
}

/// An ellipse of normals in space, before it is rounded.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shape {
    pub(super) axis: DVec3,
    pub(super) s: DVec3,
    pub(super) t: DVec3,
}

impl Shape {
    /// The ellipse around the hull of a cluster's normals, with some width in both directions.
    pub(super) fn around(fit: &ApexFit) -> Self {
        // Narrower, the slack for the test's rounding (see `Inside`) would cost more than it gains.
        const NARROWEST: f64 = 1e-3;
        let (centre, half) = best_ellipse(&fit.hull);
        let flat = |v: DVec2| fit.across[0] * v.x + fit.across[1] * v.y;
        let axis = fit.lift(centre);
        let floor = axis.length().max(half[0].length()) * NARROWEST;
        let along = half[0].normalize_or(DVec2::X);
        let [s, t] = [(half[0], along), (half[1], along.perp())]
            .map(|(v, d)| flat(d * v.length().max(floor)));
        Self { axis, s, t }
    }

    /// With both half-axes longer by twice `by`.
    fn widened(self, by: f64) -> Self {
        let longer = |v: DVec3| v * (1.0 + 2.0 * by / v.length());
        Self { s: longer(self.s), t: longer(self.t), ..self }
    }
}

/// Whether normals are in the cone of an ellipse, by the slack that its test in f32 needs.
///
/// The test finds the numbers z, s·w and t·w each off by at most 7 roundings of the sizes of axis, s and
/// t, and |w|. For a normal n = α axis + β s + γ t with ρ = |(β, γ)|/α, passing the test makes n·w/α at
/// most −|z|(1 − ρ) and that error; and |z| is at least 0.7 times the least that |(z, s·w, t·w)| can be,
/// which is |w| over the norm of the inverse matrix. A normal's own doubt moves ρ as much.
pub(super) struct Inside {
    inverse: DMat3,
    keep: f64,
}

impl Inside {
    /// `None` for vectors in a plane.
    pub(super) fn of(vectors: [[f32; 3]; 3]) -> Option<Self> {
        const ROUNDING: f64 = 2e-6;
        let [axis, s, t] = vectors.map(|v| DVec3::from(v.map(f64::from)));
        let inverse = DMat3::from_cols(axis, s, t).inverse();
        let norm = inverse.to_cols_array().iter().map(|v| v * v).sum::<f64>().sqrt();
        let keep = 1.0 - ROUNDING * norm * (axis.length() + s.length() + t.length());
        // Written so that the NaN of a singular matrix is refused.
        (keep > 0.0).then_some(Self { inverse, keep })
    }

    pub(super) fn holds_all(&self, normals: &[DVec3]) -> bool {
        normals.iter().all(|n| {
            let c = self.inverse * *n;
            c.x > 0.0 && c.y.hypot(c.z) <= c.x * self.keep
        })
    }
}
