//! Bounds of meshes whose vertices move: skinned by joints, morphed between shapes, or first
//! morphed and then skinned.
//!
//! The types are prepared once from the mesh and evaluated once a frame; the bounds, in the space
//! that the joints or the mesh are given in, go to the scene as
//! [`BoundsOverride::World`](cullet::scene::BoundsOverride::World).

mod both;
mod joints;
mod morphs;

pub use both::MorphedJointBoxes;
pub use joints::{JointBoxes, Skin};
pub use morphs::{MorphBounds, Morphs};

use cullet::Transform;
use glam::{DMat3, DVec3};
use thiserror::Error;

/// Bound on the rounding error of a vertex evaluated in f32, relative to the sizes of all its
/// terms: two dozen roundings of 2⁻²⁴ each (the product of two matrices, of matrix and vertex, eight
/// joints or a handful of targets summed, the joints themselves rounded), and some to spare.
const F32_LOSS: f64 = 32.0 / 16_777_216.0;
/// Bound on the error by underflow, absolute.
const F32_UNDERFLOW: f64 = 64.0 * f32::MIN_POSITIVE as f64;

/// The linear part of a transform.
fn linear(t: &Transform) -> DMat3 {
    let [x, y, z] = t.linear.map(|c| DVec3::from(c.map(f64::from)));
    DMat3::from_cols(x, y, z)
}

/// Why bounds cannot be prepared.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum DeformError {
    /// A list that is not as long as the vertices.
    #[error("{what} are {count}, but there are {vertices} vertices; give one for each vertex")]
    Length {
        /// The array with the wrong length.
        what: String,
        /// How many were given.
        count: usize,
        /// How many vertices there are.
        vertices: usize,
    },
    /// A vertex is moved by a joint that is not there.
    #[error(
        "vertex {vertex} is moved by joint {joint}, but there are {joints} inverse bind matrices"
    )]
    Joint {
        /// The vertex with the wrong joint.
        vertex: usize,
        /// The joint it names with a weight that is not zero.
        joint: u16,
        /// How many joints there are.
        joints: usize,
    },
}
