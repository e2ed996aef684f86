//! The pass that tests instances, and their boxes on the device.

use wgpu::{
    BindGroup, BindGroupLayout, Buffer, BufferUsages, CommandEncoder, ComputePassDescriptor,
    ComputePipeline, Device, Queue,
};

use super::blocks::{BLOCK, Blocks};
use super::buffers::{Access, buffer, buffers_layout, dispatch_rows, group, pipelines};
use super::error::GpuError;
use super::grid::GridBox;
use super::grid_plane::GridPlane;
use super::planes::{BlockPlanes, InUse};

/// The pipeline that tests instances: four storage buffers, no optional feature.
#[derive(Debug)]
pub struct InstancePass {
    layout: BindGroupLayout,
    test: ComputePipeline,
}

/// The boxes of a scene on a device, and a bit for each slot: whether one view keeps it.
#[derive(Debug)]
pub struct InstanceBits {
    boxes: Buffer,
    in_use: Buffer,
    planes: Buffer,
    bits: Buffer,
    view: Buffer,
    group: BindGroup,
    blocks: u32,
    most_planes: usize,
    uploaded: u64,
}

impl InstancePass {
    /// Compiles the pass.
    pub(crate) fn new(device: &Device) -> Self {
        const ACCESS: [Access; 5] =
            [Access::Read, Access::Read, Access::Read, Access::Write, Access::Uniform];
        let layout = buffers_layout(device, "instances", &ACCESS);
        let source =
            concat!(include_str!("shaders/boxes.wgsl"), include_str!("shaders/instances.wgsl"));
        let [test] = pipelines(device, "instances", source, &[&layout], &[], ["test"]);
        Self { layout, test }
    }

    /// Records the test of a view, of the planes that were [set](InstanceBits::set) last.
    pub fn record(&self, encoder: &mut CommandEncoder, to: &InstanceBits, planes: &BlockPlanes) {
        to.record(encoder, &self.test, None, planes);
    }

    /// Returns the layout for pipelines that do the same and more.
    pub(crate) fn layout(&self) -> &BindGroupLayout {
        &self.layout
    }
}

impl InstanceBits {
    /// Uploads the boxes of a scene, and makes room for up to so many planes in a view. O(slots).
    ///
    /// # Errors
    /// If a buffer would be larger than the device allows.
    pub fn new(
        device: &Device,
        queue: &Queue,
        pass: &InstancePass,
        blocks: &Blocks,
        most_planes: usize,
    ) -> Result<Self, GpuError> {
        let count = blocks.grids().len().max(1);
        let most_planes = most_planes.max(1);
        let written = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        let make = |what, items, size, usage| buffer(device, what, items, size, usage);
        let boxes = make("boxes of instances", count * BLOCK, size_of::<GridBox>(), written)?;
        let in_use = make("blocks in use", count, size_of::<InUse>(), written)?;
        let most = count.saturating_mul(most_planes);
        let planes = make("planes of blocks", most, size_of::<GridPlane>(), written)?;
        let copied = written | BufferUsages::COPY_SRC;
        let bits = make("bits of slots", count * BLOCK / 32, 4, copied)?;
        let view = make("view", 4, 4, BufferUsages::UNIFORM | BufferUsages::COPY_DST)?;
        let all = [&boxes, &in_use, &planes, &bits, &view].map(|b| b.as_entire_binding());
        let group = group(device, "instances", &pass.layout, &all);
        queue.write_buffer(&boxes, 0, bytemuck::cast_slice(blocks.boxes()));
        let uploaded = size_of_val(blocks.boxes()) as u64;
        let blocks = blocks.grids().len() as u32;
        Ok(Self { boxes, in_use, planes, bits, view, group, blocks, most_planes, uploaded })
    }

    /// Uploads the blocks that [changed](Blocks::changed); false where the scene has more or fewer
    /// blocks than before, so that all has to be made [anew](Self::new).
    #[must_use]
    pub fn update(&mut self, queue: &Queue, blocks: &Blocks) -> bool {
        if blocks.grids().len() as u32 != self.blocks {
            return false;
        }
        self.uploaded = 0;
        for run in blocks.changed().chunk_by(|a, b| a + 1 == *b) {
            let first = run[0] as usize * BLOCK;
            let changed = &blocks.boxes()[first..first + run.len() * BLOCK];
            let offset = (first * size_of::<GridBox>()) as u64;
            queue.write_buffer(&self.boxes, offset, bytemuck::cast_slice(changed));
            self.uploaded += size_of_val(changed) as u64;
        }
        true
    }

    /// Uploads the blocks and planes of a view. To be called before the pass is
    /// [recorded](InstancePass::record); once between two submissions.
    ///
    /// # Errors
    /// If it has more planes than room was made for.
    pub fn set(&mut self, queue: &Queue, planes: &BlockPlanes) -> Result<(), GpuError> {
        let all = self.blocks as usize * self.most_planes;
        if planes.planes.len() > all {
            let bytes = size_of_val(&planes.planes[..]) as u64;
            let limit = (all * size_of::<GridPlane>()) as u64;
            return Err(GpuError::TooLarge { what: "planes of blocks", bytes, limit });
        }
        queue.write_buffer(&self.in_use, 0, bytemuck::cast_slice(&planes.in_use));
        queue.write_buffer(&self.planes, 0, bytemuck::cast_slice(&planes.planes));
        let view = [planes.in_use.len() as u32, planes.layers(), 0, 0];
        queue.write_buffer(&self.view, 0, bytemuck::cast_slice(&view));
        Ok(())
    }

    /// Records a test by a pipeline, of bind group 0, and of 1 where it needs more.
    pub(crate) fn record(
        &self,
        encoder: &mut CommandEncoder,
        pipeline: &ComputePipeline,
        more: Option<&BindGroup>,
        planes: &BlockPlanes,
    ) {
        encoder.clear_buffer(&self.bits, 0, None);
        let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor {
            label: Some("instances"),
            timestamp_writes: None,
        });
        pass.set_bind_group(0, &self.group, &[]);
        if more.is_some() {
            pass.set_bind_group(1, more, &[]);
        }
        dispatch_rows(&mut pass, pipeline, planes.in_use().len() as u32);
    }

    /// A bit a slot, lowest first: whether the view keeps it.
    #[must_use]
    pub fn bits(&self) -> &Buffer {
        &self.bits
    }

    /// Boxes by slot, and the blocks in use, for passes that look at them again.
    pub(crate) fn boxes_in_use(&self) -> [&Buffer; 2] {
        [&self.boxes, &self.in_use]
    }

    /// Bytes of boxes that were uploaded the last time.
    #[must_use]
    pub fn uploaded(&self) -> u64 {
        self.uploaded
    }

    /// Bytes that all of it takes on the device.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        let all = [&self.boxes, &self.in_use, &self.planes, &self.bits, &self.view];
        all.into_iter().map(Buffer::size).sum()
    }
}
