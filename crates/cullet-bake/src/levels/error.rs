//! Why levels cannot be made.

use cullet::mesh::MeshError;
use thiserror::Error;

/// Why levels cannot be made.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum LevelsError {
    /// The mesh itself is invalid.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The mesh extends too far for distances in single precision.
    #[error("the mesh extends over {extent:e}, more than {limit:e}; scale it down")]
    TooLarge {
        /// Its longest side.
        extent: f64,
        /// The longest allowed.
        limit: f64,
    },
    /// A slice that must hold so much for each vertex, or for each cluster, does not.
    #[error("{what}: {count} values, not {expected}")]
    Length {
        /// The array with the wrong length.
        what: &'static str,
        /// How many there are.
        count: usize,
        /// How many there must be.
        expected: usize,
    },
    /// An option out of range.
    #[error("option {what} is {value}; it must be {allowed}")]
    Value {
        /// Name of the option.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The values that are allowed.
        allowed: &'static str,
    },
    /// An attribute of a vertex that is NaN or infinite.
    #[error("attribute {attribute} of vertex {vertex} is {value}")]
    Attribute {
        /// The vertex.
        vertex: usize,
        /// The attribute of that vertex.
        attribute: usize,
        /// Its value.
        value: f32,
    },
    /// Levels that do not fit their mesh.
    #[error(transparent)]
    Unfit(#[from] cullet::lod::LevelsError),
    /// Levels together have more triangles than 32-bit numbers hold.
    #[error("levels of {triangles} triangles may exceed the limit of {limit}; split the mesh")]
    TooMany {
        /// Triangles of the base mesh.
        triangles: usize,
        /// The most that are allowed.
        limit: usize,
    },
}
