//! Clusters of shapes made here: limits, permutation, determinism, and how much is culled.

mod models;

use std::ops::ControlFlow;

use cullet::mesh::{Clustering, MeshError, Part};
use cullet::{Mesh, MeshData};
use cullet_bake::clusters::{
    ClusterError, ClusterOptions, Probability, Quality, Report, build, build_reported,
};
use cullet_testkit::meshes::one_sided_data;
use cullet_testkit::soups::{bumpy_ball, scattered};
use proptest::prelude::*;

/// Makes a mesh of the clustering, which checks that it is a permutation within the limits of a mesh, and
/// holds it against those of the options.
fn check(data: &MeshData, clustering: &Clustering, options: &ClusterOptions) -> Mesh {
    let mesh = Mesh::with_clusters(data.clone(), clustering).expect("a valid clustering");
    for c in mesh.clusters() {
        let range = c.first_triangle..c.first_triangle + c.triangle_count;
        let mut vertices: Vec<u32> = range.flat_map(|t| mesh.triangle(t)).collect();
        vertices.sort_unstable();
        vertices.dedup();
        assert!(c.triangle_count <= options.max_triangles, "{c:?}");
        assert!(vertices.len() <= options.max_vertices as usize, "{c:?}: {}", vertices.len());
    }
    mesh
}

fn reported(data: &MeshData, options: &ClusterOptions) -> (Clustering, Report) {
    build_reported(data, options, |_| ControlFlow::Continue(())).expect("valid")
}

#[test]
fn a_ball_is_culled_nearly_as_well_as_its_triangles() {
    let data = one_sided_data(bumpy_ball(60, 0.0));
    let (clustering, report) = reported(&data, &ClusterOptions::default());
    check(&data, &clustering, &ClusterOptions::default());
    let quality = Quality::of(&data, &clustering, 3.0);
    println!("{report:?}\n{quality:?}");
    assert!(quality.ideal > 0.52 && quality.ideal <= quality.exact, "{quality:?}");
    assert!(report.triangles_per_cluster() > 80.0, "{report:?}");
    assert!((report.exact_share - report.ideal_share) < 0.12, "{report:?}");
    assert!(report.complete && report.two_sided == 0 && report.never_culled <= 2, "{report:?}");
    assert_eq!((report.triangles, report.degenerate), (14_160, 0));
    // The share that faces away is exactly known of a ball: seen from 3 radii, (1 + 1/3) / 2 of it.
    assert!((quality.exact - 2.0 / 3.0).abs() < 0.01, "{quality:?}");
}

#[test]
fn a_bumpy_ball_is_culled_better_than_its_spatial_clusters() {
    let data = one_sided_data(bumpy_ball(60, 0.06));
    let simple = Clustering::spatial(&data).expect("valid");
    let before = Quality::of(&data, &simple, 3.0);
    let mut last = 1.0;
    for options in [ClusterOptions::fast(), ClusterOptions::default(), ClusterOptions::best()] {
        let (clustering, report) = reported(&data, &options);
        check(&data, &clustering, &options);
        let after = Quality::of(&data, &clustering, 3.0);
        println!("{} {:.1} {before:?} {after:?}", report.clusters, report.triangles_per_cluster());
        assert!(after.ideal > before.ideal + 0.05, "{before:?} {after:?}");
        assert!(clustering.clusters.len() < simple.clusters.len(), "and with fewer clusters");
        let cost = 16.0 / report.triangles_per_cluster() + 1.0 - after.ideal;
        assert!(cost < last, "slower presets do better: {cost} {last}");
        last = cost;
    }
}

#[test]
fn dearer_tests_make_fewer_clusters() {
    let data = one_sided_data(bumpy_ball(40, 0.05));
    let mut clusters = usize::MAX;
    let mut ideal = 1.0;
    for test_cost in [0.5, 4.0, 16.0] {
        let options = ClusterOptions { test_cost, ..ClusterOptions::default() };
        let clustering = build(&data, &options).expect("valid");
        let quality = Quality::of(&data, &clustering, 3.0);
        assert!(clustering.clusters.len() < clusters && quality.ideal < ideal, "{test_cost}");
        (clusters, ideal) = (clustering.clusters.len(), quality.ideal);
    }
}

#[test]
fn culling_volumes_make_clusters_that_are_culled_more_too() {
    let data = one_sided_data(bumpy_ball(40, 0.05));
    let simple = Clustering::spatial(&data).expect("valid");
    let before = Quality::of(&data, &simple, 3.0).ideal;
    for probability in
        [Probability::SceneBox { scale: 4.0 }, Probability::NearBox { diagonals: 4.0 }]
    {
        for rounds in [0, 1] {
            let options = ClusterOptions { probability, rounds, ..ClusterOptions::default() };
            let clustering = build(&data, &options).expect("valid");
            check(&data, &clustering, &options);
            let after = Quality::of(&data, &clustering, 3.0).ideal;
            println!("{probability:?} {rounds}: {before} {after} {}", clustering.clusters.len());
            assert!(after > before + 0.02, "{probability:?}: {before} {after}");
        }
    }
}

#[test]
fn the_same_input_gives_the_same_clusters() {
    for data in [one_sided_data(bumpy_ball(24, 0.05)), one_sided_data(scattered(500))] {
        let options = ClusterOptions::default();
        assert_eq!(build(&data, &options), build(&data, &options));
    }
}

#[test]
fn what_is_never_culled_comes_last_in_its_part() {
    // Half of the ball is turned inside out triangle by triangle, so that neighbours oppose each other.
    let mut data = one_sided_data(bumpy_ball(40, 0.0));
    let half = data.indices.len() / 2;
    for t in data.indices[..half].chunks_exact_mut(6) {
        t.swap(0, 1);
    }
    // Expensive tests, but vertices so few that no cluster could hold opposed triangles apart.
    let options = ClusterOptions { test_cost: 40.0, ..ClusterOptions::default() };
    let (clustering, report) = reported(&data, &options);
    check(&data, &clustering, &options);
    println!("{report:?}");
    assert!(report.never_culled > 0 && report.never_culled < report.clusters, "{report:?}");
    let first = clustering.clusters.len() - report.never_culled as usize;
    let last = &clustering.clusters[first..];
    assert_eq!(last.iter().map(|c| c.triangle_count).sum::<u32>(), report.never_culled_triangles);
    // Alone, the first ones are culled more of the time than the last.
    let share = |range: &[cullet::mesh::Cluster]| {
        let mut clusters = range.to_vec();
        let mut order = Vec::new();
        for c in &mut clusters {
            let first = c.first_triangle as usize;
            c.first_triangle = order.len() as u32;
            order.extend_from_slice(&clustering.order[first..][..c.triangle_count as usize]);
        }
        Quality::of(&data, &Clustering { order, clusters }, 3.0).ideal
    };
    let (tested, untested) = (share(&clustering.clusters[..first]), share(last));
    assert!(tested > untested + 0.1, "{tested} {untested}");
    assert!(report.expected_cost < 1.0);
}

#[test]
fn parts_are_not_crossed_and_their_cost_is_reported() {
    let mut data = one_sided_data(bumpy_ball(40, 0.0));
    let triangles = (data.indices.len() / 3) as u32;
    // Narrow parts: stripes of the ball, and one of them is drawn from both sides.
    data.parts.clear();
    for first_triangle in (0..triangles).step_by(170) {
        let triangle_count = (triangles - first_triangle).min(170);
        let (material, two_sided) = (first_triangle, first_triangle == 1700);
        let part = Part { first_triangle, triangle_count, material, two_sided, ..Part::default() };
        data.parts.push(part);
    }
    let options = ClusterOptions { measure_parts: true, ..ClusterOptions::default() };
    let (clustering, report) = reported(&data, &options);
    let mesh = check(&data, &clustering, &options);
    // A strip one quad wide has as many vertices as triangles: two clusters would not do.
    assert_eq!((report.two_sided_triangles, report.two_sided), (170, 3), "{report:?}");
    assert_eq!(mesh.clusters().iter().filter(|c| c.part == 10).count(), 3);
    let one = report.as_one_part.expect("it was requested");
    println!("{report:?}");
    assert!(one.clusters < one.clusters_split && one.expected_cost < one.expected_cost_split);
    let default = reported(&data, &ClusterOptions::default());
    assert_eq!((default.0, default.1.as_one_part), (clustering, None));
}

#[test]
fn two_sided_clusters_are_full_and_compact() {
    let mut data = one_sided_data(bumpy_ball(60, 0.05));
    data.parts.clear();
    let simple = Clustering::spatial(&data).expect("valid");
    let (clustering, report) = reported(&data, &ClusterOptions::default());
    let extent = |c: &Clustering| {
        let mesh = check(&data, c, &ClusterOptions::default());
        let boxes = mesh.cluster_boxes();
        (0..mesh.clusters().len()).map(|i| boxes.get(i).surface_area()).sum::<f64>()
    };
    assert_eq!(report.two_sided, report.clusters);
    assert_eq!((report.never_culled, report.ideal_share, report.expected_cost), (0, 0.0, 1.0));
    println!("{} {}", simple.clusters.len(), clustering.clusters.len());
    assert!(clustering.clusters.len() < simple.clusters.len());
    assert!(extent(&clustering) < extent(&simple) * 1.3);
}

#[test]
fn separate_triangles_are_gathered_by_place() {
    let data = one_sided_data(scattered(3000));
    let (clustering, report) = reported(&data, &ClusterOptions::default());
    check(&data, &clustering, &ClusterOptions::default());
    println!("{report:?}");
    // 21 triangles fill a cluster.
    assert!(report.clusters < 400, "{report:?}");
    assert_eq!(report.vertex_duplication, 1.0);
}

#[test]
fn degenerate_and_deforming_triangles() {
    let mut data = one_sided_data(bumpy_ball(12, 0.0));
    let triangles = (data.indices.len() / 3) as u32;
    data.indices.extend([0, 0, 5, 7, 8, 7]);
    data.parts[0].triangle_count += 2;
    let (clustering, report) = reported(&data, &ClusterOptions::default());
    let mesh = check(&data, &clustering, &ClusterOptions::default());
    assert_eq!((report.degenerate, report.triangles), (2, triangles));
    assert_eq!(mesh.degenerate_count(), 2);
    data.deformable = true;
    let (clustering, report) = reported(&data, &ClusterOptions::default());
    check(&data, &clustering, &ClusterOptions::default());
    assert_eq!((report.degenerate, report.triangles), (0, triangles + 2));
}

#[test]
fn meshes_of_nothing_and_of_little() {
    let empty = MeshData::default();
    let (clustering, report) = reported(&empty, &ClusterOptions::default());
    assert_eq!((clustering, report.clusters, report.complete), (Clustering::default(), 0, true));
    let quality = Quality::of(&empty, &Clustering::default(), 3.0);
    assert_eq!((quality.ideal, quality.exact), (0.0, 0.0));
    let one = one_sided_data((vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![0, 1, 2]));
    let (clustering, _) = reported(&one, &ClusterOptions::default());
    check(&one, &clustering, &ClusterOptions::default());
    assert_eq!(clustering.clusters.len(), 1);
    // All triangles in one place, thousands at one edge.
    let flat = one_sided_data((vec![[2.0; 3]; 30], (0..30).collect()));
    assert_eq!(reported(&flat, &ClusterOptions::default()).1.degenerate, 10);
    let mut fins = vec![[0.0; 3], [0.0, 1.0, 0.0]];
    let n = 3000;
    fins.extend((0..n).map(|i| {
        let angle = i as f32 / n as f32 * std::f32::consts::TAU;
        [angle.cos(), 0.5, angle.sin()]
    }));
    let fins = one_sided_data((fins, (0..n).flat_map(|i| [0, 1, i + 2]).collect()));
    let (clustering, _) = reported(&fins, &ClusterOptions::default());
    check(&fins, &clustering, &ClusterOptions::default());
    assert!(
        clustering.clusters.len() < 80,
        "62 to a cluster at most: {}",
        clustering.clusters.len()
    );
    // Huge and tiny coordinates.
    for scale in [1e-30, 1e30] {
        let mut data = one_sided_data(bumpy_ball(12, 0.0));
        data.positions.iter_mut().for_each(|p| *p = p.map(|v| v * scale));
        let (clustering, report) = reported(&data, &ClusterOptions::default());
        check(&data, &clustering, &ClusterOptions::default());
        assert!(report.ideal_share > 0.3, "{scale}: {report:?}");
    }
}

#[test]
fn stopping_leaves_valid_clusters() {
    let mut data = one_sided_data(bumpy_ball(48, 0.05));
    let triangles = (data.indices.len() / 3) as u32;
    data.parts = vec![
        Part { triangle_count: 3000, ..Part::default() },
        Part { first_triangle: 3000, triangle_count: triangles - 3000, ..Part::default() },
    ];
    let mut calls = 0;
    let mut last = 0.0;
    let all = build_reported(&data, &ClusterOptions::default(), |p| {
        assert!(p.share >= last && p.share <= 1.0 && p.parts == 2, "{p:?} after {last}");
        last = p.share;
        calls += 1;
        ControlFlow::Continue(())
    });
    assert!(all.is_ok() && calls > 100 && last == 1.0, "{calls} {last}");
    for stop in [0, 1, 2, 5, calls / 2, calls - 1] {
        let mut left = stop;
        let (clustering, report) = build_reported(&data, &ClusterOptions::default(), |_| {
            left -= 1;
            if left < 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })
        .expect("valid");
        check(&data, &clustering, &ClusterOptions::default());
        assert!(!report.complete, "stopped after {stop} of {calls}");
    }
}

#[test]
fn bad_input_is_named() {
    let data = one_sided_data(bumpy_ball(4, 0.0));
    let good = ClusterOptions::default();
    let message = |options: ClusterOptions| build(&data, &options).expect_err("bad").to_string();
    let bad = message(ClusterOptions { max_vertices: 65, ..good });
    assert_eq!(bad, "option max_vertices is 65; 3 to 64 are allowed");
    assert!(message(ClusterOptions { max_triangles: 0, ..good }).contains("1 to 124"));
    assert!(message(ClusterOptions { views: 0, ..good }).contains("views is 0"));
    assert!(message(ClusterOptions { test_cost: f64::NAN, ..good }).contains("test_cost is NaN"));
    assert!(message(ClusterOptions { vertex_cost: -1.0, ..good }).contains("vertex_cost is -1"));
    let distances = [1.0, 0.0, 2.0, 3.0];
    assert!(message(ClusterOptions { distances, ..good }).contains("distances is 0"));
    let probability = Probability::NearBox { diagonals: 0.0 };
    assert!(message(ClusterOptions { probability, ..good }).contains("diagonals is 0"));
    let mut broken = data.clone();
    broken.positions[3][1] = f32::NAN;
    let error = build(&broken, &good).expect_err("NaN");
    assert!(matches!(error, ClusterError::Mesh(MeshError::NotFinite { vertex: 3, .. })), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cullet_testkit::cases(24)))]

    #[test]
    fn any_limits_and_any_triangles_make_a_valid_clustering(
        max_vertices in 3u32..=64,
        max_triangles in 1u32..=124,
        test_cost in 0.0f64..60.0,
        vertex_cost in 0.0f64..2.0,
        rounds in 0u32..3,
        deformable in any::<bool>(),
        corners in prop::collection::vec([0u32..60, 0u32..60, 0u32..60], 0..400),
        cut in 0.0f64..1.0,
        places in prop::collection::vec([-4i8..4, -4i8..4, -4i8..4], 60),
    ) {
        // Few places on a grid: seams, folds, duplicates and degenerate triangles abound.
        let positions = places.iter().map(|p| p.map(f32::from)).collect();
        let mut data = one_sided_data((positions, corners.into_iter().flatten().collect()));
        let all = data.parts[0].triangle_count;
        let first = (f64::from(all) * cut) as u32;
        data.parts = vec![
            Part { triangle_count: first, ..Part::default() },
            Part { first_triangle: first, triangle_count: all - first, two_sided: true, ..Part::default() },
        ];
        data.deformable = deformable;
        let options = ClusterOptions {
            max_vertices, max_triangles, test_cost, vertex_cost, rounds, sweeps: 5,
            ..ClusterOptions::default()
        };
        let clustering = build(&data, &options).expect("valid");
        check(&data, &clustering, &options);
    }
}
