//! The elliptic cone: the default bound of a cluster.

use glam::{DMat2, DVec2, DVec3};

use super::fit::ANGULAR_SLACK;
use super::{ApexFit, Bound, ClusterPlanes};

/// The region {e : z ≤ 0 and z² ≥ (s·w)² + (t·w)²} with w = e − apex and z = axis·w: no square root, 48
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

impl Bound for EllipticCone {
    fn fit(planes: &ClusterPlanes) -> Option<Self> {
        let fit = ApexFit::new(planes)?;
        let (centre, half) = smallest_ellipse(&fit.points);
        let flat = |v: DVec2| fit.across[0] * v.x + fit.across[1] * v.y;
        let axis = fit.lift(centre);
        let [s, t] = half.map(flat);
        // Rounding of the test and of these numbers, as an angle.
        let slack = ANGULAR_SLACK * (axis.length() + s.length() + t.length());
        let grow = |v: DVec3, instead: DVec3| {
            let direction = v.try_normalize().unwrap_or(instead);
            v + direction * slack
        };
        let across = s.try_normalize().map_or(fit.across[0], |s| s);
        let (s, t) = (grow(s, fit.across[0]), grow(t, fit.axis.cross(across)));
        let cone = Self {
            apex: fit.apex.as_vec3().into(),
            axis: axis.as_vec3().into(),
            s: s.as_vec3().into(),
            t: t.as_vec3().into(),
        };
        Some(cone)
    }

    fn is_behind(&self, eye: [f64; 4]) -> bool {
        let w = to_eye(self.apex, eye);
        let (z, s, t) = (dot(self.axis, w), dot(self.s, w), dot(self.t, w));
        z <= 0.0 && z * z >= s * s + t * t && z.is_finite()
    }
}

/// An [`EllipticCone`] in 21 bytes: directions in signed bytes, on one scale.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct EllipticConeQuantised {
    /// A point behind every plane.
    pub apex: [f32; 3],
    /// As in [`EllipticCone`], all three on one scale.
    pub axis: [i8; 3],
    /// One half-axis.
    pub s: [i8; 3],
    /// The other.
    pub t: [i8; 3],
}

impl Bound for EllipticConeQuantised {
    /// Rounds an [`EllipticCone`], then grows its ellipse until every normal is inside again.
    fn fit(planes: &ClusterPlanes) -> Option<Self> {
        let fit = ApexFit::new(planes)?;
        let exact = EllipticCone::fit(planes)?;
        let normals: Vec<DVec3> = fit.points.iter().map(|p| fit.lift(*p)).collect();
        let [axis, s, t] = [exact.axis, exact.s, exact.t].map(|v| DVec3::from(v.map(f64::from)));
        let mut grow = 1.0;
        // Some dozen steps of 2 % suffice for all but the widest cones, which are given up.
        for _ in 0..60 {
            let (s, t) = (s * grow, t * grow);
            let largest =
                [axis, s, t].map(|v| v.abs().max_element()).into_iter().fold(0.0, f64::max);
            // Half-axes are rounded away from zero by one at least, so that none vanishes.
            let byte = |v: DVec3| (v * (127.0 / largest)).to_array().map(|v| v.round() as i8);
            let q = Self { apex: exact.apex, axis: byte(axis), s: byte(s), t: byte(t) };
            if normals.iter().all(|n| q.holds(*n)) {
                return Some(q);
            }
            grow = grow * 1.02 + 0.0;
        }
        None
    }

    fn is_behind(&self, eye: [f64; 4]) -> bool {
        let w = to_eye(self.apex, eye);
        let [z, s, t] = [self.axis, self.s, self.t].map(|v| dot(v.map(f32::from), w));
        z <= 0.0 && z * z >= s * s + t * t && z.is_finite()
    }
}

impl EllipticConeQuantised {
    /// Whether a normal is in the cone of normals, by the slack that the test in f32 needs.
    fn holds(&self, n: DVec3) -> bool {
        let [axis, s, t] = [self.axis, self.s, self.t].map(|v| DVec3::from(v.map(f64::from)));
        let m = glam::DMat3::from_cols(axis, s, t);
        if m.determinant().abs() < 1e-9 {
            return false;
        }
        // n = α axis + β s + γ t is inside the ellipse where β² + γ² ≤ α².
        let c = m.inverse() * n;
        let slack = 1.0 - ANGULAR_SLACK * axis.length() / s.length().min(t.length());
        c.x > 0.0 && c.y.hypot(c.z) <= c.x * slack
    }
}

/// From an apex to a homogeneous eye.
pub(super) fn to_eye(apex: [f32; 3], eye: [f64; 4]) -> [f32; 3] {
    std::array::from_fn(|k| eye[k] as f32 - apex[k] * eye[3] as f32)
}

pub(super) fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// An ellipse of small area around points: its centre and two half-axes.
///
/// Khachiyan's iteration (Todd & Yıldırım, *On Khachiyan's algorithm for the computation of minimum-volume
/// enclosing ellipsoids*, 2007), stopped early; then grown until it holds every point.
fn smallest_ellipse(points: &[DVec2]) -> (DVec2, [DVec2; 2]) {
    let n = points.len();
    let mut weight = vec![1.0 / n as f64; n];
    let mean = points.iter().sum::<DVec2>() / n as f64;
    let spread = points.iter().map(|p| p.distance(mean)).fold(0.0, f64::max);
    if spread < 1e-12 {
        return (mean, [DVec2::X * spread, DVec2::Y * spread]);
    }
    let moments = |weight: &[f64]| {
        let centre: DVec2 = points.iter().zip(weight).map(|(p, w)| *p * *w).sum();
        let mut m = DMat2::ZERO;
        for (p, w) in points.iter().zip(weight) {
            let d = *p - centre;
            m += DMat2::from_cols(d * d.x, d * d.y) * *w;
        }
        // Points on a line have no area: a sliver of width instead.
        let floor = spread * spread * 1e-12;
        (centre, m + DMat2::from_diagonal(DVec2::splat(floor)))
    };
    for _ in 0..60 {
        let (centre, m) = moments(&weight);
        let inverse = m.inverse();
        let (far, distance) = points
            .iter()
            .map(|p| (*p - centre).dot(inverse * (*p - centre)))
            .enumerate()
            .fold((0, 0.0), |a, b| if b.1 > a.1 { b } else { a });
        // At the optimum every weighted point is at squared distance 2, the dimension.
        if distance <= 2.0 * 1.002 {
            break;
        }
        let step = (distance - 2.0) / (3.0 * distance);
        weight.iter_mut().for_each(|w| *w *= 1.0 - step);
        weight[far] += step;
    }
    let (centre, m) = moments(&weight);
    let inverse = m.inverse();
    let reach = points
        .iter()
        .map(|p| (*p - centre).dot(inverse * (*p - centre)))
        .fold(0.0, f64::max)
        .sqrt();
    // Half-axes are eigenvectors of m, as long as the roots of its eigenvalues, times the reach.
    let (a, b, d) = (m.x_axis.x, m.x_axis.y, m.y_axis.y);
    let (half_sum, half_difference) = ((a + d) * 0.5, (a - d) * 0.5);
    let root = half_difference.hypot(b);
    let angle = 0.5 * b.atan2(half_difference);
    let direction = DVec2::from_angle(angle);
    let grow = reach * (1.0 + 1e-9);
    let long = direction * ((half_sum + root).max(0.0).sqrt() * grow);
    let short = direction.perp() * ((half_sum - root).max(0.0).sqrt() * grow);
    (centre, [long, short])
}
