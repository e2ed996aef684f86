//! What can go wrong with a device.

/// What can go wrong with a device, and what can be done.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// There is none.
    #[error(
        "no graphics adapter was found ({0}); on Linux without a graphics card, install mesa-vulkan-drivers"
    )]
    NoAdapter(String),
    /// It cannot be opened.
    #[error("the adapter {adapter} cannot be opened: {why}")]
    NoDevice {
        /// Its name.
        adapter: String,
        /// What it says.
        why: String,
    },
    /// It was opened with less than the passes take.
    #[error(
        "these passes take {needed} {what}, but this device was opened with {limit}; ask for the limits of its adapter, or let the CPU decide"
    )]
    Limit {
        /// Of what.
        what: &'static str,
        /// How many they take.
        needed: u32,
        /// How many it has.
        limit: u32,
    },
    /// It has no memory left.
    #[error(
        "the device is out of memory: {0}; close other programs that draw, draw in parts, or let the CPU decide"
    )]
    OutOfMemory(String),
    /// Something is larger than a buffer may be.
    #[error(
        "{what}: {bytes} bytes, but a buffer of this device has at most {limit}; open it with the limits of its adapter \
         (max_buffer_size, max_storage_buffer_binding_size), draw in parts, or let the CPU decide"
    )]
    TooLarge {
        /// What it is.
        what: &'static str,
        /// How many bytes it takes.
        bytes: u64,
        /// How many there may be.
        limit: u64,
    },
    /// A picture is larger than a texture may be.
    #[error(
        "a picture of {width} x {height} pixels, but a texture of this device has at most {limit} a side; draw it in parts"
    )]
    Size {
        /// Pixels of a row.
        width: u32,
        /// Rows.
        height: u32,
        /// The most that a side may have.
        limit: u32,
    },
    /// The device was opened without what a tier takes.
    #[error(
        "this device was opened without {missing:?}; open it with that, if its adapter has it, or take the tier that suits it (Tier::of)"
    )]
    Tier {
        /// What it takes and the device has not.
        missing: wgpu::Features,
    },
    /// An index of a triangle has no position.
    #[error("index {index}, but there are {vertices} positions; indices count from 0")]
    Index {
        /// The index.
        index: u32,
        /// How many positions there are.
        vertices: usize,
    },
    /// Indices are not three for each triangle of the groups.
    #[error(
        "{indices} indices, but three for each of the {grouped} triangles in groups are needed"
    )]
    Groups {
        /// How many indices there are.
        indices: usize,
        /// How many triangles the groups have together.
        grouped: u64,
    },
    /// It cannot run the passes, as OpenGL cannot, where no compute shader reads a depth texture.
    #[error(
        "this device cannot run the passes: {0}; choose another with WGPU_BACKEND, or let the CPU decide"
    )]
    Passes(String),
    /// It went away while it worked.
    #[error("the device was lost: {0}; open another, and upload the scene again")]
    Lost(String),
}
