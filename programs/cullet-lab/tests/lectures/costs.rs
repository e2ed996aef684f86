//! Tests of a cluster's expected cost, and of when two are merged.

use std::ops::ControlFlow;

use cullet::cull::backface::ClusterPlanes;
use cullet::{Mesh, MeshData};
use cullet_bake::clusters::{ClusterOptions, build, build_reported};
use cullet_scenes::knobbly_ball;

use crate::bounds::planes_of;
use crate::tools::{data, dot, fibonacci, told};

/// Item 58: what T = t + (1 − P) R promises of all clusters is what other eyes pay.
#[test]
fn other_eyes_pay_what_clusters_are_expected_to_cost() {
    const EYES: usize = 500;
    const TEST: f64 = 4.0;
    let data = data(knobbly_ball(24), false);
    let options = ClusterOptions { test_cost: TEST, ..ClusterOptions::fast() };
    let (clustering, report) =
        build_reported(&data, &options, |_| ControlFlow::Continue(())).expect("clusters");
    let mesh = Mesh::with_clusters(data, &clustering).expect("a solid");
    let tested = mesh.clusters().len() - report.never_culled as usize;
    let planes = planes_of(&mesh);
    let radius = f64::from(cullet::bounds::Sphere::from_points(mesh.positions()).radius);
    // A test of each cluster that is tested, and the triangles that are left.
    let mut paid = 0.0;
    for i in 0..EYES {
        let far = options.distances[i % options.distances.len()] * radius;
        let [x, y, z] = fibonacci(i, EYES).map(|v| v * far);
        for (n, (cluster, planes)) in mesh.clusters().iter().zip(&planes).enumerate() {
            let culled = n < tested && planes.is_behind([x, y, z, 1.0]);
            paid += if n < tested { TEST } else { 0.0 };
            paid += if culled { 0.0 } else { f64::from(cluster.triangle_count) };
        }
    }
    let paid = paid / (EYES as f64 * f64::from(report.triangles));
    let off = (report.expected_cost / paid - 1.0).abs() * 100.0;
    assert!(off < 3.0 && paid < 1.0, "{off} {paid}");
    told(58, &[planes.len() as f64, f64::from(report.triangles), report.expected_cost, paid, off]);
}

/// Two triangles with a common edge along z, folded by an angle.
fn hinge(fold: f64) -> MeshData {
    let (sin, cos) = fold.sin_cos();
    let wing = [cos as f32, -sin as f32, 0.5];
    let positions = vec![[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.5], wing];
    data((positions, vec![0, 2, 1, 0, 1, 3]), false)
}

/// Item 59: two triangles are merged if and only if P(C) > (P(A) n(A) + P(B) n(B) − t/r) / (n(A) +
/// n(B)).
#[test]
fn two_clusters_are_merged_where_the_inequality_says() {
    const EYES: usize = 4000;
    let (mut merges, mut keeps) = (0, 0);
    for fold in (10..=170).step_by(20) {
        let data = hinge(f64::from(fold).to_radians());
        let mesh = Mesh::new(data.clone()).expect("two triangles");
        let planes =
            [0..1, 1..2, 0..2].map(|range| ClusterPlanes::new(range.map(|t| mesh.corners(t))));
        // Parallel views from everywhere: the fold alone decides.
        let [a, b, both] = planes.each_ref().map(|planes| {
            let behind =
                |i: &usize| planes.half_spaces().all(|(n, _)| dot(n, fibonacci(*i, EYES)) < 0.0);
            (0..EYES).filter(behind).count() as f64 / EYES as f64
        });
        for ratio in [0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4] {
            let bound = (a + b - ratio) / 2.0;
            // The two forms: what the clusters cost, and the inequality.
            let pays = ratio + (1.0 - both) * 2.0 < 2.0 * ratio + (1.0 - a) + (1.0 - b);
            assert_eq!(pays, both > bound);
            // Too near for the views that the engine samples.
            if (both - bound).abs() < 0.02 {
                continue;
            }
            let options = ClusterOptions {
                test_cost: ratio,
                vertex_cost: 0.0,
                views: 1024,
                distances: [f64::INFINITY; 4],
                rounds: 0,
                ..ClusterOptions::default()
            };
            let clusters = build(&data, &options).expect("clusters").clusters.len();
            assert_eq!(clusters == 1, pays, "folded by {fold} degrees, t/r {ratio}");
            *(if pays { &mut merges } else { &mut keeps }) += 1;
        }
    }
    // Of a whole body, the more a test costs, the fewer clusters.
    let counts = [0.5, 4.0, 32.0].map(|test_cost| {
        let options = ClusterOptions { test_cost, rounds: 0, ..ClusterOptions::default() };
        build(&data(knobbly_ball(16), false), &options).expect("clusters").clusters.len() as f64
    });
    assert!(counts.is_sorted_by(|a, b| a > b));
    told(59, &[&[f64::from(merges), f64::from(keeps)], &counts[..]].concat());
}
