//! Pipelines and targets that frames of a scene are drawn with.

use std::collections::HashMap;

use cullet::{
    DrawList, Scene, View,
    draw::{DrawCommand, DrawKey, DrawState, MeshPlace},
};
use cullet_gpu::{
    Culling, Draw, DrawArguments, EyeUniform, Gpu, GpuError, GpuScene, Kind, PLACES, culled_faces,
};
use wgpu::*;

use super::link::{Link, Way};
use super::pipelines::{
    Wanted, begin, bindings, buffer, group, pipeline, seen, shader, targets, twice,
};

/// How triangles are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Look {
    /// Shaded, with these faces culled.
    Shaded { faces: Option<Face>, blended: bool },
    /// Where no pixel passes the depth test.
    Unseen { faces: Option<Face> },
}

/// Meshes and places of a scene, pipelines, and pictures to draw into.
#[derive(Debug)]
pub(crate) struct Drawing {
    scene: GpuScene,
    pub(crate) places: Vec<MeshPlace>,
    pipelines: HashMap<Look, RenderPipeline>,
    eye: Buffer,
    pub(crate) group: BindGroup,
    pub(crate) layout: BindGroupLayout,
    pub(crate) module: ShaderModule,
    /// Targets of the given size, and of twice the area: colour and depth.
    targets: [[TextureView; 2]; 2],
    /// The frame's slots, and where they are written once more.
    slots: [Buffer; 2],
}

impl Drawing {
    /// Uploads a scene.
    pub(crate) fn new(gpu: &Gpu, scene: &Scene, size: [u32; 2]) -> Result<Self, GpuError> {
        let device = &gpu.device;
        let limit = device.limits().max_texture_dimension_2d;
        if let [width, height] = twice(size)
            && width.max(height) > limit
        {
            return Err(GpuError::Size { width, height, limit });
        }
        let on_device = GpuScene::new(device, &gpu.queue, scene)?;
        let module = shader(device, "frame", &format!("{PLACES}{}", include_str!("frame.wgsl")));
        let places = BufferBindingType::Storage { read_only: true };
        let layout = bindings(
            device,
            "frame",
            &[(ShaderStages::VERTEX, BufferBindingType::Uniform), (ShaderStages::VERTEX, places)],
        );
        let looks = |faces| {
            let shaded = |blended| Look::Shaded { faces, blended };
            [shaded(false), shaded(true), Look::Unseen { faces }]
        };
        let all = [None, Some(Face::Front), Some(Face::Back)].into_iter().flat_map(looks);
        let pipelines = all.map(|own| (own, look(device, &module, &layout, own))).collect();
        let eye = buffer(device, "eye", size_of::<EyeUniform>() as u64, BufferUsages::UNIFORM);
        let group = group(device, "frame", &layout, &[&eye, on_device.places()]);
        let targets = targets(device, size);
        let (mut first_index, mut base_vertex) = (0, 0);
        let of_mesh = |mesh: &cullet::Mesh| {
            let place = MeshPlace { first_index, base_vertex };
            first_index += mesh.indices().len() as u32;
            base_vertex += mesh.positions().len() as i32;
            place
        };
        let places = scene.meshes().iter().map(of_mesh).collect();
        // An instance may be in the list once for each of its parts that is drawn by itself, of
        // which it has few.
        let bytes = u64::from(scene.slot_count().max(1)) * 4;
        let slots = [(); 2].map(|()| buffer(device, "slots", bytes, BufferUsages::VERTEX));
        Ok(Self { scene: on_device, places, pipelines, eye, group, layout, module, targets, slots })
    }

    /// Uploads what changes from frame to frame.
    pub(crate) fn upload(&self, queue: &Queue, view: &View, list: &DrawList, way: Way) {
        let eye = EyeUniform::new(view);
        for slots in &self.slots[..1 + usize::from(way.doubles(Link::Bus))] {
            queue.write_buffer(&self.eye, 0, bytemuck::bytes_of(&eye));
            queue.write_buffer(slots, 0, bytemuck::cast_slice(&list.instances));
        }
    }

    /// Bytes that [`upload`](Self::upload) writes.
    pub(crate) fn bytes(list: &DrawList) -> u64 {
        (size_of::<EyeUniform>() + size_of_val(list.instances.as_slice())) as u64
    }

    /// Records a frame.
    pub(crate) fn record(
        &self,
        device: &Device,
        view: &View,
        list: &DrawList,
        way: Way,
    ) -> CommandBuffer {
        let mut encoder = device.create_command_encoder(&Default::default());
        let [colour, depth] = &self.targets[usize::from(way.doubles(Link::Fill))];
        let mut pass = begin(&mut encoder, "frame", (colour, StoreOp::Store), Some(depth));
        let shaded = |faces, blended| &self.pipelines[&Look::Shaded { faces, blended }];
        self.draw(&mut pass, view, list, shaded, |instances| instances);
        if way == Way::VerticesAgain {
            pass.set_scissor_rect(0, 0, 1, 1);
        }
        if way.again(1).is_some() {
            let unseen = |faces, _| &self.pipelines[&Look::Unseen { faces }];
            self.draw(&mut pass, view, list, unseen, |n| way.again(n).unwrap_or(0));
        }
        drop(pass);
        encoder.finish()
    }

    /// Draws a list, with so many instances of each command as `instances` says.
    pub(crate) fn draw<'p>(
        &self,
        pass: &mut RenderPass<'_>,
        view: &View,
        list: &DrawList,
        pipeline: impl Fn(Option<Face>, bool) -> &'p RenderPipeline,
        instances: impl Fn(u32) -> u32,
    ) {
        pass.set_bind_group(0, &self.group, &[]);
        pass.set_vertex_buffer(0, self.scene.vertices().slice(..));
        pass.set_vertex_buffer(1, self.slots[0].slice(..));
        pass.set_index_buffer(self.scene.indices().slice(..), IndexFormat::Uint32);
        let mut bound = None;
        for (key, command) in list.keys.iter().zip(&list.commands) {
            let Some(faces) = faces_of(view, key) else { continue };
            let way = (faces, key.state.has(DrawState::BLENDED));
            if bound.replace(way) != Some(way) {
                pass.set_pipeline(pipeline(way.0, way.1));
            }
            let DrawCommand { index_count, first_index, base_vertex, first_instance, .. } =
                *command;
            let last = first_instance + instances(command.instance_count);
            pass.draw_indexed(
                first_index..first_index + index_count,
                base_vertex,
                first_instance..last,
            );
        }
    }
}

/// The faces that are culled of a draw; `None` if none is left.
fn faces_of(view: &View, key: &DrawKey) -> Option<Option<Face>> {
    let draw = Draw {
        bucket: 0,
        kind: Kind { mirrored: key.state.has(DrawState::MIRRORED), ..Kind::default() },
        two_sided: key.state.has(DrawState::TWO_SIDED),
        blended: false,
        arguments: DrawArguments::default(),
    };
    culled_faces(view, &draw)
}

fn look(
    device: &Device,
    module: &ShaderModule,
    layout: &BindGroupLayout,
    look: Look,
) -> RenderPipeline {
    let (cull_mode, blended, compare) = match look {
        Look::Shaded { faces, blended } => (faces, blended, CompareFunction::Greater),
        Look::Unseen { faces } => (faces, false, CompareFunction::Never),
    };
    pipeline(
        device,
        "frame",
        &Wanted {
            module,
            layouts: &[layout],
            vertices: &Culling::vertex_layouts().map(Some),
            fragment: "shade",
            cull_mode,
            colour: seen(blended),
            depth: Some((!blended, compare)),
        },
    )
}
