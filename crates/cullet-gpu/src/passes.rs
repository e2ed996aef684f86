//! All passes, compiled once.

use wgpu::Device;

use super::clusters::ArgumentPass;
use super::counted::CountedPass;
use super::device::checked;
use super::error::GpuError;
use super::instances::InstancePass;
use super::lists::ListPass;
use super::occlusion::OcclusionPass;
use super::pyramid::PyramidPass;

/// All passes, compiled once for a device.
#[derive(Debug)]
pub struct Passes {
    /// Tests instances.
    pub instances: InstancePass,
    /// Makes lists.
    pub lists: ListPass,
    /// Makes pyramids.
    pub pyramid: PyramidPass,
    /// Tests against them.
    pub occlusion: OcclusionPass,
    /// Says of clusters whether they are drawn.
    pub arguments: ArgumentPass,
    /// Puts those that are drawn one after the other.
    pub counted: CountedPass,
}

impl Passes {
    /// Compiles them.
    ///
    /// # Errors
    /// If the device cannot run them.
    pub fn new(device: &Device) -> Result<Self, GpuError> {
        checked(device, || {
            let pyramid = PyramidPass::new(device);
            Self {
                instances: InstancePass::new(device),
                lists: ListPass::new(device),
                occlusion: OcclusionPass::new(device, &pyramid),
                arguments: ArgumentPass::new(device),
                counted: CountedPass::new(device),
                pyramid,
            }
        })
    }
}
