//! A hierarchy of joint clusters against a flat sweep.

use std::hint::black_box;

use crate::joint::JointHierarchy;
use crate::methods::Bulk;
use crate::methods::cluster::{ClusterBounds, ClusterFacing, TwoWay};
use cullet::cull::backface::EllipticCone;
use cullet::{Mesh, Simd};
use serde::Serialize;

use super::bounds::{Clusters, DISTANCES, MAIN, fastest};

/// Savings and costs of the tree; means over the eyes.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct HierarchyRow {
    /// Nodes above single clusters.
    pub(super) joint_nodes: usize,
    pub(super) tests_per_frame: f64,
    pub(super) flat_tests_per_frame: f64,
    /// Share of the clusters that are proved to face away, or towards the eye.
    pub(super) back_percent: f64,
    pub(super) front_percent: f64,
    /// A walk of the tree.
    pub(super) us_per_frame: f64,
    /// The same tests one after the other, without the tree.
    pub(super) flat_us_per_frame: f64,
    /// The same as two batches with vector instructions.
    pub(super) batch_us_per_frame: f64,
    /// Clusters that the flat sweep decides and the tree does not; 0, or something is wrong.
    pub(super) lost: u64,
}

/// Builds and measures it, from the eyes at the main distance.
pub(super) fn measure(mesh: &Mesh, clusters: &Clusters<'_>, eyes: &[[f64; 4]]) -> HierarchyRow {
    let tree = JointHierarchy::build(mesh, &[DISTANCES[MAIN]]);
    let (mut tests, mut back, mut front, mut lost) = (0, 0, 0, 0);
    let mut facing = vec![ClusterFacing::Mixed; clusters.len()];
    for &eye in eyes {
        tests += tree.visit(eye, |list, f| list.iter().for_each(|&c| facing[c as usize] = f));
        back += facing.iter().filter(|f| **f == ClusterFacing::Back).count();
        front += facing.iter().filter(|f| **f == ClusterFacing::Front).count();
        tree.flat(eye, |list, f| {
            let less = |c: &&u32| f != ClusterFacing::Mixed && facing[**c as usize] != f;
            lost += list.iter().filter(less).count() as u64;
        });
    }
    let fits: Vec<TwoWay<EllipticCone>> = clusters.planes().iter().map(TwoWay::fit).collect();
    let [behind, before]: [ClusterBounds<EllipticCone>; 2] =
        [fits.iter().map(|b| b.back).collect(), fits.iter().map(|b| b.front).collect()];
    let level = Simd::best();
    let mut bits = [Vec::new(), Vec::new()];
    let us = |pass: &mut dyn FnMut([f64; 4])| {
        fastest(|| eyes.iter().for_each(|e| pass(*e))) / 1e3 / eyes.len() as f64
    };
    let mean = |sum: usize| sum as f64 / eyes.len() as f64;
    let percent = |sum: usize| mean(sum) * 100.0 / clusters.len() as f64;
    HierarchyRow {
        joint_nodes: tree.joint_count(),
        tests_per_frame: mean(tests),
        flat_tests_per_frame: tree.expected_tests().1 as f64,
        back_percent: percent(back),
        front_percent: percent(front),
        us_per_frame: us(&mut |eye| {
            tree.visit(eye, |list, f| {
                black_box((list, f));
            });
        }),
        flat_us_per_frame: us(&mut |eye| {
            tree.flat(eye, |list, f| {
                black_box((list, f));
            });
        }),
        batch_us_per_frame: us(&mut |eye| {
            behind.cull(level, eye, &mut bits[0]);
            before.cull(level, eye, &mut bits[1]);
            black_box(&bits);
        }),
        lost,
    }
}
