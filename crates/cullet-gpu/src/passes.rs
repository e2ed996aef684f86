//! All passes, compiled once.

use wgpu::Device;

use super::clusters::ArgumentPass;
use super::cones::ConePass;
use super::device::checked;
use super::error::GpuError;
use super::instances::InstancePass;
use super::levels::LevelPass;
use super::lists::ListPass;
use super::occlusion::OcclusionPass;
use super::pyramid::PyramidPass;

/// All passes, compiled once for a device.
#[derive(Debug)]
pub struct Passes {
    /// Tests instances.
    pub instances: InstancePass,
    /// Tests which clusters face away.
    pub cones: ConePass,
    /// Chooses levels of detail.
    pub levels: LevelPass,
    /// Makes lists.
    pub lists: ListPass,
    /// Makes pyramids.
    pub pyramid: PyramidPass,
    /// Tests against them.
    pub occlusion: OcclusionPass,
    /// Says of clusters whether they are drawn.
    pub arguments: ArgumentPass,
}

impl Passes {
    /// Compiles them.
    ///
    /// # Errors
    /// If the device cannot run them.
    pub fn new(device: &Device) -> Result<Self, GpuError> {
        checked(device, || {
            let pyramid = PyramidPass::new(device);
            let instances = InstancePass::new(device);
            Self {
                cones: ConePass::new(device, &instances),
                instances,
                levels: LevelPass::new(device),
                lists: ListPass::new(device),
                occlusion: OcclusionPass::new(device, &pyramid),
                arguments: ArgumentPass::new(device),
                pyramid,
            }
        })
    }
}
