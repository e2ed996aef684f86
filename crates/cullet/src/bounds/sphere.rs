//! Spheres.

use bytemuck::{Pod, Zeroable};

/// A ball: all points no farther than `radius` from `center`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Sphere {
    /// The centre.
    pub center: [f32; 3],
    /// The radius; negative means empty.
    pub radius: f32,
}
