//! Horizons: what is hidden is behind the ellipsoid, exactly; and what is behind it by more than rounding is hidden.

use cullet::bounds::Aabb;
use cullet::cull::horizon::{Ellipsoid, Horizon};
use cullet_testkit::{Rng, cases};

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

fn mix(a: [f64; 3], b: [f64; 3], t: f64) -> [f64; 3] {
    std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t)
}

/// How far the way from `eye` to `point` stays outside of the ellipsoid: its least distance from the centre in space divided by
/// the radii, less 1. The point is hidden where that is not above 0.
fn clearance_ref(radii: [f64; 3], eye: [f64; 3], point: [f64; 3]) -> f64 {
    let scaled = |p: [f64; 3]| -> [f64; 3] { std::array::from_fn(|i| p[i] / radii[i]) };
    let (e, p) = (scaled(eye), scaled(point));
    let d = std::array::from_fn(|i| p[i] - e[i]);
    let nearest = if dot(d, d) > 0.0 { (-dot(e, d) / dot(d, d)).clamp(0.0, 1.0) } else { 0.0 };
    let foot = mix(e, p, nearest);
    dot(foot, foot).sqrt() - 1.0
}

/// The same of whole numbers, in units of which the radii are powers of two: exact.
fn hides_point_ref(radius_bits: [u32; 3], eye: [i64; 3], point: [i64; 3]) -> bool {
    // In units in which the longest radius is its own power of two, and the sphere has radius 2^top.
    let top = *radius_bits.iter().max().unwrap();
    let scaled = |p: [i64; 3]| -> [i128; 3] {
        std::array::from_fn(|i| i128::from(p[i]) << (top - radius_bits[i]))
    };
    let (e, p) = (scaled(eye), scaled(point));
    let dot = |a: [i128; 3], b: [i128; 3]| -> i128 { (0..3).map(|i| a[i] * b[i]).sum() };
    let d = std::array::from_fn(|i| p[i] - e[i]);
    let one = 1_i128 << (2 * top);
    let (above, toward, length) = (dot(e, e) - one, -dot(e, d), dot(d, d));
    if above <= 0 {
        return false;
    }
    // It is in the sphere, or the line passes through the sphere before it reaches the point.
    dot(p, p) <= one || toward >= above && toward * toward >= above * length
}

#[test]
fn points_are_hidden_as_whole_numbers_say() {
    let mut rng = Rng(1);
    let mut counts = [0; 2];
    for _ in 0..cases(400_000) {
        let bits = [(); 3].map(|()| 18 + rng.below(3) as u32);
        let size = f64::from(1 << 20);
        let near = rng.chance(0.5);
        let whole = |v: [f64; 3]| v.map(|c| (c * size) as i64);
        let eye = whole(if near { rng.direction().map(|c| c * 1.02) } else { rng.vector(4.0) });
        let point = whole(rng.vector(if near { 1.0 } else { 3.0 }));
        let real = |v: [i64; 3]| v.map(|c| c as f64);
        let ellipsoid = Ellipsoid::new(bits.map(|b| f64::from(1_u32 << b)));
        let hides = Horizon::from_eye(&ellipsoid, real(eye)).hides_points(&[real(point)]);
        let truth = hides_point_ref(bits, eye, point);
        // Of these numbers hardly any lie within rounding of the border.
        let clearance = clearance_ref(ellipsoid.radii(), real(eye), real(point));
        if hides || clearance < -1e-12 {
            assert_eq!(hides, truth, "{bits:?} {eye:?} {point:?} {clearance:e}");
        }
        counts[usize::from(hides)] += 1;
    }
    assert!(counts.iter().all(|n| *n > cases(400_000) / 10), "{counts:?}");
}

/// The eye is at 5/4 over a pole, and the cone has sides of 3 to 4: of any f64 numbers the exact answer is 3 x ≤ 4 (5/4 − z).
#[test]
fn points_within_rounding_of_the_cone_are_never_hidden_in_front_of_it() {
    let mut rng = Rng(2);
    let (mut hidden, mut kept) = (0, 0);
    for round in 0..cases(400_000) {
        let z = -rng.range(0.0, 2.0) * 10_f64.powf(rng.range(-3.0, 3.0));
        let mut x: f64 = (5.0 - 4.0 * z) / 3.0;
        for _ in 0..rng.below(30) {
            x = if rng.chance(0.5) { x.next_up() } else { x.next_down() };
        }
        if rng.chance(0.2) {
            x *= 1.0 - rng.range(0.0, 1e-13);
        }
        // 5 − 4 z − 3 x, of which the sign is exact: error-free sums, from the largest.
        let (p, tail) = cullet::math::two_product(3.0, x);
        let (s, t) = cullet::math::two_sum(-4.0 * z, -p);
        let (s, t2) = cullet::math::two_sum(s, 5.0);
        let exact = s + (t + t2 - tail);
        let (axis, aside) = (round as usize % 3, (round as usize + 1 + rng.index(2)) % 3);
        let mut radii = [1.0, 2.0, 0.5];
        radii.rotate_left(rng.index(3));
        let place = |along: f64, across: f64| {
            let mut p = [0.0; 3];
            p[axis] = along * radii[axis];
            p[aside] += if aside == axis { 0.0 } else { across * radii[aside] };
            p
        };
        if aside == axis {
            continue;
        }
        let horizon = Horizon::from_eye(&Ellipsoid::new(radii), place(1.25, 0.0));
        if horizon.hides_points(&[place(z, x)]) {
            assert!(exact >= 0.0, "{x} {z} is before the cone by {exact:e}");
            hidden += 1;
        } else {
            assert!(exact < 1e-13 * (1.0 + z.abs()), "{x} {z} is behind the cone by {exact:e}");
            kept += 1;
        }
    }
    assert!(hidden > 1000 && kept > 1000, "{hidden} {kept}");
}

/// A globe, an eye above it, and something near or beyond its horizon.
struct Case {
    ellipsoid: Ellipsoid,
    eye: [f64; 3],
    centre: [f64; 3],
    size: f64,
}

impl Case {
    fn random(rng: &mut Rng) -> Self {
        let ellipsoid = match rng.below(3) {
            0 => Ellipsoid::WGS84,
            1 => Ellipsoid::new([6e6; 3]),
            _ => Ellipsoid::new([(); 3].map(|()| rng.range(4e6, 9e6))),
        };
        let radii = ellipsoid.radii();
        let up = rng.direction();
        let height = 10_f64.powf(rng.range(-7.0, 1.0));
        let eye = std::array::from_fn(|i| up[i] * radii[i] * (1.0 + height));
        // Some way around the globe, of the size of the way to the horizon.
        let way = 2.0 * (2.0 * height).sqrt().min(2.0) * rng.unit();
        let aside = rng.direction();
        let turned: [f64; 3] = std::array::from_fn(|i| up[i] + way * aside[i]);
        let length = dot(turned, turned).sqrt();
        let level = 1.0 + height * rng.range(-0.5, 0.5);
        let centre = std::array::from_fn(|i| turned[i] / length * radii[i] * level);
        Self { ellipsoid, eye, centre, size: radii[0] * height.min(1.0) * rng.unit() }
    }
}

fn corner(min: [f64; 3], max: [f64; 3], i: usize) -> [f64; 3] {
    std::array::from_fn(|a| if i >> a & 1 == 0 { min[a] } else { max[a] })
}

#[test]
fn boxes_are_hidden_where_all_of_their_points_are_and_only_there() {
    let mut rng = Rng(3);
    let mut counts = [0; 2];
    for _ in 0..cases(100_000) {
        let Case { ellipsoid, eye, centre, size } = Case::random(&mut rng);
        let half: [f64; 3] = [(); 3].map(|()| size * rng.unit());
        let min = std::array::from_fn(|a| centre[a] - half[a]);
        let max = std::array::from_fn(|a| centre[a] + half[a]);
        let horizon = Horizon::from_eye(&ellipsoid, eye);
        let hides = horizon.hides_box(min, max);
        let clear = |p| clearance_ref(ellipsoid.radii(), eye, p);
        // Any points of the box, with its corners, edges and faces.
        for _ in 0..40 {
            let t = [(); 3].map(|()| match rng.below(4) {
                0 => 0.0,
                1 => 1.0,
                _ => rng.unit(),
            });
            let p = std::array::from_fn(|a| min[a] + (max[a] - min[a]) * t[a]);
            assert!(!hides || clear(p) < 1e-14, "{p:?} is seen by {:e}", clear(p));
        }
        let worst = (0..8).map(|i| clear(corner(min, max, i))).fold(f64::MIN, f64::max);
        // The oracle's own rounding is about 1e-15 of the radius, a nanometre on the earth.
        assert!(hides || worst > -1e-14, "all corners are behind by {worst:e}");
        let corners: [[f64; 3]; 8] = std::array::from_fn(|i| corner(min, max, i));
        assert_eq!(horizon.hides_points(&corners), hides);
        counts[usize::from(hides)] += 1;
    }
    assert!(counts.iter().all(|n| *n > cases(100_000) / 5), "{counts:?}");
}

#[test]
fn spheres_are_hidden_where_all_of_their_points_are_and_not_far_from_only_there() {
    let mut rng = Rng(4);
    let (mut hidden, mut sharp, mut within_flattening) = (0, 0, 0);
    for _ in 0..cases(40_000) {
        let Case { ellipsoid, eye, centre, size } = Case::random(&mut rng);
        let radius = size * rng.unit();
        let radii = ellipsoid.radii();
        let horizon = Horizon::from_eye(&ellipsoid, eye);
        let hides = horizon.hides_sphere(centre, radius);
        // Points of the sphere: any, and those that look most out of the shadow in a few steps uphill.
        let at = |u: [f64; 3]| -> f64 {
            let length = dot(u, u).sqrt();
            clearance_ref(radii, eye, std::array::from_fn(|a| centre[a] + u[a] / length * radius))
        };
        let mut worst = f64::MIN;
        for _ in 0..4 {
            let (mut u, mut step) = (rng.direction(), 1.0);
            let mut best = at(u);
            for _ in 0..60 {
                let aside = rng.direction();
                let to = std::array::from_fn(|a| u[a] + step * aside[a]);
                let there = at(to);
                if there > best {
                    (u, best) = (to, there);
                } else {
                    step *= 0.9;
                }
            }
            worst = worst.max(best);
        }
        assert!(!hides || worst < 1e-14, "a point is seen by {worst:e}");
        hidden += u32::from(hides);
        // Larger by the flattening, as it is taken; in space divided by the radii, its points stand apart by some 1 % at most.
        let [low, high] = [f64::min, f64::max].map(|f| radii.into_iter().reduce(f).unwrap());
        let grown = radius * (1.02 * high / low - 1.0) / low;
        if worst < -grown - 1e-14 {
            assert!(hides, "all points are behind by {:e}", -worst);
            sharp += 1;
        }
        within_flattening += u32::from(!hides && worst < 0.0);
    }
    let all = cases(40_000);
    assert!(hidden > all / 5 && sharp > all / 5, "{hidden} {sharp}");
    assert!(within_flattening < all / 10, "{within_flattening}");
}

#[test]
fn what_is_under_the_surface_is_hidden_before_the_horizon_too() {
    let horizon = Horizon::from_eye(&Ellipsoid::new([1.0; 3]), [0.0, 0.0, 3.0]);
    assert!(horizon.hides_box([-0.3; 3], [0.3, 0.3, 0.9]));
    assert!(!horizon.hides_box([-0.3; 3], [0.3, 0.3, 1.0]));
    assert!(horizon.hides_sphere([0.0, 0.0, 0.5], 0.49));
    assert!(!horizon.hides_sphere([0.0, 0.0, 0.5], 0.51));
    // In the cone, and before the cap.
    assert!(!horizon.hides_sphere([0.0, 0.0, 2.0], 0.01));
    assert!(!horizon.hides_points(&[[0.0, 0.0, 1.001]]));
    // Behind the eye.
    assert!(!horizon.hides_points(&[[0.0, 0.0, 5.0]]));
    assert!(!horizon.hides_sphere([0.0, 0.0, 9.0], 1.0));
}

#[test]
fn doubt_keeps() {
    let one = Ellipsoid::new([1.0; 3]);
    let behind = ([-0.1, -0.1, -3.0], [0.1, 0.1, -2.0]);
    let hides = |ellipsoid: &Ellipsoid, eye| {
        let horizon = Horizon::from_eye(ellipsoid, eye);
        horizon.hides_box(behind.0, behind.1)
            || horizon.hides_sphere([0.0, 0.0, -3.0], 0.0)
            || horizon.hides_occlusion_point([0.0, 0.0, -3.0])
            || horizon.hides_points(&[[0.0, 0.0, -3.0]])
    };
    assert!(hides(&one, [0.0, 0.0, 2.0]));
    // In, on and just over the surface, and nowhere.
    for z in [0.0, 0.5, 1.0, 1_f64.next_up(), f64::NAN, f64::INFINITY, 1e300] {
        assert!(!hides(&one, [0.0, 0.0, z]), "{z}");
    }
    for r in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        for radii in [[r, 1.0, 1.0], [1.0, r, 1.0], [1.0, 1.0, r]] {
            assert!(!hides(&Ellipsoid::new(radii), [0.0, 0.0, 2.0]), "{radii:?}");
        }
    }
    let horizon = Horizon::from_eye(&one, [0.0, 0.0, 2.0]);
    for odd in [f64::NAN, f64::INFINITY, -f64::INFINITY, 1e200, -1e308] {
        assert!(!horizon.hides_box([-0.1, odd, -3.0], [0.1, 0.1, -2.0]));
        assert!(!horizon.hides_box([-0.1, -0.1, -3.0], [odd, 0.1, -2.0]));
        assert!(!horizon.hides_sphere([0.0, odd, -2.0], 0.1));
        assert!(!horizon.hides_points(&[[odd, 0.0, -2.0]]));
        assert!(!horizon.hides_occlusion_point([0.0, odd, odd]));
    }
    for radius in [f64::NAN, f64::INFINITY, -1.0, -1e-9] {
        assert!(!horizon.hides_sphere([0.0, 0.0, -3.0], radius), "{radius}");
    }
    assert!(!horizon.hides_points(&[]));
    let mut kept = vec![7; 9];
    horizon.keep_boxes([0.0; 3], &[], &mut kept);
    assert!(kept.is_empty());
    let odd = Aabb::new([f32::NAN, -0.1, -3.0], [0.1, 0.1, -2.0]);
    horizon.keep_boxes([0.0; 3], &[odd], &mut kept);
    assert_eq!(kept, [1]);
}

#[test]
fn masks_say_of_each_box_what_is_said_of_it_alone() {
    let mut rng = Rng(5);
    let horizon = Horizon::from_eye(&Ellipsoid::WGS84, [6.4e6, 0.0, 0.0]);
    let origin = [6.37e6, 1e5, 0.0];
    let boxes: Vec<Aabb> = (0..1000)
        .map(|_| {
            let low = rng.vector(1e6).map(|c| c as f32);
            Aabb::new(low, std::array::from_fn(|a| low[a] + 1000.0))
        })
        .collect();
    let mut kept = Vec::new();
    horizon.keep_boxes(origin, &boxes, &mut kept);
    assert_eq!(kept.len(), 16);
    let mut count = 0;
    for (i, b) in boxes.iter().enumerate() {
        let [min, max] =
            [b.min, b.max].map(|c| std::array::from_fn(|a| origin[a] + f64::from(c[a])));
        let is_kept = kept[i / 64] >> (i % 64) & 1 == 1;
        assert_eq!(is_kept, !horizon.hides_box(min, max), "box {i}");
        count += u32::from(is_kept);
    }
    assert!((100..900).contains(&count), "{count}");
    assert_eq!(kept[15] >> (1000 - 15 * 64), 0, "no bits past the last box");
}

/// The example in the documentation of `EllipsoidalOccluder` of `CesiumJS`, and its test of scaled points.
#[test]
fn occlusion_points_are_hidden_as_in_cesium() {
    let radii = [1.0, 1.1, 0.9];
    let eye = [0.0, 0.0, 2.5];
    let horizon = Horizon::from_eye(&Ellipsoid::new(radii), eye);
    let scaled = |p: [f64; 3]| std::array::from_fn(|a| p[a] / radii[a]);
    assert!(!horizon.hides_occlusion_point(scaled([0.0, -3.0, -3.0])));
    assert!(horizon.hides_occlusion_point(scaled([0.0, -0.3, -3.0])));
    let e: [f64; 3] = scaled(eye);
    let mut rng = Rng(6);
    for _ in 0..cases(100_000) {
        let p = rng.vector(4.0);
        let d = std::array::from_fn(|a| p[a] - e[a]);
        let (above, toward) = (dot(e, e) - 1.0, -dot(d, e));
        let is_occluded = toward > above && toward * toward / dot(d, d) > above;
        // Its points lie above the ground; of those below, it hides only those past the plane.
        let is_close =
            clearance_ref(radii, eye, std::array::from_fn(|a| p[a] * radii[a])).abs() < 1e-12;
        if dot(p, p) > 1.0 && !is_close {
            assert_eq!(horizon.hides_occlusion_point(p), is_occluded, "{p:?}");
        }
    }
}

#[test]
fn a_lowered_ellipsoid_stays_below_all_ground_of_that_depth() {
    for (ellipsoid, depth) in [(Ellipsoid::WGS84, 500.0), (Ellipsoid::new([10.0, 6.0, 4.0]), 0.5)] {
        let (radii, low) = (ellipsoid.radii(), ellipsoid.lowered(depth).radii());
        let mut rng = Rng(7);
        for _ in 0..cases(100_000) {
            let u = rng.direction();
            // A point of the surface and the normal there, and the point at that depth below it.
            let p: [f64; 3] = std::array::from_fn(|a| u[a] * radii[a]);
            let n: [f64; 3] = std::array::from_fn(|a| u[a] / radii[a]);
            let length = dot(n, n).sqrt();
            let ground: [f64; 3] = std::array::from_fn(|a| p[a] - n[a] / length * depth);
            let scaled: [f64; 3] = std::array::from_fn(|a| ground[a] / low[a]);
            assert!(dot(scaled, scaled) >= 1.0, "{u:?}: {:e}", dot(scaled, scaled) - 1.0);
        }
    }
    assert_eq!(Ellipsoid::WGS84.lowered(-1.0), Ellipsoid::WGS84);
}

/// `cullet/tiles` of the npm package has the same tests in JavaScript, operation by operation: `bindings/web/test/tiles/horizon.test.mjs`
/// has these numbers, too.
#[test]
fn answers_are_those_of_the_npm_package() {
    let mut state = 1_u32;
    let mut unit = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state) / 4_294_967_296.0
    };
    let [a, b, c] = Ellipsoid::WGS84.lowered(500.0).radii();
    let (mut hash, mut counts) = (0_u32, [0; 3]);
    for round in 0..20_000 {
        let height = 0.5_f64.powi(round % 24);
        let horizon = Horizon::from_eye(
            &Ellipsoid::new([a, b, c]),
            [a * (1.0 + height), b * (unit() * 1e-9), 0.0],
        );
        let width = (2.0 * height).sqrt() * 3.0;
        let (y, z, level) =
            (width * (unit() - 0.5), width * (unit() - 0.5), height * (unit() - 0.5));
        let centre = [a * (1.0 - (y * y + z * z) * 0.5 + level), b * y, c * z];
        let size = a * width * unit() * 0.2;
        let points: [[f64; 3]; 8] = std::array::from_fn(|_| {
            std::array::from_fn(|axis| centre[axis] + size * (unit() - 0.5))
        });
        let radius = size * unit() * 0.1;
        // A horizon occlusion point above the tile's middle, made for the ellipsoid that is not lowered.
        let above = 1.0 + height * unit();
        let radii = Ellipsoid::WGS84.radii();
        let tile = std::array::from_fn(|axis| centre[axis] / radii[axis] * above);
        let tile = Ellipsoid::WGS84.lowered_occlusion_point(500.0, tile);
        let hidden = [
            horizon.hides_points(&points),
            horizon.hides_sphere(centre, radius),
            tile.is_some_and(|tile| horizon.hides_occlusion_point(tile)),
        ]
        .map(u32::from);
        counts = std::array::from_fn(|k| counts[k] + hidden[k]);
        let bits = hidden[0] + 2 * hidden[1] + 4 * hidden[2];
        hash = hash.wrapping_mul(31).wrapping_add(bits);
    }
    assert_eq!((hash, counts), (1_527_419_774, [1058, 4190, 605]));
}
