//! All passes, compiled once.

use wgpu::Device;

use super::checked::{checked, checked_later, unchecked};
use super::clusters::ArgumentPass;
use super::cones::ConePass;
use super::counted::CountedPass;
use super::error::GpuError;
use super::instances::InstancePass;
use super::levels::LevelPass;
use super::lists::ListPass;
use super::occlusion::OcclusionPass;
use super::pyramid::PyramidPass;
use super::tier::Tier;

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
    /// Puts those that are drawn one after the other.
    pub counted: CountedPass,
    has_occlusion: bool,
}

impl Passes {
    /// Compiles them.
    ///
    /// # Errors
    /// If the device has not [`Tier::Pyramid`].
    pub fn new(device: &Device) -> Result<Self, GpuError> {
        Tier::Pyramid.demand(device)?;
        checked(device, || Self::made(device, true))
    }

    /// The same, awaited: in a browser, where nobody may wait, only this says whether the device
    /// can run them.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub async fn request(device: &Device) -> Result<Self, GpuError> {
        Tier::Pyramid.demand(device)?;
        checked_later(device, || Self::made(device, true)).await
    }

    /// Compiles them without tests against a pyramid: they list what is in the view, or what the
    /// CPU [decided](super::Culling::decide). Not in browsers.
    ///
    /// # Errors
    /// If the device has not [`Tier::Compute`].
    pub fn without_occlusion(device: &Device) -> Result<Self, GpuError> {
        Tier::Compute.demand(device)?;
        checked(device, || Self::made(device, false))
    }

    /// Whether they test against a pyramid; where not,
    /// [`Culling::record_late`](super::Culling::record_late) is not valid.
    #[must_use]
    pub fn has_occlusion(&self) -> bool {
        self.has_occlusion
    }

    fn made(device: &Device, has_occlusion: bool) -> Self {
        let of_pyramid = || {
            let pyramid = PyramidPass::new(device);
            (OcclusionPass::new(device, &pyramid), pyramid)
        };
        let (occlusion, pyramid) =
            if has_occlusion { of_pyramid() } else { unchecked(device, of_pyramid) };
        let instances = InstancePass::new(device);
        Self {
            cones: ConePass::new(device, &instances),
            instances,
            levels: LevelPass::new(device),
            lists: ListPass::new(device),
            arguments: ArgumentPass::new(device),
            counted: CountedPass::new(device),
            occlusion,
            pyramid,
            has_occlusion,
        }
    }
}
