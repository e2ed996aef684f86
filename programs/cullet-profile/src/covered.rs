//! Counts the samples that a frame covers, hidden ones too.

use std::collections::HashMap;

use cullet::{DrawList, View};
use cullet_gpu::{Culling, Gpu, GpuError};
use wgpu::*;

use super::drawing::Drawing;
use super::pipelines::{Wanted, begin, bindings, buffer, group, pipeline, target};

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
        let counted = BufferBindingType::Storage { read_only: false };
        let layout = bindings(device, "covered", &[(ShaderStages::FRAGMENT, counted)]);
        let colour = ColorTargetState {
            format: TextureFormat::R8Unorm,
            blend: None,
            write_mask: ColorWrites::empty(),
        };
        let make = |cull_mode| {
            pipeline(
                device,
                "covered",
                &Wanted {
                    module: &drawing.module,
                    layouts: &[&drawing.layout, &layout],
                    vertices: &Culling::vertex_layouts().map(Some),
                    fragment: "count",
                    cull_mode,
                    colour: colour.clone(),
                    depth: None,
                },
            )
        };
        let faces = [None, Some(Face::Front), Some(Face::Back)];
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        let counts = buffer(device, "covered", COUNTERS * 4, usage);
        let group = group(device, "covered", &layout, &[&counts]);
        Self {
            pipelines: faces.map(|f| (f, make(f))).into_iter().collect(),
            counts,
            group,
            nothing: target(device, size, TextureFormat::R8Unorm),
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
        let mut pass = begin(&mut encoder, "covered", (&self.nothing, StoreOp::Discard), None);
        pass.set_bind_group(1, &self.group, &[]);
        drawing.draw(&mut pass, view, list, |faces, _| &self.pipelines[&faces], |n| n);
        drop(pass);
        gpu.queue.submit([encoder.finish()]);
        let counts = gpu.read(&self.counts, COUNTERS * 4)?;
        let number = |b: &[u8]| u64::from(u32::from_ne_bytes([b[0], b[1], b[2], b[3]]));
        Ok(counts.chunks_exact(4).map(number).sum())
    }
}
