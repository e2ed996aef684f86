//! The hierarchy of joint clusters, held against the triangles and the flat sweep.

use cullet::cull::backface::ClusterPlanes;
use cullet::mesh::Part;
use cullet::{Mesh, MeshData};
use cullet_bake::clusters::{ClusterOptions, build};
use cullet_lab::joint::JointHierarchy;
use cullet_lab::methods::cluster::ClusterFacing;
use cullet_testkit::meshes::one_sided_data;
use cullet_testkit::models::model;
use cullet_testkit::soups::{bumpy_ball, scattered};
use cullet_testkit::vectors::fibonacci;

const DISTANCES: [f64; 4] = [1.5, 2.0, 3.0, 6.0];

fn clustered(data: MeshData) -> Mesh {
    let clustering = build(&data, &ClusterOptions::fast()).expect("valid");
    Mesh::with_clusters(data, &clustering).expect("valid")
}

/// The facing of each cluster by the hierarchy and by the flat sweep, and their counts of tests.
fn both(h: &JointHierarchy, mesh: &Mesh, eye: [f64; 4]) -> ([Vec<ClusterFacing>; 2], [usize; 2]) {
    let run = |flat: bool| {
        let mut facing = vec![None; mesh.clusters().len()];
        let visit = |clusters: &[u32], f: ClusterFacing| {
            for &c in clusters {
                assert_eq!(facing[c as usize].replace(f), None, "cluster {c} comes twice");
            }
        };
        let tests = if flat { h.flat(eye, visit) } else { h.visit(eye, visit) };
        (facing.into_iter().map(|f| f.expect("every cluster comes")).collect(), tests)
    };
    let ((tree, a), (flat, b)) = (run(false), run(true));
    ([tree, flat], [a, b])
}

/// Holds every answer of some eyes against the ideal test; returns the mean counts of tests.
fn check(mesh: &Mesh, distance: f64, views: usize) -> [f64; 2] {
    let h = JointHierarchy::build(mesh, &DISTANCES);
    let planes: Vec<ClusterPlanes> = mesh
        .clusters()
        .iter()
        .map(|c| {
            let range = c.first_triangle..c.first_triangle + c.triangle_count;
            ClusterPlanes::new(range.map(|t| mesh.corners(t)))
        })
        .collect();
    let (centre, half) = (mesh.bounds().center(), mesh.bounds().half_extent());
    let radius = half.iter().map(|h| h * h).sum::<f64>().sqrt();
    let mut sum = [0.0; 2];
    let mut decided = 0;
    for d in (0..views).map(|i| fibonacci(i, views)) {
        let place = |k: usize| centre[k] + d[k] * radius * distance;
        let eye = [place(0), place(1), place(2), 1.0];
        let ([tree, flat], tests) = both(&h, mesh, eye);
        for (c, (t, f)) in tree.iter().zip(&flat).enumerate() {
            match t {
                ClusterFacing::Back => assert!(planes[c].is_behind(eye), "cluster {c}"),
                ClusterFacing::Front => assert!(planes[c].flipped().is_behind(eye), "cluster {c}"),
                ClusterFacing::Mixed => {}
            }
            decided += usize::from(*t != ClusterFacing::Mixed);
            // A cluster that its own bound decides is decided by the hierarchy too, and in the same
            // way.
            assert!(f == t || *f == ClusterFacing::Mixed, "cluster {c}: {t:?}, flat {f:?}");
        }
        sum = [sum[0] + tests[0] as f64, sum[1] + tests[1] as f64];
    }
    assert!(decided > 0);
    sum.map(|s| s / views as f64)
}

#[test]
fn a_ball_takes_fewer_tests_than_a_sweep() {
    let mesh = clustered(one_sided_data(bumpy_ball(60, 0.0)));
    let [tree, flat] = check(&mesh, 3.0, 50);
    let h = JointHierarchy::build(&mesh, &DISTANCES);
    println!("{tree} {flat} {:?} joints {}", h.expected_tests(), h.joint_count());
    assert!(tree < flat * 0.8, "{tree} {flat}");
    assert!(h.joint_count() > 0 && h.expected_tests().0 < h.expected_tests().1 as f64);
    // The measured count meets the expected one.
    let measured: f64 = DISTANCES.iter().map(|d| check(&mesh, *d, 50)[0]).sum::<f64>() / 4.0;
    assert!((measured / h.expected_tests().0 - 1.0).abs() < 0.1, "{measured}");
}

#[test]
fn nodes_that_do_not_pay_are_not_kept() {
    let mut without = 0;
    for triangles in [500, 1000, 2000, 3000] {
        let mesh = clustered(one_sided_data(scattered(triangles)));
        let h = JointHierarchy::build(&mesh, &DISTANCES);
        // In a soup a node pays now and then, by chance, and is then kept; else never.
        let (expected, flat) = h.expected_tests();
        assert_eq!(h.joint_count() > 0, expected < flat as f64, "{expected} {flat}");
        if h.joint_count() == 0 {
            // Without joints it is the flat sweep.
            let ([tree, flat], tests) = both(&h, &mesh, [30.0, 10.0, 0.0, 1.0]);
            assert_eq!((tree, tests[0]), (flat, tests[1]));
            without += 1;
        }
    }
    assert!(without >= 2, "{without}");
}

#[test]
fn what_no_bound_can_decide_is_not_tested() {
    let mut data = one_sided_data(bumpy_ball(24, 0.0));
    let triangles = data.parts[0].triangle_count;
    data.parts = vec![
        Part { triangle_count: 1000, two_sided: true, ..Part::default() },
        Part { first_triangle: 1000, triangle_count: triangles - 1000, ..Part::default() },
    ];
    let mesh = clustered(data.clone());
    let h = JointHierarchy::build(&mesh, &DISTANCES);
    let ([tree, _], _) = both(&h, &mesh, [0.0, 9.0, 0.0, 1.0]);
    for (c, facing) in mesh.clusters().iter().zip(&tree) {
        assert!(c.part == 1 || *facing == ClusterFacing::Mixed);
    }
    assert!(tree.contains(&ClusterFacing::Back) && h.expected_tests().1 < mesh.clusters().len());
    for eye in [[f64::NAN, 0.0, 0.0, 1.0], [0.0, f64::INFINITY, 0.0, 1.0]] {
        let ([tree, flat], _) = both(&h, &mesh, eye);
        assert!(tree.iter().chain(&flat).all(|f| *f == ClusterFacing::Mixed), "{eye:?}");
    }
    data.deformable = true;
    let mesh = clustered(data);
    let h = JointHierarchy::build(&mesh, &[f64::NAN, -1.0]);
    assert_eq!(h.expected_tests(), (0.0, 0));
    let empty = Mesh::new(MeshData::default()).expect("empty");
    assert_eq!(JointHierarchy::build(&empty, &[]).visit([0.0; 4], |c, _| assert!(c.is_empty())), 0);
}

#[test]
fn tests_of_the_shared_models_against_the_sweep() {
    for (name, most) in [("stanford-bunny/bun_zipper.ply", 0.9), ("armadillo/armadillo.obj", 1.02)]
    {
        let Some(data) = model(name).map(one_sided_data) else { continue };
        let [tree, flat] = check(&clustered(data), 3.0, 20);
        println!("{name}: {tree:.1} tests, {flat:.1} flat");
        assert!(tree < flat * most, "{name}: {tree} {flat}");
    }
}
