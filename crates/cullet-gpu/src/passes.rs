//! All passes, compiled once.

use wgpu::{Device, Limits};

use super::buffers::{GROUP, ROW};
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

/// Of the pass that takes most.
const MOST_STORAGE_BUFFERS: u32 = 8;

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
    /// If the device cannot run them, or was opened with limits below theirs.
    pub fn new(device: &Device) -> Result<Self, GpuError> {
        suits(&device.limits())?;
        checked(device, || Self::made(device, true))
    }

    /// The same, awaited: in a browser, where nobody may wait, only this says whether the device can run them.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub async fn request(device: &Device) -> Result<Self, GpuError> {
        suits(&device.limits())?;
        checked_later(device, || Self::made(device, true)).await
    }

    /// The same without tests against a pyramid, for a device that cannot read a depth texture, as OpenGL cannot: it lists what is in the
    /// view, or what the CPU [decided](super::Culling::decide). Not in browsers.
    ///
    /// # Errors
    /// As [`new`](Self::new), but for those of the pyramid.
    pub fn without_occlusion(device: &Device) -> Result<Self, GpuError> {
        suits(&device.limits())?;
        checked(device, || Self::made(device, false))
    }

    /// Whether they test against a pyramid; where not, [`Culling::record_late`](super::Culling::record_late) is not valid.
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

/// Whether a device has what the passes take, which is no more than any device for [WebGPU](https://www.w3.org/TR/webgpu/#limits) has.
pub(crate) fn suits(limits: &Limits) -> Result<(), GpuError> {
    let taken = [
        (
            "storage buffers a shader stage",
            MOST_STORAGE_BUFFERS,
            limits.max_storage_buffers_per_shader_stage,
        ),
        ("invocations a workgroup", GROUP, limits.max_compute_invocations_per_workgroup),
        ("invocations of a workgroup along x", GROUP, limits.max_compute_workgroup_size_x),
        ("workgroups a dimension", ROW, limits.max_compute_workgroups_per_dimension),
        ("storage textures a shader stage", 1, limits.max_storage_textures_per_shader_stage),
    ];
    for (what, needed, limit) in taken {
        if limit < needed {
            return Err(GpuError::Limit { what, needed, limit });
        }
    }
    Ok(())
}
