//! A scene drawn without a window: all that a frame needs, in one place.

use cullet::{Scene, View, Visible};
use wgpu::{CommandEncoder, Device, Queue};

use super::culling::Culling;
use super::error::GpuError;
use super::ids::{IdPass, IdTarget};
use super::passes::Passes;
use super::pyramid::Pyramid;
use super::units::{DrawMode, Phase};

/// A scene on a device, drawn as numbers and depth into textures of its own.
///
/// Its parts are for those who draw in another way: [`record`](Self::record) is how they are used.
#[derive(Debug)]
pub struct OffScreen {
    /// Passes that decide.
    pub passes: Passes,
    /// The scene.
    pub culling: Culling,
    /// Pass that draws.
    pub ids: IdPass,
    /// Target that is drawn into.
    pub target: IdTarget,
    /// Pyramid of the target's depth.
    pub pyramid: Pyramid,
    size: [u32; 2],
}

impl OffScreen {
    /// Uploads a scene, to be drawn as suits it and the device. O(triangles + slots log slots).
    ///
    /// # Errors
    /// If it does not fit the device.
    pub fn new(
        device: &Device,
        queue: &Queue,
        scene: &Scene,
        size: [u32; 2],
    ) -> Result<Self, GpuError> {
        Self::with_mode(device, queue, scene, size, DrawMode::of(device, scene))
    }

    /// The same in another way.
    ///
    /// # Errors
    /// As [`new`](Self::new), and if the device does not have the mode.
    pub fn with_mode(
        device: &Device,
        queue: &Queue,
        scene: &Scene,
        size: [u32; 2],
        mode: DrawMode,
    ) -> Result<Self, GpuError> {
        Self::with_passes((device, queue, Passes::new(device)?), scene, size, mode)
    }

    /// The same with passes of one's own, such as those [without
    /// occlusion](Passes::without_occlusion): then the CPU [decides](Self::draw_decided), or
    /// everything in the view is drawn.
    ///
    /// # Errors
    /// As [`with_mode`](Self::with_mode).
    pub fn with_passes(
        (device, queue, passes): (&Device, &Queue, Passes),
        scene: &Scene,
        size: [u32; 2],
        mode: DrawMode,
    ) -> Result<Self, GpuError> {
        let ids = IdPass::new(device)?;
        let culling = Culling::with_mode(device, queue, &passes, scene, mode)?;
        let (target, pyramid) = pictures(device, (&passes, &ids, &culling), size)?;
        Ok(Self { passes, culling, ids, target, pyramid, size })
    }

    /// Follows a scene whose instances moved, came or went; see [`Culling::follow`].
    ///
    /// # Errors
    /// If it does not fit the device.
    pub fn follow(
        &mut self,
        device: &Device,
        queue: &Queue,
        scene: &Scene,
    ) -> Result<(), GpuError> {
        if self.culling.follow(device, queue, &self.passes, scene)? {
            self.resize(device, self.size)?;
        }
        Ok(())
    }

    /// Draws a view of its own size, with occlusion culling or without, and hands it in. Pictures
    /// are made anew for another size.
    ///
    /// # Errors
    /// If there are no textures of that size, or the view has too many planes, or the passes are
    /// without occlusion and it is asked for.
    pub fn draw(
        &mut self,
        device: &Device,
        queue: &Queue,
        (scene, view): (&Scene, &View),
        occlusion: bool,
    ) -> Result<(), GpuError> {
        if occlusion && !self.passes.has_occlusion() {
            let why = "they were made without occlusion".to_owned();
            return Err(GpuError::Passes(why));
        }
        self.set(device, queue, (scene, view))?;
        let mut encoder = device.create_command_encoder(&Default::default());
        self.record(&mut encoder, view, occlusion);
        queue.submit([encoder.finish()]);
        Ok(())
    }

    /// The same of what the CPU [decided](Culling::decide).
    ///
    /// # Errors
    /// As [`draw`](Self::draw).
    pub fn draw_decided(
        &mut self,
        device: &Device,
        queue: &Queue,
        (scene, view): (&Scene, &View),
        visible: &Visible,
    ) -> Result<(), GpuError> {
        self.set(device, queue, (scene, view))?;
        self.culling.decide(queue, scene, visible);
        let mut encoder = device.create_command_encoder(&Default::default());
        self.culling.record_decided(&self.passes, &mut encoder);
        let on = (&self.culling, view);
        self.ids.draw(&mut encoder, &self.target, on, &[Phase::Late, Phase::Blended], true);
        queue.submit([encoder.finish()]);
        Ok(())
    }

    fn resize(&mut self, device: &Device, size: [u32; 2]) -> Result<(), GpuError> {
        let of = (&self.passes, &self.ids, &self.culling);
        (self.target, self.pyramid) = pictures(device, of, size)?;
        self.size = size;
        Ok(())
    }

    fn set(
        &mut self,
        device: &Device,
        queue: &Queue,
        (scene, view): (&Scene, &View),
    ) -> Result<(), GpuError> {
        if view.viewport() != self.size {
            self.resize(device, view.viewport())?;
        }
        self.culling.set(queue, scene, view, 1)?;
        self.target.set(queue, view);
        Ok(())
    }

    /// Records a frame of a view that was set in culling and target.
    pub fn record(&self, encoder: &mut CommandEncoder, view: &View, occlusion: bool) {
        let on = (&self.culling, view);
        let rest = [Phase::Late, Phase::Blended];
        if occlusion {
            self.culling.record_early(&self.passes, encoder);
            self.ids.draw(encoder, &self.target, on, &[Phase::Early], true);
            self.culling.record_late(&self.passes, encoder, &self.pyramid);
        } else {
            self.culling.record_all(&self.passes, encoder);
        }
        self.ids.draw(encoder, &self.target, on, &rest, !occlusion);
    }
}

/// Makes the pictures that a scene is drawn into.
fn pictures(
    device: &Device,
    (passes, ids, culling): (&Passes, &IdPass, &Culling),
    size: [u32; 2],
) -> Result<(IdTarget, Pyramid), GpuError> {
    let target = IdTarget::new(device, ids, culling, size)?;
    let pyramid = Pyramid::new(device, &passes.pyramid, target.depth())?;
    Ok((target, pyramid))
}
