//! The circular cone of normals.
//!
//! Shirman & Abi-Ezzi, *The Cone of Normals Technique for Fast Processing of Curved Patches*
//! (1993); in the form that meshoptimizer stores, from whose bounds it can be made as it is.

use cullet::cull::backface::{ClusterEye, ClusterPlanes};
use fearless_simd::prelude::*;
use glam::{DVec2, DVec3};

use super::lanes::{self, plain};
use super::margin::margin;
use super::{ANGULAR_SLACK, Blocks, Bound, dot};

/// The region {e : z < 0 and z² > cutoff² |w|²} with w = e − apex and z = axis·w: 28 bytes.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct NormalCone {
    /// A point behind every plane.
    pub apex: [f32; 3],
    /// The unit axis of the cone of normals.
    pub axis: [f32; 3],
    /// The sine of the cone's half-angle, not negative; above 1 it culls nothing.
    pub cutoff: f32,
}

impl NormalCone {
    /// The cone of a meshoptimizer bound: its `cone_apex`, `cone_axis` and `cone_cutoff`, widened
    /// by 1e-5 for the rounding of the test. As right as those numbers are: their apex is rounded
    /// with no margin, which may err by 1e-6 of the cluster's distance from the origin.
    #[must_use]
    pub const fn from_meshopt(apex: [f32; 3], axis: [f32; 3], cutoff: f32) -> Self {
        Self { apex, axis, cutoff: cutoff + ANGULAR_SLACK as f32 }
    }

    /// The form without an apex, for a sphere around the cluster: see [`NormalConeCentre`].
    #[must_use]
    pub fn is_behind_sphere(&self, eye: [f64; 4], centre: [f32; 3], radius: f32) -> bool {
        NormalConeCentre::new(self, centre, radius).is_behind(eye)
    }
}

impl Bound for NormalCone {
    type Batch = Blocks<Self>;

    fn fit(planes: &ClusterPlanes) -> Option<Self> {
        let fit = planes.apex(0.0)?;
        // A point at distance r from the axis, one along it, is at an angle of atan r.
        let widest = fit.hull.iter().map(|p| DVec2::from(*p).length()).fold(0.0, f64::max);
        let sine = widest.atan().sin() + ANGULAR_SLACK;
        let f32s = |v: [f64; 3]| DVec3::from(v).as_vec3().to_array();
        Some(Self { apex: f32s(fit.point), axis: f32s(fit.axis), cutoff: sine as f32 })
    }

    fn is_behind_eye(&self, eye: &ClusterEye) -> bool {
        let w = eye.way_from(self.apex);
        let z = dot(self.axis, w);
        z < 0.0 && z * z - self.cutoff * self.cutoff * dot(w, w) > ClusterEye::LEAST_SQUARE
    }

    fn margin(&self, eye: [f64; 3]) -> f64 {
        let apex = DVec3::from(self.apex.map(f64::from));
        let axis = DVec3::from(self.axis.map(f64::from));
        let w = DVec3::from(eye) - apex;
        let sine = f64::from(self.cutoff);
        // Such a cone culls nothing, ever.
        if sine >= 1.0 {
            return f64::INFINITY;
        }
        // The largest g·w of the unit normals at the border of the cone.
        let z = axis.dot(w);
        let off = (w.length_squared() - z * z).max(0.0).sqrt();
        let value = -(z * (1.0 - sine * sine).sqrt() + off * sine);
        // The axis is a unit vector of f32 numbers, and cutoffs near 1 have few digits.
        margin(value, 1.0 + 1e-6, 4.0 / (1.0 - sine * sine).sqrt(), w.length(), apex)
    }
}

plain!(NormalCone, 7, |simd, block, start, eye| {
    let w = lanes::to_eye(simd, block.three(0), start, eye);
    let z = lanes::dot::<S>(lanes::rows(simd, block.three(3), start), w);
    let cutoff = lanes::load::<S>(simd, block.one(6), start);
    lanes::in_cone(simd, z, cutoff * cutoff * lanes::dot::<S>(w, w))
});

/// The cone with a sphere around the cluster in place of the apex: 32 bytes.
///
/// The region {e : z > 0 and z² > cutoff² |w|²} with w = e − centre and z = −axis·w − radius.
/// Looser than with an apex, and right for a sphere that is moved or grown.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct NormalConeCentre {
    /// The middle of the sphere.
    pub centre: [f32; 3],
    /// Its radius, and room for what rounding takes.
    pub radius: f32,
    /// The unit axis of the cone of normals.
    pub axis: [f32; 3],
    /// The sine of the cone's half-angle, as in [`NormalCone`].
    pub cutoff: f32,
}

impl NormalConeCentre {
    /// The least z that culls: the squares of less have no digits left.
    const LEAST: f32 = 1e-15;

    /// The cone of `cone`'s normals with a sphere that holds the whole cluster. The smaller the
    /// sphere, the more is culled. With a centre or radius of NaN or infinity nothing is; a
    /// negative radius holds nothing and makes the bound wrong.
    #[must_use]
    pub const fn new(cone: &NormalCone, centre: [f32; 3], radius: f32) -> Self {
        let size = centre[0].abs() + centre[1].abs() + centre[2].abs() + radius;
        // An eye at a distance is rounded to f32 as the centre's coordinates are.
        let radius = radius + size * (4.0 * f32::EPSILON);
        Self { centre, radius, axis: cone.axis, cutoff: cone.cutoff }
    }
}

impl Bound for NormalConeCentre {
    type Batch = Blocks<Self>;

    /// Fits with the sphere around the cluster's box; [`NormalConeCentre::new`] takes a smaller
    /// one.
    fn fit(planes: &ClusterPlanes) -> Option<Self> {
        let cone = NormalCone::fit(planes)?;
        // The middle is rounded, and so is the radius.
        let radius = (planes.radius() as f32).next_up();
        Some(Self::new(&cone, planes.centre().map(|v| v as f32), radius))
    }

    fn is_behind_eye(&self, eye: &ClusterEye) -> bool {
        let w = eye.way_from(self.centre);
        let z = -dot(self.axis, w) - self.radius * eye.weight();
        z > Self::LEAST && z * z - self.cutoff * self.cutoff * dot(w, w) > ClusterEye::LEAST_SQUARE
    }
}

plain!(NormalConeCentre, 8, |simd, block, start, eye| {
    let w = lanes::to_eye(simd, block.three(0), start, eye);
    let room = lanes::load::<S>(simd, block.one(3), start) * S::f32s::splat(simd, eye.weight());
    let z = S::f32s::splat(simd, 0.0)
        - lanes::dot::<S>(lanes::rows(simd, block.three(4), start), w)
        - room;
    let cutoff = lanes::load::<S>(simd, block.one(7), start);
    let least = S::f32s::splat(simd, NormalConeCentre::LEAST);
    let above = z * z - cutoff * cutoff * lanes::dot::<S>(w, w);
    (z.simd_gt(least) & above.simd_gt(S::f32s::splat(simd, ClusterEye::LEAST_SQUARE))).to_bitmask()
});
