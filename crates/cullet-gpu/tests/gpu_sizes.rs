//! Tests of instances that are small in the picture: dropped only where the engine drops them, most
//! of them found, and the same by every device.

use crate::common;

use cullet::bounds::Plane;
use cullet::cull::detail::Detail;
use cullet::{Culler, Instance, Output, Scene, Stage, Transform, View};
use cullet_gpu::{BlockPlanes, Blocks, DrawMode, OffScreen, SizeRule, Tier, visible_ref};
use cullet_scenes::paths::{Overrides, PathSpec, views};
use cullet_testkit::answers::{cull, slots};
use cullet_testkit::scenes::{elsewhere, random_scene};
use cullet_testkit::views::{look, random_view};
use cullet_testkit::{Rng, meshes};

use common::gpu;

/// Small things in clumps, as grass and screws are, some of them weighted.
fn clumps(rng: &mut Rng, weighted: bool) -> Scene {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(meshes::tetrahedron());
    for _ in 0..8 {
        let clump = [rng.range(-60.0, 60.0), rng.range(-9.0, 9.0), rng.range(-90.0, 50.0)];
        for _ in 0..200 {
            let place = clump.map(|v| v + rng.range(-4.0, 4.0));
            let scale = [0; 3].map(|_: i32| rng.range(0.01, 0.6));
            let mut instance = Instance::new(
                mesh,
                Transform::from_scale_rotation_translation(scale, [0.0, 0.0, 0.0, 1.0], place),
            );
            if weighted && rng.below(300) == 0 {
                instance.size_weight =
                    [0.0, 3.0, 40.0, f32::INFINITY, f32::NAN][rng.below(5) as usize];
            }
            scene.add(instance).expect("few");
        }
    }
    scene
}

fn planes_of(view: &View, scene: &Scene) -> Vec<Plane> {
    view.frustum().relative_to(scene.origin()).planes().map(|(_, plane)| *plane).collect()
}

/// The slots that are in view and not small, by the oracle of the passes.
fn listed(blocks: &Blocks, scene: &Scene, view: &View, threshold_px: f32) -> Vec<u32> {
    let mut planes = BlockPlanes::default();
    let rule = SizeRule::new(view, scene.origin(), threshold_px);
    planes.set_with(blocks, &planes_of(view, scene), view.layers, rule.as_ref());
    visible_ref(blocks, &planes)
}

#[test]
fn what_is_not_small_is_kept() {
    let mut rng = Rng(21);
    let (mut by_engine, mut found, mut parallel) = (0, 0, 0);
    for round in 0..60 {
        let mut scene = match round % 3 {
            0 => random_scene(&mut rng, 400),
            1 => clumps(&mut rng, false),
            _ => clumps(&mut rng, true),
        };
        let mut views: Vec<View> = (0..8).map(|_| random_view(&mut rng)).collect();
        if round % 4 == 3 {
            views = vec![elsewhere(&mut scene, &views[0], &mut rng)];
        }
        scene.commit(&Culler::default());
        if round % 5 == 4 {
            scene.rebase([100.0, 0.0, -1e5]);
        }
        let blocks = Blocks::new(&scene);
        for view in &views {
            let threshold_px = 10_f64.powf(rng.range(-1.0, 2.0)) as f32;
            let detail = Detail::default().with_threshold_px(threshold_px.into());
            let output = Output::Instances;
            let frustum = Culler::default().only(Stage::Frustum);
            let culler = frustum.with_output(output).with_detail(detail);
            let kept = slots(&cull(&culler, &scene, view));
            let own = listed(&blocks, &scene, view, threshold_px);
            // Far from the origin the planes of the engine, in f32, reject less.
            let plain = listed(&blocks, &scene, view, 0.0);
            let has = |list: &[u32], slot: &u32| list.binary_search(slot).is_ok();
            // The bounds of engine and passes differ: what only one of them proves to be small goes for one.
            let is_small = |slot: u32| {
                let rect = view.project_box(&scene.bounds(slot), scene.origin());
                let weight = f64::from(scene.size_weight(slot));
                let size = rect.map(|rect| [rect.width(), rect.height()]);
                size.is_some_and(|size| detail.is_small_size(size, weight))
            };
            let is_lost = |s: &&u32| has(&plain, s) && !has(&own, s) && !is_small(**s);
            let lost: Vec<_> = kept.iter().filter(is_lost).collect();
            assert!(lost.is_empty(), "round {round}, {threshold_px} pixels, {lost:?}, {view:?}");
            let gone = plain.iter().filter(|slot| !has(&kept, slot)).count();
            by_engine += gone;
            let fewer = plain.len() - own.len();
            found += fewer;
            parallel += if view.is_orthographic() { fewer } else { 0 };
        }
    }
    assert!(by_engine > 5000 && parallel > 50, "{by_engine}, {parallel}");
    assert!(found * 100 > by_engine * 40, "{found} of {by_engine}");
}

/// Slots that the engine drops because they are small, and how many of them the passes drop, in views along paths.
fn shares(name: &str, path: &PathSpec, threshold_px: f32) -> [usize; 2] {
    let model = cullet_scenes::build(name).unwrap();
    let scene = &model.scene;
    let blocks = Blocks::new(scene);
    let detail = Detail::default().with_threshold_px(threshold_px.into());
    let (output, detail) = (Output::Instances, Some(detail));
    let culler = Culler::default().only(Stage::Frustum).with_output(output).with_detail(detail);
    let all = views(&model, path, 6, [1280, 720], &Overrides::default()).unwrap();
    let of_view = |view: &View| {
        let kept = slots(&cull(&culler, scene, view));
        let plain = listed(&blocks, scene, view, 0.0);
        let own = listed(&blocks, scene, view, threshold_px).len();
        [plain.iter().filter(|slot| kept.binary_search(slot).is_err()).count(), plain.len() - own]
    };
    all.iter().map(of_view).fold([0; 2], |sum, own| [sum[0] + own[0], sum[1] + own[1]])
}

#[test]
fn most_of_what_the_engine_drops_is_dropped() {
    let paths = [
        ("city:cells=16,objects=6000,sub=2", PathSpec::Walk, 20.0),
        ("forest:n=20000", PathSpec::Fly, 20.0),
    ];
    for (name, path, threshold_px) in paths {
        let [by_engine, found] = shares(name, &path, threshold_px);
        assert!(
            by_engine > 10_000 && found * 100 >= by_engine * 92,
            "{name}: {found} of {by_engine}"
        );
    }
}

#[test]
fn a_threshold_that_is_none_drops_nothing() {
    let mut rng = Rng(22);
    let mut scene = clumps(&mut rng, false);
    scene.commit(&Culler::default());
    let blocks = Blocks::new(&scene);
    let view = look([0.0, 40.0, 200.0], [0.0, 0.0, -20.0], [640, 480]);
    let all = listed(&blocks, &scene, &view, 0.0);
    assert!(all.len() > 500);
    for threshold in [-1.0, f32::NAN] {
        assert_eq!(listed(&blocks, &scene, &view, threshold), all);
    }
    assert!(listed(&blocks, &scene, &view, f32::INFINITY).len() <= all.len());
    assert!(listed(&blocks, &scene, &view, 4.0).len() < all.len() / 2);
}

#[test]
fn devices_agree_to_the_byte_in_every_mode() {
    let Some(gpu) = gpu(Tier::Pyramid) else { return };
    let mut rng = Rng(23);
    let (mut dropped, mut all) = (0, 0);
    for round in 0..6 {
        let mut scene = match round % 2 {
            0 => random_scene(&mut rng, 300),
            _ => clumps(&mut rng, true),
        };
        scene.commit(&Culler::default());
        let modes = [DrawMode::Each, DrawMode::Clusters];
        let can =
            |mode| mode == DrawMode::Each || DrawMode::of(&gpu.device, &scene) != DrawMode::Each;
        for mode in modes.into_iter().filter(|mode| can(*mode)) {
            let (device, queue) = (&gpu.device, &gpu.queue);
            let mut stage = OffScreen::with_mode(device, queue, &scene, [64, 48], mode).unwrap();
            for _ in 0..8 {
                let view = random_view(&mut rng);
                let mut in_view = |small_px| {
                    stage.culling.settings.small_px = small_px;
                    stage.draw(device, queue, (&scene, &view), false).unwrap();
                    let expected = stage.culling.in_view_ref();
                    let bits = stage.culling.in_view();
                    let words: Vec<u32> =
                        bytemuck::pod_collect_to_vec(&gpu.read(bits, bits.size()).unwrap());
                    let is_set = |n: &u32| words[*n as usize / 32] >> (n % 32) & 1 != 0;
                    let numbers = 0..words.len() as u32 * 32;
                    assert!(numbers.filter(is_set).collect::<Vec<_>>() == expected, "{view:?}");
                    expected.len()
                };
                let (plain, own) = (in_view(0.0), in_view(10_f32.powf(rng.unit() as f32 * 2.0)));
                all += plain;
                dropped += plain - own;
            }
        }
    }
    assert!(all > 5000 && dropped * 20 > all, "{dropped} of {all}");
}
