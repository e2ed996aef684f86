//! The stage of the culler: nothing that is seen through portals is dropped, and what is dropped is explained.

use cullet::{
    Culler, Handle, Instance, Mesh, Output, Scene, Stage, Transform, View, ViewState, funnel::Unit,
};
use cullet_cells::cell::{CellGraph, CellPiece, CellShapes, Mirror, Portal};
use cullet_cells::portal::ray_cells_ref;
use cullet_cells::{CellView, Cells, InCells};
use cullet_testkit::answers::{cull, listed};
use cullet_testkit::buildings::Building;
use cullet_testkit::oracles::alone::{check_rows, fates, fates_alone, telling};
use cullet_testkit::{Rng, at_every_level, cases, meshes};

use super::walk::{into, look};

/// Balls about a building: small ones and some large ones, with many clusters.
fn furnish(rng: &mut Rng, building: &Building) -> (Scene, Cells) {
    let mut scene = Scene::new();
    if rng.chance(0.5) {
        scene.rebase(rng.vector(30.0));
    }
    let ball: Mesh = meshes::ball(16);
    let ball = scene.add_mesh(ball);
    for i in 0..120 {
        let (at, _) = building.point(rng, 0.0);
        let size = if i % 6 == 0 { rng.range(0.5, 4.0) } else { rng.range(0.02, 0.3) } as f32;
        scene.add(Instance::new(ball, Transform::from_scale_translation([size; 3], at))).unwrap();
    }
    scene.commit(&Culler::default());
    let mut shapes = building.shapes.clone();
    if rng.chance(0.5) {
        shapes = shapes.sealed();
    }
    let cells = Cells::new(&mut scene, building.graph.clone(), shapes);
    (scene, cells)
}

/// Clusters and instances on a ray that ends within a triangle of them.
fn is_on(scene: &Scene, slot: u32, p: [f64; 3], slack: f64) -> bool {
    let b = scene.bounds(slot);
    (0..3).all(|a| {
        let v = p[a] - scene.origin()[a];
        v >= f64::from(b.min[a]) - slack && v <= f64::from(b.max[a]) + slack
    })
}

#[test]
fn nothing_on_a_ray_through_open_portals_is_dropped() {
    let mut rng = Rng(4);
    let (mut checked, mut dropped, mut cut, mut idle) = (0_u64, 0_u64, 0_u64, 0);
    for _ in 0..cases(60) {
        let building = Building::new(&mut rng, [5, 2, 5]);
        let (scene, cells) = furnish(&mut rng, &building);
        let (eye, cell) = building.point(&mut rng, 0.02);
        let view = look(&mut rng, eye);
        let culler = Culler::default().with_reasons(true).with_output(Output::Triangles);
        let culler = culler.only(Stage::Portal);
        let mut answers = Vec::new();
        at_every_level!(|level| {
            answers.push(cull(&culler.clone().with_simd(level), (&scene, &cells), &view));
        });
        assert!(answers.windows(2).all(|pair| pair[0] == pair[1]), "levels differ");
        let result = &answers[0];
        let of = |unit: Unit| {
            let rows = result.funnel.rows.iter();
            rows.filter(|r| r.stage == Stage::Portal && r.unit == unit)
                .map(cullet::funnel::FunnelRow::dropped)
                .sum()
        };
        let [instances, clusters]: [cullet::funnel::Counts; 2] =
            [of(Unit::Instances), of(Unit::Clusters)];
        dropped += instances.instances;
        cut += clusters.clusters;
        idle += u32::from(instances.instances == 0);
        let drawn = listed(result);
        for _ in 0..400 {
            let along = into(&mut rng, &view);
            let graph = (&building.graph, &building.shapes);
            ray_cells_ref(graph, cell, eye, along, (0, 1e-6), |_, from, to| {
                for slot in scene.slots() {
                    // Any point of it on the ray is seen: nothing else is in the way.
                    let share = rng.unit();
                    let p = std::array::from_fn(|a| from[a] + (to[a] - from[a]) * share);
                    if !is_on(&scene, slot, p, 0.0) {
                        continue;
                    }
                    assert!(result.reasons[slot as usize].is_none(), "slot {slot} at {p:?}");
                    // Nor the clusters whose boxes hold the point.
                    let (mesh, t) = (scene.mesh(slot), scene.transform(slot));
                    for (number, b) in (0..).zip(mesh.clusters()) {
                        let own: [f32; 3] = std::array::from_fn(|a| {
                            ((p[a] - t.translation[a]) / f64::from(t.linear[a][a])) as f32
                        });
                        let bounds = mesh.cluster_boxes().get(number as usize);
                        if bounds.contains(own) {
                            let mut own = b.triangles();
                            assert!(own.any(|t| drawn.contains(&(slot, t))), "cluster {number}");
                            checked += 1;
                        }
                    }
                }
            });
        }
    }
    assert!(checked > u64::from(cases(60)) * 50, "{checked}");
    // It culls, too: most of a building is behind walls.
    let all = u64::from(cases(60)) * 120;
    assert!(dropped * 2 > all && cut > u64::from(cases(60)), "{dropped} of {all}, {cut} clusters");
    assert!(idle < cases(60) / 4, "{idle} times nothing was dropped");
}

#[test]
fn rows_reasons_and_explanations_agree() {
    let mut rng = Rng(5);
    for _ in 0..cases(12) {
        let building = Building::new(&mut rng, [4, 2, 4]);
        let (scene, cells) = furnish(&mut rng, &building);
        let (eye, _) = building.point(&mut rng, 0.02);
        let view = look(&mut rng, eye);
        let culler = telling(&Culler::default().with_occlusion(None));
        let result = cull(&culler, (&scene, &cells), &view);
        let together = fates(&scene, &result);
        check_rows(&scene, &result, &together);
        assert_eq!(together, fates_alone(&culler, (&scene, &cells), &view));
        for slot in scene.slots() {
            let handle = scene.handle(slot).unwrap();
            let told = InCells::from((&scene, &cells)).explain(&culler, &view, handle).unwrap();
            assert_eq!(told.reason, result.reasons[slot as usize], "slot {slot}");
            let of_portal = told.steps.iter().find(|s| s.stage == Stage::Portal);
            if told.reason.is_some_and(|r| r.stage == Stage::Portal)
                && cells.cells_of(slot).len() == 1
            {
                let cell = cells.cells_of(slot)[0];
                assert_eq!(told.reason.unwrap().detail, cell as u8);
                let words = of_portal.unwrap().to_string();
                assert!(words.starts_with(&format!("in cell {cell}, ")), "{words}");
            }
        }
        // A view that was culled before finds the same again.
        let (mut state, mut again) = (ViewState::default(), cullet::Visible::default());
        let mut among = CellView::default();
        for _ in 0..2 {
            let among = among.on(&cells);
            culler.cull_among(&scene, &view, &among, &mut state, &mut again).unwrap();
            assert_eq!(again, result);
        }
    }
}

/// Two rooms, a door, and a ball in each.
pub(super) fn two_rooms(mirrors: Vec<Mirror>) -> (Scene, Cells, [Handle; 2], View) {
    let polygon = vec![[4.0, 0.0, 1.0], [4.0, 0.0, 3.0], [4.0, 2.0, 3.0], [4.0, 2.0, 1.0]];
    let graph = CellGraph::new(2, vec![Portal { cells: [0, 1], polygon }]);
    let graph = graph.and_then(|graph| graph.with_mirrors(mirrors)).unwrap();
    let room = |i: u32| {
        let x = f64::from(i) * 4.0;
        CellPiece::from_box(i, [x, 0.0, 0.0], [x + 4.0, 3.0, 4.0])
    };
    let shapes = CellShapes::new(&graph, vec![room(0), room(1)]).unwrap();
    let mut scene = Scene::new();
    let ball = scene.add_mesh(meshes::ball(4));
    let mut add = |at| {
        let at = Transform::from_scale_translation([0.2; 3], at);
        scene.add(Instance::new(ball, at)).unwrap()
    };
    let balls = [add([2.0, 1.0, 2.0]), add([6.0, 1.0, 2.0])];
    scene.commit(&Culler::default());
    let cells = Cells::new(&mut scene, graph, shapes);
    let view = View::perspective([1.0, 1.0, 2.0], [2.0, 1.0, 2.0], 1.2, 0.05, 99.0, [64, 64]);
    (scene, cells, balls, view.unwrap())
}

fn portal_alone() -> Culler {
    Culler::default().with_output(Output::Instances).only(Stage::Portal)
}

#[test]
fn what_sticks_out_of_its_cell_is_kept_and_what_is_in_it_is_not() {
    let (mut scene, mut cells, [_, far], view) = two_rooms(Vec::new());
    cells.set_portal_open(0, false);
    let count =
        |scene: &Scene, cells: &Cells| cull(&portal_alone(), (scene, cells), &view).instance_count;
    assert_eq!(count(&scene, &cells), 1, "the ball of the other room is behind the door");
    // Half of it is outside of the outer wall, where no cell is.
    let out = Transform::from_scale_translation([0.2; 3], [8.0, 1.0, 2.0]);
    scene.set_transform(far, out).unwrap();
    cells.update(&scene);
    assert_eq!(count(&scene, &cells), 2, "it may be seen from anywhere");
    let reached = InCells::from((&scene, &cells)).reached(&portal_alone(), &view).unwrap();
    assert_eq!(reached.visits().len(), 1, "the eye's own cell");
}

#[test]
fn what_sticks_out_is_explained_by_its_own_slot() {
    let (mut scene, mut cells, _, view) = two_rooms(Vec::new());
    cells.set_portal_open(0, false);
    let at = |x: f64, i: u32| {
        Transform::from_scale_translation([0.2; 3], [x, 0.5, 0.3 + f64::from(i) * 0.025])
    };
    let handles: Vec<Handle> =
        (0..140).map(|i| scene.add(Instance::new(0, at(6.0, i))).unwrap()).collect();
    scene.commit(&Culler::default());
    cells.update(&scene);
    let words = |scene: &Scene, cells: &Cells, handle: Handle| {
        let told = InCells::from((scene, cells)).explain(&portal_alone(), &view, handle).unwrap();
        told.steps.last().unwrap().to_string()
    };
    // One at a time, so that no bit of a word but its own is set.
    for (i, &handle) in (0..).zip(&handles).step_by(13) {
        scene.set_transform(handle, at(8.0, i)).unwrap();
        scene.refit();
        cells.update(&scene);
        let [own, other] = [handle, handles[(i as usize + 70) % 140]];
        assert!(words(&scene, &cells, own).contains("seen from everywhere"), "{i}");
        assert!(words(&scene, &cells, other).contains("portal 0 on the way is shut"), "{i}");
        scene.set_transform(handle, at(6.0, i)).unwrap();
        scene.refit();
        cells.update(&scene);
    }
}

#[test]
fn doors_open_and_shut_and_the_explanation_names_them() {
    let (scene, mut cells, [_, far], view) = two_rooms(Vec::new());
    assert_eq!(cull(&portal_alone(), (&scene, &cells), &view).instance_count, 2);
    let words = |cells: &Cells| {
        let told = InCells::from((&scene, cells)).explain(&portal_alone(), &view, far).unwrap();
        told.steps.last().unwrap().to_string()
    };
    assert_eq!(words(&cells), "in cell 1, seen from cell 0 through portal 0");
    cells.set_portal_open(0, false);
    assert_eq!(cull(&portal_alone(), (&scene, &cells), &view).instance_count, 1);
    assert_eq!(words(&cells), "in cell 1, not seen from cell 0: portal 0 on the way is shut");
    cells.set_portal_open(0, true);
    assert_eq!(cull(&portal_alone(), (&scene, &cells), &view).instance_count, 2);
}

#[test]
fn what_moves_is_kept_until_it_is_found_again() {
    let (mut scene, mut cells, [near, far], view) = two_rooms(Vec::new());
    cells.set_portal_open(0, false);
    let count =
        |scene: &Scene, cells: &Cells| cull(&portal_alone(), (scene, cells), &view).instance_count;
    let at = |x: f64| Transform::from_scale_translation([0.2; 3], [x, 1.0, 2.0]);
    assert_eq!(count(&scene, &cells), 1);
    scene.set_transform(near, at(7.0)).unwrap();
    assert_eq!(count(&scene, &cells), 1, "it moved, so it is kept");
    scene.refit();
    cells.update(&scene);
    assert_eq!(count(&scene, &cells), 0);
    scene.set_transform(far, at(3.0)).unwrap();
    assert_eq!(count(&scene, &cells), 1);
    scene.commit(&Culler::default());
    cells.update(&scene);
    assert_eq!(count(&scene, &cells), 1);
    assert_eq!(cells.cells_of(scene.slot(far).unwrap()), [0]);
    // Through the border it is in both, outside in none and seen from everywhere.
    scene.set_transform(near, at(4.0)).unwrap();
    scene.commit_slice();
    cells.update(&scene);
    assert_eq!(cells.cells_of(scene.slot(near).unwrap()), [0, 1]);
    scene.set_transform(near, at(50.0)).unwrap();
    scene.refit();
    cells.update(&scene);
    assert_eq!(count(&scene, &cells), 2);
    scene.set_transform(near, at(6.0)).unwrap();
    scene.refit();
    cells.update(&scene);
    assert_eq!(count(&scene, &cells), 1, "what was outside comes in again");
    scene.remove(near).unwrap();
    scene.commit(&Culler::default());
    cells.update(&scene);
    assert_eq!(count(&scene, &cells), 1);
}

#[test]
fn a_commit_with_fewer_slots_than_moved_is_no_harm() {
    let (mut scene, mut cells, [near, far], view) = two_rooms(Vec::new());
    let at = Transform::from_scale_translation([0.2; 3], [3.0, 1.0, 2.0]);
    scene.add(Instance::new(0, at)).unwrap();
    scene.remove(near).unwrap();
    scene.remove(far).unwrap();
    scene.commit(&Culler::default());
    cells.update(&scene);
    assert_eq!((scene.slot_count(), cells.cells_of(0)), (1, &[0][..]));
    assert_eq!(cull(&portal_alone(), (&scene, &cells), &view).instance_count, 1);
}

#[test]
fn an_eye_in_no_cell_or_in_a_wall_sees_all() {
    let (scene, mut cells, _, _) = two_rooms(Vec::new());
    cells.set_portal_open(0, false);
    let count = |eye: [f64; 3], near: f64| {
        let to = [eye[0], eye[1], eye[2] + 1.0];
        let view = View::perspective(eye, to, 1.2, near, 99.0, [64, 64]).unwrap();
        cull(&portal_alone(), (&scene, &cells), &view).instance_count
    };
    assert_eq!(count([1.0, 1.0, 0.5], 0.05), 1);
    assert_eq!(count([1.0, 1.0, -5.0], 0.05), 2, "in no cell");
    assert_eq!(count([1.0, 1.0, 3.97], 0.05), 2, "the near plane is beyond the wall");
    let flat = View::orthographic([1.0, 1.0, 1.0], [1.0, 1.0, 2.0], 2.0, 0.1, 9.0, [9, 9]).unwrap();
    assert_eq!(cull(&portal_alone(), (&scene, &cells), &flat).instance_count, 2);
}

/// Time of moving a hundredth of a building's furniture, beside that in the same scene without cells.
#[test]
#[ignore = "measures: cargo test --release -p cullet-testkit --test cells -- --ignored --nocapture a_refit_costs"]
fn a_refit_costs_what_moved_with_cells_too() {
    let mut rng = Rng(19);
    let building = Building::new(&mut rng, [8, 2, 8]);
    let mut times = Vec::new();
    for with_cells in [false, true] {
        let mut scene = Scene::new();
        let ball = scene.add_mesh(meshes::ball(3));
        let place = |rng: &mut Rng| {
            let (at, _) = building.point(rng, 0.0);
            Transform::from_scale_translation([0.05; 3], at)
        };
        let mut handles = Vec::new();
        for _ in 0..100_000 {
            handles.push(scene.add(Instance::new(ball, place(&mut rng))).unwrap());
        }
        scene.commit(&Culler::default());
        let mut cells = with_cells
            .then(|| Cells::new(&mut scene, building.graph.clone(), building.shapes.clone()));
        let mut took: Vec<_> = (0..60)
            .map(|_| {
                let moves: Vec<_> = (0..1000)
                    .map(|_| (handles[rng.index(handles.len())], place(&mut rng)))
                    .collect();
                let began = std::time::Instant::now();
                moves.iter().for_each(|&(h, at)| scene.set_transform(h, at).unwrap());
                let moved = began.elapsed();
                scene.refit();
                cells.iter_mut().for_each(|cells| cells.update(&scene));
                (moved, began.elapsed() - moved)
            })
            .collect();
        took.sort_unstable();
        times.push(took[took.len() / 2]);
    }
    println!("set and refit without cells {:?}, with cells {:?}", times[0], times[1]);
}
