//! Devices that are not there, are too small, go away or are full: an error that says what to do, or the CPU takes over.

use crate::common;

use cullet::bounds::Plane;
use cullet::{Culler, Instance, Scene, View, ViewState, Visible};
use cullet_gpu::{
    BlockPlanes, Blocks, Culling, DrawMode, Gpu, GpuError, IdPass, InView, Lack, OffScreen, Passes,
    Phase, Tier, TrianglePass, visible_ref, wait,
};
use cullet_testkit::Rng;
use cullet_testkit::scenes::{city, random_scene};
use cullet_testkit::views::random_view;
use wgpu::{Backends, Features, InstanceDescriptor, Limits};

use common::{gpu, texels};

fn only(backends: Backends) -> wgpu::Instance {
    wgpu::Instance::new(InstanceDescriptor {
        backends,
        ..InstanceDescriptor::new_without_display_handle()
    })
}

fn scene() -> Scene {
    let mut scene = random_scene(&mut Rng(11), 5000);
    scene.commit(&Culler::default());
    scene
}

fn planes_of(view: &View, scene: &Scene) -> Vec<Plane> {
    view.frustum().relative_to(scene.origin()).planes().map(|(_, plane)| *plane).collect()
}

/// Returns the slots that the CPU lists of a view.
fn list_ref(scene: &Scene, view: &View) -> Vec<u32> {
    let blocks = Blocks::new(scene);
    let mut planes = BlockPlanes::default();
    planes.set(&blocks, &planes_of(view, scene), view.layers);
    visible_ref(&blocks, &planes)
}

fn some_views() -> Vec<View> {
    let mut rng = Rng(12);
    (0..8).map(|_| random_view(&mut rng)).collect()
}

fn listed(lists: &mut InView<'_>, scene: &Scene, view: &View) -> Result<Vec<u32>, GpuError> {
    lists.list(&planes_of(view, scene), view.layers)
}

#[test]
fn without_an_adapter_the_error_says_what_to_install_and_the_cpu_lists() {
    let none = only(Backends::empty());
    let told = wait(Gpu::on(&none, Tier::Draw, Features::empty(), None)).unwrap_err();
    assert!(matches!(told, GpuError::NoAdapter { tier: Tier::Draw, .. }), "{told}");
    let words = told.to_string();
    let cure = if cfg!(target_os = "linux") { "install mesa-vulkan-drivers" } else { "install" };
    assert!(["none was found", cure, "the CPU"].iter().all(|w| words.contains(w)), "{words}");
    let mut scene = scene();
    let mut lists = InView::or_cpu(Err(told), &scene, 6);
    assert!(matches!(lists.why_cpu(), Some(GpuError::NoAdapter { .. })));
    let mut some = 0;
    for view in some_views() {
        let list = listed(&mut lists, &scene, &view).unwrap();
        some += list.len();
        assert!(list == list_ref(&scene, &view));
    }
    assert!(some > 100, "{some}");
    let moved = scene.handle(3).unwrap();
    scene.remove(moved).unwrap();
    scene.commit(&Culler::default());
    lists.follow(&scene).unwrap();
    assert!(
        listed(&mut lists, &scene, &some_views()[0]).unwrap() == list_ref(&scene, &some_views()[0])
    );
}

#[test]
fn what_an_adapter_has_not_is_named_when_it_is_opened() {
    let Some(_) = gpu(Tier::Compute) else { return };
    let told =
        Gpu::open_least(Tier::Compute, Limits { max_bind_groups: 4000, ..Limits::default() })
            .unwrap_err();
    assert!(matches!(told, GpuError::NoDevice { .. }), "{told}");
    assert!(
        told.to_string().contains("max_bind_groups") && told.to_string().contains("4000"),
        "{told}"
    );
}

#[test]
fn limits_below_those_of_the_passes_are_said_in_numbers_and_the_cpu_lists() {
    let Some(_) = gpu(Tier::Compute) else { return };
    let few = Limits { max_storage_buffers_per_shader_stage: 4, ..Limits::default() };
    let gpu = Gpu::open_least(Tier::Compute, few).unwrap();
    assert_eq!(gpu.tier(), Tier::Draw);
    let told = Passes::new(&gpu.device).unwrap_err();
    let needs = |told: &GpuError, found: [u32; 2]| matches!(told, GpuError::Tier { lack: Lack::Limit { needed, limit, .. }, .. } if [*needed, *limit] == found);
    assert!(needs(&told, [8, 4]), "{told}");
    let small = Limits { max_compute_invocations_per_workgroup: 128, ..Limits::default() };
    let small = Gpu::open_least(Tier::Compute, small).unwrap();
    let told = Passes::without_occlusion(&small.device).unwrap_err();
    assert!(needs(&told, [256, 128]), "{told}");
    assert!(matches!(IdPass::new(&small.device), Err(GpuError::Tier { .. })));
    assert!(matches!(TrianglePass::new(&small.device), Err(GpuError::Tier { .. })));
    let (scene, view) = (scene(), &some_views()[0]);
    assert!(matches!(InView::new(&gpu, &scene, 6), Err(GpuError::Tier { .. })));
    let mut lists = InView::or_cpu(Ok(&gpu), &scene, 6);
    assert!(listed(&mut lists, &scene, view).unwrap() == list_ref(&scene, view));
    assert!(matches!(lists.why_cpu(), Some(GpuError::Tier { .. })));
}

#[test]
fn a_scene_beyond_the_limits_is_said_in_numbers_and_the_cpu_lists() {
    let Some(_) = gpu(Tier::Pyramid) else { return };
    let limit = 1 << 16;
    let limits = Limits {
        max_storage_buffer_binding_size: limit,
        max_buffer_size: limit,
        ..Limits::default()
    };
    let gpu = Gpu::open_least(Tier::Pyramid, limits).unwrap();
    let (scene, view) = (scene(), &some_views()[0]);
    let told = InView::new(&gpu, &scene, 6).unwrap_err();
    // Twenty blocks of 256 boxes, each of 16 bytes.
    let bytes = 20 * 256 * 16;
    assert!(
        matches!(told, GpuError::TooLarge { bytes: b, limit: l, .. } if b == bytes && l == limit)
    );
    let words = told.to_string();
    assert!(["boxes of instances", "81920", "65536"].iter().all(|w| words.contains(w)), "{words}");
    let made = OffScreen::new(&gpu.device, &gpu.queue, &scene, [64, 64]);
    assert!(matches!(made, Err(GpuError::TooLarge { .. })));
    let mut lists = InView::or_cpu(Ok(&gpu), &scene, 6);
    assert!(listed(&mut lists, &scene, view).unwrap() == list_ref(&scene, view));
    // More planes than was said, on a device that is large enough for the scene.
    let large = Gpu::open_least(Tier::Compute, Limits::default()).unwrap();
    let many: Vec<Plane> = planes_of(view, &scene).repeat(5);
    let mut few = InView::new(&large, &scene, 1).unwrap();
    assert!(matches!(few.list(&many, view.layers), Err(GpuError::TooLarge { .. })));
    let mut or_cpu = InView::or_cpu(Ok(&large), &scene, 1);
    assert!(or_cpu.list(&many, view.layers).unwrap() == list_ref(&scene, view));
}

#[test]
fn a_device_lost_in_the_middle_of_a_frame_is_told_and_another_goes_on() {
    let Some(_) = gpu(Tier::Pyramid) else { return };
    let [lost, other] = [(); 2].map(|()| Gpu::open(Tier::Pyramid).unwrap());
    let mut scene = city(4, 1, 20);
    scene.commit(&Culler::default());
    let size = [96, 64];
    let view = View::perspective([0.0, 8.0, 60.0], [0.0, 4.0, 0.0], 1.0, 0.1, 300.0, size).unwrap();
    let mut all = OffScreen::new(&lost.device, &lost.queue, &scene, size).unwrap();
    all.draw(&lost.device, &lost.queue, (&scene, &view), true).unwrap();
    let ids = |gpu: &Gpu, all: &OffScreen| texels::<u32>(gpu, all.target.ids(), 0, size);
    let before = ids(&lost, &all);
    assert!(before.iter().any(|id| *id != 0));
    lost.is_there().unwrap();

    // Between the phases.
    all.culling.set(&lost.queue, &scene, &view, 1).unwrap();
    all.target.set(&lost.queue, &view);
    let mut encoder = lost.device.create_command_encoder(&Default::default());
    all.culling.record_early(&all.passes, &mut encoder);
    all.ids.draw(&mut encoder, &all.target, (&all.culling, &view), &[Phase::Early], true);
    lost.device.destroy();
    all.culling.record_late(&all.passes, &mut encoder, &all.pyramid);
    let rest = [Phase::Late, Phase::Blended];
    all.ids.draw(&mut encoder, &all.target, (&all.culling, &view), &rest, false);
    lost.queue.submit([encoder.finish()]);

    let told = lost.finish().unwrap_err();
    assert!(matches!(told, GpuError::Lost(_)), "{told}");
    assert!(told.to_string().contains("open another"), "{told}");
    assert!(matches!(lost.is_there(), Err(GpuError::Lost(_))));
    assert!(matches!(lost.read(all.culling.visible(), 4), Err(GpuError::Lost(_))));
    // Whatever is made of it now.
    let (device, queue) = (&lost.device, &lost.queue);
    let made = Culling::new(device, queue, &all.passes, &scene);
    assert!(matches!(made, Err(GpuError::Lost(_))), "{:?}", made.err());
    let made = OffScreen::new(device, queue, &scene, size);
    assert!(matches!(made, Err(GpuError::Lost(_))), "{:?}", made.err());

    let mut all = OffScreen::new(&other.device, &other.queue, &scene, size).unwrap();
    all.draw(&other.device, &other.queue, (&scene, &view), true).unwrap();
    assert!(ids(&other, &all) == before, "another device draws the same");
}

#[test]
fn lists_go_on_where_the_device_is_lost_if_the_cpu_may_take_over() {
    let Some(_) = gpu(Tier::Compute) else { return };
    let gpu = Gpu::open(Tier::Compute).unwrap();
    let (scene, views) = (scene(), some_views());
    let mut strict = InView::new(&gpu, &scene, 6).unwrap();
    let mut lists = InView::or_cpu(Ok(&gpu), &scene, 6);
    for (number, view) in views.iter().enumerate() {
        if number == 4 {
            gpu.device.destroy();
        }
        assert!(listed(&mut lists, &scene, view).unwrap() == list_ref(&scene, view), "{number}");
        assert_eq!(lists.why_cpu().is_some(), number >= 4);
        let own = listed(&mut strict, &scene, view);
        assert_eq!(own.is_ok(), number < 4, "{own:?}");
        assert!(own.is_ok() || matches!(own, Err(GpuError::Lost(_))));
    }
}

#[test]
fn lists_follow_a_scene_that_moves_and_grows_whoever_makes_them() {
    let Some(gpu) = gpu(Tier::Compute) else { return };
    let (mut scene, view) = (scene(), &some_views()[0]);
    let mut by_device = InView::new(gpu, &scene, 6).unwrap();
    let mut by_cpu = InView::or_cpu(Err(GpuError::Lost("none".into())), &scene, 6);
    assert_eq!(by_device.uploaded(), 20 * 256 * 16);
    let mut follow = |scene: &Scene| {
        by_device.follow(scene).unwrap();
        by_cpu.follow(scene).unwrap();
        let list = listed(&mut by_device, scene, view).unwrap();
        assert!(list == list_ref(scene, view));
        assert!(list == listed(&mut by_cpu, scene, view).unwrap());
        (list.len(), by_device.uploaded())
    };
    let moved = scene.handle(700).unwrap();
    let mut transform = *scene.transform(700);
    transform.translation[0] += 0.25;
    scene.set_transform(moved, transform).unwrap();
    scene.commit(&Culler::default());
    assert!(follow(&scene).1 <= 2 * 256 * 16, "what moved and nothing else");
    // As many blocks, and more than there were.
    for more in [50, 300] {
        let before = scene.slot_count();
        for _ in 0..more {
            let instance = Instance { layers: view.layers, ..Instance::new(0, transform) };
            scene.add(instance).unwrap();
        }
        scene.commit(&Culler::default());
        assert!(scene.slot_count() > before);
        follow(&scene);
    }
}

/// OpenGL, which runs the exact stages, but reads no depth texture in a compute shader.
fn open_gl() -> Option<Gpu> {
    let only_gl = only(Backends::GL & Backends::from_env().unwrap_or(Backends::GL));
    match wait(Gpu::on(&only_gl, Tier::Compute, Features::empty(), None)) {
        Ok(gl) => Some(gl),
        Err(_) => {
            cullet_testkit::skip("OpenGL", "apt-get install libegl1 libgl1-mesa-dri");
            None
        }
    }
}

#[test]
fn open_gl_is_no_tier_that_reads_depth_and_says_so_before_a_shader_is_compiled() {
    let Some(gl) = open_gl() else { return };
    assert_eq!(gl.tier(), Tier::Compute);
    let told = Passes::new(&gl.device).unwrap_err();
    let GpuError::Tier { tier: Tier::Pyramid, lack: Lack::Depth } = told else { panic!("{told}") };
    let told = wait(Gpu::on(&only(Backends::GL), Tier::Pyramid, Features::empty(), None));
    let words = told.map(|_| ()).unwrap_err().to_string();
    let name = gl.adapter.get_info().name;
    for part in [&*name, "by OpenGL", "depth", "install", "the CPU"] {
        assert!(words.contains(part), "{words}");
    }
}

#[test]
fn open_gl_lists_what_the_cpu_lists() {
    let Some(gl) = open_gl() else { return };
    let scene = scene();
    let mut lists = InView::new(&gl, &scene, 6).unwrap();
    let mut some = 0;
    for view in some_views() {
        let list = listed(&mut lists, &scene, &view).unwrap();
        some += list.len();
        assert!(list == list_ref(&scene, &view));
    }
    assert!(some > 100 && lists.why_cpu().is_none(), "{some}");
}

#[test]
fn open_gl_draws_what_the_cpu_decides_and_what_is_in_the_view() {
    let (Some(gl), Some(gpu)) = (open_gl(), gpu(Tier::Pyramid)) else { return };
    let mut scene = city(4, 1, 20);
    scene.commit(&Culler::default());
    let size = [96, 64];
    let view = View::perspective([0.0, 8.0, 60.0], [0.0, 4.0, 0.0], 1.0, 0.1, 300.0, size).unwrap();
    let told = OffScreen::new(&gl.device, &gl.queue, &scene, size).unwrap_err();
    assert!(matches!(told, GpuError::Tier { .. }), "{told}");
    let passes = Passes::without_occlusion(&gl.device).unwrap();
    assert!(!passes.has_occlusion());
    let mut all =
        OffScreen::with_passes((&gl.device, &gl.queue, passes), &scene, size, DrawMode::Each)
            .unwrap();
    let told = all.draw(&gl.device, &gl.queue, (&scene, &view), true).unwrap_err();
    assert!(matches!(told, GpuError::Passes(_)), "{told}");

    let owners = |ids: &[u32]| {
        let mut owners: Vec<u32> = ids.iter().copied().filter(|id| *id != 0).collect();
        owners.sort_unstable();
        owners.dedup();
        owners
    };
    all.draw(&gl.device, &gl.queue, (&scene, &view), false).unwrap();
    let in_view = texels::<u32>(&gl, all.target.ids(), 0, size);
    assert!(owners(&in_view).len() > 5);
    let mut visible = Visible::default();
    Culler::default().cull_one(&scene, &view, &mut ViewState::default(), &mut visible);
    all.draw_decided(&gl.device, &gl.queue, (&scene, &view), &visible).unwrap();
    let decided = texels::<u32>(&gl, all.target.ids(), 0, size);
    assert!(decided == in_view, "the same picture, of less");

    let mut vulkan = OffScreen::new(&gpu.device, &gpu.queue, &scene, size).unwrap();
    vulkan.draw(&gpu.device, &gpu.queue, (&scene, &view), true).unwrap();
    let there = texels::<u32>(gpu, vulkan.target.ids(), 0, size);
    let differ = there.iter().zip(&in_view).filter(|(a, b)| a != b).count();
    assert_eq!(differ, 0, "of {}", there.len());
}
