//! Bounds of clusters: never behind where a triangle is in front, the same answers at every level
//! and from frame to frame.

use cullet::Simd;
use cullet::cull::Indices;
use cullet::cull::backface::{ClusterEye, ClusterPlanes, EllipticCone};
use cullet_lab::methods::Bulk;
use cullet_lab::methods::cluster::{
    Bound, ClusterBounds, ClusterFacing, ClusterTracker, EllipticConeQuantised, NoRegion,
    NormalBox, NormalBoxAtOrigin, NormalBoxTurned, NormalCone, NormalConeCentre, Pyramid, TwoWay,
    region,
};
use cullet_testkit::vectors::{cross, dot, front};
use cullet_testkit::{Rng, at_every_level};

type Triangle = [[f32; 3]; 3];

/// A cluster of one of several kinds, of `size` units around `middle`.
fn cluster(rng: &mut Rng, kind: usize, size: f64, middle: [f64; 3]) -> Vec<Triangle> {
    let axis = rng.direction();
    let u = {
        let v = cross(axis, rng.direction());
        let length = dot(v, v).sqrt().max(1e-3);
        v.map(|x| x / length)
    };
    let v = cross(axis, u);
    // How far normals lean, in radians at the rim.
    let bend = [0.0, 0.3, 0.9, 1.4, 1.0, 0.6, 3.0][kind];
    let count = 1 + rng.index(40);
    let mut triangles = Vec::new();
    for i in 0..count {
        let (x, y) = (rng.signed(), if kind == 5 { rng.signed() * 1e-3 } else { rng.signed() });
        // A cap of a sphere, of a cylinder for kind 4, or a plane.
        let lean = [x * bend, if kind == 4 { 0.0 } else { y * bend }];
        let angle = lean[0].hypot(lean[1]);
        let at = |x: f64, y: f64| -> [f64; 3] {
            let height = if bend == 0.0 {
                0.0
            } else {
                let y = if kind == 4 { 0.0 } else { y };
                ((x * x + y * y) * bend * bend).min(9.8).sqrt().cos() / bend
            };
            std::array::from_fn(|k| u[k] * x + v[k] * y + axis[k] * height)
        };
        let step = [0.05, 0.05, 1e-4, 0.2][rng.index(4)];
        let thin = if i % 7 == 3 { 1e-5 } else { 1.0 };
        let mut corners = [at(x, y), at(x + step, y + step * thin * 0.1), at(x, y + step * thin)];
        if i % 11 == 5 {
            corners[2] = corners[i % 2];
        }
        let n = cross(
            std::array::from_fn(|k| corners[1][k] - corners[0][k]),
            std::array::from_fn(|k| corners[2][k] - corners[0][k]),
        );
        if dot(n, axis) < 0.0 && angle < 1.5 {
            corners.swap(1, 2);
        }
        let triangle = corners.map(|p| std::array::from_fn(|k| (p[k] * size + middle[k]) as f32));
        triangles.push(triangle);
        if i % 13 == 0 {
            triangles.push(triangle);
        }
    }
    triangles
}

/// Points at which a wrong bound would show: around the cluster at every distance, in it, and near
/// the border of the region of the bound `behind`.
fn eyes(
    rng: &mut Rng,
    planes: &ClusterPlanes,
    count: usize,
    behind: &dyn Fn([f64; 4]) -> bool,
) -> Vec<[f64; 4]> {
    let centre = planes.centre();
    let around = |rng: &mut Rng, far: f64| -> [f64; 4] {
        let d = rng.direction();
        let p: [f64; 3] = std::array::from_fn(|k| centre[k] + d[k] * far * planes.radius());
        [p[0], p[1], p[2], 1.0]
    };
    let mut eyes: Vec<[f64; 4]> = Vec::new();
    for i in 0..count {
        let far = [0.3, 0.99, 1.1, 3.0, 20.0, 1e4, 1e7][i % 7] * (1.0 + rng.signed() * 0.1);
        if i % 9 == 0 {
            let d = rng.direction();
            eyes.push([d[0], d[1], d[2], 0.0]);
            continue;
        }
        let eye = around(rng, far);
        eyes.push(eye);
        // Bisection finds the border between two eyes with different answers.
        let mut other = around(rng, far);
        if i % 3 == 0 && behind(eye) != behind(other) {
            let mut one = eye;
            for _ in 0..60 {
                let middle = std::array::from_fn(|k| 0.5 * (one[k] + other[k]));
                if behind(middle) == behind(eye) { one = middle } else { other = middle }
            }
            eyes.extend([one, other]);
        }
    }
    eyes
}

/// One bound of each kind, fitted and tested.
macro_rules! all_bounds {
    ($planes:expr, $each:ident) => {
        $each::<EllipticCone>("elliptic", $planes);
        $each::<EllipticConeQuantised>("elliptic_quantised", $planes);
        $each::<NormalCone>("cone", $planes);
        $each::<NormalConeCentre>("cone around a sphere", $planes);
        $each::<Pyramid<6>>("pyramid6", $planes);
        $each::<Pyramid<8>>("pyramid8", $planes);
        $each::<Pyramid<4>>("pyramid4", $planes);
        $each::<NormalBox>("box", $planes);
        $each::<NormalBoxAtOrigin>("box at origin", $planes);
        $each::<NormalBoxTurned>("box turned", $planes);
    };
}

/// The size, kind, offset and triangles of random clusters.
fn clusters(seed: u64, count: usize) -> Vec<(usize, ClusterPlanes, Vec<Triangle>)> {
    let mut rng = Rng(seed);
    let made = (0..count).map(|i| {
        let size = [1.0, 1e-12, 1e9, 0.01, 1e-25][rng.index(5)];
        let offset = [0.0, 3.0, 100.0, 1e4][rng.index(4)] * size;
        let middle = rng.direction().map(|v| v * offset);
        let triangles = cluster(&mut rng, i % 7, size, middle);
        (i % 7, ClusterPlanes::new(triangles.iter().copied()), triangles)
    });
    made.collect()
}

fn never_wrong<B: Bound>(name: &str, clusters: &[(usize, ClusterPlanes, Vec<Triangle>)]) {
    let mut rng = Rng(99);
    let (mut ideal, mut got, mut front_sure) = (0_u64, 0_u64, 0_u64);
    for (number, (kind, planes, triangles)) in clusters.iter().enumerate() {
        let bound = TwoWay::<B>::fit(planes);
        let behind = |e: [f64; 4]| bound.back.is_some_and(|b| b.is_behind(e));
        for eye in eyes(&mut rng, planes, 1000, &behind) {
            let facing = bound.facing(eye);
            ideal += u64::from(planes.is_behind(eye));
            let sign = match facing {
                ClusterFacing::Mixed => continue,
                ClusterFacing::Back => 1.0,
                ClusterFacing::Front => -1.0,
            };
            got += u64::from(facing == ClusterFacing::Back);
            front_sure += u64::from(facing == ClusterFacing::Front);
            for t in triangles {
                let (value, size) = front(*t, eye);
                assert!(
                    value * sign <= size * 1e-13,
                    "{name}: cluster {number} of kind {kind} from {eye:?}: {facing:?}, {value} of {size}, radius {}",
                    planes.radius()
                );
            }
        }
    }
    println!(
        "{name}: {:.1} % of ideal ({got} of {ideal}), front {front_sure}",
        got as f64 * 100.0 / ideal as f64
    );
    assert!(got * 100 > ideal * 25, "{name}: {got} of {ideal}");
    assert!(front_sure > 0);
}

#[test]
fn no_bound_is_behind_what_is_in_front() {
    let clusters = clusters(5, 105);
    all_bounds!(&clusters, never_wrong);
}

fn same_at_every_level<B: Bound>(name: &str, clusters: &[(usize, ClusterPlanes, Vec<Triangle>)]) {
    let mut rng = Rng(3);
    let fits: Vec<Option<B>> = clusters.iter().map(|(_, p, _)| B::fit(p)).collect();
    let bounds: ClusterBounds<B> = fits.iter().copied().collect();
    assert_eq!(bounds.len(), clusters.len());
    let bad = [[f64::NAN; 4], [0.0; 4], [1.0, 2.0, 3.0, -1.0], [f64::INFINITY, 0.0, 0.0, 1.0]];
    let mut all: Vec<[f64; 4]> = bad.to_vec();
    for (_, planes, _) in clusters.iter().take(40) {
        all.extend(eyes(&mut rng, planes, 20, &|_| false));
    }
    let mut culled_ever = 0;
    for (i, eye) in all.into_iter().enumerate() {
        let single: Vec<bool> =
            fits.iter().map(|b| b.as_ref().is_some_and(|b| b.is_behind(eye))).collect();
        let count = single.iter().filter(|b| **b).count();
        culled_ever += count;
        assert!(i >= bad.len() || count == 0, "{name}: {eye:?} is no eye");
        at_every_level!(|level_name, level| {
            let mut culled = vec![!0; 1000];
            bounds.cull(level, eye, &mut culled);
            assert_eq!(culled.len(), clusters.len().div_ceil(64));
            for i in 0..culled.len() * 64 {
                let bit = culled[i / 64] >> (i % 64) & 1 == 1;
                assert_eq!(bit, i < single.len() && single[i], "{name} {i} at {level_name}");
            }
            assert_eq!(bounds.count(level, eye), count as u64);
            let mut kept = Indices::new();
            bounds.keep(level, eye, &mut kept);
            let expected: Vec<u32> =
                (0..single.len() as u32).filter(|&i| !single[i as usize]).collect();
            assert_eq!(*kept, *expected, "{name} at {level_name}");
        });
    }
    assert!(culled_ever > 100, "{name}");
}

#[test]
fn batches_answer_as_single_bounds_do() {
    let clusters = clusters(8, 131);
    all_bounds!(&clusters, same_at_every_level);
}

fn tracks<B: Bound>(name: &str, clusters: &[(usize, ClusterPlanes, Vec<Triangle>)]) {
    let level = Simd::best();
    let fits: Vec<Option<B>> = clusters.iter().map(|(_, p, _)| B::fit(p)).collect();
    let bounds: ClusterBounds<B> = fits.iter().copied().collect();
    let mut tracker: ClusterTracker<B> = fits.iter().copied().collect();
    let mut rng = Rng(17);
    let mut eye = [3.0, 1.0, -2.0, 1.0];
    let mut heading = rng.direction();
    let (mut looked, mut changes, mut frames) = (0, 0, 0);
    let mut before = vec![0; bounds.len().div_ceil(64)];
    for frame in 0..600 {
        let step = if frame % 100 < 50 { 0.01 } else { 0.0003 };
        if frame % 40 == 0 {
            heading = rng.direction();
        }
        for k in 0..3 {
            eye[k] += heading[k] * step;
        }
        let mut e = eye;
        if frame % 97 == 96 {
            e = [heading[0], heading[1], heading[2], 0.0];
        } else if frame % 97 == 50 {
            e = [f64::NAN; 4];
        }
        let mut expected = Vec::new();
        bounds.cull(level, e, &mut expected);
        let got = tracker.update(level, e).to_vec();
        assert_eq!(got, expected, "{name}, frame {frame}");
        let different = (0..bounds.len() as u32)
            .filter(|&i| (before[i as usize / 64] ^ got[i as usize / 64]) >> (i % 64) & 1 == 1);
        assert_eq!(tracker.changed(), different.collect::<Vec<_>>());
        before = got;
        if tracker.looked_at() < bounds.len() {
            looked += tracker.looked_at();
            changes += tracker.changed().len();
            frames += bounds.len();
        }
    }
    println!("{name}: looked at {:.2} %, changed {changes}", looked as f64 * 100.0 / frames as f64);
    assert!(frames > 500 * bounds.len() && looked * 10 < frames && changes > 0);
}

#[test]
fn tracking_changes_no_answer() {
    let mut rng = Rng(21);
    let made = (0..150).map(|i| {
        let middle = rng.direction();
        let triangles = cluster(&mut rng, i % 5, 0.1, middle);
        (i % 5, ClusterPlanes::new(triangles.iter().copied()), triangles)
    });
    let clusters: Vec<_> = made.collect();
    tracks::<EllipticCone>("elliptic", &clusters);
    tracks::<EllipticConeQuantised>("elliptic_quantised", &clusters);
    tracks::<NormalCone>("cone", &clusters);
    tracks::<Pyramid<6>>("pyramid6", &clusters);
}

#[test]
fn joined_boxes_are_behind_only_where_both_are() {
    let mut rng = Rng(31);
    let (mut both, mut joint) = (0, 0);
    for _ in 0..200 {
        let near = rng.direction();
        let offset = [2.0, 30.0][rng.index(2)];
        let pair = [0, 1].map(|i| {
            let middle = near.map(|v| v * offset + f64::from(i) * 0.5);
            let kind = rng.index(3);
            ClusterPlanes::new(cluster(&mut rng, kind, 1.0, middle))
        });
        let fits = pair.each_ref().map(|p| NormalBox::fit(p).expect("planes"));
        let joined = fits[0].join(&fits[1], near.map(|v| (v * offset) as f32));
        for i in 0..1000 {
            let d = rng.direction();
            let far = [1.0, 3.0, 10.0, 1000.0][i % 4];
            let eye = [0, 1, 2].map(|k: usize| near[k] * offset + d[k] * far);
            let eye = [eye[0], eye[1], eye[2], 1.0];
            let ideal = pair.iter().all(|p| p.is_behind(eye));
            both += u64::from(ideal);
            if joined.is_behind(eye) {
                joint += 1;
                assert!(ideal, "behind the joint bound alone: {eye:?}");
            }
        }
        // The culling volume is the intersection of eight half-spaces.
        for _ in 0..50 {
            let e = rng.vector(1.0).map(|v| v * 40.0);
            let inside = joined.half_spaces().iter().all(|(n, d)| dot(*n, e) < *d);
            let slack = joined.half_spaces().iter().any(|(n, d)| (dot(*n, e) - d).abs() < 1e-4);
            assert!(slack || inside == joined.is_behind([e[0], e[1], e[2], 1.0]));
        }
    }
    println!("joint {joint} of {both}");
    assert!(joint * 10 > both, "joint {joint} of {both}");
}

#[test]
fn invalid_clusters_have_no_bound() {
    let none = ClusterPlanes::new([]);
    let nan = ClusterPlanes::new([[[f32::NAN; 3]; 3]]);
    let huge = ClusterPlanes::new([[[1e20, 0.0, 0.0], [2e20, 0.0, 0.0], [1e20, 1e20, 0.0]]]);
    let up = [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]];
    let both = ClusterPlanes::new([up, [up[0], up[2], up[1]]]);
    let sliver = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 1e-12, 0.0]];
    let doubtful = ClusterPlanes::new([up, sliver]);
    assert!(!doubtful.is_complete() && !nan.is_complete());
    for planes in [&none, &nan, &huge, &both, &doubtful] {
        assert!(EllipticCone::fit(planes).is_none());
        assert!(EllipticConeQuantised::fit(planes).is_none());
        assert!(Pyramid::<6>::fit(planes).is_none());
        assert!(NormalCone::fit(planes).is_none());
        assert!(NormalBoxTurned::fit(planes).is_none());
    }
    for planes in [&none, &nan, &huge, &doubtful] {
        assert!(NormalBox::fit(planes).is_none() && NormalBoxAtOrigin::fit(planes).is_none());
    }
    let small = ClusterPlanes::new([up.map(|p| p.map(|v: f32| v * 1e-32))]);
    assert_eq!(region(&none), Err(NoRegion::Empty));
    assert_eq!(region(&nan), Err(NoRegion::NotCertain));
    assert_eq!(region(&doubtful), Err(NoRegion::NotCertain));
    assert_eq!(region(&both), Err(NoRegion::Hemisphere));
    assert!(matches!(region(&huge), Err(NoRegion::TooLarge { largest, .. }) if largest > 1e20));
    assert!(matches!(region(&small), Err(NoRegion::TooSmall { radius, .. }) if radius > 0.0));
    // Only triangles without area: they reach no bound.
    assert_eq!(region(&ClusterPlanes::new([[up[0]; 3]])), Err(NoRegion::Empty));
    // A triangle without area is no obstacle.
    let flat = ClusterPlanes::new([up, [up[0], up[1], up[1]], [up[0]; 3]]);
    assert!(flat.is_complete() && flat.len() == 1 && EllipticCone::fit(&flat).is_some());
    assert_eq!(region(&flat), Ok(()));
    assert!(ClusterEye::new([1.0, 2.0, 3.0, 0.0]).is_some());
    assert!(ClusterEye::new([1e20, 0.0, 0.0, 1.0]).is_none());
}

#[test]
fn a_flat_cluster_has_nearly_all_of_its_half_space() {
    let up = [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]];
    let planes = ClusterPlanes::new([up]);
    // Three degrees below the plane, from well off.
    let (sine, cosine) = 3.0_f64.to_radians().sin_cos();
    for i in 0..24 {
        let (x, z) = (f64::from(i) * 0.3).sin_cos();
        let eye = [x * cosine * 100.0, -sine * 100.0, z * cosine * 100.0, 1.0];
        assert!(planes.is_behind(eye));
        assert!(EllipticCone::fit(&planes).is_some_and(|b| b.is_behind(eye)));
        assert!(Pyramid::<6>::fit(&planes).is_some_and(|b| b.is_behind(eye)));
        assert!(NormalCone::fit(&planes).is_some_and(|b| b.is_behind(eye)));
        assert!(EllipticConeQuantised::fit(&planes).is_some_and(|b| b.is_behind(eye)), "{i}");
        assert!(NormalBox::fit(&planes).is_some_and(|b| b.is_behind(eye)));
    }
}
