//! Levels of detail chosen on the device: each place drawn once, by nothing coarser than the engine allows, and the same by every
//! device.

use crate::common;

use cullet::lod::{LevelEye, Lod, NO_GROUP, PixelScale};
use cullet::{Culler, Instance, Scene, Simd, Stage, Transform, View, ViewState, Visible};
use cullet_gpu::{ClusterInstances, DrawMode, Gpu, GpuScene, LevelChoice, OffScreen, Tier};
use cullet_testkit::Rng;
use cullet_testkit::scenes::{elsewhere, random_transform};
use cullet_testkit::steps::{Balls, Strip};
use cullet_testkit::views::{look, mixed_view, random_view};

use common::{gpu, texels};

/// Balls with a chain of levels, strips with a hierarchy, and balls without, and where the strips' clusters reach.
fn scene_of_levels(rng: &mut Rng, instances: usize) -> (Scene, Vec<[u32; 2]>) {
    let mut scene = Scene::new();
    let balls = Balls::new(&[32, 16, 8, 4], 1.0).add_to(&mut scene);
    let strip = Strip::random(rng, 5, false);
    let (levels, spans) = (strip.levels(), strip.spans.clone());
    let own = scene.add_mesh(strip.mesh);
    let steps = scene.add_mesh(strip.steps);
    scene.add_levels(own, steps, levels).expect("made for it");
    let plain = scene.add_mesh(cullet_testkit::meshes::ball(12));
    for _ in 0..instances {
        let mesh = [balls, own, plain][rng.index(3)];
        let size = rng.range(0.02, 1.0);
        let t = match rng.chance(0.7) {
            true => Transform::from_scale_rotation_translation(
                [size; 3],
                [0.0, 0.6, 0.0, 0.8],
                rng.vector(9.0),
            ),
            false => random_transform(rng),
        };
        scene.add(Instance::new(mesh, t)).expect("the mesh exists");
    }
    (scene, spans)
}

#[test]
fn each_place_is_drawn_once_and_by_nothing_too_coarse() {
    let Some(gpu) = gpu(Tier::MultiDraw) else { return };
    let mut rng = Rng(31);
    let (mut drawn, mut by_engine, mut in_full, mut coarse) = (0, 0, 0, 0);
    for round in 0..12 {
        let (mut scene, spans) = scene_of_levels(&mut rng, 30);
        let mut views: Vec<View> = (0..8).map(|_| random_view(&mut rng)).collect();
        if round % 4 == 3 {
            views = vec![elsewhere(&mut scene, &views[0], &mut rng)];
        }
        scene.commit(&Culler::default());
        let on_device = GpuScene::new(&gpu.device, &gpu.queue, &scene).unwrap();
        let clusters = ClusterInstances::of(&scene, &on_device);
        let mut choice = LevelChoice::new(&scene, &clusters).expect("there are levels");
        let all: Vec<u32> = (0..clusters.len()).collect();
        let of = |number: &u32| {
            let at = *number as usize;
            (clusters.slots()[at], clusters.levels()[at], clusters.clusters()[at])
        };
        for view in &views {
            let pixels = 10_f64.powf(rng.range(-1.0, 1.5)) as f32;
            choice.set(&scene, view, pixels);
            let list = choice.keep_ref(&all);
            let lod = Lod::default().with_pixels(pixels.into());
            let scale = PixelScale::of(view, false);
            for slot in scene.slots() {
                let own: Vec<_> = list.iter().map(of).filter(|own| own.0 == slot).collect();
                let levels = scene.levels(scene.mesh_id(slot)).first();
                let mesh = scene.mesh(slot);
                let whole = mesh.clusters().len();
                let what = format!("round {round}, slot {slot}, {pixels} pixels, {view:?}");
                let Some(levels) = levels.map(|l| &l.levels) else {
                    let of_level = all.iter().map(of).filter(|own| own.0 == slot).count();
                    assert!(own.len() == of_level && of_level <= whole, "{what}");
                    continue;
                };
                let eye = LevelEye::new(&lod, &scale, scene.transform(slot), None);
                let mut made_from: Vec<u32> = Vec::new();
                for (_, level, cluster) in &own {
                    let group = match level {
                        0 => NO_GROUP,
                        _ => levels.made_from()[*cluster as usize],
                    };
                    let is_over = group != NO_GROUP && eye.is_over(&levels.group(group as usize));
                    assert!(!is_over, "{what}: coarser than the engine allows");
                    made_from.push(group);
                    let mesh = scene.mesh_at(slot, *level);
                    drawn += u64::from(mesh.clusters()[*cluster as usize].triangle_count);
                    coarse += u32::from(group != NO_GROUP);
                }
                if levels.original_clusters() == 0 {
                    // A chain: all of one level.
                    made_from.dedup();
                    let [one] = made_from[..] else { panic!("{what}: {made_from:?}") };
                    let of_level = |group: &&u32| **group == one;
                    let expected = match one {
                        NO_GROUP => whole,
                        _ => levels.made_from().iter().filter(of_level).count(),
                    };
                    assert_eq!(own.len(), expected, "{what}");
                } else {
                    let mut reached: Vec<[u32; 2]> =
                        own.iter().map(|(_, _, cluster)| spans[*cluster as usize]).collect();
                    reached.sort_unstable();
                    let ends = reached.windows(2).all(|pair| pair[0][1] == pair[1][0]);
                    let (first, last) = (reached[0][0], reached[reached.len() - 1][1]);
                    assert!(ends && (first, last) == (0, 32), "{what}: {reached:?}");
                }
                let mut selection = cullet::lod::Selection::default();
                let triangles = u64::from(mesh.triangle_count());
                let is_here = levels.select(Simd::best(), &eye, &mut selection);
                by_engine += if is_here { selection.triangle_count() } else { triangles };
                in_full += triangles;
            }
        }
    }
    assert!(coarse > 1000 && by_engine * 4 < in_full * 3, "{coarse}, {by_engine} of {in_full}");
    // What rounding to the finer costs.
    assert!(drawn * 100 <= by_engine * 103, "{drawn} drawn, {by_engine} by the engine");
}

fn off_screen(gpu: &Gpu, scene: &Scene, size: [u32; 2], mode: DrawMode) -> OffScreen {
    OffScreen::with_mode(&gpu.device, &gpu.queue, scene, size, mode).unwrap()
}

/// The numbers of the units that are in view, by the device.
fn in_view(gpu: &Gpu, stage: &OffScreen) -> Vec<u32> {
    let bits = stage.culling.in_view();
    let words: Vec<u32> = bytemuck::pod_collect_to_vec(&gpu.read(bits, bits.size()).unwrap());
    (0..words.len() as u32 * 32).filter(|n| words[*n as usize / 32] >> (n % 32) & 1 != 0).collect()
}

/// The depth of a frame.
fn drawn(gpu: &Gpu, stage: &mut OffScreen, on: (&Scene, &View), occlusion: bool) -> Vec<f32> {
    stage.draw(&gpu.device, &gpu.queue, on, occlusion).unwrap();
    texels(gpu, stage.target.depth(), 0, on.1.viewport())
}

#[test]
fn devices_agree_to_the_byte_and_pictures_to_the_pixel() {
    let Some(gpu) = gpu(Tier::MultiDraw) else { return };
    let mut rng = Rng(32);
    let size = [160, 120];
    let (mut fewer, mut differ) = (0, 0);
    for _ in 0..8 {
        let (mut scene, _) = scene_of_levels(&mut rng, 24);
        scene.commit(&Culler::default());
        let [mut stage, mut all] =
            [0; 2].map(|_| off_screen(gpu, &scene, size, DrawMode::Clusters));
        let mut without = off_screen(gpu, &scene, size, DrawMode::Each);
        for number in 0..6 {
            let view = match number {
                0..4 => mixed_view(&mut rng, size),
                _ => look([20.0, 9.0, 30.0 * f64::from(number)], [0.0; 3], size),
            };
            let on = (&scene, &view);
            stage.culling.settings.level_px = 0.0;
            let in_full = drawn(gpu, &mut stage, on, true);
            assert!(in_view(gpu, &stage) == stage.culling.in_view_ref(), "{view:?}");
            assert!(in_full == drawn(gpu, &mut without, on, true), "in full: {view:?}");
            let before = in_view(gpu, &stage).len();
            let pixels = 10_f32.powf(rng.unit() as f32 * 2.0 - 0.5);
            for stage in [&mut stage, &mut all] {
                stage.culling.settings.level_px = pixels;
            }
            let by_levels = drawn(gpu, &mut stage, on, true);
            assert!(in_view(gpu, &stage) == stage.culling.in_view_ref(), "{pixels}, {view:?}");
            assert!(by_levels == drawn(gpu, &mut all, on, false), "{pixels} pixels, {view:?}");
            fewer += before - in_view(gpu, &stage).len().min(before);
            differ += u32::from(by_levels != in_full);
        }
    }
    assert!(fewer > 500 && differ > 10, "{fewer} fewer, {differ} pictures");
}

#[test]
fn levels_that_the_cpu_chose_are_drawn() {
    let Some(gpu) = gpu(Tier::MultiDraw) else { return };
    let mut rng = Rng(33);
    let (mut scene, _) = scene_of_levels(&mut rng, 24);
    scene.commit(&Culler::default());
    let size = [160, 120];
    let mut stage = off_screen(gpu, &scene, size, DrawMode::Clusters);
    let mut coarse = 0;
    for distance in [10.0, 30.0, 90.0] {
        let view = look([distance * 0.3, distance * 0.2, distance], [0.0; 3], size);
        let culler = Culler::default().only(Stage::Frustum).with_lod(Lod::default());
        let mut visible = Visible::default();
        culler.cull_one(&scene, &view, &mut ViewState::default(), &mut visible);
        let (device, queue) = (&gpu.device, &gpu.queue);
        stage.draw_decided(device, queue, (&scene, &view), &visible).unwrap();
        let bits = stage.culling.visible();
        let words: Vec<u32> = bytemuck::pod_collect_to_vec(&gpu.read(bits, bits.size()).unwrap());
        let set: u32 = words.iter().map(|word| word.count_ones()).sum();
        let whole = visible.whole.iter().flat_map(|range| range.first..range.first + range.count);
        let of_whole: u32 = whole.map(|slot| scene.mesh(slot).clusters().len() as u32).sum();
        let of_part: u32 = visible.partial.iter().map(|of| of.cluster_count).sum();
        assert_eq!(set, of_whole + of_part, "from {distance}");
        coarse += visible.partial.iter().filter(|of| of.level > 0).count();
    }
    assert!(coarse > 10, "{coarse}");
}
