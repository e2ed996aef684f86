//! Bounds of clusters on real models: how much of the ideal each finds, and nothing wrong.

use cullet::cull::backface::{ClusterPlanes, EllipticCone};
use cullet::{Mesh, MeshData, Simd};
use cullet_lab::methods::Bulk;
use cullet_lab::methods::cluster::{
    Bound, ClusterBounds, ClusterTracker, EllipticConeQuantised, NormalBox, NormalBoxAtOrigin,
    NormalBoxTurned, NormalCone, Pyramid,
};
use cullet_testkit::models::model;
use cullet_testkit::vectors::{fibonacci, front};

struct Clusters {
    mesh: Mesh,
    planes: Vec<ClusterPlanes>,
    radius: f64,
    centre: [f64; 3],
}

fn clusters(path: &str) -> Option<Clusters> {
    let (positions, indices) = model(path)?;
    let data = MeshData { positions, indices, ..MeshData::default() };
    let mesh = Mesh::new(data).expect("a good mesh");
    let planes = mesh.clusters().iter().map(|c| {
        let end = c.first_triangle + c.triangle_count;
        ClusterPlanes::new((c.first_triangle..end).map(|t| mesh.corners(t)))
    });
    let planes = planes.collect();
    let b = mesh.bounds();
    let centre = b.center();
    let half = b.half_extent();
    let radius = half.iter().map(|v| v * v).sum::<f64>().sqrt();
    Some(Clusters { mesh, planes, radius, centre })
}

/// Share of all triangles that a bound culls, over 100 views at `far` radii, percent; each tenth
/// view checked triangle by triangle.
fn culled<B: Bound>(clusters: &Clusters, far: f64) -> f64 {
    let bounds: ClusterBounds<B> = clusters.planes.iter().map(B::fit).collect();
    share(clusters, far, |eye, words| bounds.cull(Simd::best(), eye, words))
}

fn share(clusters: &Clusters, far: f64, mut cull: impl FnMut([f64; 4], &mut Vec<u64>)) -> f64 {
    let (mut culled, mut words) = (0_u64, vec![0; clusters.planes.len().div_ceil(64)]);
    for i in 0..100 {
        let d = fibonacci(i, 100);
        let p: [f64; 3] =
            std::array::from_fn(|k| clusters.centre[k] + d[k] * far * clusters.radius);
        let eye = [p[0], p[1], p[2], 1.0];
        cull(eye, &mut words);
        for (number, c) in clusters.mesh.clusters().iter().enumerate() {
            if words[number / 64] >> (number % 64) & 1 == 0 {
                continue;
            }
            culled += u64::from(c.triangle_count);
            if i % 10 == 0 {
                for t in c.first_triangle..c.first_triangle + c.triangle_count {
                    let (value, size) = front(clusters.mesh.corners(t), eye);
                    assert!(value <= size * 1e-13, "triangle {t} from {eye:?}: {value}");
                }
            }
        }
    }
    culled as f64 / f64::from(clusters.mesh.triangle_count())
}

fn looked_at<B: Bound>(clusters: &Clusters, step: f64) -> f64 {
    let fits: Vec<Option<B>> = clusters.planes.iter().map(B::fit).collect();
    let bounds: ClusterBounds<B> = fits.iter().copied().collect();
    let mut tracker: ClusterTracker<B> = fits.into_iter().collect();
    let (mut looked, mut expected) = (0, Vec::new());
    const FRAMES: usize = 200;
    for frame in 0..=FRAMES {
        let angle = frame as f64 * step / 3.0;
        let far = 3.0 * clusters.radius;
        let [x, y, z] = clusters.centre;
        let eye = [x + far * angle.cos(), y + 0.2 * far, z + far * angle.sin(), 1.0];
        bounds.cull(Simd::best(), eye, &mut expected);
        assert_eq!(tracker.update(Simd::best(), eye), expected);
        if frame > 0 {
            looked += tracker.looked_at();
        }
    }
    looked as f64 * 100.0 / (FRAMES * clusters.planes.len()) as f64
}

/// Floors, as shares of the ideal in percent: elliptic, pyramid of 6.
fn check(path: &str, elliptic: f64, pyramid: f64) {
    let Some(clusters) = clusters(path) else { return };
    println!("{path}: {} clusters", clusters.planes.len());
    let mut shares = Vec::new();
    for far in [1.1, 3.0, 20.0] {
        let ideal = share(&clusters, far, |eye, words| {
            words.fill(0);
            for (i, p) in clusters.planes.iter().enumerate() {
                words[i / 64] |= u64::from(p.is_behind(eye)) << (i % 64);
            }
        });
        let print = |name: &str, got: f64| {
            println!("  {far:4} {name:20} {got:6.2} % {:6.1} % of ideal", got * 100.0 / ideal);
            got * 100.0 / ideal
        };
        print("ideal", ideal);
        let e = culled::<EllipticCone>(&clusters, far);
        let q = culled::<EllipticConeQuantised>(&clusters, far);
        let share_e = print("elliptic", e);
        print("elliptic_quantised", q);
        let share_p = print("pyramid6", culled::<Pyramid<6>>(&clusters, far));
        shares.push((share_e, share_p, e - q));
        print("pyramid8", culled::<Pyramid<8>>(&clusters, far));
        print("cone", culled::<NormalCone>(&clusters, far));
        print("box turned", culled::<NormalBoxTurned>(&clusters, far));
        print("box", culled::<NormalBox>(&clusters, far));
        let best: ClusterBounds<NormalBox> =
            clusters.planes.iter().map(NormalBox::fit_best).collect();
        let best = share(&clusters, far, |eye, words| best.cull(Simd::best(), eye, words));
        print("box, best of nine", best);
        print("box at origin", culled::<NormalBoxAtOrigin>(&clusters, far));
    }
    for step in [0.003, 0.01, 0.03] {
        let e = looked_at::<EllipticCone>(&clusters, step);
        println!("  {step} radii a frame: elliptic looked at {e:.2} %");
        assert!(e < 5.0 * (step / 0.01), "looked at {e} %");
    }
    // From so near that half of a model is beyond its horizon, apexes cost a point more.
    for ((e, p, lost), room) in shares.into_iter().zip([1.0, 0.0, 0.0]) {
        assert!(e + room >= elliptic && p + room >= pyramid, "{e} and {p} % of the ideal");
        assert!(lost <= 0.3, "rounding loses {lost} points");
    }
}

#[test]
fn bunny() {
    check("stanford-bunny/bun_zipper.ply", 95.0, 95.0);
}

#[test]
fn armadillo() {
    check("armadillo/armadillo.obj", 90.0, 95.0);
}

#[test]
fn buddha() {
    check("happy-buddha/buddha-100k.obj", 90.0, 95.0);
}
