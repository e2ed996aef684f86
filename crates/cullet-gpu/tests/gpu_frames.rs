//! Frames with occlusion culling on the device: the pictures without it, whatever the eye does, with far less drawn.

use crate::common;

use cullet::{Camera, Depth, Projection, Scene, Transform, View};
use cullet_gpu::{
    ClusterArguments, ClusterInstances, CountedArguments, DrawArguments, DrawMode, Gpu, GpuError,
    GpuScene, IdTarget, LaneBuffers, ListSource, Listed, OcclusionPass, OffScreen, Passes, Pyramid,
    Tier, wait,
};
use cullet_testkit::Rng;
use cullet_testkit::scenes::{city, elsewhere, mixed_scene};
use cullet_testkit::views::{look, mixed_view};

use common::gpu;
use common::stage::{Stage, Way, assert_same, walk, wrong};

const SIZES: [[u32; 2]; 6] = [[17, 31], [64, 64], [127, 65], [200, 120], [333, 187], [479, 269]];

#[test]
fn scenes_of_every_kind_are_drawn_as_without_culling() {
    let Some(gpu) = gpu(Tier::Pyramid) else { return };
    let mut rng = Rng(7);
    let (mut ties, mut pixels) = (0, 0);
    for round in 0..60 {
        let mut scene = mixed_scene(&mut rng);
        let size = SIZES[rng.index(6)];
        let mut views: Vec<View> = (0..3).map(|_| mixed_view(&mut rng, size)).collect();
        if round % 3 == 2 {
            views = vec![elsewhere(&mut scene, &views[0], &mut rng)];
        }
        scene.commit(&cullet::Culler::default());
        let mut stage = Stage::new(gpu, &scene, size);
        let mut reference = Stage::new(gpu, &scene, size);
        let mut others: Vec<_> = [DrawMode::Multi, DrawMode::Clusters, DrawMode::Counted]
            .into_iter()
            .filter(|mode| mode.is_offered(&gpu.device))
            .map(|mode| Stage::with_mode(gpu, &scene, size, mode))
            .collect();
        for view in views.iter().chain(&views) {
            let expected = reference.draw(&scene, view, Way::All);
            let found = stage.draw(&scene, view, Way::TwoPhases);
            ties += assert_same(&stage, &expected, &found, &format!("round {round}, {view:?}"));
            for other in &mut others {
                let found = other.draw(&scene, view, Way::TwoPhases);
                let what = format!("round {round}, {:?}, {view:?}", other.all.culling.mode());
                ties += assert_same(other, &expected, &found, &what);
            }
            pixels += expected.ids.iter().filter(|id| **id > 0).count();
        }
    }
    // The same instance twice, of which another was seen before.
    assert!(pixels > 100_000 && ties * 20 < pixels, "{ties} of {pixels}");
}

#[test]
fn without_the_late_phase_things_would_be_missing() {
    let Some(gpu) = gpu(Tier::Pyramid) else { return };
    let mut scene = city(16, 2, 400);
    scene.commit(&cullet::Culler::default());
    let size = [333, 187];
    let mut stage = Stage::new(gpu, &scene, size);
    let mut reference = Stage::new(gpu, &scene, size);
    let missing: usize = walk(size)
        .iter()
        .map(|view| {
            let expected = reference.draw(&scene, view, Way::All);
            wrong(&expected, &stage.draw(&scene, view, Way::EarlyAlone))
        })
        .sum();
    assert!(missing > 1000, "{missing} pixels");
}

#[test]
fn with_sizes_rounded_down_things_would_be_missing() {
    let Some(gpu) = gpu(Tier::Pyramid) else { return };
    let mut scene = city(16, 2, 400);
    scene.commit(&cullet::Culler::default());
    let mut rng = Rng(11);
    let size = [447, 319];
    let mut stage = Stage::new(gpu, &scene, size);
    let mut reference = Stage::new(gpu, &scene, size);
    let halves = |[w, h]: [u32; 2]| [(w / 2).max(1), (h / 2).max(1)];
    let next = |own: &[u32; 2]| (*own != [1, 1]).then(|| halves(*own));
    let sizes = std::iter::successors(Some(halves(size)), next).collect();
    let (device, pass) = (&gpu.device, &stage.all.passes.pyramid);
    let floored = Pyramid::with_levels(device, pass, stage.all.target.depth(), sizes).unwrap();
    let right = std::mem::replace(&mut stage.all.pyramid, floored);
    let clamped = OcclusionPass::clamped(device, pass);
    let occlusion = std::mem::replace(&mut stage.all.passes.occlusion, clamped);
    let views: Vec<View> = (0..120)
        .map(|_| {
            let eye = [rng.range(-150.0, 150.0), rng.range(2.0, 60.0), rng.range(-150.0, 150.0)];
            look(eye, [rng.range(-150.0, 150.0), 5.0, rng.range(-150.0, 150.0)], size)
        })
        .collect();
    let mut missing = 0;
    for view in &views {
        let expected = reference.draw(&scene, view, Way::All);
        // Nothing is as it was in the frame before, so that the second phase decides.
        missing += wrong(&expected, &stage.draw(&scene, view, Way::TwoPhases));
    }
    assert!(missing > 0);
    // With the sizes as they are the same test hides nothing that is seen.
    (stage.all.pyramid, stage.all.passes.occlusion) = (right, occlusion);
    for view in &views {
        let expected = reference.draw(&scene, view, Way::All);
        let found = stage.draw(&scene, view, Way::TwoPhases);
        assert_same(&stage, &expected, &found, &format!("{view:?}"));
    }
    println!("{missing} pixels missing with sizes rounded down");
}

#[test]
fn what_moves_and_what_comes_is_drawn_in_the_same_frame() {
    let Some(gpu) = gpu(Tier::Pyramid) else { return };
    let mut scene = city(10, 2, 100);
    scene.commit(&cullet::Culler::default());
    let size = [200, 120];
    let view = look([0.0, 4.0, 0.0], [100.0, 6.0, 10.0], size);
    let modes = [DrawMode::Each, DrawMode::Clusters, DrawMode::Counted];
    let can = |mode: &DrawMode| mode.is_offered(&gpu.device);
    let mut stages: Vec<_> = modes
        .into_iter()
        .filter(can)
        .map(|mode| Stage::with_mode(gpu, &scene, size, mode))
        .collect();
    // Something comes from behind, right before the eye.
    let slot = scene.slots().max_by_key(|slot| scene.bounds(*slot).min[0] as i64).unwrap();
    let handle = scene.handle(slot).unwrap();
    let there = *scene.transform(slot);
    for step in 0..6 {
        let back = [200.0, 90.0, 30.0, 12.0, 60.0, -500.0][step];
        let mut near = Transform { translation: [back, 0.0, back * 0.1], ..there };
        // Mirrored once, so that its faces turn.
        if step == 3 {
            near.linear[0] = near.linear[0].map(|v| -v);
        }
        scene.set_transform(handle, near).unwrap();
        scene.commit(&cullet::Culler::default());
        let mut reference = Stage::new(gpu, &scene, size);
        let expected = reference.draw(&scene, &view, Way::All);
        for stage in &mut stages {
            stage.all.follow(&gpu.device, &gpu.queue, &scene).unwrap();
            let found = stage.draw(&scene, &view, Way::TwoPhases);
            assert_same(stage, &expected, &found, &format!("step {step}"));
        }
    }
}

#[test]
fn scenes_of_nothing_and_of_one_and_pictures_too_large() {
    let Some(gpu) = gpu(Tier::Pyramid) else { return };
    let projection = Projection::Orthographic {
        left: -2.0,
        right: 2.0,
        bottom: -2.0,
        top: 2.0,
        near: 0.0,
        far: 100.0,
    };
    let camera = Camera::look_at([0.0, 0.0, 10.0], [0.0; 3], projection);
    let view = View::new(&camera, Depth::Reversed, [16, 16]).unwrap();
    let mut scene = Scene::new();
    scene.commit(&cullet::Culler::default());
    let mut stage = Stage::new(gpu, &scene, [16, 16]);
    let empty = stage.draw(&scene, &view, Way::TwoPhases);
    assert!(empty.ids.iter().all(|id| *id == 0) && empty.depth.iter().all(|d| *d == 0.0));
    let mesh = scene.add_mesh(cullet_testkit::meshes::block([-1.0; 3], [1.0; 3]));
    scene.add(cullet::Instance::new(mesh, Transform::IDENTITY)).unwrap();
    scene.commit(&cullet::Culler::default());
    stage = Stage::new(gpu, &scene, [16, 16]);
    for way in [Way::TwoPhases, Way::TwoPhases, Way::All] {
        let one = stage.draw(&scene, &view, way);
        assert_eq!(one.ids.iter().filter(|id| **id == 1).count(), 64);
    }
    let side = gpu.device.limits().max_texture_dimension_2d + 1;
    let made = IdTarget::new(&gpu.device, &stage.all.ids, &stage.all.culling, [side, 1]);
    assert!(matches!(made, Err(GpuError::Size { .. })));
}

#[test]
fn a_device_that_is_lost_is_an_error() {
    let Some(_) = gpu(Tier::Pyramid) else { return };
    let gpu = Gpu::open(Tier::Pyramid).unwrap();
    let mut scene = city(3, 1, 5);
    scene.commit(&cullet::Culler::default());
    let size = [64, 64];
    let view = &walk(size)[0];
    let mut all = OffScreen::new(&gpu.device, &gpu.queue, &scene, size).unwrap();
    all.draw(&gpu.device, &gpu.queue, (&scene, view), true).unwrap();
    gpu.device.destroy();
    // What is handed in now goes nowhere, and whoever waits for it is told.
    all.draw(&gpu.device, &gpu.queue, (&scene, view), true).unwrap();
    let told = gpu.read(all.culling.visible(), 4).unwrap_err();
    assert!(matches!(told, GpuError::Lost(_)), "{told}");
}

#[test]
fn a_mode_that_a_device_has_not_is_an_error_that_names_what_is_missing() {
    let Some(_) = gpu(Tier::MultiDraw) else { return };
    let mut scene = city(3, 1, 5);
    scene.commit(&cullet::Culler::default());
    let gpu = wait(Gpu::request(Tier::MultiDraw, wgpu::Features::empty(), None)).unwrap();
    assert_eq!(gpu.tier(), Tier::MultiDraw);
    let made = |mode| OffScreen::with_mode(&gpu.device, &gpu.queue, &scene, [64, 64], mode);
    let told = made(DrawMode::Counted).map(|_| ()).unwrap_err().to_string();
    assert!(told.contains("MULTI_DRAW_INDIRECT_COUNT") && told.contains("DrawMode::of"), "{told}");
    // What suits it is something else.
    let suits = DrawMode::of(&gpu.device, &scene);
    assert!(suits != DrawMode::Counted && made(suits).unwrap().culling.mode() == suits);
}

#[test]
fn counted_draws_are_those_of_one_instance_in_their_order() {
    let Some(gpu) = gpu(Tier::MultiDrawCount) else { return };
    let (device, queue) = (&gpu.device, &gpu.queue);
    let passes = Passes::new(device).unwrap();
    let arguments = |buffer: &wgpu::Buffer| -> Vec<DrawArguments> {
        bytemuck::pod_collect_to_vec(&gpu.read(buffer, buffer.size()).unwrap())
    };
    let mut rng = Rng(17);
    let (mut live, mut calls) = (0, 0);
    for round in 0..20 {
        let mut scene = if round == 0 { city(20, 1, 900) } else { mixed_scene(&mut rng) };
        scene.commit(&cullet::Culler::default());
        let on_device = GpuScene::new(device, queue, &scene).unwrap();
        let clusters = ClusterInstances::of(&scene, &on_device);
        let words: Vec<u32> =
            (0..clusters.len().div_ceil(32).max(4)).map(|_| rng.bits() as u32).collect();
        let bits = device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: words.len() as u64 * 4,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        queue.write_buffer(&bits, 0, bytemuck::cast_slice(&words));
        let source = ListSource { bits: &bits, seen: &bits, listed: Listed::All };
        let lanes = LaneBuffers::new(device, queue, &clusters.lanes()).unwrap();
        let (of, by) = ((&clusters, &lanes), (&passes.counted, &passes.lists));
        let counted = CountedArguments::new(device, queue, by, of, source).unwrap();
        let pass = &passes.arguments;
        let each = ClusterArguments::new(device, queue, pass, &clusters, source).unwrap();
        let mut encoder = device.create_command_encoder(&Default::default());
        passes.counted.record(&passes.lists, &mut encoder, &counted);
        pass.record(&mut encoder, &each);
        queue.submit([encoder.finish()]);
        let (all, found) = (arguments(each.arguments()), arguments(counted.arguments()));
        let counts = arguments(counted.counts());
        for (bucket, count) in clusters.lanes().buckets().iter().zip(&counts) {
            let own = bucket.lanes.start as usize..bucket.lanes.end as usize;
            let is_alive = |one: &&DrawArguments| one.instance_count == 1;
            let alive: Vec<_> = all[own.clone()].iter().filter(is_alive).copied().collect();
            assert_eq!(count.instance_count as usize, alive.len(), "round {round}");
            assert_eq!(found[own][..alive.len()], alive, "round {round}");
            live += alive.len();
            calls += 1;
        }
    }
    assert!(live > 500 && calls > 40, "{live} draws of {calls} calls");
}
