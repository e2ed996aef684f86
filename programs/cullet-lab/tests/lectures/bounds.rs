//! The bound of a cluster, from rules of minimum and maximum to its volume.

use std::collections::BTreeSet;

use cullet::Mesh;
use cullet::cull::backface::ClusterPlanes;
use cullet::mesh::Cluster;
use cullet_bake::clusters::{ClusterOptions, build};
use cullet_lab::methods::cluster::{Bound, CullingRegion, NormalBox, NormalBoxAtOrigin};
use cullet_scenes::knobbly_ball;

use crate::tools::{Vec3, data, dot, fibonacci, percent, told};

/// A ball with knobs, in clusters of 6,912 triangles in all, around a place.
pub(crate) struct Body {
    pub(crate) mesh: Mesh,
    /// The planes of each cluster.
    pub(crate) planes: Vec<ClusterPlanes>,
    centre: Vec3,
    radius: f64,
}

impl Body {
    pub(crate) fn at(place: [f32; 3]) -> Self {
        let (mut positions, indices) = knobbly_ball(24);
        positions.iter_mut().for_each(|p| *p = std::array::from_fn(|k| p[k] + place[k]));
        let data = data((positions, indices), false);
        let clustering = build(&data, &ClusterOptions::fast()).expect("clusters");
        let mesh = Mesh::with_clusters(data, &clustering).expect("a solid");
        let planes = planes_of(&mesh);
        let sphere = cullet::bounds::Sphere::from_points(mesh.positions());
        let (centre, radius) = (sphere.center.map(f64::from), f64::from(sphere.radius));
        Self { mesh, planes, centre, radius }
    }

    /// Eyes in so many directions from each of two distances, 1.5 and 3 radii.
    pub(crate) fn eyes(&self, directions: usize) -> Vec<[f64; 4]> {
        let at = |radii: f64| {
            (0..directions).map(move |i| {
                let d = fibonacci(i, directions).map(|v| v * radii * self.radius);
                [self.centre[0] + d[0], self.centre[1] + d[1], self.centre[2] + d[2], 1.0]
            })
        };
        at(1.5).chain(at(3.0)).collect()
    }

    /// The region of a bound within a box around the body, so many of its radii to each side.
    fn region(&self, bound: &NormalBox, radii: f64) -> CullingRegion {
        let [low, high] =
            [-1.0, 1.0].map(|side| self.centre.map(|v| v + side * radii * self.radius));
        CullingRegion::of_normal_box(bound, low, high)
    }
}

/// The planes of each cluster of a mesh.
pub(crate) fn planes_of(mesh: &Mesh) -> Vec<ClusterPlanes> {
    let of = |c: &Cluster| ClusterPlanes::new(c.triangles().map(|t| mesh.corners(t)));
    mesh.clusters().iter().map(of).collect()
}

fn greatest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(f64::NEG_INFINITY, f64::max)
}

fn least(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(f64::INFINITY, f64::min)
}

fn place([x, y, z, _]: [f64; 4]) -> Vec3 {
    [x, y, z]
}

/// comb(m′, m; e)·v: the largest of each component where e is positive, else the smallest.
fn comb(largest: [f32; 3], smallest: [f32; 3], e: Vec3, v: Vec3) -> f64 {
    (0..3).map(|k| f64::from(if e[k] > 0.0 { largest[k] } else { smallest[k] }) * v[k]).sum()
}

/// Item 47: sums, differences and factors in a maximum; what the engine keeps of a cluster is what
/// the rules ask for.
#[test]
fn rules_of_minimum_and_maximum_hold_of_the_planes_of_clusters() {
    let body = Body::at([0.0; 3]);
    let (mut tried, mut reached) = (0, 0);
    for planes in &body.planes {
        let normals: Vec<(Vec3, f64)> = planes.half_spaces().collect();
        for e in body.eyes(10).into_iter().map(place) {
            // x of a triangle is n·e, y is n·p.
            let x = || normals.iter().map(|(n, _)| dot(*n, e));
            let y = || normals.iter().map(|(_, d)| *d);
            let sum = greatest(x().zip(y()).map(|(x, y)| x + y));
            let difference = greatest(x().zip(y()).map(|(x, y)| x - y));
            let bound = greatest(x()) - least(y());
            assert!(sum <= greatest(x()) + greatest(y()) && difference <= bound);
            reached += usize::from(difference == bound);
            tried += 1;
            for (k, &factor) in e.iter().enumerate() {
                let component = || normals.iter().map(|(n, _)| n[k]);
                let scaled = greatest(component().map(|v| factor * v));
                let of = if factor > 0.0 { greatest(component()) } else { least(component()) };
                assert_eq!(scaled, factor * of);
            }
        }
        // Rounded to the safe side.
        let Some(kept) = NormalBox::fit_at(planes, [0.0; 3]) else { continue };
        for k in 0..3 {
            let component = || normals.iter().map(|(n, _)| n[k]);
            let high = f64::from(kept.largest[k]) - greatest(component());
            let low = least(component()) - f64::from(kept.smallest[k]);
            assert!([high, low].iter().all(|v| (0.0..1e-5).contains(v)), "{high} {low}");
        }
        let below = least(normals.iter().map(|(_, d)| *d)) - f64::from(kept.d);
        assert!((0.0..1e-4).contains(&below), "{below}");
    }
    told(47, &[body.planes.len() as f64, percent(reached, tried), tried as f64]);
}

/// Items 49 and 50: each step to the quicker bound culls a little less and nothing wrongly; 28
/// bytes and the eye's octant are enough for the last.
#[test]
fn each_step_to_a_quicker_bound_culls_less_and_nothing_wrongly() {
    assert_eq!(size_of::<NormalBoxAtOrigin>(), 28);
    let body = Body::at([0.0; 3]);
    let bounds: Vec<Option<NormalBoxAtOrigin>> =
        body.planes.iter().map(NormalBoxAtOrigin::fit).collect();
    let (mut culled, mut engine, mut octants) = ([0; 3], 0, BTreeSet::new());
    let eyes = body.eyes(30);
    for &eye in &eyes {
        let e = place(eye);
        octants.insert(e.map(|v| v > 0.0));
        for (planes, bound) in body.planes.iter().zip(&bounds) {
            let normals: Vec<(Vec3, f64)> = planes.half_spaces().collect();
            let d = least(normals.iter().map(|(_, d)| *d));
            let one = planes.height(eye);
            let two = greatest(normals.iter().map(|(n, _)| dot(*n, e))) - d;
            let each = |k: usize| greatest(normals.iter().map(|(n, _)| e[k] * n[k]));
            let three = each(0) + each(1) + each(2) - d;
            // Upper bounds of each other, but for the last bit.
            assert!(one <= two + 1e-12 && two <= three + 1e-12, "{one} {two} {three}");
            for (count, value) in culled.iter_mut().zip([one, two, three]) {
                *count += usize::from(value < 0.0);
            }
            assert!((one < 0.0) == planes.is_behind(eye) || one.abs() < 1e-9);
            let Some(bound) = bound else { continue };
            let goes = bound.is_behind(eye);
            engine += usize::from(goes);
            assert!(!goes || three < 0.0);
            // The engine's sum is of f32.
            let combined = comb(bound.largest, bound.smallest, e, e) - f64::from(bound.d);
            assert!(combined.abs() <= 1e-5 || goes == (combined < 0.0), "{combined}");
        }
    }
    let [one, two, three] = culled;
    assert!(one > two && two > three && engine <= three && engine * 20 > three * 19);
    assert_eq!(octants.len(), 8);
    // The example of the book: −3.9 and 0.3 against d = −0.1.
    let example =
        NormalBoxAtOrigin { largest: [0.3, 1.0, 0.2], smallest: [-0.3, 0.9, -0.2], d: -0.1 };
    let far = [[2.0, -5.0, 0.0, 1.0], [16.0, -5.0, 0.0, 1.0]].map(|eye| example.is_behind(eye));
    assert_eq!(far, [true, false]);
    let tests = eyes.len() * bounds.len();
    told(49, &[tests, one, two, three, engine].map(|n| n as f64));
    told(50, &[eyes.len(), tests, engine].map(|n| n as f64));
}

/// Items 51 and 56: no culling volume of a cluster is closed, though that of all normals of a solid
/// is; its half-axes end at (d/m, 0, 0) where d and m are above 0; cut to a room it is exactly the
/// share of eyes that cull the cluster.
#[test]
fn culling_volumes_of_clusters_have_no_end_and_are_exact_shares_of_a_room() {
    const POINTS: usize = 4000;
    let body = Body::at([0.0; 3]);
    let is_closed = |bound: &NormalBox| {
        let region = body.region(bound, 64.0);
        !region.is_empty() && region.faces().iter().all(|f| f.half_space.is_some())
    };
    let (mut regions, mut corners, mut open_axes) = (0, 0, 0);
    for planes in &body.planes {
        // Measured from a point well behind all planes, d is positive.
        let Some(apex) = planes.apex(0.0) else { continue };
        let origin = std::array::from_fn(|k| apex.point[k] - apex.axis[k] * planes.radius());
        let Some(bound) = NormalBox::fit_at(planes, origin) else { continue };
        if body.region(&bound, 64.0).is_empty() {
            continue;
        }
        regions += 1;
        assert!(!is_closed(&bound));
        let (d, c) = (f64::from(bound.d), bound.origin.map(f64::from));
        for k in 0..3 {
            for (m, side) in [(bound.largest[k], 1.0), (bound.smallest[k], -1.0)] {
                let m = f64::from(m);
                let leaves = m * side > 0.0;
                // Where the axis leaves the region, or far along it.
                let along = if leaves { d / m } else { side * 1e4 };
                let mut point = c;
                point[k] += along;
                let gaps = bound.half_spaces().map(|(n, d)| dot(n, point) - d);
                let scale = 1e-9 * along.abs().max(1.0);
                let meet = gaps.iter().filter(|gap| gap.abs() <= scale).count();
                assert!(d > 0.0 && gaps.iter().all(|gap| *gap <= scale) && leaves == (meet >= 4));
                corners += usize::from(leaves);
                open_axes += usize::from(!leaves);
            }
        }
    }
    // From the middle of a solid each triangle is seen from behind.
    let all = ClusterPlanes::new((0..body.mesh.triangle_count()).map(|t| body.mesh.corners(t)));
    let whole = NormalBox::fit_at(&all, body.centre).expect("planes");
    let [x, y, z] = body.centre;
    assert!(is_closed(&whole) && whole.is_behind([x, y, z, 1.0]));
    let around = body.region(&whole, 64.0).volume();
    told(51, &[f64::from(regions), corners as f64, open_axes as f64, around]);

    // Points that fill a room of four radii evenly (M. Roberts, *The Unreasonable Effectiveness of
    // Quasirandom Sequences*, 2018): powers of the root of x⁴ = x + 1.
    const ROOT: f64 = 1.220_744_084_605_759_5;
    let eyes: Vec<[f64; 4]> = (1..=POINTS)
        .map(|i| {
            let even = |k: i32| (0.5 + i as f64 / ROOT.powi(k)).fract() * 2.0 - 1.0;
            let at = |k: usize| body.centre[k] + even(k as i32 + 1) * 4.0 * body.radius;
            [at(0), at(1), at(2), 1.0]
        })
        .collect();
    let (mut tried, mut worst, mut most, mut growth) = (0, 0.0f64, 0.0f64, f64::INFINITY);
    for planes in &body.planes {
        let Some(bound) = NormalBox::fit(planes) else { continue };
        let share = body.region(&bound, 4.0).volume() / (8.0 * body.radius).powi(3);
        if share == 0.0 {
            continue;
        }
        let counted = eyes.iter().filter(|eye| bound.is_behind(**eye)).count();
        worst = worst.max((counted as f64 / POINTS as f64 - share).abs());
        most = most.max(share);
        growth = growth.min(body.region(&bound, 16.0).volume() / body.region(&bound, 8.0).volume());
        tried += 1;
    }
    assert!(tried > 20 && worst < 0.02 && growth > 6.0, "{tried} {worst} {growth}");
    told(56, &[f64::from(tried), most * 100.0, worst * 100.0, growth]);
}

/// Item 52: far from the origin nothing is culled but with an origin of the cluster's own, and the
/// octant is that of e − c.
#[test]
fn with_an_origin_of_its_own_a_cluster_needs_the_octant_of_the_vector_from_there() {
    assert_eq!(size_of::<NormalBox>(), 40);
    let body = Body::at([20.0, -12.0, 16.0]);
    let (mut ideal, mut culled, mut as_written, mut wrong) = (0, [0; 3], 0, 0);
    for planes in &body.planes {
        let at_origin = NormalBoxAtOrigin::fit(planes);
        let (middle, best) = (NormalBox::fit(planes), NormalBox::fit_best(planes));
        for eye in body.eyes(40) {
            let behind = planes.is_behind(eye);
            ideal += usize::from(behind);
            let goes = [
                at_origin.is_some_and(|b| b.is_behind(eye)),
                middle.is_some_and(|b| b.is_behind(eye)),
                best.is_some_and(|b| b.is_behind(eye)),
            ];
            for (count, goes) in culled.iter_mut().zip(goes) {
                *count += usize::from(goes);
                assert!(!goes || behind);
            }
            // As written in 2014: the octant is that of e, the vector e − c.
            let Some(bound) = &middle else { continue };
            let e = place(eye);
            let v = std::array::from_fn(|k| e[k] - f64::from(bound.origin[k]));
            let goes = comb(bound.largest, bound.smallest, e, v) < f64::from(bound.d);
            as_written += usize::from(goes);
            wrong += usize::from(goes && !behind);
        }
    }
    let [common, middle, best] = culled;
    assert!(wrong > 0 && common * 2 < middle && best >= middle && middle * 2 > ideal);
    let shares = culled.map(|n| percent(n, ideal));
    told(52, &[&shares[..], &[wrong as f64, as_written as f64]].concat());
}
