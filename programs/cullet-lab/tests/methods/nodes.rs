//! Bounds of normals on nodes over clusters: all that a flat sweep culls, and nothing wrong.
//!
//! `cargo test --release -p cullet-lab --test all nodes -- --nocapture` prints what the nodes save.

use std::time::Instant;

use cullet::bounds::Aabb;
use cullet::cull::backface::{ClusterPlanes, EllipticCone};
use cullet::hierarchy::spatial_order;
use cullet::{Mesh, MeshData, Simd};
use cullet_lab::methods::Bulk;
use cullet_lab::methods::cluster::{Bound, ClusterCut, ClusterNodes, NormalCone, join};
use cullet_testkit::models::model;
use cullet_testkit::vectors::{cross, fibonacci, front};
use cullet_testkit::{Rng, at_every_level};

type Corners = [[f32; 3]; 3];

/// Clusters of a bumpy sheet that bends by `bend` radians from end to end, in the order of the
/// sheet.
fn sheet(rng: &mut Rng, count: usize, bend: f64) -> Vec<Vec<Corners>> {
    (0..count)
        .map(|i| {
            let turn = bend * i as f64 / count as f64;
            let middle = [turn.sin() * 20.0, turn.cos() * 20.0, rng.signed() * 5.0];
            (0..rng.index(6))
                .map(|_| {
                    let out = [turn.sin() + rng.signed() * 0.2, turn.cos() + rng.signed() * 0.2];
                    let out = [out[0], out[1], rng.signed() * 0.2];
                    let u = cross(out, [0.0, 0.0, 1.0]);
                    let v = cross(out, u);
                    let at = |a: f64, b: f64| {
                        std::array::from_fn(|k| (middle[k] + u[k] * a + v[k] * b) as f32)
                    };
                    [at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0)]
                })
                .collect()
        })
        .collect()
}

fn bit(mask: &[u64], i: usize) -> bool {
    mask[i / 64] >> (i % 64) & 1 == 1
}

/// Nothing culled faces the eye, nothing taken for front is seen from behind.
fn check_truth(clusters: &[Vec<Corners>], eye: [f64; 4], cut: &ClusterCut) {
    for (i, triangles) in clusters.iter().enumerate() {
        for &corners in triangles {
            let (value, size) = front(corners, eye);
            assert!(!bit(cut.culled(), i) || value <= size * 1e-13, "cluster {i} from {eye:?}");
            assert!(!bit(cut.front(), i) || value >= -size * 1e-13, "cluster {i} from {eye:?}");
        }
    }
}

#[test]
fn nodes_prove_all_that_clusters_do_and_nothing_wrong() {
    let mut rng = Rng(5);
    let mut cut = ClusterCut::new();
    let mut fewer = 0;
    for count in [0, 1, 15, 16, 17, 200, 300, 700] {
        for bend in [0.0, 0.8, 6.0] {
            let clusters = sheet(&mut rng, count, bend);
            let planes: Vec<_> =
                clusters.iter().map(|c| ClusterPlanes::new(c.iter().copied())).collect();
            let nodes = ClusterNodes::<EllipticCone>::fit(&planes);
            assert_eq!((nodes.len(), nodes.is_empty()), (count, count == 0));
            for i in 0..30 {
                let far = 1.0 + 60.0 * rng.signed().abs();
                let d = rng.direction();
                let eye = [d[0] * far, d[1] * far, d[2] * far, f64::from(u8::from(i % 4 != 0))];
                let mut first: Option<[Vec<u64>; 2]> = None;
                at_every_level!(|level| {
                    nodes.cull(level, eye, &mut cut);
                    let masks = [cut.culled().to_vec(), cut.front().to_vec()];
                    assert_eq!(first.get_or_insert_with(|| masks.clone()), &masks, "{level:?}");
                });
                check_truth(&clusters, eye, &cut);
                let mut flat = Vec::new();
                for (bounds, mask) in nodes.clusters().iter().zip([cut.culled(), cut.front()]) {
                    bounds.cull(Simd::best(), eye, &mut flat);
                    for i in (0..count).filter(|&i| bit(&flat, i)) {
                        // An empty cluster has no bound, and goes with its node, whichever way.
                        assert!(bit(mask, i), "cluster {i} of {count}, bend {bend}");
                    }
                }
                fewer += usize::from(cut.blocks_tested() < count.div_ceil(16));
            }
        }
    }
    assert!(fewer > 100, "nodes saved blocks only {fewer} times: the test tests little");
    let nodes = ClusterNodes::<EllipticCone>::fit(&[ClusterPlanes::new([[[0.0; 3]; 3]])]);
    nodes.cull(Simd::best(), [f64::NAN, 0.0, 0.0, 1.0], &mut cut);
    assert_eq!((cut.culled(), cut.front()), (&[0][..], &[0][..]));
}

#[test]
fn joined_planes_are_those_of_all_triangles() {
    let mut rng = Rng(6);
    let clusters = sheet(&mut rng, 12, 0.5);
    let parts: Vec<_> = clusters.iter().map(|c| ClusterPlanes::new(c.iter().copied())).collect();
    let joined = join(&parts);
    let all = ClusterPlanes::new(clusters.iter().flatten().copied());
    assert_eq!((joined.len(), joined.is_complete()), (all.len(), true));
    assert!(joined.radius() >= all.radius() && joined.radius() < all.radius() * 1.000_001);
    for _ in 0..200 {
        let e = rng.vector(1.0).map(|v| v * 50.0);
        let eye = [e[0], e[1], e[2], 1.0];
        assert_eq!(joined.height(eye), all.height(eye));
    }
    assert!(join([]).is_empty());
}

#[test]
fn nodes_on_real_models() {
    println!(
        "{:<28} {:>8} {:>7} {:>9} {:>9} {:>8} {:>8}",
        "clusters, order", "clusters", "culled%", "flat%", "blocks%", "ns", "ns flat"
    );
    for path in ["stanford-bunny/bun_zipper.ply", "armadillo/armadillo.obj"] {
        let Some((positions, indices)) = model(path) else { continue };
        let data = MeshData { positions, indices, ..MeshData::default() };
        let mesh = Mesh::new(data).expect("a good mesh");
        let triangles: Vec<Vec<Corners>> = (mesh.clusters().iter())
            .map(|c| c.first_triangle..c.first_triangle + c.triangle_count)
            .map(|range| range.map(|t| mesh.corners(t)).collect())
            .collect();
        let middles: Vec<_> = (triangles.iter())
            .map(|c| c.iter().flatten().fold(Aabb::EMPTY, |b, &p| b.union(&Aabb::new(p, p))))
            .collect();
        let as_it_is: Vec<u32> = (0..triangles.len() as u32).collect();
        for (name, order) in [("mesh", as_it_is), ("spatial", spatial_order(&middles))] {
            let sorted: Vec<Vec<Corners>> =
                order.iter().map(|&i| triangles[i as usize].clone()).collect();
            measure::<EllipticCone>(&format!("{} {name}", &path[..9]), &mesh, &sorted);
            measure::<NormalCone>(&format!("{} {name}, circles", &path[..9]), &mesh, &sorted);
        }
    }
}

fn measure<B: Bound>(name: &str, mesh: &Mesh, clusters: &[Vec<Corners>]) {
    let planes: Vec<_> = clusters.iter().map(|c| ClusterPlanes::new(c.iter().copied())).collect();
    let nodes = ClusterNodes::<B>::fit(&planes);
    let (centre, half) = (mesh.bounds().center(), mesh.bounds().half_extent());
    let radius = half.iter().map(|v| v * v).sum::<f64>().sqrt();
    let eyes: Vec<[f64; 4]> = (0..50)
        .map(|i| fibonacci(i, 50))
        .map(|d| std::array::from_fn(|k| if k < 3 { centre[k] + d[k] * 3.0 * radius } else { 1.0 }))
        .collect();
    let (mut cut, mut flat) = (ClusterCut::new(), [Vec::new(), Vec::new()]);
    let (mut culled, mut culled_flat, mut blocks) = (0, 0, 0);
    for (i, &eye) in eyes.iter().enumerate() {
        nodes.cull(Simd::best(), eye, &mut cut);
        if i % 10 == 0 {
            check_truth(clusters, eye, &cut);
        }
        culled += cut.culled().iter().map(|w| w.count_ones()).sum::<u32>();
        culled_flat += nodes.clusters()[0].count(Simd::best(), eye) as u32;
        blocks += cut.blocks_tested();
    }
    assert!(culled >= culled_flat && culled > 0);
    let time = |cull: &mut dyn FnMut([f64; 4])| {
        let rounds = (0..9).map(|_| {
            let start = Instant::now();
            eyes.iter().for_each(|&eye| cull(eye));
            start.elapsed().as_nanos() as f64 / eyes.len() as f64
        });
        rounds.fold(f64::INFINITY, f64::min)
    };
    let walked = time(&mut |eye| nodes.cull(Simd::best(), eye, &mut cut));
    let swept = time(&mut |eye| {
        for (bounds, mask) in nodes.clusters().iter().zip(&mut flat) {
            bounds.cull(Simd::best(), eye, mask);
        }
    });
    let share = |n: u32| 100.0 * f64::from(n) / (clusters.len() * eyes.len()) as f64;
    let blocks = 100.0 * blocks as f64 / (clusters.len().div_ceil(16) * eyes.len()) as f64;
    let count = clusters.len();
    println!(
        "{name:<28} {count:>8} {:>7.2} {:>9.2} {blocks:>9.1} {walked:>8.0} {swept:>8.0}",
        share(culled),
        share(culled_flat)
    );
}
