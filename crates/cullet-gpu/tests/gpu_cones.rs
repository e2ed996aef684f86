//! Clusters that face away: dropped only where every triangle of theirs is culled, the same ones by every device, and no picture
//! differs.

use crate::common;

use cullet::bounds::Aabb;
use cullet::cull::backface::{EllipticCone, Facing, ViewEye};
use cullet::{
    Instance, Scene, Simd, Transform, View,
    prepared::Preparation,
    view::{CullFace, FrontFace},
};
use cullet_gpu::{ConeEye, DrawMode, Gpu, Grid, GridCone, OffScreen, Settings, Tier};
use cullet_testkit::Rng;
use cullet_testkit::meshes::{ball, one_sided};
use cullet_testkit::scenes::{elsewhere, mixed_scene, random_transform};
use cullet_testkit::soups;
use cullet_testkit::vectors::dot;
use cullet_testkit::views::{look, mixed_view, random_view};

use common::{gpu, texels};

/// Turned by some angle, with one size along all axes.
fn turned(rng: &mut Rng, reach: f64) -> Transform {
    let (angle, size) = (rng.range(0.0, 6.3), 10f64.powf(rng.range(-0.5, 0.5)));
    let (sin, cos) = (angle * 0.5).sin_cos();
    let axis = rng.direction().map(|v| v * sin);
    Transform::from_scale_rotation_translation(
        [size; 3],
        [axis[0], axis[1], axis[2], cos],
        rng.vector(reach),
    )
}

/// Meshes of many clusters, prepared for both sides, and instances of them, of which some are mirrored, stretched or flat.
fn scene_of_clusters(rng: &mut Rng, instances: usize) -> Scene {
    let mut scene = Scene::new();
    let lifted = |p: [f32; 3]| [p[0] * 0.2 + 3e3, p[1] * 0.2 - 7e3, p[2] * 0.2];
    scene.add_mesh(ball(40));
    scene.add_mesh(one_sided(soups::bumpy_ball(40, 0.1)));
    scene.add_mesh(one_sided(soups::divided_block(12)));
    // Far from its own zero, and flat.
    scene.add_mesh(one_sided(soups::moved(soups::ball(24, 48), lifted)));
    scene.add_mesh(one_sided(soups::terrain(24)));
    scene.prepare(Preparation::ALL);
    for _ in 0..instances {
        let t = if rng.chance(0.5) { turned(rng, 9.0) } else { random_transform(rng) };
        let mut instance = Instance::new(rng.below(5) as u32, t);
        instance.flags.double_sided = rng.chance(0.1);
        scene.add(instance).expect("the mesh exists");
    }
    scene
}

#[test]
fn what_is_behind_in_integers_is_culled_triangle_by_triangle() {
    let mut rng = Rng(3);
    let (mut found, mut engine, mut parallel) = (0, 0, 0);
    for round in 0..40 {
        let mut scene = scene_of_clusters(&mut rng, 12);
        let mut views: Vec<View> = (0..6).map(|_| random_view(&mut rng)).collect();
        if round % 4 == 3 {
            views = vec![elsewhere(&mut scene, &views[0], &mut rng)];
        }
        scene.commit(&cullet::Culler::default());
        for (view, slot) in views.iter().flat_map(|view| scene.slots().map(move |s| (view, s))) {
            let (mesh, prepared) = (scene.mesh(slot), scene.prepared_of(slot));
            let view_eye = ViewEye::new(view);
            let exact = view_eye.in_space_of(scene.transform(slot));
            let Some(cones) = prepared.cluster_cones(view_eye.culled_side()) else { continue };
            let Some(eye) = prepared.backfaces().and_then(|b| b.eye(&exact)) else { continue };
            let grid = Grid::around(&mesh.bounds());
            let on_grid = ConeEye::new(eye.homogeneous(), &grid);
            let mut culled = Vec::new();
            cones.cull(Simd::best(), &eye, &mut culled);
            for (number, cluster) in mesh.clusters().iter().enumerate() {
                engine += culled[number / 64] >> (number % 64) & 1;
                let cone = cones.get(number).map(|cone| GridCone::new(&cone, &grid));
                if !cone.is_some_and(|cone| cone.is_behind(&on_grid)) {
                    continue;
                }
                found += 1;
                parallel += u64::from(view.is_orthographic());
                let seen = cluster.triangles().find(|t| !exact.culls(&mesh.corners(*t)));
                assert_eq!(seen, None, "round {round}, slot {slot}, cluster {number}, {view:?}");
            }
        }
    }
    // What 13 bits of vectors lose of what the engine's cones cull.
    assert!(found > 15_000 && parallel > 4000, "{found}, {parallel}");
    assert!(found * 1000 >= engine * 995, "{found} of {engine}");
}

#[test]
fn an_eye_that_is_none_keeps_all() {
    let mut scene = Scene::new();
    scene.add_mesh(one_sided(soups::divided_block(8)));
    scene.prepare(Preparation::ALL);
    let mesh = &scene.meshes()[0];
    let cones = scene.prepared()[0].cluster_cones(Facing::Back).expect("flat clusters");
    let grid = Grid::around(&mesh.bounds());
    let behind = |eye: [f64; 4]| {
        let all = (0..mesh.clusters().len()).filter_map(|c| cones.get(c));
        let eye = ConeEye::new(eye, &grid);
        all.filter(|cone| GridCone::new(cone, &grid).is_behind(&eye)).count()
    };
    // Clusters go round edges, but none round the block: those of three sides are behind, or of a corner.
    assert!(behind([1e3, 1e3, 1e3, 1.0]) >= 4 && behind([1.0, 1.0, 1.0, 0.0]) >= 4);
    for eye in [
        [f64::NAN, 0.0, 1e3, 1.0],
        [0.0, 0.0, 1e3, f64::NAN],
        [0.0, 0.0, f64::INFINITY, 1.0],
        [0.0, 0.0, 1e30, 1.0],
        [0.0, 0.0, 1e3, -1.0],
        [0.0; 4],
    ] {
        assert_eq!(behind(eye), 0, "{eye:?}");
    }
    // The eye on a plane, and beyond it.
    let corner = mesh.bounds().max.map(f64::from);
    let at = |d: f64| behind([corner[0] + d, corner[1] + d, corner[2] + d, 1.0]);
    assert!(at(0.0) <= at(1e-2) && at(1e-2) > 0, "{} {}", at(0.0), at(1e-2));
}

/// Whether an eye is within a cone, in f64.
fn is_within(cone: &EllipticCone, eye: [f64; 3]) -> bool {
    let way: [f64; 3] = std::array::from_fn(|a| eye[a] - f64::from(cone.apex[a]));
    let [z, s, t] = [cone.axis, cone.s, cone.t].map(|v| dot(v.map(f64::from), way));
    z < 0.0 && z * z > s * s + t * t
}

#[test]
fn a_cone_whose_apex_is_not_on_the_grid_is_within_the_one_it_was() {
    let mut rng = Rng(8);
    let mut scene = Scene::new();
    scene.add_mesh(one_sided(soups::bumpy_ball(40, 0.3)));
    scene.prepare(Preparation::ALL);
    let cones = scene.prepared()[0].cluster_cones(Facing::Back).expect("some are narrow");
    let all: Vec<_> =
        (0..scene.meshes()[0].clusters().len()).filter_map(|c| cones.get(c)).collect();
    let (mut behind, mut within) = (0, 0);
    for _ in 0..20_000 {
        let cone = all[rng.index(all.len())];
        let (middle, size) = (rng.vector(1.0), rng.range(0.2, 2.0));
        let corner = |by: f64| middle.map(|v| (v + by) as f32);
        let grid = Grid::around(&Aabb::new(corner(-size), corner(size)));
        let eye = rng.vector(5.0);
        let found = GridCone::new(&cone, &grid)
            .is_behind(&ConeEye::new([eye[0], eye[1], eye[2], 1.0], &grid));
        assert!(!found || is_within(&cone, eye), "{cone:?} {grid:?} {eye:?}");
        behind += u32::from(found);
        within += u32::from(is_within(&cone, eye));
    }
    // Many apexes are many times as far away as the grid is large, and the eye is not behind the grid.
    assert!(behind * 3 > within && behind < within, "{behind} of {within}");
}

fn off_screen(gpu: &Gpu, scene: &Scene, view: &View) -> OffScreen {
    let (device, queue) = (&gpu.device, &gpu.queue);
    OffScreen::with_mode(device, queue, scene, view.viewport(), DrawMode::Clusters).unwrap()
}

/// The numbers of the units that are in view, by the device.
fn in_view(gpu: &Gpu, stage: &OffScreen) -> Vec<u32> {
    let bits = stage.culling.in_view();
    let words: Vec<u32> = bytemuck::pod_collect_to_vec(&gpu.read(bits, bits.size()).unwrap());
    (0..words.len() as u32 * 32).filter(|n| words[*n as usize / 32] >> (n % 32) & 1 != 0).collect()
}

#[test]
fn devices_agree_to_the_byte() {
    let Some(gpu) = gpu(Tier::MultiDraw) else { return };
    let mut rng = Rng(4);
    let (mut dropped, mut all) = (0, 0);
    for instances in [0, 1, 3, 40, 150] {
        let mut scene = scene_of_clusters(&mut rng, instances);
        scene.commit(&cullet::Culler::default());
        let mut stage: Option<OffScreen> = None;
        for number in 0..10 {
            let mut view = random_view(&mut rng);
            if number == 4 {
                // Both sides in turn on the same buffers.
                view.cull_face = CullFace::Front;
                view.front_face = FrontFace::CounterClockwise;
            }
            let stage = stage.get_or_insert_with(|| off_screen(gpu, &scene, &view));
            let [by_planes, with_cones] = [false, true].map(|backfaces| {
                stage.culling.settings.backfaces = backfaces;
                stage.draw(&gpu.device, &gpu.queue, (&scene, &view), false).unwrap();
                let expected = stage.culling.in_view_ref();
                assert!(in_view(gpu, stage) == expected, "{instances} instances, {view:?}");
                expected.len()
            });
            dropped += by_planes - with_cones;
            all += by_planes;
        }
    }
    assert!(all > 10_000 && dropped * 10 > all, "{dropped} of {all}");
}

#[test]
fn pictures_are_the_same_without() {
    let Some(gpu) = gpu(Tier::MultiDraw) else { return };
    let mut rng = Rng(5);
    let (mut pixels, mut fewer) = (0, 0);
    for round in 0..36 {
        let size = [[64, 48], [201, 117], [640, 361]][rng.index(3)];
        let mut scene = match round % 3 {
            0 => mixed_scene(&mut rng),
            _ => scene_of_clusters(&mut rng, 6),
        };
        let mut views: Vec<View> = (0..4).map(|_| mixed_view(&mut rng, size)).collect();
        if round % 4 == 3 {
            views = vec![elsewhere(&mut scene, &views[0], &mut rng)];
        } else {
            views.push(look([7.0, 3.0, 5.0], [0.0; 3], size));
        }
        scene.commit(&cullet::Culler::default());
        let [mut stage, mut without] = [0, 1].map(|_| off_screen(gpu, &scene, &views[0]));
        without.culling.settings = Settings { backfaces: false, ..Settings::default() };
        for view in &views {
            let [found, expected] = [&mut stage, &mut without].map(|stage| {
                stage.draw(&gpu.device, &gpu.queue, (&scene, view), true).unwrap();
                let (ids, depth) = (stage.target.ids(), stage.target.depth());
                (texels::<u32>(gpu, ids, 0, size), texels::<f32>(gpu, depth, 0, size))
            });
            let wrong = found.1.iter().zip(&expected.1).filter(|(a, b)| a != b).count();
            assert_eq!(wrong, 0, "round {round}, pixels of another depth, {view:?}");
            // Where two are equally near, another may have been drawn first.
            let ties = found.0.iter().zip(&expected.0).filter(|(a, b)| a != b).count();
            assert!(ties == 0 || round % 3 == 0, "round {round}, {ties} pixels, {view:?}");
            pixels += found.0.iter().filter(|id| **id > 0).count();
            fewer += in_view(gpu, &without).len() - in_view(gpu, &stage).len();
        }
    }
    assert!(pixels > 500_000 && fewer > 1000, "{pixels}, {fewer}");
}

#[test]
fn cones_follow_what_moves() {
    let Some(gpu) = gpu(Tier::MultiDraw) else { return };
    let mut rng = Rng(6);
    let mut scene = scene_of_clusters(&mut rng, 20);
    scene.commit(&cullet::Culler::default());
    let view = look([12.0, 5.0, 9.0], [0.0; 3], [100, 80]);
    let mut stage = off_screen(gpu, &scene, &view);
    for _ in 0..4 {
        for slot in 0..scene.slot_count() {
            let to = turned(&mut rng, 9.0);
            scene.set_transform(scene.handle(slot).unwrap(), to).unwrap();
        }
        scene.commit(&cullet::Culler::default());
        stage.follow(&gpu.device, &gpu.queue, &scene).unwrap();
        stage.draw(&gpu.device, &gpu.queue, (&scene, &view), false).unwrap();
        let mut anew = off_screen(gpu, &scene, &view);
        anew.draw(&gpu.device, &gpu.queue, (&scene, &view), false).unwrap();
        assert!(stage.culling.in_view_ref() == anew.culling.in_view_ref());
        assert!(in_view(gpu, &stage) == stage.culling.in_view_ref());
    }
}
