//! Polygons cut by regions, against exact arithmetic, and neighbours against each other.

use cullet::bounds::Plane;
use cullet::{Depth, view::Frustum};
use cullet_draw::clip::{Clipper, GuardBand, HalfSpace, Region, space};
use cullet_testkit::oracles::clip::clip_polygon_ref;
use cullet_testkit::strategies::{number, point};
use proptest::prelude::*;

fn region<const D: usize>(planes: usize) -> impl Strategy<Value = Region<f64, D>> {
    prop::collection::vec((point::<D>(), number()), 0..=planes).prop_map(|sides| {
        Region::new(sides.into_iter().filter_map(|(n, d)| HalfSpace::new(n, d).ok())).unwrap()
    })
}

/// The convex hull of a circle's points, squeezed: a convex polygon in the plane.
fn convex() -> impl Strategy<Value = Vec<[f64; 2]>> {
    (prop::collection::vec(0.0..std::f64::consts::TAU, 3..9), point::<2>(), 0.1..3.0f64).prop_map(
        |(mut angles, centre, size)| {
            angles.sort_by(f64::total_cmp);
            angles.dedup();
            let at = |a: &f64| [centre[0] + a.cos() * size * 1.7, centre[1] + a.sin() * size];
            angles.iter().map(at).collect()
        },
    )
}

fn area(polygon: &[[f64; 2]]) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    polygon.iter().zip(next).map(|(p, q)| p[0] * q[1] - p[1] * q[0]).sum::<f64>() / 2.0
}

/// Twice the vector area.
fn normal(polygon: &[[f64; 3]]) -> [f64; 3] {
    let next = polygon.iter().cycle().skip(1);
    polygon.iter().zip(next).fold([0.0; 3], |n, (p, q)| {
        std::array::from_fn(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            n[i] + p[j] * q[k] - p[k] * q[j]
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cullet_testkit::cases(1500)))]

    #[test]
    fn convex_polygons_are_those_of_exact_arithmetic(polygon in convex(), region in region::<2>(4)) {
        let mut clipper = Clipper::new();
        let cut = clipper.clip(&region, &polygon);
        let exact = clip_polygon_ref(&region.planes(), &polygon);
        prop_assert!((area(cut) - area(&exact)).abs() < 1e-9, "{cut:?} {exact:?}");
        prop_assert!(cut.len() <= polygon.len() + region.sides().count());
        for p in cut {
            for (i, side) in region.sides() {
                prop_assert!(side.height(p) < 1e-9, "plane {i}: {}", side.height(p));
            }
        }
    }

    /// The points are few and whole, so that many heights are exactly zero.
    #[test]
    fn triangles_in_space_are_those_of_exact_arithmetic(
        triangle in prop::array::uniform3(point::<3>()),
        region in region::<3>(4),
    ) {
        let mut clipper = Clipper::new();
        let cut = normal(clipper.clip(&region, &triangle));
        let exact = normal(&clip_polygon_ref(&region.planes(), &triangle));
        for i in 0..3 {
            prop_assert!((cut[i] - exact[i]).abs() < 1e-8, "{cut:?} {exact:?}");
        }
    }

    /// Cutting by both sides of a plane leaves the whole area, whatever is on the plane.
    #[test]
    fn two_halves_make_a_whole(polygon in convex(), n in point::<2>(), d in number()) {
        let (Ok(side), Ok(other)) = (HalfSpace::new(n, d), HalfSpace::new(n.map(|v| -v), -d)) else {
            return Ok(());
        };
        let mut clipper = Clipper::new();
        let halves = [side, other].map(|s| area(clipper.clip(&Region::new([s]).unwrap(), &polygon)));
        prop_assert!((halves[0] + halves[1] - area(&polygon)).abs() < 1e-9);
    }

    /// Both triangles of a shared edge keep the same of it, bit for bit: a point on it has a weight
    /// of exactly 0 for the third corner. Each has its own winding and starts at any corner.
    #[test]
    fn neighbours_agree_about_their_edge(
        [a, b, c, d] in prop::array::uniform4(point::<3>()),
        region in region::<3>(8),
        turn in 0..3usize,
    ) {
        let weighted = |p: [f64; 3], w: f64| [p[0], p[1], p[2], w];
        let on_edge = |mut triangle: [[f64; 4]; 3]| {
            triangle.rotate_left(turn);
            let mut clipper = Clipper::new();
            let cut = clipper.clip(&region, &triangle);
            let mut kept: Vec<_> =
                cut.iter().filter(|v| v[3] == 0.0).map(|v| v.map(f64::to_bits)).collect();
            kept.sort_unstable();
            kept.dedup();
            kept
        };
        let left = on_edge([weighted(a, 0.0), weighted(b, 0.0), weighted(c, 1.0)]);
        let right = on_edge([weighted(b, 0.0), weighted(a, 0.0), weighted(d, 1.0)]);
        // A triangle of which nothing is left has no edge.
        if !left.is_empty() && !right.is_empty() {
            prop_assert_eq!(left, right);
        }
    }

    /// An attribute that is linear in space still is where it was cut.
    #[test]
    fn attributes_follow(triangle in prop::array::uniform3(point::<3>()), region in region::<3>(5)) {
        let linear = |p: &[f64]| 3.0 * p[0] - 2.0 * p[1] + 0.5 * p[2] + 7.0;
        let full = triangle.map(|p| [p[0], p[1], p[2], linear(&p), 1.0]);
        for v in Clipper::new().clip(&region, &full) {
            prop_assert!((v[3] - linear(v)).abs() < 1e-10 && v[4] == 1.0);
        }
    }

    /// Before the divide: what is left is within the volume, has w ≥ 0, and is what exact arithmetic
    /// leaves; a band spares cuts, and adds nothing within the view.
    #[test]
    fn clip_space_is_right_for_any_sign_of_w(
        triangle in prop::array::uniform3(point::<4>()),
        reversed in any::<bool>(),
        wide in 1.0..6.0f64,
    ) {
        let depth = if reversed { Depth::Reversed } else { Depth::Standard };
        let full = space::full::<f64>(depth);
        let mut clipper = Clipper::new();
        let cut = clipper.clip(&full, &triangle).to_vec();
        for p in &cut {
            prop_assert!(p[3] >= -1e-12, "{p:?}");
            for (_, side) in full.sides() {
                prop_assert!(side.height(p) < 1e-11);
            }
        }
        // The area in (x, y, w) is linear in the parts, and has no divide that could hide a mistake.
        let flat = |polygon: &[[f64; 4]]| {
            normal(&polygon.iter().map(|p| [p[0], p[1], p[3]]).collect::<Vec<_>>())
        };
        let [n, m] = [flat(&cut), flat(&clip_polygon_ref(&full.planes(), &triangle))];
        for i in 0..3 {
            prop_assert!((n[i] - m[i]).abs() < 1e-9);
        }
        let band = GuardBand::new(depth, wide).unwrap();
        let spared = band.clip(&mut clipper, &triangle).to_vec();
        let again = flat(clipper.clip(&full, &spared));
        for i in 0..3 {
            prop_assert!((n[i] - again[i]).abs() < 1e-9, "{n:?} {again:?}");
        }
    }
}

#[test]
fn thirty_two_planes_round_off_a_square() {
    let sides = (0..32).map(|i| {
        let (s, c) = (f64::from(i) * std::f64::consts::TAU / 32.0).sin_cos();
        HalfSpace::new([c, s], 1.0).unwrap()
    });
    let square = [[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]];
    let mut clipper = Clipper::new();
    let cut = clipper.clip(&Region::new(sides).unwrap(), &square);
    // The polygon with 32 sides around the unit circle; its four sides on the square's slants too.
    let expected = 32.0 * (std::f64::consts::PI / 32.0).tan();
    assert!((area(cut) - expected).abs() < 1e-12);
}

#[test]
fn a_frustum_is_a_region_with_the_same_numbers() {
    let planes = [None, Some(Plane::new([1.0, 0.0, 0.0], 1.0)), None, None, None, None];
    let mut frustum = Frustum::from_planes(planes);
    frustum.push(Plane::new([0.0, 1.0, 0.0], 2.0)).unwrap();
    let region = Region::<f64, 3>::from(&frustum);
    assert_eq!(region.present(), 0b100_0010);
    assert_eq!(region.outcode(&[2.0, 3.0, 0.0]), 0b100_0010);
}

#[test]
fn a_reentrant_polygon_keeps_its_area() {
    // A comb whose two teeth are cut off from each other: joined by an edge along the plane.
    let comb = [
        [0.0, 0.0],
        [3.0, 0.0],
        [3.0, 2.0],
        [2.0, 2.0],
        [2.0, 1.0],
        [1.0, 1.0],
        [1.0, 2.0],
        [0.0, 2.0],
    ];
    let above = Region::new([HalfSpace::new([0.0, -1.0], -1.5).unwrap()]).unwrap();
    let mut clipper = Clipper::new();
    assert!((area(clipper.clip(&above, &comb)) - 1.0).abs() < 1e-15);
}
