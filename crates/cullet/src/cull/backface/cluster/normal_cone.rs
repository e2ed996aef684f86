//! The circular cone of normals.
//!
//! Shirman & Abi-Ezzi, *The Cone of Normals Technique for Fast Processing of Curved Patches* (1993); in
//! the form that meshoptimizer stores, from whose bounds it can be made as it is.

use super::elliptic::{dot, to_eye};
use super::fit::ANGULAR_SLACK;
use super::{ApexFit, Bound, ClusterPlanes};

/// The region {e : −axis·w ≥ cutoff |w|} with w = e − apex: 28 bytes.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct NormalCone {
    /// A point behind every plane.
    pub apex: [f32; 3],
    /// The unit axis of the cone of normals.
    pub axis: [f32; 3],
    /// The sine of the cone's half-angle; 1 or more culls nothing.
    pub cutoff: f32,
}

impl NormalCone {
    /// The cone of a meshoptimizer bound: its `cone_apex`, `cone_axis` and `cone_cutoff`.
    #[must_use]
    pub const fn from_meshopt(apex: [f32; 3], axis: [f32; 3], cutoff: f32) -> Self {
        Self { apex, axis, cutoff }
    }

    /// The form without an apex: the eye is behind every plane wherever
    /// −axis·(e − centre) ≥ cutoff |e − centre| + radius, for a sphere around the cluster. Looser, and
    /// right for a sphere that is moved or grown.
    #[must_use]
    pub fn is_behind_sphere(&self, eye: [f64; 4], centre: [f32; 3], radius: f32) -> bool {
        let w = to_eye(centre, eye);
        let length = dot(w, w).sqrt();
        -dot(self.axis, w) >= self.cutoff * length + radius * eye[3] as f32 && length.is_finite()
    }
}

impl Bound for NormalCone {
    fn fit(planes: &ClusterPlanes) -> Option<Self> {
        let fit = ApexFit::new(planes)?;
        // A point at distance r from the axis, one along it, is at an angle of atan r.
        let widest = fit.points.iter().map(|p| p.length()).fold(0.0, f64::max);
        let sine = widest.atan().sin() + ANGULAR_SLACK;
        Some(Self {
            apex: fit.apex.as_vec3().into(),
            axis: fit.axis.as_vec3().into(),
            cutoff: sine as f32,
        })
    }

    fn is_behind(&self, eye: [f64; 4]) -> bool {
        let w = to_eye(self.apex, eye);
        let length = dot(w, w).sqrt();
        -dot(self.axis, w) >= self.cutoff * length && length.is_finite()
    }
}
