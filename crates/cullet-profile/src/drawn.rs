//! Frames of a scene: culled by the CPU as told, drawn by the device.

use cullet::{Culler, Scene, View, ViewState, Visible};
use cullet_gpu::{Culling, EyeUniform, Gpu, GpuError, Passes, Phase, Tier, culled_faces};
use wgpu::*;

use super::link::Link;
use super::measure::Workload;

/// A scene, drawn in one view.
#[derive(Debug)]
pub struct Drawn<'a> {
    scene: &'a Scene,
    view: View,
    culler: Option<Culler>,
    state: ViewState,
    visible: Visible,
    passes: Passes,
    culling: Culling,
    draw: Drawing,
    /// Where uploads go that are dropped.
    spare: Buffer,
}

/// Pipelines, and what they draw into and with.
#[derive(Debug)]
struct Drawing {
    /// By faces that are culled: none, front, back.
    pipelines: [RenderPipeline; 3],
    eye: Buffer,
    /// As it is, and with the vertices' work doubled.
    groups: [BindGroup; 2],
    /// As large as it is, and of twice the area.
    targets: [[TextureView; 2]; 2],
}

impl<'a> Drawn<'a> {
    /// Uploads a scene, to be drawn in a view of it; without a culler everything is drawn that is in the view's layers.
    ///
    /// # Errors
    /// If it does not fit the device.
    pub fn new(
        gpu: &Gpu,
        scene: &'a Scene,
        view: &View,
        culler: Option<Culler>,
    ) -> Result<Self, GpuError> {
        let passes = Passes::new(&gpu.device)?;
        let tier = Tier::of(&gpu.device, scene);
        let culling = Culling::with_tier(&gpu.device, &gpu.queue, &passes, scene, tier)?;
        let draw = Drawing::new(gpu, &culling, view.viewport());
        let spare = gpu.device.create_buffer(&BufferDescriptor {
            label: Some("spare"),
            size: culling.visible().size(),
            usage: BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Ok(Self {
            scene,
            view: view.clone(),
            culler,
            state: ViewState::default(),
            visible: Visible::default(),
            passes,
            culling,
            draw,
            spare,
        })
    }

    /// What the culler listed last.
    #[must_use]
    pub fn visible(&self) -> &Visible {
        &self.visible
    }

    /// Culls, and records the frame.
    fn record(&mut self, gpu: &Gpu, doubled: Option<Link>) -> CommandBuffer {
        if let Some(culler) = &self.culler {
            culler.cull_one(self.scene, &self.view, &mut self.state, &mut self.visible);
        }
        let twice = |link| usize::from(doubled == Some(link));
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        if self.culler.is_some() {
            self.culling.record_decided(&self.passes, &mut encoder);
        } else {
            self.culling.record_all(&self.passes, &mut encoder);
        }
        let [colour, depth] = &self.draw.targets[twice(Link::Fill)];
        let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
            label: Some("frame"),
            color_attachments: &[Some(RenderPassColorAttachment {
                view: colour,
                depth_slice: None,
                resolve_target: None,
                ops: Operations { load: LoadOp::Clear(Color::BLACK), store: StoreOp::Store },
            })],
            depth_stencil_attachment: Some(RenderPassDepthStencilAttachment {
                view: depth,
                depth_ops: Some(Operations { load: LoadOp::Clear(0.0), store: StoreOp::Store }),
                stencil_ops: None,
            }),
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        pass.set_bind_group(0, &self.draw.groups[twice(Link::Transform)], &[]);
        for phase in [Phase::Late, Phase::Blended] {
            self.culling.draw(&mut pass, phase, |pass, draw| {
                let Some(faces) = culled_faces(&self.view, draw) else { return false };
                let at = match faces {
                    None => 0,
                    Some(Face::Front) => 1,
                    Some(Face::Back) => 2,
                };
                pass.set_pipeline(&self.draw.pipelines[at]);
                true
            });
        }
        drop(pass);
        encoder.finish()
    }
}

impl Workload for Drawn<'_> {
    fn frame(&mut self, gpu: &Gpu, doubled: Option<Link>) -> Result<SubmissionIndex, GpuError> {
        self.culling.set(&gpu.queue, self.scene, &self.view, 1)?;
        let eye = EyeUniform::new(&self.view);
        gpu.queue.write_buffer(&self.draw.eye, 0, bytemuck::bytes_of(&eye));
        let commands = self.record(gpu, doubled);
        if self.culler.is_some() {
            self.culling.decide(&gpu.queue, self.scene, &self.visible);
            if doubled == Some(Link::Bus) {
                let bytes = vec![0_u8; self.spare.size() as usize];
                gpu.queue.write_buffer(&self.spare, 0, &bytes);
            }
        }
        if doubled == Some(Link::Cpu) {
            drop(self.record(gpu, doubled));
        }
        Ok(gpu.queue.submit([commands]))
    }
}

impl Drawing {
    fn new(gpu: &Gpu, culling: &Culling, size: [u32; 2]) -> Self {
        let device = &gpu.device;
        let module = device.create_shader_module(ShaderModuleDescriptor {
            label: Some("frame"),
            source: ShaderSource::Wgsl(include_str!("frame.wgsl").into()),
        });
        let entry = |binding, ty| BindGroupLayoutEntry {
            binding,
            visibility: ShaderStages::VERTEX,
            ty: BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
            count: None,
        };
        let read = BufferBindingType::Storage { read_only: true };
        let uniform = BufferBindingType::Uniform;
        let layout = device.create_bind_group_layout(&BindGroupLayoutDescriptor {
            label: Some("frame"),
            entries: &[entry(0, uniform), entry(1, read), entry(2, uniform)],
        });
        let of_all = device.create_pipeline_layout(&PipelineLayoutDescriptor {
            label: Some("frame"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let pipelines = [None, Some(Face::Front), Some(Face::Back)].map(|cull_mode| {
            device.create_render_pipeline(&RenderPipelineDescriptor {
                label: Some("frame"),
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
                    targets: &[Some(TextureFormat::Rgba8Unorm.into())],
                }),
                primitive: PrimitiveState { cull_mode, ..PrimitiveState::default() },
                depth_stencil: Some(DepthStencilState {
                    format: TextureFormat::Depth32Float,
                    depth_write_enabled: Some(true),
                    depth_compare: Some(CompareFunction::Greater),
                    stencil: Default::default(),
                    bias: Default::default(),
                }),
                multisample: Default::default(),
                multiview_mask: None,
                cache: None,
            })
        });
        let buffer = |size| {
            device.create_buffer(&BufferDescriptor {
                label: Some("frame"),
                size,
                usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        let eye = buffer(size_of::<EyeUniform>() as u64);
        let groups = [1_u32, 2].map(|times| {
            let loops = buffer(16);
            gpu.queue.write_buffer(&loops, 0, bytemuck::cast_slice(&[times, 0, 0, 0]));
            device.create_bind_group(&BindGroupDescriptor {
                label: Some("frame"),
                layout: &layout,
                entries: &[
                    BindGroupEntry { binding: 0, resource: eye.as_entire_binding() },
                    BindGroupEntry {
                        binding: 1,
                        resource: culling.scene().places().as_entire_binding(),
                    },
                    BindGroupEntry { binding: 2, resource: loops.as_entire_binding() },
                ],
            })
        });
        let target = |[width, height]: [u32; 2], format| {
            let texture = device.create_texture(&TextureDescriptor {
                label: Some("frame"),
                size: Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: TextureDimension::D2,
                format,
                usage: TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            });
            texture.create_view(&TextureViewDescriptor::default())
        };
        let twice = size.map(|v| (f64::from(v) * std::f64::consts::SQRT_2).round() as u32);
        let targets = [size, twice].map(|size| {
            [TextureFormat::Rgba8Unorm, TextureFormat::Depth32Float].map(|f| target(size, f))
        });
        Self { pipelines, eye, groups, targets }
    }
}
