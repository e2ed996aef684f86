//! Depth of what was seen before, and the pyramid that is made of it.

use std::collections::HashMap;

use cullet_gpu::{GpuError, Pyramid, PyramidPass};
use eframe::wgpu::*;

use super::super::frame::Paint;
use super::super::pipelines::{Pipelines, slots_layout, vertices_layout};
use super::super::textures::DEPTH;

/// Pipelines that draw nothing but depth, reversed.
#[derive(Debug)]
pub(super) struct DepthPipelines {
    made: HashMap<(Option<Face>, u32), RenderPipeline>,
}

impl DepthPipelines {
    pub(super) fn new(device: &Device, pipelines: &Pipelines) -> Self {
        let faces = [None, Some(Face::Front), Some(Face::Back)];
        let ways = faces.into_iter().flat_map(|face| [(face, 1), (face, 4)]);
        Self { made: ways.map(|way| (way, make(device, pipelines, way))).collect() }
    }

    /// The pipeline that leaves out some faces, of so many samples a pixel.
    pub(super) fn get(&self, faces: Option<Face>, samples: u32) -> &RenderPipeline {
        &self.made[&(faces, samples)]
    }
}

fn make(
    device: &Device,
    pipelines: &Pipelines,
    (cull_mode, count): (Option<Face>, u32),
) -> RenderPipeline {
    // The paint that asks least of vertices.
    let constants = [("PAINT", f64::from(Paint::Depth as u32))];
    device.create_render_pipeline(&RenderPipelineDescriptor {
        label: Some("depth alone"),
        layout: Some(&pipelines.plain),
        vertex: VertexState {
            module: &pipelines.module,
            entry_point: Some("vs_indexed"),
            compilation_options: PipelineCompilationOptions {
                constants: &constants,
                ..PipelineCompilationOptions::default()
            },
            buffers: &[Some(vertices_layout()), Some(slots_layout())],
        },
        fragment: None,
        primitive: PrimitiveState { cull_mode, ..PrimitiveState::default() },
        depth_stencil: Some(DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(true),
            depth_compare: Some(CompareFunction::Greater),
            stencil: StencilState::default(),
            bias: DepthBiasState::default(),
        }),
        multisample: MultisampleState { count, ..MultisampleState::default() },
        multiview_mask: None,
        cache: None,
    })
}

/// Depth of a picture's size, and its pyramid.
#[derive(Debug)]
pub(super) struct Depth {
    size: [u32; 2],
    pub(super) samples: u32,
    view: TextureView,
    pub(super) pyramid: Pyramid,
}

impl Depth {
    pub(super) fn new(
        device: &Device,
        pass: &PyramidPass,
        size: [u32; 2],
        samples: u32,
    ) -> Result<Self, GpuError> {
        let [width, height] = size;
        let texture = device.create_texture(&TextureDescriptor {
            label: Some("depth of what was seen"),
            size: Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: samples,
            dimension: TextureDimension::D2,
            format: DEPTH,
            usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        let view = texture.create_view(&TextureViewDescriptor::default());
        let pyramid = Pyramid::new(device, pass, &texture)?;
        Ok(Self { size, samples, view, pyramid })
    }

    /// Whether it is of that size, with so many samples.
    pub(super) fn fits(&self, size: [u32; 2], samples: u32) -> bool {
        (self.size, self.samples) == (size, samples)
    }

    /// Begins to draw depth, over nothing.
    pub(super) fn begin<'e>(&self, encoder: &'e mut CommandEncoder) -> RenderPass<'e> {
        encoder.begin_render_pass(&RenderPassDescriptor {
            label: Some("depth alone"),
            color_attachments: &[],
            depth_stencil_attachment: Some(RenderPassDepthStencilAttachment {
                view: &self.view,
                depth_ops: Some(Operations { load: LoadOp::Clear(0.0), store: StoreOp::Store }),
                stencil_ops: None,
            }),
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        })
    }
}
