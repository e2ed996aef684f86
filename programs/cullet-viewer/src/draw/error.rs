//! Why a scene cannot be drawn.

use thiserror::Error;

/// Why a scene does not fit the graphics device. What was drawn before stays as it was.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum DrawError {
    /// The instances, parts or meshes' corners need a larger texture than the device has.
    #[error(
        "{count} {what} are more than the {limit} that this device's largest texture \
         ({side}×{side}) holds; try a native window, or a part of the scene"
    )]
    Texture {
        /// The kind of item of which there are too many.
        what: &'static str,
        /// How many.
        count: u64,
        /// How many at the most.
        limit: u64,
        /// The side of the device's largest texture (`max_texture_dimension_2d`).
        side: u32,
    },
    /// One mesh does not fit the device's largest buffer or texture.
    #[error(
        "mesh {mesh} ({name}) needs {count} {what}, but this device takes {limit} of one mesh \
         ({cause}); try a native window, or split or simplify the mesh"
    )]
    Mesh {
        /// The number of the mesh.
        mesh: usize,
        /// Its name, or nothing.
        name: String,
        /// The elements of which it has too many.
        what: &'static str,
        /// How many.
        count: u64,
        /// How many at the most.
        limit: u64,
        /// The device's limit that stands in the way.
        cause: &'static str,
    },
    /// The buffers of the device's decision do not fit, or it cannot run the passes.
    #[error("the device cannot decide what is drawn: {0}")]
    Device(String),
}
