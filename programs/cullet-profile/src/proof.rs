//! Frames of which the slowest link is known, because hardly anything else is in them.

use bytemuck::{Pod, Zeroable};
use cullet_gpu::{Gpu, GpuError};
use wgpu::*;

use super::drawing::target;
use super::link::{Link, Way};
use super::measure::Workload;

/// How much work of each kind a frame has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Amounts {
    /// Draws.
    pub draws: u32,
    /// Instances of each; with none the device has nothing to do, and the program as much.
    pub instances: u32,
    /// Triangles a draw.
    pub triangles: u32,
    /// Whether each triangle covers the picture; else it is a hundredth of a pixel.
    pub covers: bool,
    /// Turns of a loop for each vertex.
    pub vertex_loops: u32,
    /// Turns of a loop for each fragment.
    pub fragment_loops: u32,
    /// Bytes that are uploaded anew.
    pub upload: u64,
}

impl Amounts {
    /// A frame that waits for one link.
    #[must_use]
    pub fn of(link: Link) -> Self {
        let little = Self {
            draws: 1,
            instances: 1,
            triangles: 1,
            covers: false,
            vertex_loops: 1,
            fragment_loops: 1,
            upload: 0,
        };
        match link {
            Link::Fill => Self { triangles: 4, covers: true, fragment_loops: 24, ..little },
            Link::Transform => Self { triangles: 1 << 16, vertex_loops: 64, ..little },
            Link::Bus => Self { upload: 64 << 20, ..little },
            Link::Cpu => Self { draws: 50_000, instances: 0, ..little },
        }
    }
}

/// The picture's size, nothing doubled.
const SIZE: u32 = 512;

/// The shader's `Loops`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct Loops {
    vertex: u32,
    fragment: u32,
    covers: u32,
    /// Always 0, which no compiler knows.
    zero: f32,
}

/// A frame of some amounts of work.
#[derive(Debug)]
pub struct Proof {
    amounts: Amounts,
    pipeline: RenderPipeline,
    /// Where no pixel passes the depth test.
    unseen: RenderPipeline,
    loops: BindGroup,
    /// As large as it is, and of twice the area.
    targets: [[TextureView; 2]; 2],
    uploads: [Buffer; 2],
    data: Vec<u8>,
    /// Another each frame, so that no frame's upload is that of the one before.
    stamp: u8,
}

impl Proof {
    /// Makes what it needs.
    #[must_use]
    pub fn new(gpu: &Gpu, amounts: Amounts) -> Self {
        let device = &gpu.device;
        let module = device.create_shader_module(ShaderModuleDescriptor {
            label: Some("proof"),
            source: ShaderSource::Wgsl(include_str!("proof.wgsl").into()),
        });
        let layout = device.create_bind_group_layout(&BindGroupLayoutDescriptor {
            label: Some("proof"),
            entries: &[BindGroupLayoutEntry {
                binding: 0,
                visibility: ShaderStages::VERTEX_FRAGMENT,
                ty: BindingType::Buffer {
                    ty: BufferBindingType::Uniform,
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            }],
        });
        let of_all = device.create_pipeline_layout(&PipelineLayoutDescriptor {
            label: Some("proof"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let [pipeline, unseen] = [CompareFunction::Always, CompareFunction::Never].map(|compare| {
            device.create_render_pipeline(&RenderPipelineDescriptor {
                label: Some("proof"),
                layout: Some(&of_all),
                vertex: VertexState {
                    module: &module,
                    entry_point: None,
                    compilation_options: Default::default(),
                    buffers: &[],
                },
                fragment: Some(FragmentState {
                    module: &module,
                    entry_point: None,
                    compilation_options: Default::default(),
                    targets: &[Some(ColorTargetState {
                        format: TextureFormat::Rgba8Unorm,
                        // Of opaque layers a device may fill the last alone.
                        blend: Some(BlendState::ALPHA_BLENDING),
                        write_mask: ColorWrites::ALL,
                    })],
                }),
                primitive: PrimitiveState::default(),
                depth_stencil: Some(DepthStencilState {
                    format: TextureFormat::Depth32Float,
                    depth_write_enabled: Some(false),
                    depth_compare: Some(compare),
                    stencil: Default::default(),
                    bias: Default::default(),
                }),
                multisample: Default::default(),
                multiview_mask: None,
                cache: None,
            })
        });
        let buffer = |size, usage| {
            let label = Some("proof");
            let usage = usage | BufferUsages::COPY_DST;
            let mapped_at_creation = false;
            device.create_buffer(&BufferDescriptor { label, size, usage, mapped_at_creation })
        };
        let own = Loops {
            vertex: amounts.vertex_loops,
            fragment: amounts.fragment_loops,
            covers: u32::from(amounts.covers),
            zero: 0.0,
        };
        let uniform = buffer(16, BufferUsages::UNIFORM);
        gpu.queue.write_buffer(&uniform, 0, bytemuck::bytes_of(&own));
        let loops = device.create_bind_group(&BindGroupDescriptor {
            label: Some("proof"),
            layout: &layout,
            entries: &[BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() }],
        });
        let targets = [SIZE, (f64::from(SIZE) * std::f64::consts::SQRT_2) as u32].map(|side| {
            [TextureFormat::Rgba8Unorm, TextureFormat::Depth32Float]
                .map(|format| target(device, [side; 2], format))
        });
        let uploads = [(); 2].map(|()| buffer(amounts.upload.max(4), BufferUsages::STORAGE));
        let data = vec![0; amounts.upload as usize];
        Self { amounts, pipeline, unseen, loops, targets, uploads, data, stamp: 0 }
    }

    fn record(&self, gpu: &Gpu, way: Way) -> CommandBuffer {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let [colour, depth] = &self.targets[usize::from(way.doubles(Link::Fill))];
        let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
            label: Some("proof"),
            color_attachments: &[Some(RenderPassColorAttachment {
                view: colour,
                depth_slice: None,
                resolve_target: None,
                ops: Operations { load: LoadOp::Clear(Color::BLACK), store: StoreOp::Store },
            })],
            depth_stencil_attachment: Some(RenderPassDepthStencilAttachment {
                view: depth,
                depth_ops: Some(Operations { load: LoadOp::Clear(0.0), store: StoreOp::Discard }),
                stencil_ops: None,
            }),
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        pass.set_pipeline(&self.pipeline);
        self.draw(&mut pass, self.amounts.instances);
        if let Some(instances) = way.again(self.amounts.instances) {
            if way == Way::VerticesAgain {
                pass.set_scissor_rect(0, 0, 1, 1);
            }
            pass.set_pipeline(&self.unseen);
            self.draw(&mut pass, instances);
        }
        drop(pass);
        encoder.finish()
    }

    fn draw(&self, pass: &mut RenderPass<'_>, instances: u32) {
        for _ in 0..self.amounts.draws {
            // What a program sets between two draws.
            pass.set_bind_group(0, &self.loops, &[]);
            pass.draw(0..self.amounts.triangles * 3, 0..instances);
        }
    }
}

impl Workload for Proof {
    fn frames(&self) -> usize {
        1
    }

    fn frame(&mut self, gpu: &Gpu, _: usize, way: Way) -> Result<SubmissionIndex, GpuError> {
        self.stamp = self.stamp.wrapping_add(1);
        if let Some(first) = self.data.first_mut() {
            *first = self.stamp;
            gpu.queue.write_buffer(&self.uploads[0], 0, &self.data);
            if way.doubles(Link::Bus) {
                gpu.queue.write_buffer(&self.uploads[1], 0, &self.data);
            }
        }
        let commands = self.record(gpu, way);
        if way.doubles(Link::Cpu) {
            drop(self.record(gpu, way));
        }
        Ok(gpu.queue.submit([commands]))
    }
}
