//! Pictures of several samples a pixel, and of views that are moved by parts of a pixel from frame to frame.

use crate::common;

use std::collections::HashMap;

use cullet::{Scene, View};
use cullet_gpu::{
    Culling, EyeUniform, Gpu, OffScreen, Phase, Pyramid, Tier, culled_faces, pyramid_ref,
};
use cullet_testkit::Rng;
use cullet_testkit::scenes::city;
use cullet_testkit::views::look;
use wgpu::*;

use common::stage::{Stage, Way, assert_same, walk, wrong};
use common::{gpu, texels};

const SAMPLES: u32 = 4;

/// Shader that draws like that of the numbers, but with four bytes of a colour, as a pixel may have
/// several of these.
const COLOURS: &str = concat!(
    include_str!("../src/shaders/places.wgsl"),
    include_str!("../src/shaders/ids.wgsl"),
    "@fragment fn colour(own: Varying) -> @location(0) vec4<f32> {
        return unpack4x8unorm(own.slot + 1u);
    }"
);

/// Number and depth of each sample.
const READ: &str = "
    @group(0) @binding(0) var colour: texture_multisampled_2d<f32>;
    @group(0) @binding(1) var depth: texture_depth_multisampled_2d;
    @group(0) @binding(2) var<storage, read_write> found: array<vec2<u32>>;
    @compute @workgroup_size(8, 8) fn all(@builtin(global_invocation_id) id: vec3<u32>) {
        let size = textureDimensions(depth);
        if any(id.xy >= size) { return; }
        for (var s = 0u; s < 4u; s++) {
            let number = pack4x8unorm(textureLoad(colour, id.xy, s));
            let own = vec2<u32>(number, bitcast<u32>(textureLoad(depth, id.xy, s)));
            found[(id.y * size.x + id.x) * 4u + s] = own;
        }
    }";

/// A scene drawn with several samples a pixel.
struct Sampled<'a> {
    gpu: &'a Gpu,
    all: OffScreen,
    colour: Texture,
    depth: Texture,
    pyramid: Pyramid,
    eye: Buffer,
    pipelines: HashMap<Option<Face>, RenderPipeline>,
    read: ComputePipeline,
}

/// Depth that tests are made against.
#[derive(Clone, Copy, PartialEq)]
enum Against {
    Nothing,
    AllSamples,
    /// Depth in the middles of pixels: wrong.
    Middles,
}

impl<'a> Sampled<'a> {
    fn new(gpu: &'a Gpu, scene: &Scene, [width, height]: [u32; 2]) -> Self {
        let device = &gpu.device;
        let all = OffScreen::new(device, &gpu.queue, scene, [width, height]).unwrap();
        let texture = |format| {
            device.create_texture(&TextureDescriptor {
                label: None,
                size: Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: SAMPLES,
                dimension: TextureDimension::D2,
                format,
                usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            })
        };
        let [colour, depth] = [TextureFormat::Rgba8Unorm, TextureFormat::Depth32Float].map(texture);
        let eye = device.create_buffer(&BufferDescriptor {
            label: None,
            size: size_of::<EyeUniform>() as u64,
            usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let shader = |source: &'static str| {
            let source = ShaderSource::Wgsl(source.into());
            device.create_shader_module(ShaderModuleDescriptor { label: None, source })
        };
        let module = shader(COLOURS);
        let pipeline = |cull_mode| {
            device.create_render_pipeline(&RenderPipelineDescriptor {
                label: None,
                layout: None,
                vertex: VertexState {
                    module: &module,
                    entry_point: None,
                    compilation_options: Default::default(),
                    buffers: &Culling::vertex_layouts().map(Some),
                },
                fragment: Some(FragmentState {
                    module: &module,
                    entry_point: Some("colour"),
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
                multisample: MultisampleState { count: SAMPLES, ..Default::default() },
                multiview_mask: None,
                cache: None,
            })
        };
        let faces = [None, Some(Face::Front), Some(Face::Back)];
        let pipelines = faces.map(|faces| (faces, pipeline(faces))).into();
        let read = device.create_compute_pipeline(&ComputePipelineDescriptor {
            label: None,
            layout: None,
            module: &shader(READ),
            entry_point: None,
            compilation_options: Default::default(),
            cache: None,
        });
        let pyramid = Pyramid::new(device, &all.passes.pyramid, &depth).unwrap();
        Self { gpu, all, colour, depth, pyramid, eye, pipelines, read }
    }

    fn group(&self, layout: &BindGroupLayout, all: [BindingResource<'_>; 2]) -> BindGroup {
        let [a, b] = all;
        let entry = |binding, resource| BindGroupEntry { binding, resource };
        self.gpu.device.create_bind_group(&BindGroupDescriptor {
            label: None,
            layout,
            entries: &[entry(0, a), entry(1, b)],
        })
    }

    fn draw_phase(&self, encoder: &mut CommandEncoder, view: &View, phase: Phase, first: bool) {
        let [colour, depth] =
            [&self.colour, &self.depth].map(|t| t.create_view(&Default::default()));
        let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
            label: None,
            color_attachments: &[Some(RenderPassColorAttachment {
                view: &colour,
                depth_slice: None,
                resolve_target: None,
                ops: Operations {
                    load: if first { LoadOp::Clear(Color::TRANSPARENT) } else { LoadOp::Load },
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
        self.all.culling.draw(&mut pass, phase, |pass, draw| {
            let Some(faces) = culled_faces(view, draw) else { return false };
            let pipeline = &self.pipelines[&faces];
            pass.set_pipeline(pipeline);
            let places = self.all.culling.scene().places();
            let all = [&self.eye, places].map(|b| b.as_entire_binding());
            pass.set_bind_group(0, &self.group(&pipeline.get_bind_group_layout(0), all), &[]);
            true
        });
    }

    /// Number and depth, by pixel and sample.
    fn draw(&mut self, scene: &Scene, view: &View, against: Against) -> Vec<[u32; 2]> {
        let (device, queue) = (&self.gpu.device, &self.gpu.queue);
        let samples = if against == Against::Middles { 1 } else { SAMPLES };
        self.all.culling.set(queue, scene, view, samples).unwrap();
        queue.write_buffer(&self.eye, 0, bytemuck::bytes_of(&EyeUniform::new(view)));
        self.all.target.set(queue, view);
        let mut encoder = device.create_command_encoder(&Default::default());
        let all = &self.all;
        let on = (&all.culling, view);
        match against {
            Against::Nothing => all.culling.record_all(&all.passes, &mut encoder),
            Against::AllSamples => {
                all.culling.record_early(&all.passes, &mut encoder);
                self.draw_phase(&mut encoder, view, Phase::Early, true);
                all.culling.record_late(&all.passes, &mut encoder, &self.pyramid);
            }
            Against::Middles => {
                all.culling.record_early(&all.passes, &mut encoder);
                self.draw_phase(&mut encoder, view, Phase::Early, true);
                all.ids.draw(&mut encoder, &all.target, on, &[Phase::Early], true);
                all.culling.record_late(&all.passes, &mut encoder, &all.pyramid);
            }
        }
        self.draw_phase(&mut encoder, view, Phase::Late, against == Against::Nothing);
        let [width, height] = view.viewport();
        let size = u64::from(width * height * SAMPLES) * 8;
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        let label = None;
        let found = device.create_buffer(&BufferDescriptor {
            label,
            size,
            usage,
            mapped_at_creation: false,
        });
        let [colour, depth] =
            [&self.colour, &self.depth].map(|t| t.create_view(&Default::default()));
        let entry = |binding, resource| BindGroupEntry { binding, resource };
        let group = device.create_bind_group(&BindGroupDescriptor {
            label: None,
            layout: &self.read.get_bind_group_layout(0),
            entries: &[
                entry(0, BindingResource::TextureView(&colour)),
                entry(1, BindingResource::TextureView(&depth)),
                entry(2, found.as_entire_binding()),
            ],
        });
        let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor::default());
        pass.set_pipeline(&self.read);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(width.div_ceil(8), height.div_ceil(8), 1);
        drop(pass);
        queue.submit([encoder.finish()]);
        bytemuck::pod_collect_to_vec(&self.gpu.read(&found, size).unwrap())
    }
}

fn differing(a: &[[u32; 2]], b: &[[u32; 2]]) -> usize {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).filter(|(a, b)| a != b).count()
}

#[test]
fn every_sample_is_drawn_as_without_culling() {
    let Some(gpu) = gpu(Tier::Pyramid) else { return };
    let mut scene = city(16, 2, 400);
    scene.commit(&cullet::Culler::default());
    let (mut edges, mut drawn) = (0, 0);
    for size in [[1, 1], [5, 70], [200, 120], [447, 319]] {
        let mut culled = Sampled::new(gpu, &scene, size);
        let mut reference = Sampled::new(gpu, &scene, size);
        for (number, view) in walk(size).iter().enumerate() {
            let expected = reference.draw(&scene, view, Against::Nothing);
            for frame in 0..2 {
                let found = culled.draw(&scene, view, Against::AllSamples);
                let wrong = differing(&expected, &found);
                assert_eq!(wrong, 0, "{size:?}, view {number}, frame {frame}: samples");
            }
            // Each texel is the farthest of all samples of its pixels.
            let pixels = expected.chunks_exact(SAMPLES as usize);
            let farthest =
                |of: &[[u32; 2]]| of.iter().map(|own| f32::from_bits(own[1])).fold(1.0, f32::min);
            let depths: Vec<f32> = pixels.clone().map(farthest).collect();
            let levels = pyramid_ref(&depths, size);
            for (level, (own, of_level)) in levels.iter().zip(culled.pyramid.sizes()).enumerate() {
                let found: Vec<f32> =
                    texels(gpu, culled.pyramid.texture(), level as u32, *of_level);
                assert!(found == *own, "level {level} of {size:?}");
            }
            edges += pixels.filter(|of| of.iter().any(|own| own[0] != of[0][0])).count();
            drawn += depths.iter().filter(|own| **own > 0.0).count();
        }
    }
    assert!(edges > 10_000 && drawn > 500_000, "{edges} pixels of several, {drawn} drawn");
}

/// Views from all over the city.
fn anywhere(size: [u32; 2], count: usize) -> Vec<View> {
    let mut rng = Rng(11);
    let mut view = || {
        let eye = [rng.range(-150.0, 150.0), rng.range(2.0, 60.0), rng.range(-150.0, 150.0)];
        look(eye, [rng.range(-150.0, 150.0), 5.0, rng.range(-150.0, 150.0)], size)
    };
    (0..count).map(|_| view()).collect()
}

#[test]
fn with_the_middles_of_pixels_alone_samples_would_be_missing() {
    let Some(gpu) = gpu(Tier::Pyramid) else { return };
    let mut scene = city(16, 1, 3000);
    scene.commit(&cullet::Culler::default());
    let size = [200, 120];
    let mut culled = Sampled::new(gpu, &scene, size);
    let mut reference = Sampled::new(gpu, &scene, size);
    let mut missing = 0;
    for view in &anywhere(size, 60) {
        let expected = reference.draw(&scene, view, Against::Nothing);
        for _ in 0..2 {
            missing += differing(&expected, &culled.draw(&scene, view, Against::Middles));
        }
    }
    assert!(missing > 0);
    println!("{missing} samples missing where the middles of pixels are tested");
}

/// A view moved by parts of a pixel.
fn moved(view: &View, [x, y]: [f64; 2]) -> View {
    let mut m = view.clip_from_world();
    let [width, height] = view.viewport().map(f64::from);
    for column in m.chunks_exact_mut(4) {
        column[0] += column[3] * 2.0 * x / width;
        column[1] += column[3] * 2.0 * y / height;
    }
    View::from_matrix(m, view.depth(), view.viewport()).unwrap()
}

#[test]
fn jittered_views_are_drawn_as_without_culling_and_the_test_must_be_jittered_too() {
    let Some(gpu) = gpu(Tier::Pyramid) else { return };
    let mut scene = city(16, 1, 3000);
    scene.commit(&cullet::Culler::default());
    let size = [333, 187];
    let mut rng = Rng(3);
    let [mut culled, mut steady, mut reference] = [(); 3].map(|()| Stage::new(gpu, &scene, size));
    let (mut missing, mut ties) = (0, 0);
    for (number, view) in anywhere(size, 60).iter().enumerate() {
        for frame in 0..3 {
            let jittered = moved(view, [rng.range(-0.5, 0.5), rng.range(-0.5, 0.5)]);
            let expected = reference.draw(&scene, &jittered, Way::All);
            let found = culled.draw(&scene, &jittered, Way::TwoPhases);
            let what = format!("view {number}, frame {frame}");
            ties += assert_same(&culled, &expected, &found, &what);
            // Tested as if it were not.
            let (device, queue, all) = (&gpu.device, &gpu.queue, &mut steady.all);
            all.culling.set(queue, &scene, view, 1).unwrap();
            all.target.set(queue, &jittered);
            let mut encoder = device.create_command_encoder(&Default::default());
            all.record(&mut encoder, &jittered, true);
            queue.submit([encoder.finish()]);
            missing += wrong(&expected, &steady.frame(size));
        }
    }
    assert_eq!(ties, 0);
    assert!(missing > 0);
    println!("{missing} pixels missing where the test is not jittered");
}
