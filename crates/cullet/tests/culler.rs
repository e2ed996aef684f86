//! The culler against a slow oracle, on random scenes and views of every kind.

use std::collections::BTreeSet;

use cullet::{
    Culler, Handle, Instance, InstanceFlags, Output, Reason, Stage, Transform, View, ViewState,
    Visible, scene::BoundsOverride,
};
use cullet_testkit::answers::cull;
use cullet_testkit::oracles::visible::visible_ref;
use cullet_testkit::scenes::random_scene;
use cullet_testkit::views::{
    looking_down_z, random_box, random_culler, random_view, view_and_moved,
};
use cullet_testkit::{Rng, answers, at_every_level, cases, meshes};

fn triangles() -> Culler {
    Culler::default().with_output(Output::Triangles).with_reasons(true)
}

/// Everything that the oracle can see is in the answer, and the answer is not just everything.
#[test]
fn nothing_visible_is_dropped() {
    let mut rng = Rng(1);
    let (mut all, mut kept, mut needed) = (0u64, 0u64, 0u64);
    for round in 0..300 {
        let scene = random_scene(&mut rng, 12);
        let view = random_view(&mut rng);
        let culler = triangles().with_frustum_exact(round % 2 == 0);
        let result = cull(&culler, &scene, &view);
        let listed = answers::listed(&result);
        for (slot, triangle) in visible_ref(&scene, &view) {
            needed += 1;
            assert!(
                listed.contains(&(slot, triangle)),
                "round {round}: triangle {triangle} of slot {slot} is visible, dropped for {:?}",
                result.reasons[slot as usize]
            );
        }
        all += scene.triangle_count();
        kept += result.triangle_count;
    }
    // The floor: at this seed 36 % of all triangles survive, 30 % are needed.
    assert!(kept * 100 < all * 45, "{kept} of {all} kept, {needed} needed");
}

/// The default leaves all that a preset leaves, and no preset has a lossy stage.
#[test]
fn presets_drop_more_than_the_default_and_none_is_lossy() {
    let mut rng = Rng(7);
    let (mut kept, mut all) = (0, 0);
    for _ in 0..40 {
        let scene = random_scene(&mut rng, 30);
        let view = random_view(&mut rng);
        let default = cull(&Culler::default(), &scene, &view);
        let slots = answers::slots(&default);
        for preset in [Culler::exact(), Culler::balanced(), Culler::fast()] {
            let result = cull(&preset, &scene, &view);
            assert!(answers::slots(&result).iter().all(|s| slots.contains(s)), "{preset:?}");
            kept += result.instance_count;
            all += default.instance_count;
        }
    }
    assert!(kept < all, "{kept} of {all}: nothing was hidden");
    for preset in [Culler::exact(), Culler::balanced(), Culler::fast(), Culler::default()] {
        assert!(!preset.runs(Stage::Detail) && !preset.runs(Stage::Lod), "{preset:?}");
    }
}

/// The three depths of the answer nest, and each ascends.
#[test]
fn outputs_nest_and_ascend() {
    let mut rng = Rng(2);
    for _ in 0..100 {
        let scene = random_scene(&mut rng, 20);
        let view = random_view(&mut rng);
        let answers = [Output::Instances, Output::Clusters, Output::Triangles]
            .map(|output| cull(&triangles().with_output(output), &scene, &view));
        for pair in answers.windows(2) {
            assert!(pair[1].triangle_count <= pair[0].triangle_count);
            assert!(pair[1].instance_count <= pair[0].instance_count);
            let coarse = answers::slots(&pair[0]);
            assert!(answers::slots(&pair[1]).iter().all(|s| coarse.contains(s)));
        }
        for a in &answers {
            let slots = answers::slots(a);
            assert!(slots.is_sorted() && slots.windows(2).all(|w| w[0] != w[1]));
            assert_eq!(slots.len() as u64, a.instance_count);
            assert!(a.partial.is_sorted_by_key(|d| (d.slot, d.first_cluster)));
        }
        let listed: Vec<_> = answers::listed_in_order(&answers[2]);
        assert!(listed.windows(2).all(|w| w[0] < w[1]), "triangles ascend");
    }
}

/// `explain` gives, for every instance, the reason that the whole cull wrote.
#[test]
fn explanations_equal_reasons() {
    let mut rng = Rng(4);
    for round in 0..60 {
        let scene = random_scene(&mut rng, 20);
        let view = random_view(&mut rng);
        let detail = cullet::cull::detail::Detail::default()
            .with_measure(cullet::cull::detail::Measure::WidthAndHeight)
            .with_threshold_px(40.0);
        let culler = triangles()
            .with_frustum_exact(round % 3 == 0)
            .with_detail((round % 2 == 0).then_some(detail));
        let result = cull(&culler, &scene, &view);
        let drawn = answers::slots(&result);
        for slot in scene.slots() {
            let handle = scene.handle(slot).expect("the slot is taken");
            let e = culler.explain(&scene, &view, handle).expect("the handle is good");
            assert_eq!(e.reason, result.reasons[slot as usize], "slot {slot}: {:?}", e.steps);
            assert_eq!(e.reason.is_none(), drawn.contains(&slot));
            assert!(!e.steps.is_empty());
        }
    }
}

/// A state that has seen other views and scenes gives what a fresh one gives, and several views in one
/// call what each gives alone.
#[test]
fn warm_equals_cold_and_many_equals_one() {
    let mut rng = Rng(5);
    let culler = triangles();
    let mut states = vec![ViewState::default(); 3];
    let mut results = vec![Visible::default(); 3];
    for _ in 0..40 {
        let scene = random_scene(&mut rng, 15);
        let views: Vec<View> = (0..3).map(|_| random_view(&mut rng)).collect();
        culler.cull(&scene, &views, &mut states, &mut results).expect("counts agree");
        for (view, result) in views.iter().zip(&results) {
            assert_eq!(result, &cull(&culler, &scene, view));
        }
    }
    let scene = random_scene(&mut rng, 1);
    let views = [random_view(&mut rng)];
    assert!(culler.cull(&scene, &views, &mut [], &mut results[..1]).is_err());
    assert!(culler.cull(&scene, &[], &mut [], &mut []).is_ok());
}

#[test]
fn every_simd_level_gives_the_same_answer() {
    let mut rng = Rng(6);
    for _ in 0..40 {
        let scene = random_scene(&mut rng, 70);
        let view = random_view(&mut rng);
        let expected = cull(&triangles(), &scene, &view);
        at_every_level!(|level| {
            assert!(cull(&triangles().with_simd(level), &scene, &view) == expected);
        });
    }
}

#[test]
fn flags_layers_and_overrides_are_obeyed() {
    let mut rng = Rng(7);
    let mut scene = cullet::Scene::new();
    let mesh = scene.add_mesh(meshes::tetrahedron());
    let view = looking_down_z();
    let aside = Transform::from_translation([50.0, 0.0, -5.0]);
    let mut add = |instance: Instance| scene.add(instance).expect("the mesh exists");
    let plain = add(Instance::new(mesh, aside));
    let always = add(Instance {
        flags: InstanceFlags { always_visible: true, ..InstanceFlags::default() },
        ..Instance::new(mesh, aside)
    });
    let no_bounds = add(Instance { bounds: BoundsOverride::None, ..Instance::new(mesh, aside) });
    let wide = add(Instance { bounds: BoundsOverride::Margin(60.0), ..Instance::new(mesh, aside) });
    let nan = add(Instance::new(mesh, Transform::from_translation([f64::NAN, 0.0, 0.0])));
    let other_layer = add(Instance { layers: 2, ..Instance::new(mesh, Transform::IDENTITY) });
    let line = add(Instance::new(
        mesh,
        Transform::from_scale_translation([1.0, 0.0, 0.0], [0.0, 0.0, -5.0]),
    ));
    let plate = add(Instance::new(
        mesh,
        Transform::from_scale_translation([1.0, 1.0, 0.0], [0.0, 0.0, -5.0]),
    ));
    let result = cull(&triangles(), &scene, &view.with_layers(1));
    let reason = |h: Handle| result.reasons[scene.slot(h).expect("it is there") as usize];
    assert_eq!(reason(plain).map(|r| r.stage), Some(Stage::Frustum));
    assert_eq!(
        reason(plain).map(|r| r.detail),
        Some(cullet::view::FrustumPlane::Right as u8),
        "named for the plane"
    );
    for kept in [always, no_bounds, wide, nan, plate] {
        assert_eq!(reason(kept), None, "{kept:?}");
    }
    let layer = Reason { stage: Stage::Layer, detail: 0 };
    assert_eq!(reason(other_layer), Some(layer));
    assert_eq!(reason(line), Some(Reason { stage: Stage::Degenerate, detail: 0 }));
    let _ = rng.bits();
}

#[test]
fn margins_never_shrink_bounds() {
    let mut scene = cullet::Scene::new();
    let mesh = scene.add_mesh(meshes::tetrahedron());
    let (before, aside) = ([0.0, 0.0, -5.0], [50.0, 0.0, -5.0]);
    let mut add = |place: [f64; 3], margin: f32| {
        let bounds = BoundsOverride::Margin(margin);
        let transform = Transform::from_translation(place);
        scene.add(Instance { bounds, ..Instance::new(mesh, transform) }).expect("the mesh exists")
    };
    let shrunk = [-0.0, -0.1, -10.0, f32::MIN, f32::NEG_INFINITY];
    let kept: Vec<Handle> = shrunk
        .map(|margin| add(before, margin))
        .into_iter()
        .chain([f32::NAN, f32::INFINITY].map(|margin| add(aside, margin)))
        .collect();
    let dropped = shrunk.map(|margin| add(aside, margin));
    scene.commit(&Culler::default());
    let visible: BTreeSet<u32> =
        answers::slots(&cull(&triangles(), &scene, &looking_down_z())).into_iter().collect();
    let is_visible = |&handle: &Handle| visible.contains(&scene.slot(handle).expect("it is there"));
    assert!(kept.iter().all(is_visible));
    assert!(!dropped.iter().any(is_visible));
    assert_eq!(scene.audit(|_| None).expect("no positions are given"), []);
}

#[test]
fn removed_instances_leave_no_trace() {
    let mut rng = Rng(8);
    for _ in 0..30 {
        let mut scene = random_scene(&mut rng, 40);
        let view = random_view(&mut rng);
        let handles: Vec<Handle> = scene.slots().filter_map(|s| scene.handle(s)).collect();
        let (gone, stay): (Vec<Handle>, Vec<Handle>) =
            handles.into_iter().partition(|_| rng.bits().is_multiple_of(3));
        for &h in &gone {
            scene.remove(h).expect("it is there");
            assert!(scene.remove(h).is_err(), "removed twice");
        }
        let before = cull(&triangles(), &scene, &view);
        let commit = scene.commit(&Culler::default());
        let after = cull(&triangles(), &scene, &view);
        let moved: BTreeSet<_> = answers::listed(&before)
            .into_iter()
            .map(|(slot, triangle)| (commit.slot_of_old[slot as usize], triangle))
            .collect();
        assert_eq!(moved, answers::listed(&after));
        assert!(gone.iter().all(|&h| scene.slot(h).is_err()));
        assert!(stay.iter().all(|&h| {
            let slot = scene.slot(h).expect("it stayed");
            scene.handle(slot) == Some(h)
        }));
    }
}

/// The same scene a long way from zero gives the same answer once the origin follows.
#[test]
fn far_worlds_are_as_good_as_near_ones() {
    let mut rng = Rng(9);
    let offset = [1.0e7, -3.0e6, 2.0e7];
    let (mut differing, mut all) = (0, 0);
    for _ in 0..40 {
        let seed = rng.bits();
        let mut near_rng = Rng(seed);
        let scene = random_scene(&mut near_rng, 20);
        let (view, far_view) = view_and_moved(&mut near_rng, offset);
        let mut far = random_scene(&mut Rng(seed), 20);
        for slot in 0..far.slot_count() {
            let handle = far.handle(slot).expect("the slot is taken");
            let mut t = *far.transform(slot);
            (0..3).for_each(|a| t.translation[a] += offset[a]);
            far.set_transform(handle, t).expect("it is there");
        }
        far.rebase(offset);
        let (a, b) = (cull(&triangles(), &scene, &view), cull(&triangles(), &far, &far_view));
        let (a, b) = (answers::listed(&a), answers::listed(&b));
        differing += a.symmetric_difference(&b).count() as u64;
        all += scene.triangle_count();
        for (slot, triangle) in visible_ref(&far, &far_view) {
            assert!(b.contains(&(slot, triangle)));
        }
    }
    // Points within the rounding of 1e7 in f64 of a plane may differ: nearly flat instances mostly,
    // whose back faces are then in doubt and kept.
    assert!(differing * 200 < all, "{differing} of {all} triangles differ");
}

#[test]
fn several_views_at_once_are_each_alone() {
    let mut rng = Rng(31);
    for _ in 0..6 {
        let mut scene = random_scene(&mut rng, 300);
        scene.commit(&Culler::default());
        let views: Vec<View> = (0..5).map(|_| random_view(&mut rng)).collect();
        let mut states = vec![ViewState::default(); 5];
        let mut results = vec![Visible::default(); 5];
        for _ in 0..2 {
            triangles().cull(&scene, &views, &mut states, &mut results).expect("one each");
            for (view, result) in views.iter().zip(&results) {
                assert_eq!(*result, cull(&triangles(), &scene, view));
            }
        }
    }
}

#[test]
fn changes_lead_from_one_result_to_the_next() {
    let mut rng = Rng(32);
    let mut scene = random_scene(&mut rng, 200);
    scene.commit(&Culler::default());
    let clusters = Culler::default();
    let mut before = Visible::default();
    let (mut added, mut removed) = (Vec::new(), Vec::new());
    let mut held = BTreeSet::new();
    for _ in 0..20 {
        let now = cull(&clusters, &scene, &random_view(&mut rng));
        let drawn: BTreeSet<u32> = answers::slots(&now).into_iter().collect();
        assert!(now.slots().is_sorted() && now.slots().eq(drawn.iter().copied()));
        now.changes_since(&before, &mut added, &mut removed);
        assert!(added.iter().all(|&slot| held.insert(slot)));
        assert!(removed.iter().all(|slot| held.remove(slot)));
        assert_eq!(held, drawn);
        before = now;
    }
}

#[test]
fn bounds_written_in_place_are_bounds_given_by_handle() {
    let mut rng = Rng(33);
    for _ in 0..10 {
        let mut scene = random_scene(&mut rng, 150);
        scene.commit(&Culler::default());
        let view = random_view(&mut rng);
        let given: Vec<_> = scene
            .slots()
            .filter(|slot| slot % 3 != 0)
            .map(|slot| {
                let at = rng.vector(20.0).map(|v| v as f32);
                let unbounded = rng.below(10) == 0;
                let high = if unbounded { f32::INFINITY } else { at[0] + 2.0 };
                (slot, cullet::bounds::Aabb::new(at, [high, at[1] + 1.0, at[2] + 1.0]))
            })
            .collect();
        for round in 0..2 {
            scene.write_bounds(|writer| given.iter().for_each(|(slot, b)| writer.set(*slot, b)));
            scene.hierarchy().validate().expect("refitted");
            let written = cull(&triangles(), &scene, &view);
            for (slot, b) in &given {
                let handle = scene.handle(*slot).expect("it is there");
                scene.set_bounds(handle, BoundsOverride::World(*b)).expect("it is there");
            }
            let by_handle = cull(&triangles(), &scene, &view);
            assert_eq!(written, by_handle, "round {round}");
        }
    }
}

#[test]
fn nodes_hold_what_was_written_before_a_panic() {
    let mut scene = random_scene(&mut Rng(34), 150);
    scene.commit(&Culler::default());
    let far = cullet::bounds::Aabb::new([900.0; 3], [901.0; 3]);
    let version = scene.change_version();
    let written = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
        scene.write_bounds(|writer| {
            (0..100).for_each(|slot| writer.set(slot, &far));
            std::panic::resume_unwind(Box::new("a caller's panic"));
        });
    }));
    assert!(written.is_err());
    assert!(scene.bounds(7) == far && scene.change_version() > version);
    scene.hierarchy().validate().expect("refitted");
}

#[test]
fn meshes_that_an_edit_leaves_as_they_are_keep_what_was_prepared() {
    let mut scene = random_scene(&mut Rng(36), 20);
    scene.commit(&Culler::default());
    let occluder = scene.prepared()[0].occluder().expect("made by the commit").clone();
    scene.set_occluder(0, occluder);
    let versions = |scene: &cullet::Scene| (scene.change_version(), scene.version());
    let before = versions(&scene);
    let lost = scene.edit_meshes(|_, mesh| {
        let same = mesh.clone();
        *mesh = same;
    });
    assert_eq!((lost.len(), versions(&scene)), (0, before));
    assert!(scene.prepared()[0].given_occluder().is_some());
    let lost = scene.edit_meshes(|id, mesh| mesh.set_two_sided(id == 0));
    assert_eq!(
        (lost.as_slice(), scene.prepared()[0].given_occluder().is_some()),
        (&[0][..], false)
    );
    assert!(scene.prepared()[0].occluder().is_some(), "of the mesh itself");
    assert!(!scene.edit_mesh(0, |mesh| mesh.set_two_sided(false)), "it lost none");
}

#[test]
fn many_instances_are_explained_as_each_alone() {
    let mut rng = Rng(37);
    for _ in 0..cases(8) {
        let mut scene = random_scene(&mut rng, 60);
        scene.commit(&Culler::default());
        let (view, culler) = (random_view(&mut rng), random_culler(&mut rng));
        let handles: Vec<Handle> = scene.slots().filter_map(|slot| scene.handle(slot)).collect();
        let together = culler.explain_many(&scene, &view, &handles).expect("they are there");
        assert_eq!(together.len(), handles.len());
        for (&handle, explained) in handles.iter().zip(&together) {
            assert_eq!(*explained, culler.explain(&scene, &view, handle).expect("it is there"));
        }
        scene.remove(handles[0]).expect("it is there");
        assert!(culler.explain_many(&scene, &view, &handles).is_err());
        assert_eq!(culler.explain_many(&scene, &view, &[]), Ok(Vec::new()));
    }
}

/// A view that wanders, and sometimes stands, keeps in each frame what is found afresh.
#[test]
fn a_wandering_view_sees_what_a_cold_one_sees() {
    let mut rng = Rng(12);
    let (mut came, mut went) = (0, 0);
    for count in [0, 5, 16, 17, 300, 5000, 30_000] {
        let mut scene = cullet::Scene::new();
        for _ in 0..count {
            scene.add(Instance::of_bounds(random_box(&mut rng))).expect("room");
        }
        scene.commit(&Culler::default());
        let culler = Culler::default().with_output(Output::Instances).with_occlusion(None);
        let (mut state, mut warm) = (ViewState::default(), Visible::default());
        let (mut eye, mut turn, mut before) = (rng.vector(20.0), 0.0_f64, BTreeSet::new());
        for frame in 0..150 {
            if frame % 5 != 4 {
                turn += rng.range(-0.05, 0.2);
                let step = rng.vector(0.5);
                (0..3).for_each(|a| eye[a] += step[a]);
            }
            let target = [eye[0] + turn.cos(), eye[1], eye[2] + turn.sin()];
            let view = View::perspective(eye, target, 1.0, 0.1, 100.0, [640, 480]).expect("a view");
            culler.cull_one(&scene, &view, &mut state, &mut warm);
            assert_eq!(warm, cull(&culler, &scene, &view), "frame {frame} of {count} boxes");
            let now: BTreeSet<u32> = warm.slots().collect();
            (came, went) =
                (came + now.difference(&before).count(), went + before.difference(&now).count());
            before = now;
        }
    }
    assert!(came > 10_000 && went > 10_000, "{came} came, {went} went");
}
