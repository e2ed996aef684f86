//! Why what a file has baked is left out.

use cullet::lod::LevelsError;
use cullet::mesh::MeshError;
use cullet_mesh::ImpostorError;
use thiserror::Error;

/// Why what a file has baked is left out.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum BakedError {
    /// It is of another version.
    #[error(
        "version {found}, but only version {} is known: bake the model again, or read it with the program that baked it",
        super::VERSION
    )]
    Version {
        /// Its version.
        found: u64,
    },
    /// Its JSON is not as it should be: what, in words.
    #[error("{0}")]
    Form(String),
    /// Its bytes are not those that were written.
    #[error(
        "{what} has the sum {found:016x}, not {expected:016x}: it is damaged; bake the model again"
    )]
    Damaged {
        /// The damaged item.
        what: String,
        /// Sum that was found.
        found: u64,
        /// Sum that the file states.
        expected: u64,
    },
    /// It was baked of another mesh.
    #[error(
        "it was baked of another geometry ({expected:016x}, and the mesh is {found:016x}): the mesh was changed since; \
         bake the model again"
    )]
    Geometry {
        /// Geometry hash of the mesh in the file.
        found: u64,
        /// Geometry hash of the mesh that it was baked of.
        expected: u64,
    },
    /// A table whose size is none that it can have.
    #[error("{what} has {bytes} bytes, which is no multiple of {row}")]
    Size {
        /// Which.
        what: &'static str,
        /// How many it has.
        bytes: usize,
        /// Bytes of a row.
        row: usize,
    },
    /// Its triangles are not as many as its parts have, or its parts not those of the mesh.
    #[error("{what}: {found}, expected {expected}")]
    Count {
        /// The kind of item with the wrong count.
        what: &'static str,
        /// How many there are.
        found: u64,
        /// How many there should be.
        expected: u64,
    },
    /// A table that does not lie where it can be used as it is.
    #[error(
        "{what} begins at byte {at}, which is no multiple of {}: bake the model again",
        super::TABLE_ALIGNMENT
    )]
    Unaligned {
        /// Which.
        what: &'static str,
        /// Where it begins in the file.
        at: usize,
    },
    /// The mesh of the levels is none.
    #[error("the mesh of its levels: {0}")]
    Mesh(#[from] MeshError),
    /// The levels are none.
    #[error("its levels: {0}")]
    Levels(#[from] LevelsError),
    /// The impostor is none, or none of this mesh.
    #[error("its impostor: {0}")]
    Impostor(#[from] ImpostorError),
}
