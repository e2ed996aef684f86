//! Detail: what is small goes, whole nodes of it at once.

use cullet::bounds::Aabb;
use cullet::cull::detail::{Detail, Measure};
use cullet::{Culler, Instance, Output, Scene, Simd, Stage, Transform, View};
use cullet_testkit::answers::cull;
use cullet_testkit::views::{look, random_view};
use cullet_testkit::{Rng, cases, meshes, soups};
use proptest::prelude::*;

const MEASURES: [Measure; 3] = [Measure::WidthAndHeight, Measure::Area, Measure::Diameter];

/// Small things in clumps, as grass and screws are, some of them weighted.
fn clumps(rng: &mut Rng, weighted: bool) -> Scene {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(meshes::tetrahedron());
    for _ in 0..8 {
        let clump = [rng.range(-200.0, 200.0), rng.range(-9.0, 9.0), rng.range(-400.0, 50.0)];
        for _ in 0..200 {
            let place = clump.map(|v| v + rng.range(-4.0, 4.0));
            let scale = [0; 3].map(|_: i32| rng.range(0.01, 0.6));
            let mut instance = Instance::new(
                mesh,
                Transform::from_scale_rotation_translation(scale, [0.0, 0.0, 0.0, 1.0], place),
            );
            if weighted && rng.below(9) == 0 {
                instance.size_weight =
                    [0.0, 3.0, 40.0, f32::INFINITY, f32::NAN][rng.below(5) as usize];
            }
            scene.add(instance).expect("few");
        }
    }
    scene.commit(&Culler::default());
    scene
}

/// Clip w of a point.
fn depth_of(view: &View, point: [f32; 3]) -> f64 {
    let m = view.clip_from_world();
    let [x, y, z] = point.map(f64::from);
    m[3] * x + m[7] * y + m[11] * z + m[15]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(40), ..ProptestConfig::default() })]

    #[test]
    fn what_goes_is_small_by_itself_and_hardly_anything_small_stays(seed in any::<u64>()) {
        let mut rng = Rng(seed);
        let mut scene = clumps(&mut rng, seed % 2 == 0);
        if seed % 3 == 0 {
            scene.rebase([100.0, 0.0, -1e5]);
        }
        // Below no node until the next commit.
        let late = Instance::new(0, Transform::from_translation([0.0, 0.0, -30.0]));
        let late = scene.add(late).expect("few");
        for round in 0..6 {
            let view = random_view(&mut rng);
            let threshold_px = 10_f64.powf(rng.range(-1.0, 2.0));
            let measure = MEASURES[rng.below(3) as usize];
            let detail = Detail::default().with_measure(measure).with_threshold_px(threshold_px);
            let culler = Culler::default().only(Stage::Detail).with_detail(detail).with_output(Output::Instances).with_reasons(true);
            let result = cull(&culler, &scene, &view);
            for level in Simd::all() {
                let again = cull(&culler.clone().with_simd(level), &scene, &view);
                prop_assert!(again == result, "{:?}", level);
            }
            for slot in scene.slots() {
                let rect = view.project_box(&scene.bounds(slot), scene.origin());
                let size = rect.map(|r| [r.width(), r.height()]);
                let weight = f64::from(scene.size_weight(slot));
                let small = size.is_some_and(|size| detail.is_small_size(size, weight));
                let gone = result.reasons[slot as usize].is_some();
                prop_assert!(small || !gone, "slot {} of round {}: {:?}", slot, round, size);
                // Far from the origin f32 bounds too wide to say more, and what touches the near plane has no bound.
                let b = scene.bounds(slot);
                let grown = Aabb::new(b.min.map(|v| v - 0.01), b.max.map(|v| v + 0.01));
                let is_ahead = view.project_box(&grown, scene.origin()).is_some();
                if small && !gone && seed % 3 != 0 && is_ahead {
                    let depths = b.corners().map(|c| depth_of(&view, c));
                    let [near, far] = [f64::min, f64::max].map(|f| depths.into_iter().reduce(f).unwrap());
                    let wide = size.map(|size| size.map(|v| v * far / near * 1.3));
                    prop_assert!(
                        !wide.is_some_and(|size| detail.is_small_size(size, weight)),
                        "slot {slot} of round {round} stays: {size:?}, depths {near} to {far}"
                    );
                }
            }
            scene.set_size_weight(late, round as f32).expect("live");
        }
    }
}

#[test]
fn clusters_go_by_themselves_only_where_asked() {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(meshes::ball(40));
    scene.add(Instance::new(mesh, Transform::from_translation([0.0, 0.0, -60.0]))).expect("one");
    scene.commit(&Culler::default());
    let view: View = look([0.0; 3], [0.0, 0.0, -1.0], [640, 360]);
    let detail = Detail::default().with_threshold_px(4.0);
    let left = |clusters| {
        let detail = Some(detail.with_clusters(clusters));
        let culler = Culler::default().only(Stage::Detail).with_detail(detail);
        cull(&culler, &scene, &view).triangle_count
    };
    let all = scene.triangle_count();
    assert!(left(false) == all && left(true) < all, "{} of {all}", left(true));
}

#[test]
fn an_occluder_keeps_its_clusters() {
    let mut scene = Scene::new();
    // Of many small clusters, so that they would all go.
    let wall = scene.add_mesh(meshes::one_sided(soups::moved(soups::divided_block(24), |p| {
        [p[0] * 4.0, p[1] * 8.0 - 4.0, p[2] * 0.1]
    })));
    let bead = scene.add_mesh(meshes::block([-0.1; 3], [0.1; 3]));
    let wall = scene.add(Instance::new(wall, Transform::IDENTITY)).expect("few");
    let mut behind = Instance::new(bead, Transform::from_translation([0.0, 0.0, -3.0]));
    behind.size_weight = f32::INFINITY;
    let bead = scene.add(behind).expect("few");
    scene.commit(&Culler::default());
    let [wall, bead] = [wall, bead].map(|h| scene.slot(h).expect("there"));
    scene.prepare(&Culler::exact());
    let view = look([0.3, 0.2, 10.0], [0.0; 3], [640, 400]);
    let detail = Detail::default().with_clusters(true).with_threshold_px(200.0);
    let all = Culler::exact().with_detail(detail).with_reasons(true);
    let [alone, all] = [all.without(Stage::Occlusion), all].map(|c| cull(&c, &scene, &view));
    assert_eq!(alone.slots().collect::<Vec<_>>(), [bead], "its clusters are small");
    assert_eq!(all.slots().collect::<Vec<_>>(), [wall], "what hides is drawn");
    assert_eq!(all.reasons[bead as usize].map(|r| r.stage), Some(Stage::Occlusion));
}

#[test]
fn what_fades_hides_nothing() {
    let mut scene = Scene::new();
    let wall = scene.add_mesh(meshes::block([-1.0, -1.0, 0.0], [1.0, 1.0, 0.1]));
    let bead = scene.add_mesh(meshes::block([-0.1; 3], [0.1; 3]));
    let wall = scene.add(Instance::new(wall, Transform::IDENTITY)).expect("few");
    let mut behind = Instance::new(bead, Transform::from_translation([0.0, 0.0, -3.0]));
    behind.size_weight = f32::INFINITY;
    scene.add(behind).expect("few");
    scene.commit(&Culler::default());
    let wall = scene.slot(wall).expect("there");
    scene.prepare(&Culler::exact());
    let view = look([0.0, 0.0, 10.0], [0.0; 3], [640, 400]);
    // The wall is some 70 pixels high.
    let left = |fade| {
        let detail = Detail::default().with_threshold_px(50.0).with_fade(fade);
        let culler = Culler::exact().with_detail(detail);
        cull(&culler, &scene, &view).slots().collect::<Vec<_>>()
    };
    assert_eq!(left(0.0), [wall]);
    assert_eq!(left(0.1), [wall], "it is larger than that");
    assert_eq!(left(4.0).len(), 2);
}
