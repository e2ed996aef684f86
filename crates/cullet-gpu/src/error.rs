//! Errors of a device.

use wgpu::Device;

use super::tier::{Lack, Tier};

/// Error of a device, and what can be done about it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// No adapter has the tier.
    #[error("no graphics adapter can {tier}: {found}; {cure}, or let the CPU decide")]
    NoAdapter {
        /// The least tier that was wanted.
        tier: Tier,
        /// The adapters that were found, and what each lacks.
        found: String,
        /// Remedy: what to install or set.
        cure: String,
    },
    /// It cannot be opened.
    #[error("the adapter {adapter} cannot be opened: {why}")]
    NoDevice {
        /// Its name.
        adapter: String,
        /// Reason that the device gives.
        why: String,
    },
    /// The device does not have the tier, or was opened with less.
    #[error(
        "this device cannot {tier}: {lack}; open it with the limits and features that its adapter has (Gpu::open), choose another adapter, \
         a lower tier (Passes::without_occlusion, DrawMode::of), or let the CPU decide"
    )]
    Tier {
        /// The tier.
        tier: Tier,
        /// Capability that is missing.
        lack: Lack,
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
        /// The item that is too large.
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
    /// A shader, a pipeline or what they bind was refused.
    #[error(
        "this device cannot run the passes: {0}; choose another with WGPU_BACKEND, or let the CPU decide"
    )]
    Passes(String),
    /// Something that was made or recorded was refused, which is found when the device is waited
    /// for.
    #[error("the device refused its work: {0}; what it drew or listed is not valid")]
    Refused(String),
    /// It went away while it worked.
    #[error("the device was lost: {0}; open another, and upload the scene again")]
    Lost(String),
}

impl Tier {
    /// Returns an error unless an opened device has this tier.
    ///
    /// # Errors
    /// [`GpuError::Tier`], which names what is missing.
    pub fn demand(self, device: &Device) -> Result<(), GpuError> {
        let lack = self.lack_of_device(device);
        lack.map_or(Ok(()), |lack| Err(GpuError::Tier { tier: self, lack }))
    }
}
