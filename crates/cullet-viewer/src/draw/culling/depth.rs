//! Depth of what was seen before, and the pyramid that is made of it.

use std::collections::HashMap;

use cullet_gpu::{Pyramid, PyramidPass};
use eframe::wgpu::*;

use super::super::frame::Paint;
use super::super::pipelines::{Pipelines, slots_layout, vertices_layout};
use super::super::textures::DEPTH;

/// The farthest of the samples of each pixel, so that a pyramid of one sample a pixel is conservative for all.
const FARTHEST: &str = "
@group(0) @binding(0) var samples: texture_depth_multisampled_2d;

// One triangle over all of the target.
@vertex fn vs(@builtin(vertex_index) n: u32) -> @builtin(position) vec4<f32> {
    return vec4<f32>(f32(n & 1u) * 4.0 - 1.0, f32(n >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment fn fs(@builtin(position) at: vec4<f32>) -> @builtin(frag_depth) f32 {
    var far = 1.0;
    for (var i = 0; i < 4; i++) { far = min(far, textureLoad(samples, vec2<u32>(at.xy), i)); }
    return far;
}";

/// Pipelines that draw nothing but depth, reversed.
#[derive(Debug)]
pub(super) struct DepthPipelines {
    made: HashMap<(Option<Face>, u32), RenderPipeline>,
    farthest: RenderPipeline,
}

impl DepthPipelines {
    pub(super) fn new(device: &Device, pipelines: &Pipelines) -> Self {
        let faces = [None, Some(Face::Front), Some(Face::Back)];
        let ways = faces.into_iter().flat_map(|face| [(face, 1), (face, 4)]);
        let module = device.create_shader_module(ShaderModuleDescriptor {
            label: Some("farthest of samples"),
            source: ShaderSource::Wgsl(FARTHEST.into()),
        });
        let farthest = device.create_render_pipeline(&RenderPipelineDescriptor {
            label: Some("farthest of samples"),
            layout: None,
            vertex: VertexState {
                module: &module,
                entry_point: Some("vs"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            fragment: Some(FragmentState {
                module: &module,
                entry_point: Some("fs"),
                compilation_options: Default::default(),
                targets: &[],
            }),
            primitive: PrimitiveState::default(),
            depth_stencil: Some(written(CompareFunction::Always)),
            multisample: MultisampleState::default(),
            multiview_mask: None,
            cache: None,
        });
        Self { made: ways.map(|way| (way, make(device, pipelines, way))).collect(), farthest }
    }

    /// The pipeline that leaves out some faces, of so many samples a pixel.
    pub(super) fn get(&self, faces: Option<Face>, samples: u32) -> &RenderPipeline {
        &self.made[&(faces, samples)]
    }
}

fn written(compare: CompareFunction) -> DepthStencilState {
    DepthStencilState {
        format: DEPTH,
        depth_write_enabled: Some(true),
        depth_compare: Some(compare),
        stencil: StencilState::default(),
        bias: DepthBiasState::default(),
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
        depth_stencil: Some(written(CompareFunction::Greater)),
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
    /// One sample a pixel; what the pyramid is made of.
    single: TextureView,
    /// Where there are several samples, these, and how a shader sees them.
    many: Option<(TextureView, BindGroup)>,
    pub(super) pyramid: Pyramid,
}

impl Depth {
    pub(super) fn new(
        device: &Device,
        pass: &PyramidPass,
        pipelines: &DepthPipelines,
        size: [u32; 2],
        samples: u32,
    ) -> Self {
        let make = |label, sample_count| {
            let [width, height] = size;
            device.create_texture(&TextureDescriptor {
                label: Some(label),
                size: Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count,
                dimension: TextureDimension::D2,
                format: DEPTH,
                usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            })
        };
        let single = make("depth of what was seen", 1);
        let many = (samples > 1).then(|| {
            let view = make("samples of depth", samples).create_view(&Default::default());
            let group = device.create_bind_group(&BindGroupDescriptor {
                label: Some("samples of depth"),
                layout: &pipelines.farthest.get_bind_group_layout(0),
                entries: &[BindGroupEntry {
                    binding: 0,
                    resource: BindingResource::TextureView(&view),
                }],
            });
            (view, group)
        });
        let pyramid = Pyramid::new(device, pass, &single);
        Self { size, samples, single: single.create_view(&Default::default()), many, pyramid }
    }

    /// Whether it is of that size, with so many samples.
    pub(super) fn fits(&self, size: [u32; 2], samples: u32) -> bool {
        (self.size, self.samples) == (size, samples)
    }

    /// Begins to draw depth, over nothing.
    pub(super) fn begin<'e>(&self, encoder: &'e mut CommandEncoder) -> RenderPass<'e> {
        begin(encoder, self.many.as_ref().map_or(&self.single, |(view, _)| view))
    }

    /// Records how one sample a pixel is made of several.
    pub(super) fn resolve(&self, encoder: &mut CommandEncoder, pipelines: &DepthPipelines) {
        if let Some((_, group)) = &self.many {
            let mut pass = begin(encoder, &self.single);
            pass.set_pipeline(&pipelines.farthest);
            pass.set_bind_group(0, group, &[]);
            pass.draw(0..3, 0..1);
        }
    }
}

fn begin<'e>(encoder: &'e mut CommandEncoder, view: &TextureView) -> RenderPass<'e> {
    encoder.begin_render_pass(&RenderPassDescriptor {
        label: Some("depth alone"),
        color_attachments: &[],
        depth_stencil_attachment: Some(RenderPassDepthStencilAttachment {
            view,
            depth_ops: Some(Operations { load: LoadOp::Clear(0.0), store: StoreOp::Store }),
            stencil_ops: None,
        }),
        timestamp_writes: None,
        occlusion_query_set: None,
        multiview_mask: None,
    })
}
