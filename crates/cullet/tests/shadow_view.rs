//! Lights as views of the pipeline: the same kept sets as the regions give box by box, nothing lost, everything said.

use cullet::bounds::Aabb;
use cullet::cull::detail::Detail;
use cullet::cull::frustum::batch::{Planes, VISIBLE, reject_boxes};
use cullet::cull::occlusion::Occlusion;
use cullet::cull::shadow::{CasterReason, CasterRegion, Light};
use cullet::mesh::Part;
use cullet::{
    Culler, Handle, Instance, InstanceFlags, Mesh, MeshData, Output, Scene, ShadowView, Simd,
    Stage, Transform, View, ViewState, Visible, funnel::Unit, scene::BoundsOverride,
};
use cullet_testkit::answers::listed;
use cullet_testkit::scenes::random_scene;
use cullet_testkit::views::{random_view, view_and_moved};
use cullet_testkit::{Rng, at_every_level};

const SUN: Light = Light::Directional { direction: [0.0, -1.0, 0.0] };

fn random_light(rng: &mut Rng) -> Light {
    let range = if rng.below(3) == 0 { f64::INFINITY } else { rng.range(1.0, 60.0) };
    let (position, direction) = (rng.vector(25.0), rng.vector(1.0));
    match rng.below(3) {
        0 => Light::Directional { direction },
        1 => Light::Point { position, range },
        _ => Light::Spot { position, direction, half_angle_radians: rng.range(0.1, 1.8), range },
    }
}

fn moved(p: [f64; 3], offset: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|a| p[a] + offset[a])
}

fn moved_light(light: Light, offset: [f64; 3]) -> Light {
    match light {
        Light::Point { position, range } => {
            Light::Point { position: moved(position, offset), range }
        }
        Light::Spot { position, direction, half_angle_radians, range } => {
            Light::Spot { position: moved(position, offset), direction, half_angle_radians, range }
        }
        other => other,
    }
}

/// A view from a light towards something near a place, as wide as it may be.
fn map_of(rng: &mut Rng, light: &Light, near: [f64; 3]) -> View {
    let size = [256, 256];
    let towards = moved(rng.vector(10.0), near);
    match *light {
        Light::Directional { direction } => {
            let eye = std::array::from_fn(|a| towards[a] - direction[a] * 80.0);
            View::orthographic(eye, towards, rng.range(10.0, 60.0), 0.1, 400.0, size)
        }
        Light::Point { position, .. } | Light::Spot { position, .. } => {
            View::perspective(position, towards, rng.range(0.5, 2.0), 0.05, 200.0, size)
        }
        _ => unreachable!("no other light is made here"),
    }
    .expect("a good map")
}

fn cull(culler: &Culler, scene: &Scene, shadows: &ShadowView) -> Visible {
    let mut result = Visible::default();
    culler.cull_shadow(scene, shadows, &mut ViewState::default(), &mut result);
    result
}

fn telling(output: Output) -> Culler {
    Culler::default().with_reasons(true).with_output(output)
}

fn cube() -> Mesh {
    const FACES: [[u32; 4]; 6] =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    Mesh::new(MeshData {
        positions: Aabb::new([-1.0; 3], [1.0; 3]).corners().to_vec(),
        indices: FACES.iter().flat_map(|f| [0, 1, 2, 0, 2, 3].map(|k| f[k])).collect(),
        parts: vec![Part { triangle_count: 12, ..Part::default() }],
        ..MeshData::default()
    })
    .expect("a good mesh")
}

/// Cubes of given bounds, of which some are none.
fn scene_of_boxes(boxes: &[Aabb]) -> (Scene, Vec<Handle>) {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(cube());
    let add = |b: &Aabb| {
        let place =
            Transform::from_scale_translation(b.half_extent().map(|h| h as f32), b.center());
        scene.add(Instance::new(mesh, place)).expect("room")
    };
    let handles = boxes.iter().map(add).collect();
    scene.commit(&Culler::default());
    (scene, handles)
}

#[test]
fn the_pipeline_keeps_what_the_region_keeps_box_by_box() {
    let mut rng = Rng(12);
    let mut seen = [0; 5];
    for round in 0..40 {
        let mut scene = Scene::new();
        let mesh = scene.add_mesh(cube());
        for i in 0..[1, 17, 700, 3000][round % 4] {
            let at = Transform::from_scale_translation([0.5; 3], rng.vector(40.0));
            let mut instance = Instance::new(mesh, at);
            match i % 50 {
                0 => instance.bounds = BoundsOverride::World(Aabb::EMPTY),
                1 => instance.bounds = BoundsOverride::None,
                _ => {}
            }
            scene.add(instance).expect("room");
        }
        // Some lie under no node.
        if round % 3 != 0 {
            scene.commit(&Culler::default());
        }
        let camera = random_view(&mut rng);
        let light = random_light(&mut rng);
        let mut shadows = ShadowView::new(camera.clone(), light);
        if rng.below(2) == 0 {
            let middle = rng.vector(15.0).map(|v| v as f32);
            shadows.receivers = Some(Aabb::new(middle.map(|v| v - 9.0), middle.map(|v| v + 9.0)));
        }
        let region = CasterRegion::new(&camera.frustum(), shadows.receivers.as_ref(), &light);
        let boxes = scene.boxes();
        let mut planes = vec![VISIBLE; boxes.len()];
        reject_boxes(Simd::best(), &Planes::new(region.frustum()), boxes, 0, &mut planes);
        let expected = |slot: u32| {
            let (i, exempt) =
                (slot as usize, scene.exempt()[slot as usize / 64] >> (slot % 64) & 1);
            let plane = (planes[i] != VISIBLE).then_some(planes[i]);
            region.reason(&boxes.get(i), plane).filter(|_| exempt == 0)
        };
        let mut state = ViewState::default();
        at_every_level!(|level| {
            let culler = telling(Output::Instances).with_simd(level).with_degenerate(false);
            // Cold, then warm.
            for _ in 0..2 {
                let mut result = Visible::default();
                culler.cull_shadow(&scene, &shadows, &mut state, &mut result);
                for slot in scene.slots() {
                    let reason = result.reasons[slot as usize].and_then(cullet::Reason::caster);
                    let is_empty = boxes.get(slot as usize).is_empty();
                    let expected = expected(slot);
                    // An empty box is outside of some plane of a region, of whichever.
                    assert!(
                        reason == expected || is_empty && reason.is_some() && expected.is_some(),
                        "{level:?} slot {slot}: {reason:?}, by itself {expected:?}"
                    );
                }
                let kept = scene.slots().filter(|&s| result.reasons[s as usize].is_none());
                assert!(result.slots().eq(kept), "{level:?}");
            }
        });
        for slot in scene.slots() {
            seen[match expected(slot) {
                None => 0,
                Some(CasterReason::NoReceiver) => 1,
                Some(CasterReason::BeyondRange) => 2,
                Some(CasterReason::OutsideCone) => 3,
                _ => 4,
            }] += 1;
        }
    }
    assert!(seen.iter().all(|&n| n > 0), "the test must see every reason: {seen:?}");
}

/// A triangle where it stands.
fn corners(scene: &Scene, slot: u32, triangle: u32) -> [[f64; 3]; 3] {
    let Transform { linear, translation } = *scene.transform(slot);
    scene.mesh(slot).corners(triangle).map(|p| {
        std::array::from_fn(|a| {
            let turned = (0..3).map(|c| f64::from(linear[c][a]) * f64::from(p[c]));
            turned.sum::<f64>() + translation[a]
        })
    })
}

/// A point of a triangle that the camera sees, lit, or `None`.
fn on_a_seen_triangle(rng: &mut Rng, scene: &Scene, visible: &Visible) -> Option<[f64; 3]> {
    let range =
        visible.triangle_ranges.get(rng.bits() as usize % visible.triangle_ranges.len().max(1))?;
    let triangle = visible.triangles[(range.first + rng.bits() as u32 % range.count) as usize];
    let [a, b, c] = corners(scene, range.slot, triangle);
    let (mut u, mut v) = (rng.range(0.0, 1.0), rng.range(0.0, 1.0));
    if u + v > 1.0 {
        (u, v) = (1.0 - u, 1.0 - v);
    }
    Some(std::array::from_fn(|i| a[i] + (b[i] - a[i]) * u + (c[i] - a[i]) * v))
}

/// Where the way from one point to another meets a triangle, as a part of it; `None` near its edges.
fn meets([a, b, c]: [[f64; 3]; 3], from: [f64; 3], way: [f64; 3]) -> Option<f64> {
    let sub = |p: [f64; 3], q: [f64; 3]| -> [f64; 3] { std::array::from_fn(|i| p[i] - q[i]) };
    let dot = |p: [f64; 3], q: [f64; 3]| (0..3).map(|i| p[i] * q[i]).sum::<f64>();
    let cross = |p: [f64; 3], q: [f64; 3]| {
        [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
    };
    let (e, f) = (sub(b, a), sub(c, a));
    let h = cross(way, f);
    let det = dot(e, h);
    let s = sub(from, a);
    let u = dot(s, h) / det;
    let q = cross(s, e);
    let (v, t) = (dot(way, q) / det, dot(f, q) / det);
    let inside = u > 1e-6 && v > 1e-6 && u + v < 1.0 - 1e-6;
    (inside && t.is_finite()).then_some(t)
}

/// The proof that matters: of every ray from a seen and lit point to the light that meets anything, it meets something
/// that is kept; and without occlusion all that it meets is.
#[test]
fn what_shades_a_seen_point_is_kept_down_to_the_triangle() {
    let mut rng = Rng(31);
    let (mut shaded, mut kept_triangles, mut all_triangles) = (0, 0, 0);
    for round in 0..120 {
        let mut scene = random_scene(&mut rng, 14);
        // At times far from where f64 is finest.
        let offset = if round % 3 == 0 { rng.vector(1e7).map(f64::round) } else { [0.0; 3] };
        scene.rebase(offset);
        let handles: Vec<_> = scene.slots().filter_map(|slot| scene.handle(slot)).collect();
        for handle in handles {
            let t = *scene.transform(scene.slot(handle).expect("there"));
            let translation = moved(t.translation, offset);
            scene.set_transform(handle, Transform { translation, ..t }).expect("there");
        }
        // Everything is in the camera's layers, and in the light's.
        let camera = view_and_moved(&mut rng, offset).1.with_layers(u32::MAX);
        let mut light = moved_light(random_light(&mut rng), offset);
        if let Light::Point { range, .. } | Light::Spot { range, .. } = &mut light {
            *range = f64::INFINITY;
        }
        if let Light::Spot { half_angle_radians, .. } = &mut light {
            *half_angle_radians = 2.0;
        }
        let mut seen = Visible::default();
        telling(Output::Triangles).cull_one(&scene, &camera, &mut ViewState::default(), &mut seen);
        let mut shadows = ShadowView::new(camera.clone(), light).receiving(&scene, &seen).unwrap();
        let with_map = round % 2 == 0;
        if with_map {
            let mut map = map_of(&mut rng, &light, offset);
            map.cull_face = cullet::view::CullFace::None;
            shadows.map = Some(map);
        }
        let occlusion = (round % 4 == 0).then(Occlusion::default);
        let result = cull(&telling(Output::Triangles).with_occlusion(occlusion), &scene, &shadows);
        kept_triangles += result.triangle_count;
        all_triangles += scene.triangle_count();
        let listed = listed(&result);
        for _ in 0..30 {
            let Some(y) = on_a_seen_triangle(&mut rng, &scene, &seen) else { break };
            let in_map = |p| shadows.map.as_ref().is_none_or(|m| m.frustum().contains(p));
            if !camera.frustum().contains(y) || !in_map(y) {
                continue;
            }
            let (way, end) = match light {
                Light::Directional { direction } => (direction.map(|v| -v), f64::INFINITY),
                Light::Point { position, .. } | Light::Spot { position, .. } => {
                    (std::array::from_fn(|a| position[a] - y[a]), 1.0)
                }
                _ => unreachable!("no other light is made here"),
            };
            let (mut any, mut any_kept) = (false, false);
            for slot in scene.slots() {
                let mesh = scene.mesh(slot);
                for t in 0..mesh.triangle_count() - mesh.degenerate_count() {
                    let Some(at) = meets(corners(&scene, slot, t), y, way) else { continue };
                    let place = std::array::from_fn(|a| y[a] + way[a] * at);
                    if at < 1e-4 || at > end * 0.999 || !in_map(place) {
                        continue;
                    }
                    let kept = listed.contains(&(slot, t));
                    (any, any_kept) = (true, any_kept || kept);
                    assert!(
                        kept || occlusion.is_some(),
                        "round {round}: {t} of {slot} shades {y:?}, dropped for {:?}",
                        result.reasons[slot as usize]
                    );
                }
            }
            assert!(any_kept || !any, "round {round}: {y:?} has lost its shadow");
            shaded += u32::from(any);
        }
    }
    println!("{shaded} shaded points; {kept_triangles} of {all_triangles} triangles kept");
    assert!(shaded > 200, "{shaded}");
    // Keeping everything would pass the rest.
    assert!(kept_triangles * 10 < all_triangles * 7, "{kept_triangles} of {all_triangles}");
}

#[test]
fn explanations_equal_reasons_and_funnels_add_up() {
    let mut rng = Rng(33);
    let mut kinds = std::collections::BTreeSet::new();
    for round in 0..60 {
        let scene = random_scene(&mut rng, 20);
        let light = random_light(&mut rng);
        let mut shadows = ShadowView::new(random_view(&mut rng), light);
        shadows.margin_world = if round % 5 == 0 { 0.5 } else { 0.0 };
        shadows.map = (round % 2 == 0).then(|| map_of(&mut rng, &light, [0.0; 3]));
        let culler = telling([Output::Instances, Output::Clusters, Output::Triangles][round % 3])
            .with_occlusion((round % 3 == 0).then(Occlusion::default))
            .with_detail((round % 4 == 0).then(Detail::default))
            .with_frustum_exact(round % 7 == 0);
        let result = cull(&culler, &scene, &shadows);
        for pair in result.funnel.rows.windows(2) {
            assert_eq!(pair[0].left, pair[1].entered, "{pair:?}");
        }
        assert_eq!(result.funnel.left().instances, result.instance_count);
        for slot in scene.slots() {
            let handle = scene.handle(slot).expect("taken");
            let e = culler.explain_shadows(&scene, &shadows, handle).expect("a good handle");
            assert_eq!(e.reason, result.reasons[slot as usize], "{round} {slot}: {:?}", e.steps);
            let caster = e.reason.and_then(cullet::Reason::caster);
            if let (Some(caster), Some(step)) = (caster, e.steps.last()) {
                let said = step.unit != Unit::Instances || step.to_string().contains(caster.name());
                assert!(said, "{step}");
                kinds.insert(caster.name());
            }
        }
    }
    assert_eq!(kinds.len(), 5, "{kinds:?}");
}

/// A light without a map has nothing to look from: what would need it does not run.
#[test]
fn without_a_map_no_stage_looks_through_the_camera() {
    let mut rng = Rng(34);
    for _ in 0..20 {
        let scene = random_scene(&mut rng, 20);
        let shadows = ShadowView::new(random_view(&mut rng), random_light(&mut rng));
        let culler = telling(Output::Triangles)
            .with_occlusion(Occlusion::default())
            .with_detail(Detail::default().with_threshold_px(1e6));
        let result = cull(&culler, &scene, &shadows);
        let ran = |stage| result.funnel.rows.iter().any(|row| row.stage == stage);
        assert!([Stage::Occlusion, Stage::Detail, Stage::Backface].into_iter().all(|s| !ran(s)));
        assert!(ran(Stage::Layer) && ran(Stage::Frustum) && ran(Stage::Degenerate));
    }
}

/// The answer does not depend on what a state has seen before: cameras, other lights, other scenes.
#[test]
fn warm_equals_cold() {
    let mut rng = Rng(35);
    let mut state = ViewState::default();
    let culler = telling(Output::Clusters).with_occlusion(Occlusion::default());
    for _ in 0..12 {
        let mut scene = random_scene(&mut rng, 300);
        scene.commit(&Culler::default());
        for _ in 0..4 {
            let light = random_light(&mut rng);
            let mut shadows = ShadowView::new(random_view(&mut rng), light);
            shadows.map = (rng.below(2) == 0).then(|| map_of(&mut rng, &light, [0.0; 3]));
            let mut result = Visible::default();
            culler.cull_one(&scene, &shadows.camera, &mut state, &mut result);
            // Twice: the second time by what the first proved.
            for _ in 0..2 {
                culler.cull_shadow(&scene, &shadows, &mut state, &mut result);
                assert_eq!(result, cull(&culler, &scene, &shadows));
            }
        }
    }
}

#[test]
fn only_the_layer_mask_drops_what_is_always_visible() {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(cube());
    let mut add = |z: f64, layers, always_visible| {
        let mut instance = Instance::new(mesh, Transform::from_translation([0.0, 0.0, z]));
        (instance.layers, instance.flags) =
            (layers, InstanceFlags { always_visible, ..InstanceFlags::default() });
        scene.add(instance).expect("room")
    };
    let (always, hidden, plain) = (add(500.0, 1, true), add(500.0, 2, true), add(500.0, 1, false));
    let camera = View::perspective([0.0; 3], [0.0, 0.0, -1.0], 1.0, 0.1, 50.0, [64, 64]);
    let camera = camera.expect("good").with_layers(1);
    let nothing = Light::Point { position: [0.0; 3], range: 0.0 };
    for light in [SUN, nothing] {
        let shadows = ShadowView::new(camera.clone(), light);
        let result = cull(&telling(Output::Clusters), &scene, &shadows);
        let stage = |handle| {
            let slot = scene.slot(handle).expect("there");
            result.reasons[slot as usize].map(|r| r.stage)
        };
        assert_eq!(stage(always), None);
        assert_eq!(stage(hidden), Some(Stage::Layer));
        assert_eq!(stage(plain), Some(Stage::Frustum));
    }
}

/// Whether the open way from a point towards the light meets a box, which is where it is shaded (slabs, in f64).
fn is_shaded(b: &Aabb, point: [f64; 3], to_light: [f64; 3]) -> bool {
    let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
    for a in 0..3 {
        let (low, high) = (f64::from(b.min[a]), f64::from(b.max[a]));
        if to_light[a] == 0.0 {
            if point[a] < low || point[a] > high {
                return false;
            }
            continue;
        }
        let (s, t) = ((low - point[a]) / to_light[a], (high - point[a]) / to_light[a]);
        enter = enter.max(s.min(t));
        leave = leave.min(s.max(t));
    }
    enter < leave
}

/// Boxes over a floor of 40 × 40.
fn random_box(rng: &mut Rng, size: f64) -> Aabb {
    let low = [rng.range(-18.0, 16.0), rng.range(0.2, 15.0), rng.range(-18.0, 16.0)];
    let side: [f64; 3] = std::array::from_fn(|_| rng.range(0.1, size));
    Aabb::new(
        low.map(|v| v as f32),
        std::array::from_fn::<f32, 3, _>(|a| (low[a] + side[a]) as f32),
    )
}

#[test]
fn a_caster_hidden_from_the_light_shades_nothing_of_its_own() {
    let mut rng = Rng(12);
    let (mut dropped_in_all, mut shaded_points) = (0, 0);
    // A camera that sees everything, so that no region drops anything.
    let camera =
        View::orthographic([0.0, 0.0, 90.0], [0.0; 3], 90.0, 0.1, 200.0, [64, 64]).unwrap();
    for _ in 0..40 {
        let casters: Vec<Aabb> =
            (0..60).map(|i| random_box(&mut rng, if i < 8 { 12.0 } else { 2.0 })).collect();
        let to_light = [rng.range(-0.6, 0.6), 1.0, rng.range(-0.6, 0.6)];
        let eye = to_light.map(|v| v * 60.0);
        let map = View::orthographic(eye, [0.0; 3], 80.0, 0.1, 200.0, [1024, 1024]).unwrap();
        let (scene, handles) = scene_of_boxes(&casters);
        let sun = Light::Directional { direction: to_light.map(|v| -v) };
        let shadows = ShadowView { map: Some(map), ..ShadowView::new(camera.clone(), sun) };
        let occlusion = Some(Occlusion::default());
        let culler = telling(Output::Instances).with_occlusion(occlusion);
        let result = cull(&culler, &scene, &shadows);
        let is_kept = |i: usize| {
            let slot = scene.slot(handles[i]).unwrap();
            let reason = result.reasons[slot as usize];
            assert!(reason.is_none_or(|r| r.stage == Stage::Occlusion), "{reason:?}");
            reason.is_none()
        };
        dropped_in_all += (0..60).filter(|&i| !is_kept(i)).count();
        // Any point that is in a dropped caster's shadow, and beyond the caster, is in that of one which is left.
        for (i, caster) in casters.iter().enumerate().filter(|(i, _)| !is_kept(*i)) {
            for _ in 0..200 {
                let on: [f64; 3] = std::array::from_fn(|a| {
                    rng.range(f64::from(caster.min[a]), f64::from(caster.max[a]))
                });
                let below = on[1] * rng.range(0.0, 1.0);
                let point = std::array::from_fn(|a| on[a] - to_light[a] * below);
                if is_shaded(caster, point, to_light) {
                    shaded_points += 1;
                    let others = casters.iter().enumerate().filter(|(k, _)| is_kept(*k));
                    let shaded = others.into_iter().any(|(_, b)| is_shaded(b, point, to_light));
                    assert!(shaded, "{point:?} is in the shadow of caster {i} alone");
                }
            }
        }
    }
    println!("{dropped_in_all} dropped, {shaded_points} points in their shadows");
    // Keeping everything would pass the rest.
    assert!(dropped_in_all >= 40, "{dropped_in_all} dropped");
    assert!(shaded_points > 1000, "{shaded_points}");
}

#[test]
fn casters_through_the_near_plane_or_without_bounds_are_kept_and_those_beside_the_map_go() {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(cube());
    let mut add = |scale: [f32; 3], at: [f64; 3], bounds| {
        let place = Transform::from_scale_translation(scale, at);
        scene.add(Instance { bounds, ..Instance::new(mesh, place) }).unwrap()
    };
    let mesh_bounds = BoundsOverride::Mesh;
    let wall = add([50.0, 0.5, 50.0], [0.0, 9.5, 0.0], mesh_bounds);
    let under = add([0.5; 3], [0.0, 0.5, 0.0], mesh_bounds);
    let boundless = add([0.5; 3], [0.0, 0.5, 0.0], BoundsOverride::None);
    let crossing = add([0.5; 3], [0.0, 59.9, 0.0], mesh_bounds);
    let beside = add([0.5; 3], [30.5, 0.5, 0.5], mesh_bounds);
    let over = add([0.5; 3], [0.5, 20.5, 0.5], mesh_bounds);
    scene.commit(&Culler::default());
    let camera =
        View::orthographic([0.0, 0.0, 90.0], [0.0; 3], 99.0, 0.1, 200.0, [64, 64]).unwrap();
    let map = View::orthographic([0.0, 60.0, 0.0], [0.0; 3], 40.0, 0.1, 200.0, [64, 64]).unwrap();
    let shadows = ShadowView { map: Some(map), ..ShadowView::new(camera, SUN) };
    let occlusion = Some(Occlusion::default());
    let result = cull(&telling(Output::Clusters).with_occlusion(occlusion), &scene, &shadows);
    let reason = |handle| result.reasons[scene.slot(handle).unwrap() as usize];
    for kept in [wall, boundless, crossing, over] {
        assert_eq!(reason(kept), None);
    }
    assert_eq!(reason(under).map(|r| r.stage), Some(Stage::Occlusion));
    assert_eq!(reason(beside).and_then(cullet::Reason::caster), Some(CasterReason::OutsideMap));
}

/// Only receivers that the camera sees are shaded: where it sees none, nothing casts.
#[test]
fn receivers_are_what_the_camera_sees() {
    let boxes = [[0.0, 0.0, -8.0], [0.0, 30.0, -8.0], [0.0, 30.0, -30.0]]
        .map(|c: [f32; 3]| Aabb::new(c.map(|v| v - 1.0), c.map(|v| v + 1.0)));
    let (scene, handles) = scene_of_boxes(&boxes);
    let camera = View::perspective([0.0; 3], [0.0, 0.0, -1.0], 1.0, 0.1, 50.0, [64, 64]).unwrap();
    let mut seen = Visible::default();
    Culler::default().cull_one(&scene, &camera, &mut ViewState::default(), &mut seen);
    assert_eq!(seen.instance_count, 1);
    let kept = |shadows: &ShadowView| {
        let result = cull(&telling(Output::Clusters), &scene, shadows);
        handles.iter().map(|h| result.reasons[scene.slot(*h).unwrap() as usize].is_none()).collect()
    };
    let shadows = ShadowView::new(camera, SUN);
    let by_frustum: Vec<bool> = kept(&shadows);
    assert_eq!(by_frustum, [true, true, true]);
    let by_receivers: Vec<bool> = kept(&shadows.clone().receiving(&scene, &seen).unwrap());
    assert_eq!(by_receivers, [true, true, false]);
    let nothing = Visible { version: scene.version(), ..Visible::default() };
    let by_none: Vec<bool> = kept(&shadows.clone().receiving(&scene, &nothing).unwrap());
    assert_eq!(by_none, [false, false, false]);
    assert!(shadows.receiving(&scene, &Visible::default()).is_err(), "never culled");
}

/// The cascades of a camera: each keeps what can shade the receivers in its own slice, so that near ones take less.
#[test]
fn cascades_keep_what_shades_their_slice() {
    let camera =
        View::perspective([0.0, 2.0, 0.0], [0.0, 2.0, -1.0], 1.0, 0.1, 100.0, [640, 480]).unwrap();
    let boxes: Vec<Aabb> = (0..20)
        .flat_map(|i| {
            let z = -5.0 * i as f32 - 4.0;
            // What the camera sees, and what stands above it.
            [1.0, 60.0].map(|y| Aabb::new([-1.0, y, z], [1.0, y + 2.0, z + 2.0]))
        })
        .collect();
    let (scene, handles) = scene_of_boxes(&boxes);
    let culler = Culler::default();
    let mut seen = Visible::default();
    culler.without(Stage::Occlusion).cull_one(
        &scene,
        &camera,
        &mut ViewState::default(),
        &mut seen,
    );
    assert!(seen.instance_count >= 10);
    let splits = [0.1, 12.0, 40.0, 100.0];
    let cascades = ShadowView::cascades(&camera, SUN, &splits).unwrap();
    let cascades: Vec<_> =
        cascades.into_iter().map(|s| s.receiving(&scene, &seen).unwrap()).collect();
    let mut states = vec![ViewState::default(); 3];
    let mut casters = vec![Visible::default(); 3];
    culler.cull_shadows(&scene, &cascades, &mut states, &mut casters).unwrap();
    let whole = ShadowView::new(camera.clone(), SUN).receiving(&scene, &seen).unwrap();
    let of_all: Vec<u32> = cull(&culler, &scene, &whole).slots().collect();
    let mut of_any: Vec<u32> = casters.iter().flat_map(Visible::slots).collect();
    of_any.sort_unstable();
    of_any.dedup();
    assert_eq!(of_any, of_all, "together they keep what the whole view does");
    for (i, casters) in casters.iter().enumerate() {
        assert!(casters.instance_count < of_all.len() as u64, "cascade {i}");
        // What is seen in the slice shades itself, and what stands above it shades it.
        for (pair, at) in boxes.chunks(2).zip(handles.chunks(2)) {
            let distance = f64::from(-pair[0].center()[2] as f32);
            if distance > splits[i] + 1.0 && distance < splits[i + 1] - 1.0 {
                let is_seen = seen.slots().any(|s| s == scene.slot(at[0]).unwrap());
                let kept = at.iter().map(|&h| scene.slot(h).unwrap());
                let kept: Vec<bool> = kept.map(|slot| casters.slots().any(|s| s == slot)).collect();
                assert!(!is_seen || kept == [true, true], "{distance} in cascade {i}: {kept:?}");
            }
        }
    }
    let refused = culler.cull_shadows(&scene, &cascades, &mut states, &mut casters[..2]);
    assert!(refused.unwrap_err().to_string().contains("3 views, but 3 states and 2 results"));
}
