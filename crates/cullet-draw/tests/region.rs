//! Visible sets of boxes of eyes, against what the reference renderer draws from eyes in them.

use std::time::Instant;

use cullet::{Camera, Depth, Projection, Scene, View};
use cullet_cells::query::{EyeBox, Motion, MotionQuery, RegionCuller, RegionState, RegionVisible};
use cullet_draw::{RenderOptions, Selection, render};
use cullet_testkit::{Rng, cases, scenes};

/// The six directions, each with one that is up.
const DIRECTIONS: [[[f64; 3]; 2]; 6] = [
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
    [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
    [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    [[0.0, -1.0, 0.0], [0.0, 0.0, 1.0]],
    [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]],
    [[0.0, 0.0, -1.0], [0.0, 1.0, 0.0]],
];

/// Near rectangles reach √3 times this far.
const NEAR: f64 = 0.1;

/// Sets the flags of the slots that own a pixel as seen from an eye, in all directions.
fn look(scene: &Scene, eye: [f64; 3], pixels: u32, seen: &mut [bool]) {
    for [direction, up] in DIRECTIONS {
        let projection = Projection::Perspective {
            fov_y_radians: std::f64::consts::FRAC_PI_2,
            aspect: 1.0,
            near: NEAR,
            far: 1e5,
        };
        let camera = Camera { eye, direction, up, projection };
        let view = View::new(&camera, Depth::Reversed, [pixels; 2]).expect("a side of a cube");
        let frame = render(scene, &view, Selection::All, &RenderOptions::default());
        frame.visible().iter().for_each(|id| seen[id.slot as usize] = true);
    }
}

/// An eye in a box: at a corner of it, or anywhere.
fn eye_in(eyes: &EyeBox, rng: &mut Rng) -> [f64; 3] {
    let corner = rng.chance(0.3);
    std::array::from_fn(|a| match corner {
        true if rng.chance(0.5) => eyes.min[a],
        true => eyes.max[a],
        false => rng.range(eyes.min[a], eyes.max[a]),
    })
}

/// Slots that are seen from some eyes in a box.
fn seen_from(scene: &Scene, eyes: &EyeBox, count: u32, pixels: u32, rng: &mut Rng) -> Vec<bool> {
    let mut seen = vec![false; scene.slot_count() as usize];
    for _ in 0..count {
        look(scene, eye_in(eyes, rng), pixels, &mut seen);
    }
    seen
}

fn query(culler: &RegionCuller, scene: &Scene, eyes: &EyeBox) -> RegionVisible {
    let (mut state, mut visible) = (RegionState::default(), RegionVisible::default());
    culler.cull(scene, eyes, &mut state, &mut visible).expect("settings in range");
    visible
}

fn assert_none_lost(visible: &RegionVisible, seen: &[bool], what: &dyn std::fmt::Debug) {
    let lost: Vec<usize> = (0..seen.len()).filter(|&s| seen[s] && !visible.has(s as u32)).collect();
    assert!(lost.is_empty(), "{what:?}: slots {lost:?} are seen");
}

#[test]
fn nothing_seen_from_an_eye_in_the_box_is_dropped() {
    let mut scene = scenes::city(8, 2, 600);
    scene.commit(&cullet::Culler::default());
    let mut rng = Rng(5);
    let mut dropped = 0;
    for case in 0..cases(12) {
        let middle = [rng.range(-90.0, 90.0), rng.range(0.5, 9.0), rng.range(-90.0, 90.0)];
        let size = [rng.range(0.0, 9.0), rng.range(0.0, 2.0), rng.range(0.0, 9.0)];
        let size = if case % 4 == 0 { [0.0; 3] } else { size };
        let eyes = EyeBox {
            min: std::array::from_fn(|a| middle[a] - size[a] * 0.5),
            max: std::array::from_fn(|a| middle[a] + size[a] * 0.5),
        };
        let culler = RegionCuller {
            cell_world: rng.range(0.5, 4.0),
            most_cells: 1 + rng.below(20) as u32,
            width: 32 << rng.below(4),
            ..RegionCuller::default()
        };
        let visible = query(&culler, &scene, &eyes);
        dropped += scene.instance_count() as usize - visible.slots().count();
        let seen = seen_from(&scene, &eyes, 6, 192, &mut rng);
        assert_none_lost(&visible, &seen, &(culler, eyes));
    }
    assert!(dropped > cases(12) as usize * 160, "{dropped}");
}

/// A street of the built-in city, 12 by 8 metres of it at the height of eyes.
fn street() -> EyeBox {
    EyeBox::new([-6.0, 1.5, -4.0], [6.0, 1.9, 4.0])
}

#[test]
fn most_of_the_built_in_city_is_dropped_from_a_street() {
    let model = cullet_scenes::build("city").expect("built in");
    let (scene, mut rng) = (&model.scene, Rng(9));
    let all = f64::from(scene.instance_count());
    for (cell_world, floor) in [(1.0, 0.97), (2.0, 0.968), (4.0, 0.965)] {
        let culler = RegionCuller { cell_world, ..RegionCuller::default() };
        let (mut state, mut visible) = (RegionState::default(), RegionVisible::default());
        let mut best = f64::INFINITY;
        for _ in 0..3 {
            let begin = Instant::now();
            culler.cull(scene, &street(), &mut state, &mut visible).expect("settings in range");
            best = best.min(begin.elapsed().as_secs_f64());
        }
        let kept = visible.slots().count();
        let dropped = 1.0 - kept as f64 / all;
        println!(
            "cells of {cell_world} m: {kept} of {all} kept in {:.1} ms, {:?}",
            best * 1e3,
            visible.work
        );
        assert!(dropped > floor, "{cell_world}: {dropped}");
    }
    let visible = query(&RegionCuller::default(), scene, &street());
    let seen = seen_from(scene, &street(), 24, 512, &mut rng);
    assert_none_lost(&visible, &seen, &"street");
    let seen = seen.iter().filter(|s| **s).count();
    println!(
        "{seen} seen from 24 eyes: {:.2} times as many kept",
        visible.slots().count() as f64 / seen as f64
    );
}

#[test]
fn nothing_is_seen_along_a_way_before_its_distance() {
    let mut scene = scenes::city(8, 2, 400);
    scene.commit(&cullet::Culler::default());
    let mut rng = Rng(3);
    let points = [[0.0, 1.7, 90.0], [0.0, 1.7, 20.0], [40.0, 1.7, 0.0]];
    let motion = Motion { radius_world: 0.5, reach_world: 100.0, ..Motion::along(&points) };
    let (mut state, mut needed) = (RegionState::default(), Vec::new());
    let query = MotionQuery { step_world: 6.0, ..MotionQuery::default() };
    query.needed(&scene, &motion, &mut state, &mut needed).expect("settings in range");
    assert!(needed.is_sorted_by(|a, b| a.distance <= b.distance));
    let mut first = vec![f64::INFINITY; scene.slot_count() as usize];
    for n in &needed {
        first[scene.slot(n.handle).expect("of this scene") as usize] = n.distance;
    }
    assert!(needed.len() < scene.instance_count() as usize * 9 / 10, "{}", needed.len());
    assert!(needed.iter().filter(|n| n.distance > 0.0).count() > 20);
    for _ in 0..cases(16) {
        let distance = rng.range(0.0, 100.0);
        let place = |a: usize| match distance {
            d if d < 70.0 => points[0][a] + (points[1][a] - points[0][a]) * d / 70.0,
            d => {
                let whole = 40.0_f64.hypot(20.0);
                points[1][a] + (points[2][a] - points[1][a]) * (d - 70.0) / whole
            }
        };
        let eye = std::array::from_fn(|a| place(a) + rng.range(-0.5, 0.5));
        let mut seen = vec![false; first.len()];
        look(&scene, eye, 192, &mut seen);
        for slot in (0..first.len()).filter(|&s| seen[s]) {
            assert!(first[slot] <= distance, "{slot} at {distance}: {}", first[slot]);
        }
    }
}
