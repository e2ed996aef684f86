//! Counts the samples that a frame covers, hidden ones too.

use std::collections::HashMap;

use cullet::{DrawList, View};
use cullet_gpu::{Culling, Gpu, GpuError};
use wgpu::*;

use super::drawing::Drawing;

/// Counters, each a part of the sum.
const COUNTERS: u64 = 256;

/// Draws without a depth test, and counts.
#[derive(Debug)]
pub(crate) struct Covered {
    pipelines: HashMap<Option<Face>, RenderPipeline>,
    counts: Buffer,
    group: BindGroup,
    nothing: TextureView,
}

impl Covered {
    /// For pictures of a size.
    pub(crate) fn new(gpu: &Gpu, drawing: &Drawing, size: [u32; 2]) -> Self {
        let device = &gpu.device;
        let layout = device.create_bind_group_layout(&BindGroupLayoutDescriptor {
            label: Some("covered"),
            entries: &[BindGroupLayoutEntry {
                binding: 0,
                visibility: ShaderStages::FRAGMENT,
                ty: BindingType::Buffer {
                    ty: BufferBindingType::Storage { read_only: false },
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            }],
        });
        let of_all = device.create_pipeline_layout(&PipelineLayoutDescriptor {
            label: Some("covered"),
            bind_group_layouts: &[Some(&drawing.layout), Some(&layout)],
            immediate_size: 0,
        });
        let make = |cull_mode| {
            device.create_render_pipeline(&RenderPipelineDescriptor {
                label: Some("covered"),
                layout: Some(&of_all),
                vertex: VertexState {
                    module: &drawing.module,
                    entry_point: None,
                    compilation_options: Default::default(),
                    buffers: &Culling::vertex_layouts().map(Some),
                },
                fragment: Some(FragmentState {
                    module: &drawing.module,
                    entry_point: Some("count"),
                    compilation_options: Default::default(),
                    targets: &[Some(ColorTargetState {
                        format: TextureFormat::R8Unorm,
                        blend: None,
                        write_mask: ColorWrites::empty(),
                    })],
                }),
                primitive: PrimitiveState { cull_mode, ..PrimitiveState::default() },
                depth_stencil: None,
                multisample: Default::default(),
                multiview_mask: None,
                cache: None,
            })
        };
        let faces = [None, Some(Face::Front), Some(Face::Back)];
        let counts = device.create_buffer(&BufferDescriptor {
            label: Some("covered"),
            size: COUNTERS * 4,
            usage: BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let group = device.create_bind_group(&BindGroupDescriptor {
            label: Some("covered"),
            layout: &layout,
            entries: &[BindGroupEntry { binding: 0, resource: counts.as_entire_binding() }],
        });
        Self {
            pipelines: faces.map(|f| (f, make(f))).into_iter().collect(),
            counts,
            group,
            nothing: super::drawing::target(device, size, TextureFormat::R8Unorm),
        }
    }

    /// Covered samples of a list that was uploaded.
    ///
    /// # Errors
    /// If the device is lost.
    pub(crate) fn count(
        &self,
        gpu: &Gpu,
        drawing: &Drawing,
        view: &View,
        list: &DrawList,
    ) -> Result<u64, GpuError> {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encoder.clear_buffer(&self.counts, 0, None);
        let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
            label: Some("covered"),
            color_attachments: &[Some(RenderPassColorAttachment {
                view: &self.nothing,
                depth_slice: None,
                resolve_target: None,
                ops: Operations { load: LoadOp::Clear(Color::BLACK), store: StoreOp::Discard },
            })],
            depth_stencil_attachment: None,
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        pass.set_bind_group(1, &self.group, &[]);
        drawing.draw(&mut pass, view, list, |faces, _| &self.pipelines[&faces], |n| n);
        drop(pass);
        gpu.queue.submit([encoder.finish()]);
        let counts = gpu.read(&self.counts, COUNTERS * 4)?;
        let number = |b: &[u8]| u64::from(u32::from_ne_bytes([b[0], b[1], b[2], b[3]]));
        Ok(counts.chunks_exact(4).map(number).sum())
    }
}
