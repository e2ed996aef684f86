//! Candidates of the caller: what is left of an answer by them, and masks of other scenes.

use cullet::{
    CullError, Culler, Handle, Reason, Scene, Stage, View, ViewState, Visible, funnel::Unit,
};
use cullet_testkit::answers::{cull, listed, slots};
use cullet_testkit::scenes::random_scene;
use cullet_testkit::views::{random_culler, random_view};
use cullet_testkit::{Rng, cases};

/// Culls among the slots of a mask, by a culler that remembers nothing.
fn cull_among(
    culler: &Culler,
    scene: &Scene,
    view: &View,
    mask: &[u64],
) -> Result<Visible, CullError> {
    let (mut state, mut result) = (ViewState::default(), Visible::default());
    culler.cull_among(scene, view, &mask, &mut state, &mut result)?;
    Ok(result)
}

fn has(words: &[u64], slot: u32) -> bool {
    words[slot as usize / 64] >> (slot % 64) & 1 == 1
}

#[test]
fn what_is_left_are_the_candidates_of_the_answer() {
    let mut rng = Rng(41);
    let (mut kept, mut taken) = (0, 0);
    for _ in 0..cases(200) {
        let mut scene = random_scene(&mut rng, 150);
        scene.commit(&Culler::default());
        let view = random_view(&mut rng);
        let random = random_culler(&mut rng);
        // What dropped instances hide, or would have stood for, is no part of the answer without them.
        let culler = random.with_occlusion(None).with_lod(None).with_reasons(true);
        let mask: Vec<u64> = scene.exempt().iter().map(|_| rng.bits()).collect();
        let (all, among) = (
            cull(&culler, &scene, &view),
            cull_among(&culler, &scene, &view, &mask).expect("as long as the scene"),
        );
        let is_left = |slot: u32| has(&mask, slot) || has(scene.exempt(), slot);
        let expected: Vec<u32> = slots(&all).into_iter().filter(|&s| is_left(s)).collect();
        assert_eq!(slots(&among), expected);
        let expected = listed(&all).into_iter().filter(|(slot, _)| is_left(*slot)).collect();
        assert_eq!(listed(&among), expected);
        for slot in scene.slots() {
            let reason = among.reasons[slot as usize];
            let of_mask = Some(Reason { stage: Stage::Pvs, detail: 0 });
            let before = all.reasons[slot as usize]
                .filter(|r| matches!(r.stage, Stage::Layer | Stage::Frustum));
            match is_left(slot) {
                true => assert_eq!(reason, all.reasons[slot as usize]),
                // The frustum tests clusters after the candidates, and corners before, with the same detail.
                false if before.is_some_and(|r| r.detail == Reason::MIXED) => {
                    assert!(reason == of_mask || reason == before, "{reason:?}");
                }
                false => assert_eq!(reason, before.or(of_mask)),
            }
            let handle = scene.handle(slot).expect("a slot that is filled");
            let told = culler
                .explain_among(&scene, &view, &mask, &[handle])
                .expect("an instance")
                .remove(0);
            assert_eq!(told.reason, reason);
            if reason == of_mask {
                let last = told.steps.last().expect("the stage of the mask");
                assert_eq!(last.to_string(), "none of the candidates");
            }
            kept += u64::from(reason.is_none());
            taken += u64::from(reason == of_mask);
        }
        let rows = &among.funnel.rows;
        let row = rows.iter().find(|r| r.stage == Stage::Pvs).expect("a row of the candidates");
        assert_eq!(row.unit, Unit::Instances);
        assert_eq!(row.entered.instances - row.left.instances, {
            let of_mask = |r: &&Option<Reason>| r.is_some_and(|r| r.stage == Stage::Pvs);
            among.reasons.iter().filter(of_mask).count() as u64
        });
    }
    assert!(kept > 1000 && taken > 1000, "{kept} kept, {taken} taken");
}

#[test]
fn all_as_candidates_change_nothing() {
    let mut rng = Rng(42);
    for _ in 0..cases(50) {
        let mut scene = random_scene(&mut rng, 150);
        scene.commit(&Culler::default());
        let (culler, view) = (random_culler(&mut rng), random_view(&mut rng));
        let mask = vec![u64::MAX; scene.exempt().len()];
        let all = cull(&culler, &scene, &view);
        let among = cull_among(&culler, &scene, &view, &mask).expect("as long as the scene");
        assert_eq!((slots(&among), listed(&among)), (slots(&all), listed(&all)));
        assert_eq!(among.reasons, all.reasons);
    }
}

#[test]
fn masks_of_another_length_are_refused_and_change_nothing() {
    let mut scene = random_scene(&mut Rng(43), 150);
    scene.commit(&Culler::default());
    let (view, culler) = (random_view(&mut Rng(43)), Culler::default());
    let (mut state, mut result) = (ViewState::default(), Visible::default());
    culler.cull_one(&scene, &view, &mut state, &mut result);
    let before = slots(&result);
    let (slots_of_scene, expected) = (scene.slot_count(), scene.exempt().len());
    for words in [0, 1, expected - 1, expected + 1] {
        let mask = vec![0; words];
        let refused = culler.cull_among(&scene, &view, &mask, &mut state, &mut result);
        let error = CullError::Candidates { words, expected, slots: slots_of_scene };
        assert_eq!(refused, Err(error));
        let text = error.to_string();
        assert!(text.contains(&words.to_string()) && text.contains(&expected.to_string()));
        let handle = scene.handle(0).unwrap_or(Handle { index: 0, generation: 0 });
        assert_eq!(culler.explain_among(&scene, &view, &mask, &[handle]), Err(error));
        assert_eq!(slots(&result), before);
    }
}
