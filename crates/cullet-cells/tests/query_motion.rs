//! Motions: steps, lower bounds of distances, and degenerate ways.

use cullet::{Instance, Scene, Transform};
use cullet_cells::query::{
    EyeBox, Motion, MotionQuery, Needed, RegionCuller, RegionState, RegionVisible,
};
use cullet_testkit::Rng;
use cullet_testkit::meshes::block;

/// A street along −z: a row of houses at x = 10, with a shed behind each but the first two.
fn street() -> Scene {
    let mut scene = Scene::new();
    let cube = scene.add_mesh(block([-1.0; 3], [1.0; 3]));
    for i in 0..12_u32 {
        let z = f64::from(i) * -14.0;
        let house = Transform::from_scale_translation([4.0, 6.0, 6.0], [10.0, 6.0, z]);
        scene
            .add(Instance { user_data: 100 + u64::from(i), ..Instance::new(cube, house) })
            .expect("few");
        if i >= 2 {
            let shed = Transform::from_translation([17.0, 1.0, z]);
            scene
                .add(Instance { user_data: u64::from(i), ..Instance::new(cube, shed) })
                .expect("few");
        }
    }
    scene.commit(&cullet::Culler::default());
    scene
}

fn needed(query: &MotionQuery, scene: &Scene, motion: &Motion<'_>) -> Vec<Needed> {
    let (mut state, mut needed) = (RegionState::default(), Vec::new());
    query.needed(scene, motion, &mut state, &mut needed).expect("settings in range");
    needed
}

#[test]
fn each_step_adds_what_its_box_may_see_and_none_before_it_did() {
    let scene = street();
    let way = [[0.0, 1.7, 40.0], [0.0, 1.7, -240.0]];
    let motion = Motion { radius_world: 0.25, ..Motion::along(&way) };
    let query = MotionQuery { step_world: 5.0, ..MotionQuery::default() };
    let list = needed(&query, &scene, &motion);
    let key = |n: &Needed| (n.distance, scene.slot(n.handle).unwrap());
    assert!(list.is_sorted_by(|a, b| key(a) <= key(b)));
    // By hand: the region query of each step.
    let mut first = vec![None; scene.slot_count() as usize];
    for step in 0..56 {
        let (from, to) = (40.0 - f64::from(step) * 5.0, 35.0 - f64::from(step) * 5.0);
        let eyes = EyeBox::around(&[[0.0, 1.7, from], [0.0, 1.7, to]], 0.25);
        let (mut state, mut visible) = (RegionState::default(), RegionVisible::default());
        query.region.cull(&scene, &eyes, &mut state, &mut visible).unwrap();
        for slot in visible.slots() {
            first[slot as usize].get_or_insert(f64::from(step) * 5.0);
        }
    }
    assert_eq!(list.len(), first.iter().flatten().count());
    for n in &list {
        let expected = first[scene.slot(n.handle).unwrap() as usize].unwrap();
        assert!((n.distance - expected).abs() < 1e-6 && n.distance <= expected, "{n:?} {expected}");
    }
    assert!(list.iter().filter(|n| n.distance > 0.0).count() > 2, "{list:?}");
    assert!(list[0].distance == 0.0);
}

#[test]
fn a_way_of_many_short_stretches_is_that_of_one() {
    let scene = street();
    let ends = [[0.0, 1.7, 40.0], [0.0, 1.7, -56.0]];
    let many: Vec<[f64; 3]> = (0..=96).map(|i| [0.0, 1.7, 40.0 - f64::from(i)]).collect();
    let query = MotionQuery { step_world: 8.0, ..MotionQuery::default() };
    let one = needed(&query, &scene, &Motion::along(&ends));
    let cut = needed(&query, &scene, &Motion::along(&many));
    assert_eq!(one, cut);
    // Points that are the same are no way.
    let twice = [ends[0], ends[0], ends[1], ends[1]];
    assert_eq!(needed(&query, &scene, &Motion::along(&twice)), one);
}

#[test]
fn reach_and_number_of_steps_are_kept() {
    let scene = street();
    let way = Motion::straight([0.0, 1.7, 40.0], [0.0, 0.0, -28.0], 10.0);
    assert_eq!(way[1], [0.0, 1.7, -240.0]);
    let query = MotionQuery::default();
    let all = needed(&query, &scene, &Motion::along(&way));
    let half = needed(&query, &scene, &Motion { reach_world: 40.0, ..Motion::along(&way) });
    assert!(half.len() < all.len() && half.iter().all(|n| n.distance < 40.0));
    assert_eq!(half[..], all[..half.len()]);
    let start = needed(&query, &scene, &Motion { reach_world: 0.0, ..Motion::along(&way) });
    assert!(start.iter().all(|n| n.distance == 0.0));
    // Two steps: two distances.
    let few = MotionQuery { most_steps: 2, ..query };
    let few = needed(&few, &scene, &Motion::along(&way));
    assert!(few.iter().all(|n| n.distance == 0.0 || (n.distance - 140.0).abs() < 1e-3), "{few:?}");
}

#[test]
fn degenerate_ways_have_stated_answers() {
    let scene = street();
    let query = MotionQuery::default();
    assert!(needed(&query, &scene, &Motion::along(&[])).is_empty());
    let stays = needed(&query, &scene, &Motion::along(&[[0.0, 1.7, 40.0]]));
    assert!(!stays.is_empty() && stays.len() < scene.instance_count() as usize);
    let everything = scene.instance_count() as usize;
    for bad in [f64::NAN, f64::INFINITY] {
        let lost = [[0.0, 1.7, 40.0], [0.0, 1.7, 20.0], [bad, 1.7, 0.0], [0.0; 3]];
        let list = needed(&query, &scene, &Motion::along(&lost));
        assert_eq!(list.len(), everything, "{bad}");
        // Until then it was known where the eye is.
        assert!(list.last().unwrap().distance > 15.9);
        let way = [[0.0, 1.7, 40.0], [0.0, 1.7, 20.0]];
        let strays = Motion { radius_world: bad, ..Motion::along(&way) };
        assert_eq!(needed(&query, &scene, &strays).len(), everything, "{bad}");
    }
    assert!(needed(&query, &Scene::new(), &Motion::along(&[[0.0; 3]])).is_empty());
}

#[test]
fn settings_out_of_range_are_named() {
    let scene = street();
    let way = [[0.0; 3], [1.0; 3]];
    let error = |query: MotionQuery, motion: Motion<'_>| {
        let (mut state, mut needed) = (RegionState::default(), Vec::new());
        query.needed(&scene, &motion, &mut state, &mut needed).unwrap_err().to_string()
    };
    let query = MotionQuery::default;
    let along = Motion::along(&way);
    assert!(
        error(MotionQuery { step_world: 0.0, ..query() }, along).starts_with("step_world is 0;")
    );
    assert!(error(MotionQuery { most_steps: 0, ..query() }, along).starts_with("most_steps is 0;"));
    let region = RegionCuller { width: 2, ..RegionCuller::default() };
    assert!(error(MotionQuery { region, ..query() }, along).starts_with("width is 2;"));
    let back = Motion { radius_world: -1.0, ..along };
    assert!(error(query(), back).starts_with("radius_world is -1;"));
    let short = Motion { reach_world: -3.0, ..along };
    assert!(error(query(), short).starts_with("reach_world is -3;"));
}

#[test]
fn memory_that_was_used_changes_no_answer() {
    let scene = street();
    let mut rng = Rng(6);
    let (mut state, mut list) = (RegionState::default(), Vec::new());
    let query = MotionQuery { step_world: 10.0, ..MotionQuery::default() };
    for _ in 0..4 {
        let way = [rng.vector(20.0), rng.vector(40.0)];
        query.needed(&scene, &Motion::along(&way), &mut state, &mut list).unwrap();
        assert_eq!(list, needed(&query, &scene, &Motion::along(&way)));
    }
}
