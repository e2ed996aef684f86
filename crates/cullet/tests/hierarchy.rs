//! The hierarchy under random treatment: always valid, and its walk always the answer of a flat sweep.

use std::collections::HashMap;

use cullet::Simd;
use cullet::bounds::{Aabb, Boxes, Side};
use cullet::cull::Indices;
use cullet::cull::frustum::batch::{self, Planes, mask_words};
use cullet::cull::frustum::tree::Cut;
use cullet::hierarchy::{Handle, Hierarchy, HierarchyError, Nodes, NodesError, spatial_order};
use cullet_draw::Trace;
use cullet_testkit::views::{looking_down_z, random_box, random_planes};
use cullet_testkit::{Rng, at_every_level};

/// The walk says what the sweep says, in every form, at every level.
fn check(planes: &Planes, nodes: &Nodes, boxes: &Boxes, cut: &mut Cut) {
    let words = mask_words(boxes.len());
    at_every_level!(|level| {
        let (mut visible, mut inside) = (vec![0; words], vec![0; words]);
        batch::classify_boxes(level, planes, boxes, 0, &mut visible, &mut inside);
        cut.cull(level, planes, nodes, boxes);
        assert_eq!(cut.visible(), visible, "visible, {level:?}");
        assert_eq!(cut.inside(), inside, "inside, {level:?}");
        let trace = Trace::new(planes, nodes, boxes);
        if cut.swept() as usize <= boxes.len() - nodes.len() / 64 * 64 {
            let straddling = |level: &[Option<Side>]| {
                level.iter().filter(|side| **side == Some(Side::Straddling)).count() as u64
            };
            // The root is tested without being in any level.
            let inner: u64 =
                trace.levels[2.min(trace.levels.len())..].iter().map(|l| straddling(l)).sum();
            let root = u64::from(!nodes.levels().is_empty());
            assert_eq!(cut.nodes_tested(), inner + root);
        }
        let (mut swept, mut walked) = (Indices::new(), Indices::new());
        batch::cull_boxes(level, planes, boxes, &mut swept);
        cut.list(level, &mut walked);
        assert_eq!(*walked, *swept);
        assert_eq!(cut.count(), swept.len());
        assert_eq!(trace.visible(planes, boxes), *swept);
    });
}

#[test]
fn the_walk_is_the_sweep_for_any_number_of_boxes() {
    let mut rng = Rng(1);
    let mut cut = Cut::new();
    for len in [0, 1, 15, 16, 17, 255, 256, 257, 1000, 4096, 4097, 5000, 40_000] {
        let unsorted: Vec<_> = (0..len).map(|_| random_box(&mut rng)).collect();
        let order = spatial_order(&unsorted);
        let mut boxes = Boxes::new();
        boxes.gather(Simd::best(), &unsorted, &order);
        let nodes = Nodes::over(Simd::best(), &boxes);
        nodes.validate(&boxes).expect("just built");
        // Some that lie under no node.
        (0..rng.below(3) * 70).for_each(|_| boxes.push(&random_box(&mut rng)));
        for _ in 0..12 {
            check(&random_planes(&mut rng), &nodes, &boxes, &mut cut);
        }
    }
}

#[test]
fn a_hierarchy_is_built_in_spatial_order() {
    let mut rng = Rng(5);
    let heap = |rng: &mut Rng| Aabb::new([rng.range(0.0, 1e-3) as f32; 3], [1.0; 3]);
    for len in [0, 1, 15, 16, 17, 255, 1000, 4099, 30_000] {
        for kind in 0..3 {
            let one = |rng: &mut Rng| match kind {
                0 => random_box(rng),
                // Nearly all in one place; all alike.
                1 if rng.below(100) > 0 => heap(rng),
                1 => random_box(rng),
                _ => Aabb::new([1.0; 3], [2.0; 3]),
            };
            let items: Vec<_> = (0..len).map(|_| one(&mut rng)).collect();
            let order = spatial_order(&items);
            let mut expected = Boxes::new();
            order.iter().for_each(|&i| expected.push(&items[i as usize]));
            let (h, handles) = Hierarchy::build(&items).expect("few");
            h.validate().expect("just built");
            assert_eq!(h.boxes().as_floats(), expected.as_floats(), "{len}");
            assert_eq!(h.len() as usize, len);
            for (slot, &i) in (0..).zip(&order) {
                assert_eq!(h.handle(slot), Some(handles[i as usize]));
                assert_eq!(h.slot(handles[i as usize]), Ok(slot));
            }
        }
    }
}

#[test]
fn a_hierarchy_stays_right_whatever_is_done_to_it() {
    let mut rng = Rng(2);
    for round in 0..6 {
        let start: Vec<_> = (0..rng.below(3000)).map(|_| random_box(&mut rng)).collect();
        let (mut h, handles) = Hierarchy::build(&start).expect("few");
        h.validate().expect("just built");
        let mut truth: HashMap<Handle, Aabb> = handles.into_iter().zip(start).collect();
        let mut gone = Vec::new();
        let mut cut = Cut::new();
        for step in 0..300 {
            let any = |truth: &HashMap<Handle, Aabb>, rng: &mut Rng| {
                let mut all: Vec<_> = truth.keys().copied().collect();
                all.sort_unstable();
                (!all.is_empty()).then(|| all[rng.below(all.len() as u64) as usize])
            };
            match rng.below(12) {
                0..=2 => {
                    let b = random_box(&mut rng);
                    truth.insert(h.insert(&b).expect("few"), b);
                }
                3 | 4 => {
                    if let Some(handle) = any(&truth, &mut rng) {
                        h.remove(handle).expect("it is there");
                        truth.remove(&handle);
                        gone.push(handle);
                    }
                }
                5..=8 => {
                    if let Some(handle) = any(&truth, &mut rng) {
                        let b = random_box(&mut rng);
                        h.set_bounds(handle, &b).expect("it is there");
                        truth.insert(handle, b);
                    }
                }
                9 => h.refit(),
                10 => {
                    let before: Vec<_> = (0..h.slot_count()).map(|s| h.handle(s)).collect();
                    let mut after = before.clone();
                    for [old, new] in h.commit_slice() {
                        after[new as usize] = before[old as usize];
                    }
                    assert!((0..h.slot_count()).all(|s| h.handle(s) == after[s as usize]));
                }
                _ if step % 7 == 0 => {
                    let before: Vec<_> = (0..h.slot_count()).map(|s| h.handle(s)).collect();
                    let moves = rng.below(2) == 0;
                    let commit = h.commit_parts(|slot| moves && slot % 5 == 0);
                    assert_eq!(h.len(), h.slot_count());
                    for (old, &new) in commit.slot_of_old.iter().enumerate() {
                        assert_eq!(before[old].is_none(), new == u32::MAX);
                        assert!(new == u32::MAX || h.handle(new) == before[old]);
                    }
                }
                _ => {
                    let slots = h.slot_count();
                    if slots > 0 {
                        let slot = rng.below(u64::from(slots)) as u32;
                        if let Some(handle) = h.handle(slot) {
                            let b = random_box(&mut rng);
                            h.write_bounds(|boxes| boxes.set(slot, &b));
                            truth.insert(handle, b);
                        }
                    }
                }
            }
            h.validate().unwrap_or_else(|e| panic!("round {round}, step {step}: {e}"));
        }
        assert_eq!(h.len() as usize, truth.len());
        for (&handle, b) in &truth {
            let slot = h.slot(handle).expect("it is there") as usize;
            let expected = Boxes::from_slice(&[*b]);
            assert_eq!(
                h.boxes().get(slot),
                expected.get(0),
                "a box is stored once, not wider and wider"
            );
            assert_eq!(h.handle(slot as u32), Some(handle));
        }
        for &handle in &gone {
            let no = Err(HierarchyError::NoItem(handle));
            assert_eq!(h.slot(handle), no.map(|()| 0));
            assert_eq!(h.remove(handle), no);
            assert_eq!(h.set_bounds(handle, &Aabb::EMPTY), no);
        }
        for _ in 0..6 {
            check(&random_planes(&mut rng), h.nodes(), h.boxes(), &mut cut);
        }
    }
}

#[test]
fn a_refit_makes_nodes_as_tight_as_new_ones() {
    let mut rng = Rng(3);
    let start: Vec<_> = (0..5000).map(|_| random_box(&mut rng)).collect();
    let (mut h, handles) = Hierarchy::build(&start).expect("few");
    for _ in 0..5 {
        for _ in 0..200 {
            let handle = handles[rng.below(5000) as usize];
            h.set_bounds(handle, &random_box(&mut rng)).expect("it is there");
        }
        h.refit();
        let fresh = Nodes::over(Simd::best(), h.boxes());
        for (ours, new) in h.nodes().levels().iter().zip(fresh.levels()) {
            assert_eq!(ours.as_floats(), new.as_floats());
        }
    }
}

#[test]
fn boxes_that_are_written_few_or_many_at_once_leave_nodes_as_tight_as_new_ones() {
    let mut rng = Rng(11);
    for round in 0..60 {
        let count = 1 + rng.below(6000) as usize;
        let start: Vec<_> = (0..count).map(|_| random_box(&mut rng)).collect();
        let (mut h, _) = Hierarchy::build(&start).expect("few");
        // Beyond the nodes: no node holds these.
        (0..rng.below(40)).for_each(|_| {
            h.insert(&random_box(&mut rng)).expect("few");
        });
        for share in [1, 3, 20, 400] {
            let written = 1 + u64::from(h.slot_count()) / share;
            let version = h.change_version();
            h.write_bounds(|boxes| {
                for _ in 0..written {
                    let b = if rng.below(20) == 0 { Aabb::EMPTY } else { random_box(&mut rng) };
                    boxes.set(rng.below(count as u64) as u32, &b);
                }
            });
            assert!(h.change_version() > version);
            let mut covered = h.boxes().clone();
            covered.resize(h.nodes().len());
            let fresh = Nodes::over(Simd::best(), &covered);
            assert_eq!(h.nodes().levels().len(), fresh.levels().len());
            for (ours, new) in h.nodes().levels().iter().zip(fresh.levels()) {
                assert_eq!(ours.as_floats(), new.as_floats(), "round {round}, 1 in {share}");
            }
            h.validate().unwrap_or_else(|e| panic!("round {round}, 1 in {share}: {e}"));
            check(&random_planes(&mut rng), h.nodes(), h.boxes(), &mut Cut::new());
        }
    }
}

#[test]
fn the_slot_of_a_removed_item_stays_empty_whatever_is_written_to_it() {
    let before_eye = Aabb::new([-1.0, -1.0, -6.0], [1.0, 1.0, -5.0]);
    let planes = Planes::new(&looking_down_z().frustum());
    let (mut h, handles) = Hierarchy::build(&[before_eye; 40]).expect("few");
    let slot = h.slot(handles[7]).expect("it is there");
    h.remove(handles[7]).expect("it is there");
    h.write_bounds(|boxes| boxes.set(slot, &before_eye));
    let mut cut = Cut::new();
    cut.cull(Simd::best(), &planes, h.nodes(), h.boxes());
    assert_eq!(cut.count(), 39);
    assert!(h.boxes().get(slot as usize).is_empty());
}

#[test]
fn nodes_hold_what_was_written_before_a_panic() {
    let (mut h, _) = Hierarchy::build(&[Aabb::new([0.0; 3], [1.0; 3]); 300]).expect("few");
    let version = h.change_version();
    let caught = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
        h.write_bounds(|boxes| {
            boxes.set(100, &Aabb::new([50.0; 3], [60.0; 3]));
            boxes.set(300, &Aabb::EMPTY);
        });
    }));
    assert!(caught.is_err(), "there is no slot 300");
    assert!(h.change_version() > version);
    h.validate().expect("fitted");
}

#[test]
fn slices_keep_a_world_in_motion_sorted() {
    let mut rng = Rng(4);
    let start: Vec<_> = (0..20_000)
        .map(|_| rng.vector(100.0).map(|v| v as f32))
        .map(|c| Aabb::new(c, c.map(|v| v + 1.0)))
        .collect();
    let (mut h, handles) = Hierarchy::build(&start).expect("few");
    let mut places = start.clone();
    let speed: Vec<_> = (0..places.len()).map(|_| rng.vector(0.2).map(|v| v as f32)).collect();
    for _ in 0..300 {
        for ((b, v), &handle) in places.iter_mut().zip(&speed).zip(&handles) {
            for a in 0..3 {
                b.min[a] += v[a];
                b.max[a] += v[a];
            }
            let slot = h.slot(handle).expect("it is there");
            h.set_bounds(h.handle(slot).expect("full"), b).expect("it is there");
        }
        h.refit();
        h.commit_slice();
    }
    let drifted = h.validate().expect("valid").surface[0];
    let mut left_alone = Boxes::new();
    let order = spatial_order(&start);
    left_alone.gather(Simd::best(), &places, &order);
    let left_alone =
        Nodes::over(Simd::best(), &left_alone).validate(&left_alone).expect("valid").surface[0];
    h.commit();
    let fresh = h.validate().expect("valid").surface[0];
    assert!(drifted < 1.5 * fresh, "{drifted} after slices, {fresh} when sorted anew");
    assert!(left_alone > 1.5 * fresh, "the test must drift: {left_alone} without, {fresh} anew");
}

#[test]
fn what_is_inserted_in_order_need_not_be_sorted() {
    let mut rng = Rng(9);
    for count in [0, 1, 15, 16, 17, 5_000] {
        let boxes: Vec<_> = (0..count).map(|_| random_box(&mut rng)).collect();
        let (sorted, _) = Hierarchy::build(&boxes).expect("few");
        let mut again = Hierarchy::new();
        for slot in 0..sorted.slot_count() {
            again.insert(&sorted.boxes().get(slot as usize)).expect("few");
        }
        let before = again.order_version();
        again.commit_in_order();
        assert!(again.order_version() > before);
        let statistics = |h: &Hierarchy| h.validate().expect("valid");
        assert_eq!(statistics(&again), statistics(&sorted), "{count}");
        assert_eq!(again.nodes().len(), count);
        // It is as good as any for what follows.
        assert!(again.commit_slice().is_empty());
        if let Some(handle) = again.handle(0) {
            again.set_bounds(handle, &Aabb::new([-1e3; 3], [1e3; 3])).expect("it is there");
            again.remove(handle).expect("it is there");
        }
        again.insert(&Aabb::new([0.0; 3], [1.0; 3])).expect("few");
        again.commit_in_order();
        again.validate().expect("valid");
        check(&random_planes(&mut rng), again.nodes(), again.boxes(), &mut Cut::new());
    }
}

#[test]
fn a_stale_node_is_found() {
    let boxes = Boxes::from_slice(&[Aabb::new([0.0; 3], [1.0; 3]); 100]);
    let nodes = Nodes::over(Simd::best(), &boxes);
    let statistics = nodes.validate(&boxes).expect("fresh");
    assert_eq!(statistics.nodes, [7]);
    let mut moved = boxes.clone();
    moved.set(40, &Aabb::new([0.0; 3], [2.0; 3]));
    assert_eq!(nodes.validate(&moved), Err(NodesError::Loose { level: 0, node: 2, child: 40 }));
    moved.resize(99);
    assert_eq!(nodes.validate(&moved), Err(NodesError::Len { nodes: 100, boxes: 99 }));
}

#[test]
fn a_million_alike_and_a_world_of_one() {
    let one = Aabb::new([0.0, 0.0, -5.0], [1.0, 1.0, -4.0]);
    let planes = Planes::new(&looking_down_z().frustum());
    for len in [1, 1_000_000] {
        let (h, _) = Hierarchy::build(&vec![one; len]).expect("fits");
        let mut cut = Cut::new();
        cut.cull(Simd::best(), &planes, h.nodes(), h.boxes());
        let mut flat = Indices::new();
        batch::cull_boxes(Simd::best(), &planes, h.boxes(), &mut flat);
        assert_eq!(cut.count(), flat.len());
        assert!(flat.len() == len || flat.is_empty());
    }
}
