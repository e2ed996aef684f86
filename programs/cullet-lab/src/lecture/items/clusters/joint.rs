//! Joint clusters and their hierarchy: items 54 and 55.

use crate::joint::JointHierarchy;
use crate::methods::cluster::{Bound, ClusterFacing, NormalBox, NormalBoxAtOrigin, TwoWay};
use crate::shapes::fibonacci;

use super::body::Body;
use super::bound::FINENESS;
use crate::lecture::finding::Finding;
use crate::lecture::items::subject::percent;
use crate::lecture::lab::{Lab, LabError};
use crate::lecture::tools::grouped;

/// What the slides make of two bounds: the box around both boxes of normals, and the smaller d.
fn joined(a: &NormalBox, b: &NormalBox, origin: [f32; 3]) -> NormalBox {
    NormalBox {
        largest: std::array::from_fn(|k| a.largest[k].max(b.largest[k])),
        smallest: std::array::from_fn(|k| a.smallest[k].min(b.smallest[k])),
        d: a.d.min(b.d),
        origin,
    }
}

pub(super) fn joint(_: &Lab) -> Result<Finding, LabError> {
    // Two bodies of one mesh side by side, and eyes between and around them.
    let apart: f32 = 3.0;
    let bodies = [Body::new(FINENESS, [0.0; 3])?, Body::new(FINENESS, [apart, 0.0, 0.0])?];
    let eyes: Vec<[f64; 4]> = (0..180)
        .map(|i| {
            let [x, y, z] = fibonacci(i, 180).map(|v| v * [0.3, 2.5, 5.0][i % 3]);
            [x + f64::from(apart) * 0.5, y, z, 1.0]
        })
        .collect();
    // By the slides at origins of their own, the same at a common one, and the engine's.
    let (mut culls, mut wrong) = ([0; 3], [0; 3]);
    for (a, b) in bodies[0].planes.iter().zip(&bodies[1].planes) {
        let at = |planes, origin| NormalBox::fit_at(planes, origin);
        let own = (NormalBox::fit(a), NormalBox::fit(b));
        let common = (at(a, [0.0; 3]), at(b, [0.0; 3]));
        let ((Some(own_a), Some(own_b)), (Some(at_a), Some(at_b))) = (own, common) else {
            continue;
        };
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
    let measured = format!(
        "with the smaller of two d from two origins {} of {} culls of joint clusters are wrong; from a common origin {} of {}, and with d moved \
         to it first {} of {}",
        grouped(wrong[0]),
        grouped(culls[0]),
        wrong[1],
        grouped(culls[1]),
        wrong[2],
        grouped(culls[2])
    );
    let shown = wrong[0] > 0 && wrong[1..] == [0, 0] && culls[1..].iter().all(|&n| n > 0);
    Ok(if shown { Finding::mended(measured) } else { Finding::fails(measured) })
}

pub(super) fn hierarchy(_: &Lab) -> Result<Finding, LabError> {
    let body = Body::new(FINENESS, [0.0; 3])?;
    let eyes = body.eyes(50);
    // A test for fronts with the d of the test for backs.
    let (mut analogous, mut wrong, mut fronts, mut false_fronts, mut bad) = (0, 0, 0, 0, 0);
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
            let says_front = part(0) + part(1) + part(2) > f64::from(bound.d);
            analogous += usize::from(says_front);
            wrong += usize::from(says_front && !is_front);
            match both_ways.facing(eye) {
                ClusterFacing::Front => {
                    fronts += 1;
                    false_fronts += usize::from(!is_front);
                }
                ClusterFacing::Back => bad += usize::from(!planes.is_behind(eye)),
                ClusterFacing::Mixed => {}
            }
        }
    }
    // The tree stops where a joint cluster is decided, and decides all that single tests do.
    let tree = JointHierarchy::build(&body.subject.mesh, &[1.5, 3.0]);
    let (mut tests, mut flat, mut decided) = (0, 0, 0);
    let mut facing = vec![ClusterFacing::Mixed; body.planes.len()];
    for &eye in &eyes {
        tests += tree.visit(eye, |list, f| list.iter().for_each(|&c| facing[c as usize] = f));
        for (planes, facing) in body.planes.iter().zip(&facing) {
            bad += usize::from(match facing {
                ClusterFacing::Back => !planes.is_behind(eye),
                ClusterFacing::Front => !planes.flipped().is_behind(eye),
                ClusterFacing::Mixed => false,
            });
            decided += usize::from(*facing != ClusterFacing::Mixed);
        }
        flat += tree.flat(eye, |list, f| {
            let less = |c: &&u32| f != ClusterFacing::Mixed && facing[**c as usize] != f;
            bad += list.iter().filter(less).count();
        });
    }
    let measured = format!(
        "with d = min n·p, {} of {} clusters that the test calls front are not; with max n·p for it {} of {}; a tree of joint clusters decides \
         {:.0} % of all in {} tests where single ones take {}, and none wrongly",
        grouped(wrong),
        grouped(analogous),
        false_fronts,
        grouped(fronts),
        percent(decided, eyes.len() * body.planes.len()),
        grouped(tests),
        grouped(flat)
    );
    let shown = wrong > 0
        && false_fronts + bad == 0
        && fronts > 0
        && tree.joint_count() > 0
        && tests < flat;
    Ok(if shown { Finding::mended(measured) } else { Finding::fails(measured) })
}
