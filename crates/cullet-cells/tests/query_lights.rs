//! Lights that are dropped light nothing that is seen, by points tried one after the other; and enough are dropped.

use cullet::bounds::Aabb;
use cullet::cull::detail::Detail;
use cullet::cull::occlusion::Occlusion;
use cullet::cull::shadow::Light;
use cullet::{
    Culler, Instance, Output, Scene, ShadowView, Transform, View, ViewState, Visible,
    scene::BoundsOverride,
};
use cullet_cells::query::{
    BlockingSides, LightAnswer, LightOptions, LightReason, SightOptions, cull_light_casters,
    cull_lights, line_of_sight,
};
use cullet_testkit::meshes::block;
use cullet_testkit::oracles::sight::place;
use cullet_testkit::scenes::{city, random_scene};
use cullet_testkit::vectors::dot;
use cullet_testkit::views::{look, random_view};
use cullet_testkit::{Rng, at_every_level, cases};

fn minus(p: [f64; 3], q: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|a| p[a] - q[a])
}

fn along(p: [f64; 3], q: [f64; 3], share: f64) -> [f64; 3] {
    std::array::from_fn(|a| p[a] + (q[a] - p[a]) * share)
}

/// Whether a light shines on a point, nothing being in between.
fn shines_on(light: &Light, p: [f64; 3]) -> bool {
    let reaches = |position, range| {
        let way = minus(p, position);
        dot(way, way).sqrt() <= range
    };
    match *light {
        Light::Directional { .. } => true,
        Light::Point { position, range } => reaches(position, range),
        Light::Spot { position, direction, half_angle_radians, range } => {
            let way = minus(p, position);
            let length = dot(way, way).sqrt() * dot(direction, direction).sqrt();
            let is_in_cone = half_angle_radians >= std::f64::consts::FRAC_PI_2
                || dot(way, direction) >= length * half_angle_radians.cos();
            half_angle_radians > 0.0 && is_in_cone && reaches(position, range)
        }
        _ => unreachable!("no other light is made here"),
    }
}

/// A point that a light shines on.
fn lit_point(rng: &mut Rng, light: &Light) -> Option<[f64; 3]> {
    let (position, range) = match *light {
        Light::Point { position, range } | Light::Spot { position, range, .. } => (position, range),
        _ => return Some(rng.vector(60.0)),
    };
    let reach = range.min(100.0) * rng.unit().cbrt();
    (0..200)
        .map(|_| {
            let way = rng.direction();
            std::array::from_fn(|a| position[a] + way[a] * reach)
        })
        .find(|&p| shines_on(light, p))
}

fn random_light(rng: &mut Rng, reach: f64) -> Light {
    let range = match rng.below(12) {
        0 => f64::INFINITY,
        1 => 0.0,
        _ => rng.range(0.5, 12.0),
    };
    let (position, direction) = (rng.vector(reach), rng.vector(1.0));
    match rng.below(8) {
        0 => Light::Directional { direction },
        1..=3 => Light::Point { position, range },
        _ => Light::Spot { position, direction, half_angle_radians: rng.range(-0.1, 1.9), range },
    }
}

/// Rows that follow from the reasons, and lists that belong together.
fn check_counts(lights: &[Light], answer: &LightAnswer) {
    let mut left = lights.len() as u64;
    assert!(answer.rows.is_sorted_by(|a, b| a.stage < b.stage));
    for row in &answer.rows {
        assert_eq!(row.entered, left);
        let dropped = answer.reasons.iter().filter(|&&r| r == Some(row.stage)).count() as u64;
        left -= dropped;
        assert_eq!(row.left, left);
    }
    let kept = answer.reasons.iter().enumerate().filter(|(_, r)| r.is_none());
    assert!(kept.map(|(i, _)| i as u32).eq(answer.kept.iter().copied()));
    assert_eq!(answer.receivers.len(), answer.kept.len());
}

/// Points of triangles that are drawn whole, in world space, some of each instance.
fn surface_points(scene: &Scene, visible: &Visible, rng: &mut Rng) -> Vec<(u32, [f64; 3])> {
    let mut points = Vec::new();
    for slot in visible.slots() {
        let mesh = scene.mesh(slot);
        for _ in 0..6 {
            let corners = mesh.corners(rng.below(u64::from(mesh.triangle_count())) as u32);
            let [p, q, r] = corners.map(|p| place(scene.transform(slot), p));
            points.push((slot, along(along(p, q, rng.unit()), r, rng.unit())));
        }
    }
    points
}

#[test]
fn a_light_that_is_dropped_lights_no_point_that_is_seen() {
    let mut rng = Rng(0x1167);
    let mut dropped = [0; 5];
    for round in 0..cases(40) {
        let mut scene = random_scene(&mut rng, 60);
        scene.commit(&Culler::default());
        if rng.chance(0.5) {
            scene.rebase(rng.vector(1e4));
        }
        let view = random_view(&mut rng);
        let lights: Vec<Light> = (0..60).map(|_| random_light(&mut rng, 30.0)).collect();
        let mut visible = Visible::default();
        Culler::default().cull_one(&scene, &view, &mut ViewState::default(), &mut visible);
        let points = surface_points(&scene, &visible, &mut rng);
        let frustum = view.frustum();
        for with_visible in [false, true] {
            let options =
                LightOptions { visible: with_visible.then_some(&visible), ..Default::default() };
            let mut answer = LightAnswer::default();
            cull_lights(&scene, &view, &lights, &options, &mut answer);
            check_counts(&lights, &answer);
            for (light, reason) in lights.iter().zip(&answer.reasons) {
                let Some(reason) = *reason else { continue };
                dropped[reason as usize] += 1;
                for _ in 0..40 {
                    let Some(p) = lit_point(&mut rng, light) else { break };
                    let is_lit = shines_on(light, p);
                    match reason {
                        LightReason::Unlit => assert!(!is_lit || p == position_of(light)),
                        LightReason::Frustum => {
                            assert!(!frustum.contains(p), "{round}: {light:?} {p:?}");
                        }
                        _ => {}
                    }
                }
                let seen =
                    points.iter().find(|(_, p)| frustum.contains(*p) && shines_on(light, *p));
                assert!(seen.is_none() || reason == LightReason::Unlit, "{light:?} {seen:?}");
            }
            // What is lit and seen is among the receivers.
            for (at, &kept) in answer.kept.iter().enumerate() {
                let light = &lights[kept as usize];
                let Some(b) = answer.receivers[at] else { continue };
                let lit =
                    points.iter().filter(|(_, p)| frustum.contains(*p) && shines_on(light, *p));
                for &(slot, p) in lit {
                    let own = scene.bounds(slot);
                    assert_eq!(b.union(&own), b, "{light:?}: {p:?} of slot {slot}");
                }
            }
        }
    }
    let [unlit, frustum, _, _, receiver] = dropped;
    let rounds = cases(40);
    let enough = unlit > rounds * 4 && frustum > rounds * 40 && receiver > rounds * 3;
    assert!(enough, "{dropped:?}");
}

fn position_of(light: &Light) -> [f64; 3] {
    match *light {
        Light::Point { position, .. } | Light::Spot { position, .. } => position,
        _ => [f64::NAN; 3],
    }
}

struct Night {
    scene: Scene,
    view: View,
    state: ViewState,
    visible: Visible,
    lamps: Vec<Light>,
}

/// The city at night, seen from a street: lamps and the heads of cars all over it.
fn night() -> Night {
    let mut scene = city(12, 1, 300);
    scene.commit(&Culler::default());
    let view = look([2.0, 1.7, 140.0], [0.0, 3.0, 0.0], [640, 480]);
    let (mut state, mut visible) = (ViewState::default(), Visible::default());
    let culler = Culler::default().with_occlusion(Occlusion::default());
    culler.cull_one(&scene, &view, &mut state, &mut visible);
    let mut rng = Rng(31);
    let lamps = (0..600)
        .map(|i| {
            let position =
                [rng.range(-140.0, 140.0), rng.range(0.5, 6.0), rng.range(-140.0, 140.0)];
            let range = rng.range(3.0, 9.0);
            match i % 3 {
                0 => Light::Point { position, range },
                _ => Light::Spot {
                    position,
                    direction: rng.vector(1.0),
                    half_angle_radians: rng.range(0.2, 1.0),
                    range,
                },
            }
        })
        .collect();
    Night { scene, view, state, visible, lamps }
}

#[test]
fn a_light_behind_houses_lights_no_point_that_the_eye_sees() {
    let Night { scene, view, state, visible, lamps } = night();
    let eye = [2.0, 1.7, 140.0];
    let options = LightOptions {
        buffer: state.occlusion_buffer(),
        visible: Some(&visible),
        ..LightOptions::default()
    };
    assert!(options.buffer.is_some());
    let mut answer = LightAnswer::default();
    cull_lights(&scene, &view, &lamps, &options, &mut answer);
    check_counts(&lamps, &answer);
    let mut rng = Rng(8);
    let sides = SightOptions { sides: BlockingSides::Both, ..SightOptions::default() };
    let frustum = view.frustum();
    let mut tried = 0;
    for (lamp, reason) in lamps.iter().zip(&answer.reasons) {
        if *reason != Some(LightReason::Occlusion) {
            continue;
        }
        for _ in 0..30 {
            let Some(p) = lit_point(&mut rng, lamp).filter(|&p| frustum.contains(p)) else {
                continue;
            };
            tried += 1;
            assert!(line_of_sight(&scene, eye, p, &sides).is_blocked(), "{lamp:?} {p:?}");
        }
    }
    assert!(tried > 500, "{tried}");
    // A floor: of those in the frustum, most are behind houses.
    let left = |stage| answer.rows.iter().find(|r| r.stage == stage).map(|r| r.left);
    let [in_view, hidden] =
        [LightReason::Frustum, LightReason::Occlusion].map(|s| left(s).unwrap());
    assert!(in_view < 450 && hidden * 6 < in_view, "{:?}", answer.rows);
}

/// Without what it was not given, a stage does not run and drops nothing.
#[test]
fn stages_run_that_were_asked_for() {
    let Night { scene, view, state, visible, lamps } = night();
    let ran = |options: &LightOptions<'_>| {
        let mut answer = LightAnswer::default();
        cull_lights(&scene, &view, &lamps, options, &mut answer);
        check_counts(&lamps, &answer);
        (answer.rows.iter().map(|r| r.stage).collect::<Vec<_>>(), answer)
    };
    let (stages, plain) = ran(&LightOptions::default());
    assert_eq!(stages, [LightReason::Unlit, LightReason::Frustum]);
    let all = LightOptions {
        detail: Some(Detail::default().with_threshold_px(40.0)),
        buffer: state.occlusion_buffer(),
        visible: Some(&visible),
        ..LightOptions::default()
    };
    let (stages, small) = ran(&all);
    assert_eq!(stages, LightReason::ALL);
    at_every_level!(|simd| {
        let (_, answer) = ran(&LightOptions { simd, ..all });
        assert_eq!((&answer.kept, &answer.reasons), (&small.kept, &small.reasons));
        assert_eq!(answer.receivers, small.receivers);
    });
    for (lamp, reason) in lamps.iter().zip(&small.reasons) {
        if *reason == Some(LightReason::Detail) {
            // The range is a radius: a ball of 40 pixels at 554 pixels a unit of tangent is so far away.
            let way = minus(position_of(lamp), [2.0, 1.7, 140.0]);
            assert!(dot(way, way).sqrt() > 30.0, "{lamp:?}");
        }
    }
    let took = |a: &LightAnswer, r| a.reasons.iter().filter(|x| **x == Some(r)).count();
    assert!(took(&small, LightReason::Detail) > 10, "{:?}", small.rows);
    assert!(
        small.kept.iter().all(|k| plain.kept.contains(k)) && small.kept.len() < plain.kept.len()
    );
    assert_eq!(LightReason::ALL.map(LightReason::name).len(), 5);
}

/// Each light's casters are those of its own call, and hold all that stands between it and a point that it lights.
#[test]
fn casters_are_kept_that_stand_between_a_light_and_what_it_lights() {
    let mut rng = Rng(99);
    let mut between = 0;
    for _ in 0..cases(20) {
        let mut scene = random_scene(&mut rng, 80);
        scene.commit(&Culler::default());
        let view = random_view(&mut rng);
        let lights: Vec<Light> = (0..12).map(|_| random_light(&mut rng, 20.0)).collect();
        let culler = Culler::default().with_output(Output::Instances).with_reasons(true);
        let mut visible = Visible::default();
        culler.cull_one(&scene, &view, &mut ViewState::default(), &mut visible);
        let options = LightOptions { visible: Some(&visible), ..LightOptions::default() };
        let mut answer = LightAnswer::default();
        cull_lights(&scene, &view, &lights, &options, &mut answer);
        let (mut states, mut results) = (Vec::new(), vec![Visible::default(); 40]);
        let asked = (&view, &lights[..], &answer);
        cull_light_casters(&culler, &scene, asked, &mut states, &mut results);
        assert_eq!([states.len(), results.len()], [answer.kept.len(); 2]);
        let points = surface_points(&scene, &visible, &mut rng);
        for (at, (&number, casters)) in answer.kept.iter().zip(&results).enumerate() {
            let light = &lights[number as usize];
            let shadows = answer.shadow_view(&view, &lights, at).unwrap();
            let wider = ShadowView { receivers: None, ..shadows.clone() };
            let [own, all] = [&shadows, &wider].map(|s| {
                let mut result = Visible::default();
                culler.cull_shadow(&scene, s, &mut ViewState::default(), &mut result);
                result
            });
            assert_eq!(&own, casters);
            assert!(own.instance_count <= all.instance_count);
            let frustum = view.frustum();
            for (_, p) in
                points.iter().filter(|(_, p)| frustum.contains(*p) && shines_on(light, *p))
            {
                let from = match *light {
                    Light::Directional { direction } => {
                        std::array::from_fn(|a| p[a] - direction[a] * 100.0)
                    }
                    _ => position_of(light),
                };
                let sides = SightOptions { layers: view.layers, ..SightOptions::default() };
                let sides = SightOptions { sides: BlockingSides::Both, ..sides };
                for share in [1.0, 0.99] {
                    let sight = line_of_sight(&scene, from, along(from, *p, share), &sides);
                    if let cullet_cells::query::Sight::Blocked(by) = sight {
                        between += 1;
                        let reason = casters.reasons[by.slot as usize];
                        assert_eq!(reason, None, "{light:?} {p:?} {by:?}");
                    }
                }
            }
        }
        assert!(answer.shadow_view(&view, &lights, answer.kept.len()).is_none());
    }
    assert!(between > 200, "{between}");
}

#[test]
fn what_is_not_known_keeps_the_light() {
    let view = look([0.0; 3], [0.0, 0.0, -1.0], [64, 64]);
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(block([-1.0; 3], [1.0; 3]));
    let place = Transform::from_translation([0.0, 0.0, -8.0]);
    let seen = scene.add(Instance::new(mesh, place)).unwrap();
    let behind = |range| Light::Point { position: [0.0, 0.0, 50.0], range };
    let lights = [
        behind(f64::NAN),
        Light::Point { position: [0.0, f64::NAN, 50.0], range: 1.0 },
        Light::Directional { direction: [0.0; 3] },
        behind(f64::INFINITY),
        behind(1.0),
    ];
    let mut visible = Visible::default();
    Culler::default().cull_one(&scene, &view, &mut ViewState::default(), &mut visible);
    assert_eq!(visible.instance_count, 1);
    let kept = |scene: &Scene, options: &LightOptions<'_>| {
        let mut answer = LightAnswer::default();
        cull_lights(scene, &view, &lights, options, &mut answer);
        answer.kept
    };
    assert_eq!(kept(&scene, &LightOptions::default()), [0, 1, 2, 3]);
    let with_visible = LightOptions { visible: Some(&visible), ..LightOptions::default() };
    assert_eq!(kept(&scene, &with_visible), [0, 1, 2, 3]);
    // Nothing is seen: then no light matters, except where no bounds say that it is not.
    let nothing = Visible::default();
    let options = LightOptions { visible: Some(&nothing), ..LightOptions::default() };
    assert_eq!(kept(&scene, &options), [0_u32; 0]);
    scene.set_bounds(seen, BoundsOverride::None).unwrap();
    let near = [Light::Point { position: [0.0, 0.5, -3.0], range: 0.5 }];
    let mut answer = LightAnswer::default();
    cull_lights(&scene, &view, &near, &with_visible, &mut answer);
    assert_eq!(answer.receivers, [Some(Aabb::EVERYTHING)], "it may be anywhere");
}
