//! Frames of which the slowest link is known, because hardly anything else is in them.

use bytemuck::{Pod, Zeroable};
use cullet_gpu::{Gpu, GpuError};
use wgpu::*;

use super::link::{Link, Way};
use super::measure::Workload;
use super::pipelines::{Wanted, begin, bindings, buffer, group, pipeline, seen, shader, targets};

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
    /// Targets of the given size, and of twice the area.
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
        let module = shader(device, "proof", include_str!("proof.wgsl"));
        let stages = ShaderStages::VERTEX_FRAGMENT;
        let layout = bindings(device, "proof", &[(stages, BufferBindingType::Uniform)]);
        let [drawn, unseen] = [CompareFunction::Always, CompareFunction::Never].map(|compare| {
            pipeline(
                device,
                "proof",
                &Wanted {
                    module: &module,
                    layouts: &[&layout],
                    vertices: &[],
                    fragment: "fs",
                    cull_mode: None,
                    // Of opaque layers a device may fill the last alone.
                    colour: seen(true),
                    depth: Some((false, compare)),
                },
            )
        });
        let own = Loops {
            vertex: amounts.vertex_loops,
            fragment: amounts.fragment_loops,
            covers: u32::from(amounts.covers),
            zero: 0.0,
        };
        let uniform = buffer(device, "loops", 16, BufferUsages::UNIFORM);
        gpu.queue.write_buffer(&uniform, 0, bytemuck::bytes_of(&own));
        let loops = group(device, "proof", &layout, &[&uniform]);
        let targets = targets(device, [SIZE; 2]);
        let bytes = amounts.upload.max(4);
        let uploads = [(); 2].map(|()| buffer(device, "upload", bytes, BufferUsages::STORAGE));
        let data = vec![0; amounts.upload as usize];
        Self { amounts, pipeline: drawn, unseen, loops, targets, uploads, data, stamp: 0 }
    }

    fn record(&self, gpu: &Gpu, way: Way) -> CommandBuffer {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let [colour, depth] = &self.targets[usize::from(way.doubles(Link::Fill))];
        let mut pass = begin(&mut encoder, "proof", (colour, StoreOp::Store), Some(depth));
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
