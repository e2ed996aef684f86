//! A level of the depth pyramid as a picture, in the greys of
//! [`Paint::Depth`](super::super::frame::Paint).

use std::collections::HashMap;

use bytemuck::{Pod, Zeroable};
use cullet::View;
use cullet_gpu::Pyramid;
use eframe::wgpu::*;
use glam::{DMat4, DVec3};

use super::super::textures::{COLOUR, DEPTH, Target};

/// The shader's `Shown`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Shown {
    world: [[f32; 4]; 4],
    sight: [f32; 4],
    place: [f32; 4],
    size: [f32; 2],
    half: f32,
    level: u32,
}

const _: () = assert!(size_of::<Shown>() == 112);

impl Shown {
    /// A level of the pyramid of a view's picture, at a place of the target, in a scene of some
    /// radius.
    pub(super) fn new(view: &View, (place, level): ([u32; 4], u32), radius: f32) -> Self {
        let [x, y, z, w] = view.eye();
        let is_parallel = w == 0.0;
        // What distances are measured from: the eye, or what is in the middle of the near plane.
        let clip = DMat4::from_cols_array(&view.world_from_clip());
        let eye = if is_parallel {
            clip.project_point3(DVec3::new(0.0, 0.0, 1.0))
        } else {
            DVec3::new(x, y, z)
        };
        let world = (DMat4::from_translation(-eye) * clip).as_mat4();
        Self {
            world: world.to_cols_array_2d(),
            sight: if is_parallel { [x as f32, y as f32, z as f32, 1.0] } else { [0.0; 4] },
            place: place.map(|v| v as f32),
            size: view.viewport().map(|v| v as f32),
            half: radius * 0.5,
            level,
        }
    }
}

/// Shows levels of a pyramid.
#[derive(Debug)]
pub(super) struct Picture {
    module: ShaderModule,
    layout: BindGroupLayout,
    /// Pipelines by the samples a pixel of their target.
    pipelines: HashMap<u32, RenderPipeline>,
    shown: Buffer,
    group: Option<BindGroup>,
}

impl Picture {
    pub(super) fn new(device: &Device) -> Self {
        let module = device.create_shader_module(ShaderModuleDescriptor {
            label: Some("pyramid as a picture"),
            source: ShaderSource::Wgsl(include_str!("../pyramid.wgsl").into()),
        });
        let entry = |binding, ty| BindGroupLayoutEntry {
            binding,
            visibility: ShaderStages::FRAGMENT,
            ty,
            count: None,
        };
        let uniform = BindingType::Buffer {
            ty: BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let texture = BindingType::Texture {
            sample_type: TextureSampleType::Float { filterable: false },
            view_dimension: TextureViewDimension::D2,
            multisampled: false,
        };
        let layout = device.create_bind_group_layout(&BindGroupLayoutDescriptor {
            label: Some("pyramid as a picture"),
            entries: &[entry(0, uniform), entry(1, texture)],
        });
        let shown = device.create_buffer(&BufferDescriptor {
            label: Some("which level is shown"),
            size: size_of::<Shown>() as u64,
            usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Self { module, layout, pipelines: HashMap::new(), shown, group: None }
    }

    /// Shows that pyramid from now on.
    pub(super) fn follow(&mut self, device: &Device, pyramid: &Pyramid) {
        let view = pyramid.texture().create_view(&Default::default());
        let entries = [
            BindGroupEntry { binding: 0, resource: self.shown.as_entire_binding() },
            BindGroupEntry { binding: 1, resource: BindingResource::TextureView(&view) },
        ];
        self.group = Some(device.create_bind_group(&BindGroupDescriptor {
            label: Some("pyramid as a picture"),
            layout: &self.layout,
            entries: &entries,
        }));
    }

    /// Uploads what is shown; once between two submissions.
    pub(super) fn set(&self, queue: &Queue, shown: &Shown) {
        queue.write_buffer(&self.shown, 0, bytemuck::bytes_of(shown));
    }

    /// Draws it at a place, as far as that lies in the target.
    pub(super) fn draw(
        &mut self,
        device: &Device,
        pass: &mut RenderPass<'_>,
        [x, y, width, height]: [u32; 4],
        target: &Target,
    ) {
        let [right, bottom] = [x.saturating_add(width), y.saturating_add(height)];
        let [right, bottom] = [right.min(target.size[0]), bottom.min(target.size[1])];
        let Some(group) = self.group.as_ref().filter(|_| x < right && y < bottom) else { return };
        let make = || pipeline(device, &self.module, &self.layout, target.samples);
        pass.set_pipeline(self.pipelines.entry(target.samples).or_insert_with(make));
        pass.set_bind_group(0, group, &[]);
        pass.set_viewport(x as f32, y as f32, width as f32, height as f32, 0.0, 1.0);
        pass.set_scissor_rect(x, y, right - x, bottom - y);
        pass.draw(0..3, 0..1);
    }
}

fn pipeline(
    device: &Device,
    module: &ShaderModule,
    layout: &BindGroupLayout,
    count: u32,
) -> RenderPipeline {
    let layout = device.create_pipeline_layout(&PipelineLayoutDescriptor {
        label: Some("pyramid as a picture"),
        bind_group_layouts: &[Some(layout)],
        immediate_size: 0,
    });
    device.create_render_pipeline(&RenderPipelineDescriptor {
        label: Some("pyramid as a picture"),
        layout: Some(&layout),
        vertex: VertexState {
            module,
            entry_point: Some("vs"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        fragment: Some(FragmentState {
            module,
            entry_point: Some("fs"),
            compilation_options: Default::default(),
            targets: &[Some(COLOUR.into())],
        }),
        primitive: PrimitiveState::default(),
        depth_stencil: Some(DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(false),
            depth_compare: Some(CompareFunction::Always),
            stencil: StencilState::default(),
            bias: DepthBiasState::default(),
        }),
        multisample: MultisampleState { count, ..MultisampleState::default() },
        multiview_mask: None,
        cache: None,
    })
}
