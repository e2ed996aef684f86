//! On a page the CPU decides what is drawn: WebGL2 has no compute shaders, and a page draws the
//! same with all that it may find.

use cullet::Scene;
use eframe::wgpu::{Adapter, BindGroup, CommandEncoder, Device, Queue, RenderPass};

use super::error::DrawError;
use super::frame::{DeviceFigures, DeviceView};
use super::groups::Kind;
use super::pipelines::Pipelines;
use super::textures::Target;
use super::upload::Uploaded;

/// Why.
const WHY: &str = "on a page the CPU decides; the window can do both";

/// There is none.
#[derive(Debug)]
pub(super) enum DeviceCulling {}

/// A draw of one that there is not.
#[derive(Debug)]
pub(super) struct ListedDraw {
    pub(super) kind: Kind,
    pub(super) chunk: u32,
    pub(super) two_sided: bool,
    pub(super) blended: bool,
}

impl DeviceCulling {
    pub(super) fn refused(_: &Adapter) -> Option<String> {
        Some(WHY.to_owned())
    }

    pub(super) fn new(
        _: &Device,
        _: &Queue,
        _: &Pipelines,
        _: (&Scene, &Uploaded),
    ) -> Result<Self, DrawError> {
        Err(DrawError::Device(WHY.to_owned()))
    }

    pub(super) fn set(&mut self, _: &Device, _: &Queue, _: &DeviceView<'_>, _: (f32, u32)) -> bool {
        match *self {}
    }

    pub(super) fn record(
        &mut self,
        _: &Queue,
        _: &mut CommandEncoder,
        _: (&BindGroup, u32),
        _: &Uploaded,
        _: &DeviceView<'_>,
    ) {
        match *self {}
    }

    pub(super) fn draws(&self) -> &[ListedDraw] {
        match *self {}
    }

    pub(super) fn draw(&self, _: &mut RenderPass<'_>, _: &ListedDraw, _: bool) {
        match *self {}
    }

    pub(super) fn draw_pyramid(
        &mut self,
        _: &Device,
        _: &mut RenderPass<'_>,
        _: &DeviceView<'_>,
        _: &Target,
    ) {
        match *self {}
    }

    pub(super) fn submitted(&self) {
        match *self {}
    }

    pub(super) fn figures(&self) -> DeviceFigures {
        match *self {}
    }

    pub(super) fn frames(&self) -> u64 {
        match *self {}
    }
}
