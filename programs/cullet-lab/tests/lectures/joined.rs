//! Joint clusters and their trees.

use cullet_lab::joint::JointHierarchy;
use cullet_lab::methods::cluster::{Bound, ClusterFacing, NormalBox, NormalBoxAtOrigin, TwoWay};

use crate::bounds::Body;
use crate::tools::{fibonacci, percent, told};

/// Returns what the slides make of two bounds: the box around both boxes of normals, and the
/// smaller d.
fn joined(a: &NormalBox, b: &NormalBox, origin: [f32; 3]) -> NormalBox {
    NormalBox {
        largest: std::array::from_fn(|k| a.largest[k].max(b.largest[k])),
        smallest: std::array::from_fn(|k| a.smallest[k].min(b.smallest[k])),
        d: a.d.min(b.d),
        origin,
    }
}

/// Item 54: the smaller d of two origins culls wrongly; of a common one, or moved to it first, it
/// does not.
#[test]
fn the_smaller_d_is_right_of_a_common_origin_alone() {
    // Two bodies of one mesh side by side, and eyes between and around them.
    let apart: f32 = 3.0;
    let bodies = [Body::at([0.0; 3]), Body::at([apart, 0.0, 0.0])];
    let eyes: Vec<[f64; 4]> = (0..180)
        .map(|i| {
            let [x, y, z] = fibonacci(i, 180).map(|v| v * [0.3, 2.5, 5.0][i % 3]);
            [x + f64::from(apart) * 0.5, y, z, 1.0]
        })
        .collect();
    // By the slides at origins of their own, the same at a common one, and the engine's.
    let (mut culls, mut wrong) = ([0; 3], [0; 3]);
    for (a, b) in bodies[0].planes.iter().zip(&bodies[1].planes) {
        let at = |planes| NormalBox::fit_at(planes, [0.0; 3]);
        let bounds = (NormalBox::fit(a), NormalBox::fit(b), at(a), at(b));
        let (Some(own_a), Some(own_b), Some(at_a), Some(at_b)) = bounds else { continue };
        let middle = std::array::from_fn(|k| (own_a.origin[k] + own_b.origin[k]) * 0.5);
        let of = [
            joined(&own_a, &own_b, middle),
            joined(&at_a, &at_b, [0.0; 3]),
            own_a.join(&own_b, middle),
        ];
        for &eye in &eyes {
            let both = a.is_behind(eye) && b.is_behind(eye);
            for (which, bound) in of.iter().enumerate() {
                let goes = bound.is_behind(eye);
                culls[which] += usize::from(goes);
                wrong[which] += usize::from(goes && !both);
            }
        }
    }
    assert!(wrong[0] > 0 && wrong[1..] == [0, 0] && culls[1..].iter().all(|&n| n > 0));
    told(54, &[wrong[0], culls[0], culls[1], culls[2]].map(|n| n as f64));
}

/// Item 55: the test for fronts needs the largest n·p; with it a tree decides what single tests do,
/// by fewer.
#[test]
fn a_test_for_fronts_needs_a_second_d_and_then_a_tree_saves_tests() {
    let body = Body::at([0.0; 3]);
    let eyes = body.eyes(50);
    let (mut analogous, mut wrong, mut fronts) = (0, 0, 0);
    for planes in &body.planes {
        let (Some(bound), turned) = (NormalBoxAtOrigin::fit(planes), planes.flipped()) else {
            continue;
        };
        let both_ways = TwoWay::<NormalBoxAtOrigin>::fit(planes);
        for &eye in &eyes {
            let is_front = turned.is_behind(eye);
            let part = |k: usize| {
                f64::min(
                    f64::from(bound.largest[k]) * eye[k],
                    f64::from(bound.smallest[k]) * eye[k],
                )
            };
            // With the d of the test for backs.
            let says_front = part(0) + part(1) + part(2) > f64::from(bound.d);
            analogous += usize::from(says_front);
            wrong += usize::from(says_front && !is_front);
            match both_ways.facing(eye) {
                ClusterFacing::Front => {
                    fronts += 1;
                    assert!(is_front);
                }
                ClusterFacing::Back => assert!(planes.is_behind(eye)),
                ClusterFacing::Mixed => {}
            }
        }
    }
    assert!(wrong > 0 && fronts > 0);
    let tree = JointHierarchy::build(&body.mesh, &[1.5, 3.0]);
    let (mut tests, mut flat, mut decided) = (0, 0, 0);
    let mut facing = vec![ClusterFacing::Mixed; body.planes.len()];
    for &eye in &eyes {
        tests += tree.visit(eye, |list, f| list.iter().for_each(|&c| facing[c as usize] = f));
        for (planes, facing) in body.planes.iter().zip(&facing) {
            assert!(match facing {
                ClusterFacing::Back => planes.is_behind(eye),
                ClusterFacing::Front => planes.flipped().is_behind(eye),
                ClusterFacing::Mixed => true,
            });
            decided += usize::from(*facing != ClusterFacing::Mixed);
        }
        flat += tree.flat(eye, |list, f| {
            let agrees = |c: &u32| f == ClusterFacing::Mixed || facing[*c as usize] == f;
            assert!(list.iter().all(agrees), "the tree decides all that single tests do");
        });
    }
    assert!(tree.joint_count() > 0 && tests < flat);
    let share = percent(decided, eyes.len() * body.planes.len());
    told(
        55,
        &[wrong as f64, analogous as f64, f64::from(fronts), share, tests as f64, flat as f64],
    );
}
