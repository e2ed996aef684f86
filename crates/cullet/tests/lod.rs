//! Levels of detail: what is chosen, and what is drawn of it.

use std::ops::Range;

use cullet::lod::{Group, LevelEye, Levels, LevelsError, Lod, NO_GROUP, PixelScale, Selection};
use cullet::view::EyeBall;
use cullet::{
    Culler, DrawList, Instance, Mesh, Output, Scene, Simd, Stage, Transform, View, ViewState,
    Visible,
};
use cullet_testkit::answers::cull;
use cullet_testkit::memory::{Counting, allocations_of};
use cullet_testkit::steps::{Strip, ball_before_beads};
use cullet_testkit::views::look;
use cullet_testkit::{Rng, cases, meshes};
use proptest::prelude::*;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const DEPTH: u32 = 6;

fn random_eye(rng: &mut Rng) -> LevelEye {
    let far = 10_f64.powf(rng.range(-1.0, 3.0));
    let eye = [rng.range(-far, 64.0 + far), rng.range(-far, far), rng.range(-far, far)];
    let scale = PixelScale {
        eye: (rng.below(8) > 0).then_some(eye),
        pixels: 10_f64.powf(rng.range(0.0, 4.0)),
        near: rng.range(0.0, 2.0),
    };
    let lod = Lod::default().with_pixels(rng.range(0.1, 4.0));
    let ball = (rng.below(3) == 0).then(|| EyeBall { centre: eye, radius: rng.range(0.0, 9.0) });
    LevelEye::new(&lod, &scale, &Transform::IDENTITY, ball)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(60), ..ProptestConfig::default() })]

    #[test]
    fn what_is_chosen_covers_the_surface_once(seed in any::<u64>()) {
        let mut rng = Rng(seed);
        // Few groups are swept; of many, the walk asks for those that it comes to.
        let depth = DEPTH + rng.below(2) as u32 * 3;
        let strip = Strip::random(&mut rng, depth, false);
        let levels = strip.levels();
        let mut selection = Selection::default();
        for _ in 0..20 {
            let eye = random_eye(&mut rng);
            let by_rule = levels.select_where(|group| eye.is_over(group));
            let mut spans: Vec<[u32; 2]> = Vec::new();
            for simd in Simd::all() {
                prop_assert!(levels.select(simd, &eye, &mut selection));
                let chosen: Vec<u32> = selection.ranges().flatten().collect();
                let wanted: Vec<u32> = (0..).zip(&by_rule).filter(|c| *c.1).map(|c| c.0).collect();
                prop_assert_eq!(&chosen, &wanted, "{:?}", simd);
                prop_assert_eq!(selection.cluster_count() as usize, chosen.len());
                prop_assert_eq!(selection.triangle_count(), chosen.len() as u64 * 60);
                spans = chosen.iter().map(|&c| strip.spans[c as usize]).collect();
            }
            spans.sort_unstable();
            let ends: Vec<u32> = std::iter::once(0).chain(spans.iter().map(|s| s[1])).collect();
            let starts: Vec<u32> = spans.iter().map(|s| s[0]).chain([1 << depth]).collect();
            prop_assert_eq!(starts, ends);
        }
    }

    #[test]
    fn as_much_as_is_allowed_is_not_over_and_more_is(seed in any::<u64>()) {
        let mut rng = Rng(seed);
        for _ in 0..50 {
            let eye = random_eye(&mut rng);
            let centre = [0; 3].map(|_| rng.range(-300.0, 300.0) as f32);
            let radius = rng.range(0.0, 40.0) as f32;
            let error = eye.allowed(centre, radius);
            let group = |error| Group { centre, radius, error };
            prop_assert!(error >= 0.0 && (error == 0.0 || !eye.is_over(&group(error))), "{error}");
            // Lengths here are up to some 2000, and rounded by a hundred thousandth.
            let more = error * 1.001 + 0.1 / eye.reach + 1e-30;
            prop_assert!(eye.is_over(&group(more)), "{error}");
        }
    }

    #[test]
    fn no_eye_of_a_ball_sees_more_than_the_threshold(seed in any::<u64>()) {
        let mut rng = Rng(seed);
        let strip = Strip::random(&mut rng, DEPTH, false);
        let stretch = [0, 1, 2].map(|_| rng.range(0.2, 5.0));
        let turn = [rng.range(-1.0, 1.0), rng.range(-1.0, 1.0), rng.range(-1.0, 1.0), 1.5];
        let long = turn.iter().map(|v| v * v).sum::<f64>().sqrt();
        let turn = turn.map(|v| v / long);
        let place = [rng.range(-50.0, 50.0), 3.0, 1.0];
        let transform = Transform::from_scale_rotation_translation(stretch, turn, place);
        let largest = stretch.into_iter().fold(0.0, f64::max);
        let centre = [rng.range(-99.0, 99.0), rng.range(-9.0, 9.0), rng.range(-40.0, 40.0)];
        let ball = EyeBall { centre, radius: rng.range(0.0, 3.0) };
        let lod = Lod::default().with_pixels(rng.range(0.3, 3.0));
        let scale = PixelScale { eye: Some(centre), pixels: 900.0, near: 0.1 };
        let eye = LevelEye::new(&lod, &scale, &transform, Some(ball));
        let matrix = glam::DMat4::from_cols_array(&transform.to_matrix());
        for group in strip.groups.iter().filter(|g| !eye.is_over(g)) {
            for _ in 0..10 {
                let away: [f64; 3] = [0; 3].map(|_: i32| rng.range(-1.0, 1.0));
                let long = away.iter().map(|v| v * v).sum::<f64>().sqrt().max(1.0);
                let at: [f64; 3] = std::array::from_fn(|a| centre[a] + away[a] / long * ball.radius);
                // A point of the sphere around the group, where it is nearest to the eye in the space of the mesh.
                let own = matrix.inverse().transform_point3(at.into());
                let to = own - glam::DVec3::from(group.centre.map(f64::from));
                let on = own - to.normalize() * (to.length() - f64::from(group.radius)).max(0.0);
                let distance = matrix.transform_vector3(own - on).length().max(scale.near);
                let seen = f64::from(group.error) * largest * scale.pixels / distance;
                prop_assert!(seen <= lod.pixels, "{seen} of {} pixels", lod.pixels);
            }
        }
    }

    #[test]
    fn every_output_draws_the_chosen_clusters(seed in any::<u64>()) {
        let mut rng = Rng(seed);
        let (scene, strips) = random_scene(&mut rng);
        for _ in 0..6 {
            let view = view_of_strips(&mut rng);
            let lod = Lod::default().with_pixels(10_f64.powf(rng.range(-1.0, 1.5)));
            let all = Culler::default().with_lod(lod).with_reasons(true).with_dropped(true);
            let only = all.only(Stage::Lod);
            let (by_clusters, by_triangles) = (
                cull(&only.clone().with_output(Output::Clusters), &scene, &view),
                cull(&only.clone().with_output(Output::Triangles), &scene, &view),
            );
            let by_instances = cull(&only.with_output(Output::Instances), &scene, &view);
            let chosen = chosen_ref(&scene, &strips, &view, &lod);
            prop_assert_eq!(&drawn(&scene, &by_instances), &chosen);
            prop_assert_eq!(&drawn(&scene, &by_clusters), &chosen);
            prop_assert_eq!(&triangles(&by_triangles), &chosen);
            // With the other stages a part of that is left, and by each output alike.
            let of_triangles = all.clone().with_output(Output::Triangles);
            let part = cull(&of_triangles, &scene, &view);
            let left = triangles(&part);
            prop_assert!(left.iter().all(|t| chosen.binary_search(t).is_ok()));
            let clusters = drawn(&scene, &cull(&all, &scene, &view));
            prop_assert!(left.iter().all(|t| clusters.binary_search(t).is_ok()));
            prop_assert!(clusters.iter().all(|t| chosen.binary_search(t).is_ok()));
            prop_assert_eq!(part.triangle_count as usize, left.len());
            for simd in Simd::all() {
                let again = all.clone().with_output(Output::Triangles).with_simd(simd);
                prop_assert_eq!(&cull(&again, &scene, &view), &part, "{:?}", simd);
            }
            for slot in scene.slots() {
                let handle = scene.handle(slot).expect("live");
                let told = of_triangles.explain(&scene, &view, handle).expect("live");
                prop_assert_eq!(told.reason, part.reasons[slot as usize]);
            }
        }
    }
}

#[test]
fn steps_count_simplifications() {
    let strip = Strip::random(&mut Rng(3), DEPTH, false);
    let steps = strip.levels().steps();
    assert_eq!(steps.len(), strip.spans.len());
    for (span, step) in strip.spans.iter().zip(steps) {
        assert_eq!(span[1] - span[0], 1 << step, "{span:?}");
    }
    // Of a chain that leaves out what the mesh itself is, the finest is level 1 all the same.
    let clusters = strip.steps.clusters().len();
    let group = Group { centre: [0.0; 3], radius: 99.0, error: 0.1 };
    let chain = Levels::new(&strip.steps, &[group], vec![0; clusters], vec![NO_GROUP; clusters]);
    assert_eq!(chain.expect("a level").steps(), vec![1; clusters]);
}

/// Strips at different distances, one of them in a shape of the caller's.
fn random_scene(rng: &mut Rng) -> (Scene, Vec<Strip>) {
    let mut scene = Scene::new();
    let mut strips = Vec::new();
    for at in 0..3 {
        let strip = Strip::random(rng, DEPTH, at == 1);
        let mesh = scene.add_mesh(strip.mesh.clone());
        let steps = scene.add_mesh(strip.steps.clone());
        scene.add_levels(mesh, steps, strip.levels()).expect("made right");
        for _ in 0..3 {
            let place = [rng.range(-60.0, 0.0), rng.range(-9.0, 9.0), -rng.range(1.0, 300.0)];
            let scale = [rng.range(0.5, 2.0) as f32; 3];
            let transform = Transform::from_scale_translation(scale, place);
            let mut instance = Instance::new(mesh, transform);
            if rng.below(6) == 0 {
                instance.bounds = cullet::scene::BoundsOverride::Margin(1.0);
            }
            scene.add(instance).expect("few");
        }
        strips.push(strip);
    }
    scene.commit(&Culler::default());
    (scene, strips)
}

fn view_of_strips(rng: &mut Rng) -> View {
    let eye = [rng.range(-20.0, 20.0), rng.range(-5.0, 5.0), rng.range(-20.0, 20.0)];
    look(eye, [rng.range(-20.0, 20.0), 0.0, -100.0], [320, 200])
}

/// The triangles of a scene that levels leave, as (slot, level, triangle).
fn chosen_ref(scene: &Scene, strips: &[Strip], view: &View, lod: &Lod) -> Vec<(u32, u32, u32)> {
    let mut chosen = Vec::new();
    for slot in scene.slots() {
        let strip = &strips[scene.mesh_id(slot) as usize / 2];
        let scale = PixelScale::of(view, lod.at_corners);
        let eye = LevelEye::new(lod, &scale, scene.transform(slot), None);
        let by_rule = strip.levels().select_where(|group| eye.is_over(group));
        let clusters = by_rule.iter().filter(|c| **c).count();
        let replaced = scene.is_rigid(slot) && clusters <= strip.mesh.clusters().len();
        if !replaced {
            chosen.extend((0..strip.mesh.triangle_count()).map(|t| (slot, 0, t)));
            continue;
        }
        for (cluster, _) in strip.steps.clusters().iter().zip(by_rule).filter(|c| c.1) {
            chosen.extend(cluster.triangles().map(|t| (slot, 1, t)));
        }
    }
    chosen
}

fn drawn(scene: &Scene, visible: &Visible) -> Vec<(u32, u32, u32)> {
    let mut drawn = Vec::new();
    let mut list = |slot, level, clusters: Range<u32>| {
        let range = scene.mesh_at(slot, level).index_range(clusters);
        drawn.extend((range.start / 3..range.end / 3).map(|t| (slot, level, t)));
    };
    for r in &visible.whole {
        for slot in r.first..r.first + r.count {
            list(slot, 0, 0..scene.mesh(slot).clusters().len() as u32);
        }
    }
    for d in &visible.partial {
        list(d.slot, d.level, d.first_cluster..d.first_cluster + d.cluster_count);
    }
    drawn.sort_unstable();
    drawn
}

fn triangles(visible: &Visible) -> Vec<(u32, u32, u32)> {
    let ranges = visible.triangle_ranges.iter();
    let mut listed: Vec<(u32, u32, u32)> = ranges
        .flat_map(|r| {
            let own = &visible.triangles[r.first as usize..(r.first + r.count) as usize];
            own.iter().map(|&t| (r.slot, r.level, t))
        })
        .collect();
    listed.sort_unstable();
    listed
}

#[test]
fn a_budget_is_kept_with_the_finest_levels_that_fit() {
    const FINEST: f64 = 0.004;
    let coarsest = FINEST * 2.0_f64.powf(15.75);
    let mut rng = Rng(12);
    let mut raised = 0;
    for _ in 0..cases(60) {
        let (scene, _) = random_scene(&mut rng);
        let view = view_of_strips(&mut rng);
        let with = |pixels, triangles| {
            Culler::default()
                .with_lod(Lod::default().with_pixels(pixels).with_triangles(triangles))
                .with_output(Output::Instances)
        };
        let drawn = |pixels: f64, most: Option<u64>| {
            let visible = cull(&with(pixels, most), &scene, &view);
            (visible.triangle_count, visible.lod_pixels.expect("levels are on"))
        };
        let (full, fewest) = (drawn(0.0, None).0, drawn(coarsest, None).0);
        let most = fewest + rng.below(full - fewest + 1);
        let (triangles, pixels) = drawn(FINEST, Some(most));
        assert!(triangles <= most, "{triangles} of {most}");
        let step = (pixels / FINEST).log2() * 4.0;
        assert!((step - step.round()).abs() < 1e-9 && pixels >= FINEST, "{pixels}");
        // The very levels of that threshold, and those of the step below are too many, or so near to it that they may be.
        assert_eq!((triangles, pixels), drawn(pixels, None));
        let one_below = drawn(pixels * 2.0_f64.powf(-0.25) * (1.0 - 3e-4), None).0;
        assert!(step == 0.0 || one_below > most, "{one_below} of {most} at {step}");
        raised += u32::from(step > 0.0);
        // Nothing is coarser than it must be.
        assert_eq!(drawn(0.0, Some(full)), (full, 0.0));
        assert_eq!(drawn(FINEST, Some(u64::MAX)), drawn(FINEST, None));
        assert_eq!(drawn(FINEST, Some(0)).0, drawn(coarsest, None).0);
        // And an explanation is of the same levels.
        let culler = with(FINEST, Some(most)).with_output(Output::Clusters);
        for slot in scene.slots() {
            let handle = scene.handle(slot).expect("live");
            let told = culler.explain(&scene, &view, handle).expect("live");
            let lod = told.steps.iter().find(|s| s.stage == Stage::Lod);
            if let Some(step) = lod.filter(|s| s.to_string().contains("within")) {
                assert!(step.to_string().contains(&format!("within {pixels} pixels")), "{step:?}");
            }
        }
    }
    assert!(raised * 3 > cases(60), "{raised}");
}

#[test]
fn draws_are_of_the_mesh_that_holds_the_levels() {
    let mut rng = Rng(5);
    let (scene, _) = random_scene(&mut rng);
    let view = look([0.0, 0.0, 20.0], [0.0, 0.0, -100.0], [320, 200]);
    let culler = Culler::default().with_lod(Lod::default().with_pixels(4.0));
    let visible = cull(&culler, &scene, &view);
    let draws = visible.draws(&scene).unwrap();
    let coarse = draws.iter().filter(|d| d.level == 1).count();
    assert!(coarse > 0 && draws.iter().all(|d| d.mesh == scene.mesh_id_at(d.slot, d.level)));
    let mut list = DrawList::default();
    list.fill(&scene, &visible, &[]).unwrap();
    let indices: u64 = draws.iter().map(|d| d.indices.len() as u64).sum();
    let of = list.commands.iter().map(|c| u64::from(c.index_count * c.instance_count));
    assert_eq!(of.sum::<u64>(), indices);
    assert!(list.keys.iter().any(|key| key.level == 1 && key.mesh % 2 == 1));
    let triangles = culler.with_output(Output::Triangles);
    let visible = cull(&triangles, &scene, &view);
    list.fill_triangles(&scene, &visible, &[]).unwrap();
    assert!(list.keys.iter().any(|key| key.level == 1 && key.mesh % 2 == 1));
}

#[test]
fn levels_allocate_nothing_in_steady_state() {
    let mut rng = Rng(8);
    let (scene, _) = random_scene(&mut rng);
    let views: Vec<View> = (0..12).map(|_| view_of_strips(&mut rng)).collect();
    for output in [Output::Instances, Output::Clusters, Output::Triangles] {
        let lod = Some(Lod::default().with_pixels(3.0));
        let culler = Culler::default().with_output(output).with_lod(lod);
        let (mut state, mut result) = (ViewState::default(), Visible::default());
        let mut all = || {
            for view in &views {
                culler.cull_one(&scene, view, &mut state, &mut result);
            }
        };
        all();
        let ((), allocations) = allocations_of(all);
        assert_eq!(allocations, 0, "{output:?}");
    }
}

#[test]
fn a_shadow_is_cast_by_what_its_camera_draws() {
    let mut rng = Rng(3);
    let (scene, strips) = random_scene(&mut rng);
    let camera = look([0.0, 0.0, 30.0], [0.0, 0.0, -100.0], [320, 200]);
    let lod = Lod::default().with_pixels(2.0);
    let culler = Culler::default().with_lod(lod);
    let light = cullet::cull::shadow::Light::Directional { direction: [0.0, -1.0, 0.0] };
    let shadows = cullet::ShadowView::new(camera.clone(), light);
    let (mut state, mut result) = (ViewState::default(), Visible::default());
    culler.cull_shadow(&scene, &shadows, &mut state, &mut result);
    let chosen = chosen_ref(&scene, &strips, &camera, &lod);
    let cast = drawn(&scene, &result);
    assert!(!cast.is_empty() && cast.iter().any(|t| t.1 == 1));
    assert!(cast.iter().all(|t| chosen.binary_search(t).is_ok()));
}

#[test]
fn thresholds_that_mean_nothing_draw_everything() {
    let mut rng = Rng(2);
    let strip = Strip::random(&mut rng, DEPTH, false);
    let levels = strip.levels();
    let scale = PixelScale { eye: Some([1e4; 3]), pixels: 1000.0, near: 0.1 };
    let mut selection = Selection::default();
    let mut originals = |lod: &Lod, scale: &PixelScale, transform: &Transform| {
        let eye = LevelEye::new(lod, scale, transform, None);
        assert!(levels.select(Simd::best(), &eye, &mut selection));
        let is_chosen = |c: usize| selection.clusters()[c / 64] >> (c % 64) & 1 == 1;
        let of_none = levels.made_from().iter().enumerate().filter(|(_, g)| **g == NO_GROUP);
        of_none.filter(|(c, _)| is_chosen(*c)).count()
    };
    let one = Transform::IDENTITY;
    // A group without an error is never over a threshold, but is where everything is drawn.
    for pixels in [0.0, -1.0, f64::NAN, f64::NEG_INFINITY] {
        assert_eq!(originals(&Lod::default().with_pixels(pixels), &scale, &one), 64, "{pixels}");
    }
    let lod = Lod::default().with_pixels(1000.0);
    let flat = Transform::from_scale_translation([1.0, 0.0, 1.0], [0.0; 3]);
    assert_eq!(originals(&lod, &scale, &flat), 64);
    let nowhere = PixelScale { eye: Some([f64::NAN; 3]), ..scale };
    assert_eq!(originals(&lod, &nowhere, &one), 64);
    assert!(originals(&lod, &scale, &one) < 64);
}

#[test]
fn levels_that_would_leave_holes_are_refused() {
    let mut rng = Rng(4);
    let strip = Strip::random(&mut rng, 2, false);
    let made = |groups: &[Group], made_from: &[u32], replaced_by: &[u32]| {
        Levels::new(&strip.steps, groups, made_from.to_vec(), replaced_by.to_vec())
    };
    let (from, by) = (&strip.made_from[..], &strip.replaced_by[..]);
    assert!(made(&strip.groups, from, by).is_ok());
    let mut groups = strip.groups.clone();
    groups[2].error = -1.0;
    let told = made(&groups, from, by).unwrap_err();
    assert!(matches!(told, LevelsError::NotFinite { group: 2, .. }), "{told}");
    groups.clone_from(&strip.groups);
    groups[0].error = groups[2].error + 1.0;
    let told = made(&groups, from, by).unwrap_err().to_string();
    assert!(told.contains("group 0 is simplified further in group 2, whose error is"), "{told}");
    groups.clone_from(&strip.groups);
    groups[2].radius = 0.5;
    let told = made(&groups, from, by).unwrap_err().to_string();
    assert!(told.contains("sphere leaves out"), "{told}");
    let told = made(&strip.groups, &from[1..], by).unwrap_err().to_string();
    assert_eq!(told, "made_from has 6 entries, but the mesh has 7 clusters");
    let mut far = by.to_vec();
    far[1] = 9;
    let told = made(&strip.groups, from, &far).unwrap_err().to_string();
    assert_eq!(told, "replaced_by of cluster 1 is 9, but there are 3 groups");
    let mut own = by.to_vec();
    own[4] = from[4];
    assert!(made(&strip.groups, from, &own).is_err());
    assert_eq!(from[0], NO_GROUP);
}

#[test]
fn where_the_finest_are_left_out_the_mesh_is_drawn() {
    let mut rng = Rng(9);
    let strip = Strip::random(&mut rng, 1, false);
    // The one segment that was made of two, without those.
    let mut data = strip.steps.to_data();
    data.indices.drain(..120 * 3);
    data.parts[0].triangle_count = 60;
    let steps = Mesh::new(data).expect("a segment");
    let clusters = steps.clusters().len();
    let groups = [Group { error: 0.5, ..strip.groups[0] }];
    let levels = Levels::new(&steps, &groups, vec![0; clusters], vec![NO_GROUP; clusters]);
    let levels = levels.expect("made right");
    let mut selection = Selection::default();
    let mut at = |distance| {
        let scale = PixelScale { eye: Some([0.0, 0.0, distance]), pixels: 100.0, near: 0.1 };
        let eye = LevelEye::new(&Lod::default(), &scale, &Transform::IDENTITY, None);
        let all = levels.select(Simd::best(), &eye, &mut selection);
        (all, selection.cluster_count() as usize, selection.triangle_count())
    };
    assert_eq!(at(1000.0), (true, clusters, 60));
    assert_eq!(at(20.0), (false, 0, 0));
}

#[test]
fn pixels_of_a_view_are_those_of_its_projection() {
    let view = look([3.0, 2.0, 9.0], [0.0, 1.0, 0.0], [1920, 1080]);
    let centre = PixelScale::of(&view, false);
    let corner = PixelScale::of(&view, true);
    assert!(corner.pixels > centre.pixels * 1.2);
    let eye = centre.eye.expect("perspective");
    // A short stick across the line of sight, at distance 9.
    let middle = [0.0, 1.0, 0.0];
    let away = (0..3).map(|a| (eye[a] - middle[a]).powi(2)).sum::<f64>().sqrt();
    let stick = |h: f64| {
        let at = [(middle[0] - h) as f32, middle[1] as f32, middle[2] as f32];
        let to = [(middle[0] + h) as f32, middle[1] as f32, middle[2] as f32];
        let bounds = cullet::bounds::Aabb { min: at, max: to };
        view.project_box(&bounds, [0.0; 3]).expect("ahead").width()
    };
    let seen = stick(0.005) / (0.01 * centre.pixels / away);
    // It leans to the line of sight a little, and so is seen a little shorter.
    assert!((0.9..1.0001).contains(&seen), "{seen}");
}

#[test]
fn what_is_drawn_is_what_hides() {
    let mut scene = ball_before_beads();
    scene.prepare(&Culler::exact());
    let view = look([0.0, 0.0, 6.0], [0.0; 3], [640, 400]);
    let hidden = |pixels: Option<f64>| {
        let lod = pixels.map(|pixels| Lod::default().with_pixels(pixels));
        let result = cull(&Culler::exact().with_lod(lod).with_reasons(true), &scene, &view);
        let is_coarse = result.partial.iter().any(|d| d.slot == 0 && d.level == 1);
        let is_hidden =
            |r: &&Option<cullet::Reason>| r.is_some_and(|r| r.stage == Stage::Occlusion);
        (is_coarse, result.reasons.iter().filter(is_hidden).count())
    };
    // In full the ball hides the beads behind its rim. Its coarse level does not reach that far.
    for in_full in [None, Some(0.5)] {
        assert_eq!(hidden(in_full), (false, 48));
    }
    assert_eq!(hidden(Some(1e3)), (true, 0));
}

/// A chain of whole meshes: each is drawn where its error is below the threshold, the fewest triangles first.
#[test]
fn a_chain_of_whole_meshes_is_chosen_by_its_errors() {
    let mut scene = Scene::new();
    let [fine, middle, coarse] = [32, 16, 8].map(|rings| scene.add_mesh(meshes::ball(rings)));
    // In any order.
    scene.add_lod(fine, coarse, 0.08).unwrap();
    scene.add_lod(fine, middle, 0.02).unwrap();
    let handle = scene.add(Instance::new(fine, Transform::IDENTITY)).unwrap();
    scene.commit(&Culler::default());
    let lod = Some(Lod::default().with_pixels(1.0));
    let culler = Culler::default().with_lod(lod).with_output(Output::Triangles);
    let drawn = |distance: f64| {
        let eye = [0.0, 0.0, distance];
        let view = View::perspective(eye, [0.0; 3], 1.0, 0.01, 1e4, [1000, 1000]).unwrap();
        let visible = cull(&culler, &scene, &view);
        assert_eq!(visible.triangle_ranges.len(), 1);
        scene.mesh_id_at(scene.slot(handle).unwrap(), visible.triangle_ranges[0].level)
    };
    // A unit is 1000 / (2 tan 0.5) = 915 pixels at a distance of 1: 0.02 is a pixel at 18 units, 0.08 at 73.
    assert_eq!([3.0, 15.0].map(drawn), [fine, fine]);
    assert_eq!([25.0, 60.0].map(drawn), [middle, middle]);
    assert_eq!([90.0, 1000.0].map(drawn), [coarse, coarse]);
    for error in [-1.0, f32::NAN, f32::INFINITY] {
        assert!(matches!(scene.add_lod(fine, coarse, error), Err(LevelsError::NotFinite { .. })));
    }
    assert_eq!(scene.add_lod(fine, 9, 0.1), Err(LevelsError::NoMesh { mesh: 9, meshes: 3 }));
    let empty = scene.add_mesh(Mesh::default());
    assert_eq!(scene.add_lod(fine, empty, 0.1), Ok(()));
}

#[test]
fn an_impostor_is_a_level_with_a_picture_of_the_callers() {
    let mut scene = Scene::new();
    let own = scene.add_mesh(meshes::ball(24));
    let held = meshes::block([-1.1; 3], [1.1; 3]);
    let group = Group { centre: [0.0; 3], radius: 2.0, error: 0.1 };
    let count = held.clusters().len();
    let levels = Levels::new(&held, &[group], vec![0; count], vec![NO_GROUP; count]);
    let levels = levels.expect("a level");
    let held_by = scene.add_mesh(held);
    let picture = std::sync::Arc::new(77_u64);
    let no_mesh = scene.add_impostor(9, held_by, levels.clone(), picture.clone());
    assert_eq!(no_mesh, Err(LevelsError::NoMesh { mesh: 9, meshes: 2 }));
    scene.add_impostor(own, held_by, levels, picture).expect("made for it");
    let back = scene.levels(own)[0].impostor.as_ref().and_then(|p| p.downcast_ref::<u64>());
    assert_eq!(back, Some(&77));
    scene.add(Instance::new(own, Transform::IDENTITY)).expect("one");
    scene.commit(&Culler::default());
    let view = look([0.0, 0.0, 500.0], [0.0; 3], [64, 64]);
    for (impostors, level) in [(true, 1), (false, 0)] {
        let lod = Lod::default().with_impostors(impostors);
        let culler = Culler::exact().with_lod(lod).with_output(Output::Triangles);
        assert_eq!(cull(&culler, &scene, &view).triangle_ranges[0].level, level);
    }
    // Of another mesh in its place it is no picture.
    scene.edit_mesh(own, |mesh| mesh.set_two_sided(true));
    assert_eq!(scene.levels(own).len(), 1);
    scene.edit_mesh(own, |mesh| *mesh = meshes::block([-2.0; 3], [1.0; 3]));
    assert!(scene.levels(own).is_empty());
}
