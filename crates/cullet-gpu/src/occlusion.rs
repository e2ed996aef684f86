//! The late phase: which of what passed the exact stages is not hidden by what was drawn.

use bytemuck::{Pod, Zeroable};
use cullet::{Depth, View};
use glam::{DMat4, DVec3};
use wgpu::{
    BindGroup, BindGroupLayout, Buffer, BufferUsages, CommandEncoder, ComputePassDescriptor,
    ComputePipeline, Device, Queue,
};

use super::blocks::{BLOCK, Blocks};
use super::buffers::{Access, buffer, buffers_layout, dispatch_rows, group, pipelines};
use super::error::GpuError;
use super::grid::GridBox;
use super::instances::InstanceBits;
use super::planes::BlockPlanes;
use super::pyramid::{Pyramid, PyramidPass, of_depths};
use super::tier::GROUP;

/// The pipeline that tests instances against a pyramid: seven storage buffers and two textures, no
/// optional feature.
#[derive(Debug)]
pub struct OcclusionPass {
    layout: BindGroupLayout,
    /// Pipelines for blocks and for their contents, for depth of one sample a pixel and of several.
    late: [[ComputePipeline; 2]; 2],
}

/// Visible bits of one view: a bit a slot, and what the test needs.
#[derive(Debug)]
pub struct VisibleBits {
    matrices: Buffer,
    around: Buffer,
    visible: Buffer,
    frame: Buffer,
    group: BindGroup,
    /// Kept from frame to frame, so that none is allocated.
    scratch: Vec<[[f32; 4]; 4]>,
    boxes: Vec<GridBox>,
}

/// The shader's `Frame`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct Frame {
    size: [f32; 2],
    inset: f32,
    blocks: u32,
}

impl OcclusionPass {
    /// Compiles the pass.
    pub(crate) fn new(device: &Device, pyramid: &PyramidPass) -> Self {
        Self::made(device, pyramid, false)
    }

    /// The same for pyramids whose sizes are rounded down, to see that it hides what is visible.
    #[doc(hidden)]
    #[must_use]
    pub fn clamped(device: &Device, pyramid: &PyramidPass) -> Self {
        Self::made(device, pyramid, true)
    }

    fn made(device: &Device, pyramid: &PyramidPass, clamped: bool) -> Self {
        const ACCESS: [Access; 8] = [
            Access::Read,
            Access::Read,
            Access::Read,
            Access::Read,
            Access::Write,
            Access::Uniform,
            Access::Read,
            Access::Write,
        ];
        let layout = buffers_layout(device, "occlusion", &ACCESS);
        let constants = [("CLAMPED", f64::from(u8::from(clamped)))];
        let late = |source, has_several| {
            let layouts = [&layout, pyramid.depth(has_several), pyramid.levels()];
            let names = ["blocks", "late"];
            pipelines(device, "occlusion", source, &layouts, &constants, names)
        };
        let [one, many] = of_depths!("shaders/boxes.wgsl", "shaders/occlusion.wgsl");
        let late = [late(one, false), late(many, true)];
        Self { layout, late }
    }

    /// Records the test of what passed against a pyramid of the size that was
    /// [set](VisibleBits::set).
    pub fn record(
        &self,
        encoder: &mut CommandEncoder,
        to: &VisibleBits,
        planes: &BlockPlanes,
        pyramid: &Pyramid,
    ) {
        encoder.clear_buffer(&to.visible, 0, None);
        let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor {
            label: Some("occlusion"),
            timestamp_writes: None,
        });
        pass.set_bind_group(0, &to.group, &[]);
        pass.set_bind_group(1, pyramid.depth(), &[]);
        pass.set_bind_group(2, pyramid.levels(), &[]);
        let [blocks, late] = &self.late[usize::from(pyramid.has_several())];
        let count = planes.in_use().len() as u32;
        dispatch_rows(&mut pass, blocks, count.div_ceil(GROUP));
        dispatch_rows(&mut pass, late, count);
    }
}

impl VisibleBits {
    /// Room for a bit a slot of those whose boxes were uploaded.
    ///
    /// # Errors
    /// If a buffer would be larger than the device allows.
    pub fn new(
        device: &Device,
        pass: &OcclusionPass,
        blocks: &Blocks,
        passed: &InstanceBits,
    ) -> Result<Self, GpuError> {
        let count = blocks.grids().len().max(1);
        let written = BufferUsages::COPY_DST;
        let storage = BufferUsages::STORAGE | written;
        let matrices = buffer(device, "matrices of blocks", count, 64, storage)?;
        let around = buffer(device, "boxes of blocks", count, size_of::<GridBox>(), storage)?;
        let hidden = buffer(device, "hidden blocks", count, 4, BufferUsages::STORAGE)?;
        let bits = storage | BufferUsages::COPY_SRC;
        let visible = buffer(device, "visible slots", count * BLOCK / 32, 4, bits)?;
        let frame = buffer(device, "frame", 4, 4, BufferUsages::UNIFORM | written)?;
        let [boxes, in_use] = passed.boxes_in_use();
        let resources =
            [boxes, in_use, &matrices, passed.bits(), &visible, &frame, &around, &hidden]
                .map(|b| b.as_entire_binding());
        let group = group(device, "occlusion", &pass.layout, &resources);
        let (scratch, own) = (Vec::new(), Vec::new());
        Ok(Self { matrices, around, visible, frame, group, scratch, boxes: own })
    }

    /// Uploads the matrices of a view of a scene with some origin, for a picture of a size and of
    /// so many samples a pixel. To be called once between two submissions.
    pub fn set(
        &mut self,
        queue: &Queue,
        (blocks, planes): (&Blocks, &BlockPlanes),
        (view, origin): (&View, [f64; 3]),
        (size, samples): ([u32; 2], u32),
    ) {
        let clip = reversed_clip(view) * DMat4::from_translation(DVec3::from(origin));
        let of_block = |block: u32| {
            let (grid, _) = blocks.grids()[block as usize];
            let to_grid = DMat4::from_translation(DVec3::from(grid.origin))
                * DMat4::from_scale(DVec3::splat(grid.step));
            // One that is not finite makes no corner lie before the near plane: nothing is hidden.
            let matrix = (clip * to_grid).as_mat4();
            if matrix.is_finite() { matrix.to_cols_array_2d() } else { [[0.0; 4]; 4] }
        };
        self.scratch.clear();
        self.scratch.extend(planes.in_use().iter().map(|own| of_block(own.block)));
        queue.write_buffer(&self.matrices, 0, bytemuck::cast_slice(&self.scratch));
        self.boxes.clear();
        self.boxes.extend(planes.in_use().iter().map(|own| {
            let (grid, around) = &blocks.grids()[own.block as usize];
            // The grid was made around it.
            grid.round_out(around).unwrap_or(GridBox::ALWAYS)
        }));
        queue.write_buffer(&self.around, 0, bytemuck::cast_slice(&self.boxes));
        let frame = Frame {
            size: size.map(|v| v as f32),
            inset: if samples > 1 { 0.0 } else { 0.5 },
            blocks: planes.in_use().len() as u32,
        };
        queue.write_buffer(&self.frame, 0, bytemuck::bytes_of(&frame));
    }

    /// A bit a slot, lowest first.
    #[must_use]
    pub fn bits(&self) -> &Buffer {
        &self.visible
    }
}

/// World to clip space with reversed depth, whichever the view's own is.
pub(crate) fn reversed_clip(view: &View) -> DMat4 {
    let clip = DMat4::from_cols_array(&view.clip_from_world());
    match view.depth() {
        Depth::Reversed => clip,
        // z is w − z.
        Depth::Standard => {
            let mut turned = DMat4::IDENTITY;
            (turned.z_axis.z, turned.w_axis.z) = (-1.0, 1.0);
            // The last column is multiplied by w.
            turned * clip
        }
    }
}
