//! The passes that make lists of instances.

use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, BindGroupLayout, BindGroupLayoutDescriptor,
    BindGroupLayoutEntry, BindingType, Buffer, BufferBindingType, BufferDescriptor, BufferUsages,
    CommandEncoder, ComputePassDescriptor, ComputePipeline, ComputePipelineDescriptor, Device,
    PipelineLayoutDescriptor, Queue, ShaderModuleDescriptor, ShaderSource, ShaderStages,
};

use super::blocks::{BLOCK, Blocks};
use super::error::GpuError;
use super::grid::GridBox;
use super::planes::{BlockPlanes, GridPlane, InUse};

/// Workgroups in a row of a dispatch, as in the shader: 65,535 are the most along one dimension.
const ROW: u32 = 32768;

/// Pipelines that make lists of instances: seven storage buffers, no optional feature.
#[derive(Debug)]
pub struct InstancePass {
    layout: BindGroupLayout,
    test: ComputePipeline,
    scan: ComputePipeline,
    scatter: ComputePipeline,
}

/// The boxes of a scene on a device, and the list of one view.
#[derive(Debug)]
pub struct Lists {
    boxes: Buffer,
    in_use: Buffer,
    planes: Buffer,
    bits: Buffer,
    places: Buffer,
    /// Slots that are visible, ascending.
    list: Buffer,
    /// How many blocks are in use, and how many slots are visible.
    counts: Buffer,
    group: BindGroup,
    blocks: u32,
    most_planes: usize,
    uploaded: u64,
}

impl InstancePass {
    /// Compiles the passes.
    #[must_use]
    pub fn new(device: &Device) -> Self {
        let entry = |binding, read_only| BindGroupLayoutEntry {
            binding,
            visibility: ShaderStages::COMPUTE,
            ty: BindingType::Buffer {
                ty: BufferBindingType::Storage { read_only },
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        };
        let entries: Vec<_> = (0..7).map(|binding| entry(binding, binding < 3)).collect();
        let layout = device.create_bind_group_layout(&BindGroupLayoutDescriptor {
            label: Some("instances"),
            entries: &entries,
        });
        let of_all = device.create_pipeline_layout(&PipelineLayoutDescriptor {
            label: Some("instances"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let module = device.create_shader_module(ShaderModuleDescriptor {
            label: Some("instances"),
            source: ShaderSource::Wgsl(include_str!("shaders/instances.wgsl").into()),
        });
        let pipeline = |name| {
            device.create_compute_pipeline(&ComputePipelineDescriptor {
                label: Some(name),
                layout: Some(&of_all),
                module: &module,
                entry_point: Some(name),
                compilation_options: Default::default(),
                cache: None,
            })
        };
        let [test, scan, scatter] = ["test", "scan", "scatter"].map(pipeline);
        Self { layout, test, scan, scatter }
    }

    /// Records the passes of a view. Its list is right when they are done.
    pub fn record(&self, encoder: &mut CommandEncoder, lists: &Lists, planes: &BlockPlanes) {
        let blocks = planes.in_use().len() as u32;
        let rows = [blocks.min(ROW), blocks.div_ceil(ROW)];
        let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor {
            label: Some("instances"),
            timestamp_writes: None,
        });
        pass.set_bind_group(0, &lists.group, &[]);
        for (pipeline, [x, y]) in [(&self.test, rows), (&self.scan, [1, 1]), (&self.scatter, rows)]
        {
            if x > 0 {
                pass.set_pipeline(pipeline);
                pass.dispatch_workgroups(x, y, 1);
            }
        }
    }
}

impl Lists {
    /// Uploads the boxes of a scene, and makes room for its lists, with up to so many planes in a view. O(slots).
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
        let limits = device.limits();
        let limit = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size);
        let make = |what, items: usize, size: usize, more: BufferUsages| {
            let bytes = (items * size).max(16) as u64;
            if bytes > limit {
                return Err(GpuError::TooLarge { what, bytes, limit });
            }
            Ok(device.create_buffer(&BufferDescriptor {
                label: Some(what),
                size: bytes,
                usage: BufferUsages::STORAGE | more,
                mapped_at_creation: false,
            }))
        };
        let (to, from) = (BufferUsages::COPY_DST, BufferUsages::COPY_SRC);
        let none = BufferUsages::empty();
        let most_planes = most_planes.max(1);
        let boxes = make("boxes of instances", count * BLOCK, size_of::<GridBox>(), to)?;
        let in_use = make("blocks in use", count, size_of::<InUse>(), to)?;
        let planes = make("planes of blocks", count * most_planes, size_of::<GridPlane>(), to)?;
        let bits = make("bits of instances", count * BLOCK / 32, 4, none)?;
        let places = make("places of blocks", count, 4, none)?;
        let list = make("visible slots", count * BLOCK, 4, from)?;
        let counts = make("counts", 4, 4, to | from)?;
        let all = [&boxes, &in_use, &planes, &bits, &places, &list, &counts];
        let entries: Vec<_> = (0..)
            .zip(all)
            .map(|(binding, buffer)| BindGroupEntry {
                binding,
                resource: buffer.as_entire_binding(),
            })
            .collect();
        let group = device.create_bind_group(&BindGroupDescriptor {
            label: Some("instances"),
            layout: &pass.layout,
            entries: &entries,
        });
        queue.write_buffer(&boxes, 0, bytemuck::cast_slice(blocks.boxes()));
        let uploaded = size_of_val(blocks.boxes()) as u64;
        let blocks = blocks.grids().len() as u32;
        Ok(Self {
            boxes,
            in_use,
            planes,
            bits,
            places,
            list,
            counts,
            group,
            blocks,
            most_planes,
            uploaded,
        })
    }

    /// Uploads the blocks that [changed](Blocks::changed); false where the scene has more or fewer blocks than before, so that
    /// [new](Self::new) lists are needed.
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

    /// Uploads the blocks and planes of a view. To be called before the passes are [recorded](InstancePass::record); once between two submissions.
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
        let counts = [planes.in_use.len() as u32, 0, 0, 0];
        queue.write_buffer(&self.counts, 0, bytemuck::cast_slice(&counts));
        Ok(())
    }

    /// Slots that are visible, ascending, u32 each; as many as [counted](Self::counts).
    #[must_use]
    pub fn list(&self) -> &Buffer {
        &self.list
    }

    /// u32 each: how many blocks were tested, and how many slots are visible.
    #[must_use]
    pub fn counts(&self) -> &Buffer {
        &self.counts
    }

    /// Bytes of boxes that were uploaded the last time.
    #[must_use]
    pub fn uploaded(&self) -> u64 {
        self.uploaded
    }

    /// Bytes that all of it takes on the device.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        let all = [&self.boxes, &self.in_use, &self.planes, &self.bits, &self.places];
        let all = all.into_iter().chain([&self.list, &self.counts]);
        all.map(Buffer::size).sum()
    }
}
