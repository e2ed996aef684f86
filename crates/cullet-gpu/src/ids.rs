//! A renderer of numbers: which instance owns each pixel, and how deep it lies there.

use std::collections::HashMap;

use bytemuck::{Pod, Zeroable};
use cullet::{
    View,
    view::{CullFace, FrontFace},
};
use glam::{DMat4, DVec3, DVec4};
use wgpu::*;

use super::buffers::{Access, buffer, group, layout};
use super::checked::checked;
use super::culling::Culling;
use super::error::GpuError;
use super::geometry::{Draw, halves};
use super::occlusion::reversed_clip;
use super::tier::Tier;
use super::units::Phase;

/// WGSL of an [`EyeUniform`] at `@group(0) @binding(0)`, of the [places](super::GpuScene::places)
/// of a scene at `@binding(1)`, and of a function `placed(position: vec3<f32>, slot: u32) ->
/// vec3<f32>` that gives a point of an instance relative to the eye.
pub const PLACES: &str = include_str!("shaders/places.wgsl");

/// An eye, as shaders take it.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct EyeUniform {
    /// Reversed clip space from world space relative to the eye, column by column.
    pub clip: [[f32; 4]; 4],
    /// The high half of the eye, or of a point of the near plane where lines of sight are parallel.
    pub high: [f32; 4],
    /// Its low half.
    pub low: [f32; 4],
}

impl EyeUniform {
    /// The eye of a view. Depth is reversed, whichever the view's own is.
    #[must_use]
    pub fn new(view: &View) -> Self {
        let clip = reversed_clip(view);
        let [x, y, z, w] = view.eye();
        let eye = if w == 0.0 {
            let near = clip.inverse() * DVec4::new(0.0, 0.0, 1.0, 1.0);
            near.truncate() / near.w
        } else {
            DVec3::new(x, y, z)
        };
        let eye = if eye.is_finite() { eye } else { DVec3::ZERO };
        let [high, low] = halves(&eye.to_array());
        let wide = |v: [f32; 3]| [v[0], v[1], v[2], 0.0];
        Self {
            clip: (clip * DMat4::from_translation(eye)).as_mat4().to_cols_array_2d(),
            high: wide(high),
            low: wide(low),
        }
    }
}

/// The faces that graphics hardware is to cull of a draw in a view; `None` if no face is left.
#[must_use]
pub fn culled_faces(view: &View, draw: &Draw) -> Option<Option<Face>> {
    let clockwise = view.front_face == FrontFace::Clockwise;
    // The hardware's front is counter-clockwise on the screen.
    let flipped = (view.is_mirrored() != clockwise) != draw.kind.mirrored;
    Some(match view.cull_face {
        _ if draw.two_sided => None,
        CullFace::None => None,
        CullFace::Back if !flipped => Some(Face::Back),
        CullFace::Front if flipped => Some(Face::Back),
        _ => Some(Face::Front),
    })
}

/// Draws the number of an instance, its slot and one, into `R32Uint`, and depth, reversed, into
/// `Depth32Float`.
#[derive(Debug)]
pub struct IdPass {
    layout: BindGroupLayout,
    pipelines: HashMap<(Option<Face>, bool), RenderPipeline>,
}

/// Target of an [`IdPass`], for one scene and one size.
#[derive(Debug)]
pub struct IdTarget {
    ids: Texture,
    depth: Texture,
    eye: Buffer,
    group: BindGroup,
}

impl IdPass {
    /// Compiles the pass.
    ///
    /// # Errors
    /// If the device has not [`Tier::Compute`].
    pub fn new(device: &Device) -> Result<Self, GpuError> {
        Tier::Compute.demand(device)?;
        checked(device, || Self::compile(device))
    }

    fn compile(device: &Device) -> Self {
        let seen = ShaderStages::VERTEX;
        let entries = [Access::Uniform.entry(0, seen), Access::Read.entry(1, seen)];
        let layout = layout(device, "ids", &entries);
        let of_all = device.create_pipeline_layout(&PipelineLayoutDescriptor {
            label: Some("ids"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let module = device.create_shader_module(ShaderModuleDescriptor {
            label: Some("ids"),
            source: ShaderSource::Wgsl(
                format!("{PLACES}{}", include_str!("shaders/ids.wgsl")).into(),
            ),
        });
        let make = |cull_mode, blended: bool| {
            device.create_render_pipeline(&RenderPipelineDescriptor {
                label: Some("ids"),
                layout: Some(&of_all),
                vertex: VertexState {
                    module: &module,
                    entry_point: None,
                    compilation_options: Default::default(),
                    buffers: &Culling::vertex_layouts().map(Some),
                },
                fragment: Some(FragmentState {
                    module: &module,
                    entry_point: None,
                    compilation_options: Default::default(),
                    targets: &[Some(TextureFormat::R32Uint.into())],
                }),
                primitive: PrimitiveState { cull_mode, ..PrimitiveState::default() },
                depth_stencil: Some(DepthStencilState {
                    format: TextureFormat::Depth32Float,
                    // What is blended hides nothing.
                    depth_write_enabled: Some(!blended),
                    depth_compare: Some(CompareFunction::Greater),
                    stencil: Default::default(),
                    bias: Default::default(),
                }),
                multisample: Default::default(),
                multiview_mask: None,
                cache: None,
            })
        };
        let faces = [None, Some(Face::Front), Some(Face::Back)];
        let all = faces.into_iter().flat_map(|face| [(face, false), (face, true)]);
        let pipelines = all.map(|way| (way, make(way.0, way.1))).collect();
        Self { layout, pipelines }
    }

    /// Draws phases of a scene: over what is there, or over nothing where they are the first of a
    /// frame.
    pub fn draw(
        &self,
        encoder: &mut CommandEncoder,
        target: &IdTarget,
        (culling, view): (&Culling, &View),
        phases: &[Phase],
        first: bool,
    ) {
        let mut pass = self.begin(encoder, target, first);
        for phase in phases {
            culling.draw(&mut pass, *phase, |pass, draw| {
                let Some(faces) = culled_faces(view, draw) else { return false };
                pass.set_pipeline(self.pipeline(faces, draw.blended));
                true
            });
        }
    }

    /// The pipeline that culls some faces, of what is blended or not.
    #[must_use]
    pub fn pipeline(&self, faces: Option<Face>, blended: bool) -> &RenderPipeline {
        &self.pipelines[&(faces, blended)]
    }

    /// Begins a pass over what is there, or over nothing.
    pub fn begin<'e>(
        &self,
        encoder: &'e mut CommandEncoder,
        target: &IdTarget,
        first: bool,
    ) -> RenderPass<'e> {
        let [ids, depth] =
            [&target.ids, &target.depth].map(|t| t.create_view(&TextureViewDescriptor::default()));
        let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
            label: Some("ids"),
            color_attachments: &[Some(RenderPassColorAttachment {
                view: &ids,
                depth_slice: None,
                resolve_target: None,
                ops: Operations {
                    load: if first { LoadOp::Clear(Color::BLACK) } else { LoadOp::Load },
                    store: StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(RenderPassDepthStencilAttachment {
                view: &depth,
                depth_ops: Some(Operations {
                    load: if first { LoadOp::Clear(0.0) } else { LoadOp::Load },
                    store: StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        pass.set_bind_group(0, &target.group, &[]);
        pass
    }
}

impl IdTarget {
    /// Textures of a size, at least one pixel, to draw a scene into.
    ///
    /// # Errors
    /// If the device has no textures of that size, or no memory left for them.
    pub fn new(
        device: &Device,
        pass: &IdPass,
        culling: &Culling,
        [width, height]: [u32; 2],
    ) -> Result<Self, GpuError> {
        let limit = device.limits().max_texture_dimension_2d;
        if width.max(height) > limit {
            return Err(GpuError::Size { width, height, limit });
        }
        let texture = |label, format| {
            device.create_texture(&TextureDescriptor {
                label: Some(label),
                size: Extent3d {
                    width: width.max(1),
                    height: height.max(1),
                    depth_or_array_layers: 1,
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: TextureDimension::D2,
                format,
                usage: TextureUsages::RENDER_ATTACHMENT
                    | TextureUsages::TEXTURE_BINDING
                    | TextureUsages::COPY_SRC,
                view_formats: &[],
            })
        };
        let uniform = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        let eye = buffer(device, "eye", 1, size_of::<EyeUniform>(), uniform)?;
        let resources = [&eye, culling.scene().places()].map(|b| b.as_entire_binding());
        let group = group(device, "ids", &pass.layout, &resources);
        let all = [("ids", TextureFormat::R32Uint), ("depth", TextureFormat::Depth32Float)];
        let [ids, depth] = checked(device, || all.map(|(label, format)| texture(label, format)))?;
        Ok(Self { ids, depth, eye, group })
    }

    /// Uploads the eye of a view; once between two submissions.
    pub fn set(&self, queue: &Queue, view: &View) {
        queue.write_buffer(&self.eye, 0, bytemuck::bytes_of(&EyeUniform::new(view)));
    }

    /// Numbers: 0 where nothing is, else a slot and one.
    #[must_use]
    pub fn ids(&self) -> &Texture {
        &self.ids
    }

    /// Depth, reversed: 0 where nothing is.
    #[must_use]
    pub fn depth(&self) -> &Texture {
        &self.depth
    }
}
