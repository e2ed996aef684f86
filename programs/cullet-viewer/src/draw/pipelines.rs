//! Pipelines, made when they are first needed and kept.

use std::collections::HashMap;

use eframe::wgpu::*;

use super::frame::Paint;
use super::textures::{COLOUR, DEPTH};

/// Where vertices come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum VertexSource {
    /// Vertex and index buffers.
    Indexed,
    /// Textures, three corners a triangle.
    Pulled,
    /// Vertex and index buffers, the boxes of impostors.
    Impostors,
    /// Textures, a line a triangle.
    FaceNormals,
    /// Textures, a line a vertex.
    VertexNormals,
    /// Lines of the caller.
    Lines,
    /// Translucent triangles of the caller.
    Ghosts,
    /// A triangle over the whole pane.
    Clear,
}

/// Blending of a fragment's colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Mix {
    /// It replaces.
    Replace,
    /// It covers by its alpha.
    Alpha,
    /// It adds.
    Add,
}

/// Depth test and depth write of fragments.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Near {
    /// The nearer wins.
    Write,
    /// The nearer is drawn, and hides nothing.
    Test,
    /// All are drawn.
    Ignore,
    /// All are drawn, and their depth is kept.
    Overwrite,
}

/// One way of drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct PipelineKey {
    pub(super) source: VertexSource,
    /// The quantity that colours triangles of the scene.
    pub(super) paint: Paint,
    /// Whether fragments may be discarded, or edges are drawn.
    pub(super) cut: bool,
    pub(super) mix: Mix,
    pub(super) near: Near,
    pub(super) cull: Option<Face>,
    pub(super) reversed: bool,
    pub(super) samples: u32,
}

/// The pipelines of a device.
#[derive(Debug)]
pub(super) struct Pipelines {
    pub(super) module: ShaderModule,
    pub(super) plain: PipelineLayout,
    /// For shaders that take corners from textures.
    pulling: PipelineLayout,
    /// For shaders that follow rays through impostors.
    tracing: PipelineLayout,
    /// For what a pane shares: numbers, transforms, colours.
    pub(super) pane_layout: BindGroupLayout,
    /// For the corners of a chunk's triangles.
    pub(super) chunk_layout: BindGroupLayout,
    /// For the impostors of a scene.
    pub(super) impostor_layout: BindGroupLayout,
    made: HashMap<PipelineKey, RenderPipeline>,
}

/// Shaders that a scene may need. A page has no impostors, so it does not load and check their
/// shader.
#[cfg(not(target_arch = "wasm32"))]
const SHADERS: &str = concat!(include_str!("scene.wgsl"), include_str!("impostor.wgsl"));
#[cfg(target_arch = "wasm32")]
const SHADERS: &str = include_str!("scene.wgsl");

/// Vertices, as [`VertexSource::Indexed`] takes them.
pub(super) fn vertices_layout() -> VertexBufferLayout<'static> {
    const ATTRIBUTES: [VertexAttribute; 2] = vertex_attr_array![0 => Float32x3, 1 => Uint32];
    VertexBufferLayout {
        array_stride: 16,
        step_mode: VertexStepMode::Vertex,
        attributes: &ATTRIBUTES,
    }
}

/// Slots of instances.
pub(super) fn slots_layout() -> VertexBufferLayout<'static> {
    const ATTRIBUTES: [VertexAttribute; 1] = vertex_attr_array![2 => Uint32];
    VertexBufferLayout {
        array_stride: 4,
        step_mode: VertexStepMode::Instance,
        attributes: &ATTRIBUTES,
    }
}

impl VertexSource {
    /// Whether it makes triangles of the scene.
    pub(super) fn is_painted(self) -> bool {
        matches!(self, Self::Indexed | Self::Pulled | Self::Impostors)
    }
}

impl Pipelines {
    pub(super) fn new(device: &Device, uniform_size: u64) -> Self {
        let module = device.create_shader_module(ShaderModuleDescriptor {
            label: Some("scene"),
            source: ShaderSource::Wgsl(SHADERS.into()),
        });
        let texture = |binding, sample_type| BindGroupLayoutEntry {
            binding,
            // The fragments of impostors read what the vertices of others do.
            visibility: ShaderStages::VERTEX_FRAGMENT,
            ty: BindingType::Texture {
                sample_type,
                view_dimension: TextureViewDimension::D2,
                multisampled: false,
            },
            count: None,
        };
        let float = TextureSampleType::Float { filterable: false };
        let layout = |label, entries: &[BindGroupLayoutEntry]| {
            device.create_bind_group_layout(&BindGroupLayoutDescriptor {
                label: Some(label),
                entries,
            })
        };
        let uniform = BindGroupLayoutEntry {
            binding: 0,
            visibility: ShaderStages::VERTEX_FRAGMENT,
            ty: BindingType::Buffer {
                ty: BufferBindingType::Uniform,
                has_dynamic_offset: true,
                min_binding_size: BufferSize::new(uniform_size),
            },
            count: None,
        };
        let pane_layout =
            layout("pane", &[uniform, texture(1, float), texture(2, float), texture(3, float)]);
        let uint = TextureSampleType::Uint;
        let chunk_layout =
            layout("chunk", &[texture(0, uint), texture(1, uint), texture(2, float)]);
        let impostor_layout = layout("impostors", &[texture(3, uint), texture(4, float)]);
        let layout = |label, layouts: &[Option<&BindGroupLayout>]| {
            device.create_pipeline_layout(&PipelineLayoutDescriptor {
                label: Some(label),
                bind_group_layouts: layouts,
                immediate_size: 0,
            })
        };
        let plain = layout("plain", &[Some(&pane_layout)]);
        let pulling = layout("pulling", &[Some(&pane_layout), Some(&chunk_layout)]);
        let tracing = layout("tracing", &[Some(&pane_layout), Some(&impostor_layout)]);
        let made = HashMap::new();
        Self { module, plain, pulling, tracing, pane_layout, chunk_layout, impostor_layout, made }
    }

    /// The pipeline of a way of drawing.
    pub(super) fn get(&mut self, device: &Device, way: PipelineKey) -> RenderPipeline {
        if let Some(made) = self.made.get(&way) {
            return made.clone();
        }
        let made = self.make(device, way);
        self.made.insert(way, made.clone());
        made
    }

    fn make(&self, device: &Device, way: PipelineKey) -> RenderPipeline {
        let (vertices, slots) = (vertices_layout(), slots_layout());
        let lines = VertexBufferLayout {
            array_stride: 16,
            step_mode: VertexStepMode::Vertex,
            attributes: &vertex_attr_array![0 => Float32x3, 1 => Unorm8x4],
        };
        let triangles = PrimitiveTopology::TriangleList;
        let (entry, topology, buffers) = match way.source {
            VertexSource::Indexed => ("vs_indexed", triangles, vec![Some(vertices), Some(slots)]),
            VertexSource::Impostors => {
                ("vs_impostor", triangles, vec![Some(vertices), Some(slots)])
            }
            VertexSource::Pulled => ("vs_pulled", triangles, vec![Some(slots)]),
            VertexSource::FaceNormals => {
                ("vs_face_normal", PrimitiveTopology::LineList, vec![Some(slots)])
            }
            VertexSource::VertexNormals => {
                ("vs_vertex_normal", PrimitiveTopology::LineList, vec![Some(slots)])
            }
            VertexSource::Lines => ("vs_line", PrimitiveTopology::LineList, vec![Some(lines)]),
            VertexSource::Ghosts => ("vs_line", triangles, vec![Some(lines)]),
            VertexSource::Clear => ("vs_clear", triangles, vec![]),
        };
        let fragment = match way.source {
            VertexSource::Impostors => "fs_impostor",
            source if source.is_painted() && way.cut => "fs_cut",
            source if source.is_painted() => "fs_fill",
            _ => "fs_line",
        };
        let blend = match way.mix {
            Mix::Replace => None,
            Mix::Alpha => Some(BlendState::ALPHA_BLENDING),
            Mix::Add => {
                let add = BlendComponent {
                    src_factor: BlendFactor::One,
                    dst_factor: BlendFactor::One,
                    operation: BlendOperation::Add,
                };
                Some(BlendState { color: add, alpha: add })
            }
        };
        let constants = [("PAINT", f64::from(way.paint as u32))];
        let compilation_options = PipelineCompilationOptions {
            constants: &constants,
            ..PipelineCompilationOptions::default()
        };
        let nearer = if way.reversed { CompareFunction::Greater } else { CompareFunction::Less };
        let (write, compare) = match way.near {
            Near::Write => (true, nearer),
            Near::Test => (false, nearer),
            Near::Ignore => (false, CompareFunction::Always),
            Near::Overwrite => (true, CompareFunction::Always),
        };
        device.create_render_pipeline(&RenderPipelineDescriptor {
            label: Some(entry),
            layout: Some(match way.source {
                VertexSource::Pulled | VertexSource::FaceNormals | VertexSource::VertexNormals => {
                    &self.pulling
                }
                VertexSource::Impostors => &self.tracing,
                VertexSource::Indexed
                | VertexSource::Lines
                | VertexSource::Ghosts
                | VertexSource::Clear => &self.plain,
            }),
            vertex: VertexState {
                module: &self.module,
                entry_point: Some(entry),
                compilation_options: compilation_options.clone(),
                buffers: &buffers,
            },
            primitive: PrimitiveState {
                topology,
                cull_mode: way.cull,
                ..PrimitiveState::default()
            },
            depth_stencil: Some(DepthStencilState {
                format: DEPTH,
                depth_write_enabled: Some(write),
                depth_compare: Some(compare),
                stencil: StencilState::default(),
                bias: DepthBiasState::default(),
            }),
            multisample: MultisampleState { count: way.samples, ..MultisampleState::default() },
            fragment: Some(FragmentState {
                module: &self.module,
                entry_point: Some(fragment),
                compilation_options,
                targets: &[Some(ColorTargetState {
                    format: COLOUR,
                    blend,
                    write_mask: ColorWrites::ALL,
                })],
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}
