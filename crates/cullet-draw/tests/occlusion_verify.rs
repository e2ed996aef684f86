//! Verifying a set from which what is hidden was dropped, and the sampled judge on the large city.

use std::time::Instant;

use cullet::bounds::Aabb;
use cullet::{Reason, Scene, Stage, View, Visible, draw::TriangleRange};
use cullet_draw::{
    Prover, SampleOptions, Sampled, VerifyOptions, sampled_boxes, sampled_instances, verify_visible,
};
use cullet_testkit::scenes::city;
use cullet_testkit::views::look;

/// All triangles of the slots for which `keep` holds, as an occlusion culler would return them.
fn kept(scene: &Scene, keep: impl Fn(u32) -> bool) -> Visible {
    let mut visible = Visible::default();
    for slot in 0..scene.slot_count() {
        let keep = keep(slot);
        let reason = Reason { stage: Stage::Occlusion, detail: 0 };
        visible.reasons.push((!keep).then_some(reason));
        if keep {
            let count = scene.mesh(slot).triangle_count();
            let first = visible.triangles.len() as u32;
            visible.triangles.extend(0..count);
            visible.triangle_ranges.push(TriangleRange { slot, level: 0, first, count });
        }
    }
    visible
}

#[test]
fn verify_agrees_with_occlusion_that_is_right_and_finds_what_is_wrong() {
    let scene = city(6, 1, 400);
    let view = look([5.0, 3.0, 90.0], [0.0, 2.0, 0.0], [160, 90]);
    let prover = Prover::of_scene(&view, &scene);
    let options = Default::default();
    let hidden: Vec<u32> = scene
        .slots()
        .filter(|&s| {
            let proof = prover.prove(&scene.bounds(s), &cullet::Transform::IDENTITY, &options);
            proof == cullet_draw::Proof::Proved
        })
        .collect();
    assert!(hidden.len() > 100, "{}", hidden.len());
    for samples in [1, 4, 8] {
        let options = VerifyOptions { samples, seed: 17, ..VerifyOptions::default() };
        let right = verify_visible(&scene, &view, kept(&scene, |s| !hidden.contains(&s)), &options);
        assert!(right.false_culls.is_empty(), "{:?}", right.false_culls);
        assert_eq!(right.frame.ids, right.culled_frame.ids);
        assert!(
            right.visible <= right.potentially_visible && right.potentially_visible < right.all
        );
    }
    // One that only finer samples see.
    let at = |samples| {
        let options = VerifyOptions { samples, seed: 17, ..VerifyOptions::default() };
        sampled_instances(&scene, &view, &options)
    };
    let coarse = verify_visible(&scene, &view, kept(&scene, |_| true), &VerifyOptions::default());
    let owns = |slot: u32| coarse.seen.iter().any(|id| id.slot == slot);
    let fine = at(8);
    let between =
        fine.iter().find(|(slot, _)| !owns(*slot)).expect("one that only 8x8 samples see");
    let without = || kept(&scene, |s| s != between.0);
    let found = |samples| {
        let options = VerifyOptions { samples, seed: 17, ..VerifyOptions::default() };
        verify_visible(&scene, &view, without(), &options).false_culls
    };
    assert!(found(1).is_empty());
    let lost = found(8);
    assert_eq!((lost.len(), lost[0].slot, lost[0].triangle), (1, between.0, None));
    assert_eq!(lost[0].reason.map(|r| r.stage), Some(Stage::Occlusion));
    assert_eq!(lost[0].pixel, between.1.map(|v| v / 8));
}

/// The city of the occlusion benchmarks, as its text has it: 10,000 buildings, 100,000 boxes.
#[test]
fn the_large_city_is_sampled_in_seconds() {
    let model = cullet_scenes::build("city:ground=0").unwrap();
    let scene = &model.scene;
    let buildings: Vec<u32> = scene.slots().filter(|&s| is_building(&model, s)).collect();
    let mut occluders = Scene::new();
    let mesh = occluders.add_mesh(scene.mesh(buildings[0]).clone());
    for &slot in &buildings {
        occluders.add(cullet::Instance::new(mesh, *scene.transform(slot))).unwrap();
    }
    occluders.commit(&cullet::Culler::default());
    let objects = scene.slots().filter(|&s| !is_building(&model, s));
    let boxes: Vec<Aabb> = objects.map(|s| scene.bounds(s)).collect();
    assert_eq!((occluders.triangle_count(), boxes.len()), (120_000, 100_000));
    let view: View = look([0.0, 1.7, 0.0], [100.0, 1.7, 20.0], [1280, 720]);
    let mut seen = Vec::new();
    for samples in [1, 4] {
        let start = Instant::now();
        let options = SampleOptions { samples, tolerance: 1e-6, ..SampleOptions::default() };
        let answers = sampled_boxes(&occluders, &view, &boxes, &options);
        let count = |what| answers.iter().filter(|a| **a == what).count();
        println!(
            "{samples}x: {} visible, {} hidden, {} outside, {:.2} s",
            count(Sampled::Visible),
            count(Sampled::Hidden),
            count(Sampled::Outside),
            start.elapsed().as_secs_f64()
        );
        assert!(count(Sampled::Hidden) > 20 * count(Sampled::Visible));
        assert!(count(Sampled::Outside) > boxes.len() / 2);
        seen.push(count(Sampled::Visible));
    }
    assert!(seen[0] > 0 && seen[1] >= seen[0], "{seen:?}");
}

fn is_building(model: &cullet_io::Model, slot: u32) -> bool {
    model.mesh_names[model.scene.mesh_id(slot) as usize].ends_with("building")
}
