//! Horizon occlusion points: where one is hidden, all that it stands for is; and it is no higher than that takes.

use cullet::cull::horizon::{Ellipsoid, Horizon};
use cullet_testkit::{Rng, cases};

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

fn scale(a: [f64; 3], by: f64) -> [f64; 3] {
    a.map(|c| c * by)
}

fn divide(p: [f64; 3], radii: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| p[i] / radii[i])
}

fn multiply(p: [f64; 3], radii: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| p[i] * radii[i])
}

/// Whether the way between two whole points meets the ball of radius 2^20: exact. The eye is outside of it.
fn meets_ball_ref(eye: [i64; 3], point: [i64; 3]) -> bool {
    let dot = |a: [i64; 3], b: [i64; 3]| -> i128 {
        (0..3).map(|i| i128::from(a[i]) * i128::from(b[i])).sum()
    };
    let d = std::array::from_fn(|i| point[i] - eye[i]);
    let one = 1_i128 << 40;
    let (above, toward, length) = (dot(eye, eye) - one, -dot(eye, d), dot(d, d));
    assert!(above > 0);
    dot(point, point) <= one || toward >= above && toward * toward >= above * length
}

/// How far the way from `eye` to `point` stays outside of the ellipsoid: its least distance from the centre in space divided
/// by the radii, less 1.
fn clearance_ref(radii: [f64; 3], eye: [f64; 3], point: [f64; 3]) -> f64 {
    let (e, p) = (divide(eye, radii), divide(point, radii));
    let d: [f64; 3] = std::array::from_fn(|i| p[i] - e[i]);
    let nearest = if dot(d, d) > 0.0 { (-dot(e, d) / dot(d, d)).clamp(0.0, 1.0) } else { 0.0 };
    let foot: [f64; 3] = std::array::from_fn(|i| e[i] + d[i] * nearest);
    dot(foot, foot).sqrt() - 1.0
}

/// The angle of a point's cone around `axis`, for points of balls of `radius` on a ball of ground `level`: by the angles
/// themselves.
fn angle_ref(axis: [f64; 3], points: &[[f64; 3]], radius: f64, level: f64) -> f64 {
    let cone = |p: &[f64; 3]| {
        let distance = dot(*p, *p).sqrt();
        if distance <= level - radius {
            return 0.0;
        }
        let beside = dot(*p, axis) / (distance * dot(axis, axis).sqrt());
        ((level - radius) / distance).min(1.0).acos() + beside.clamp(-1.0, 1.0).acos()
    };
    points.iter().map(cone).fold(0.0, f64::max) + level.acos()
}

/// Points of the size of a tile, on and over a ball with radii of 1.
fn tile(rng: &mut Rng) -> Vec<[f64; 3]> {
    let middle = rng.direction();
    let size = 10_f64.powf(rng.range(-5.0, 0.3));
    let height = 10_f64.powf(rng.range(-7.0, 0.0));
    (0..1 + rng.below(12))
        .map(|_| {
            let aside = rng.vector(size);
            let p: [f64; 3] = std::array::from_fn(|i| middle[i] + aside[i]);
            scale(p, (1.0 + height * rng.unit()) / dot(p, p).sqrt())
        })
        .collect()
}

#[test]
fn points_are_hidden_where_their_occlusion_point_is_as_whole_numbers_say() {
    let mut rng = Rng(1);
    let size = f64::from(1 << 20);
    let whole = |v: [f64; 3]| v.map(|c| (c * size) as i64);
    let real = |v: [i64; 3]| v.map(|c| c as f64);
    let (mut hidden, mut both, mut all) = (0, 0, 0);
    for _ in 0..cases(40_000) {
        let points: Vec<[i64; 3]> = tile(&mut rng).into_iter().map(whole).collect();
        let reals: Vec<[f64; 3]> = points.iter().map(|p| real(*p)).collect();
        let ball = Ellipsoid::new([size; 3]);
        let Some(point) = ball.occlusion_point(0.0, &reals, 0.0) else { continue };
        for _ in 0..8 {
            // Near the way from the point past its horizon, where answers change.
            let eye = whole(eye_behind(&mut rng, point));
            let is_outside = dot(real(eye), real(eye)) > size * size * 1.000_001;
            if !is_outside {
                continue;
            }
            let hides = Horizon::from_eye(&ball, real(eye)).hides_occlusion_point(point);
            let truth = points.iter().all(|p| meets_ball_ref(eye, *p));
            assert!(!hides || truth, "{points:?} from {eye:?}, {point:?}");
            hidden += u32::from(hides);
            both += u32::from(truth);
            all += 1;
        }
    }
    // A few points leave more hidden than a cone around them: 0.53 of it is found.
    assert!(hidden * 10 > all * 3 && hidden * 2 > both, "{hidden} of {both} of {all}");
}

/// An eye on the side of the cone of `point` that touches the unit ball, or a little beside it.
fn eye_behind(rng: &mut Rng, point: [f64; 3]) -> [f64; 3] {
    let distance = dot(point, point).sqrt();
    let axis = scale(point, 1.0 / distance);
    let any = rng.direction();
    let along = dot(any, axis);
    let aside: [f64; 3] = std::array::from_fn(|i| any[i] - along * axis[i]);
    let aside = scale(aside, 1.0 / dot(aside, aside).sqrt());
    // The touched point, and on from there.
    let cosine = 1.0 / distance;
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let far = 10_f64.powf(rng.range(-4.0, 0.5));
    let beside = if rng.chance(0.5) { rng.range(-0.3, 0.3) } else { rng.range(-1e-5, 1e-5) };
    std::array::from_fn(|i| {
        let touched = axis[i] * cosine + aside[i] * sine;
        let on = aside[i] * cosine - axis[i] * sine;
        touched * (1.0 + beside * far) + on * far
    })
}

/// A globe with ground below it, and a body on it, in space divided by the radii.
struct Case {
    ellipsoid: Ellipsoid,
    depth: f64,
    level: f64,
    points: Vec<[f64; 3]>,
    radius: f64,
    point: [f64; 3],
}

impl Case {
    fn random(rng: &mut Rng) -> Option<Self> {
        let ellipsoid = match rng.below(3) {
            0 => Ellipsoid::WGS84,
            1 => Ellipsoid::new([6e6; 3]),
            _ => Ellipsoid::new([(); 3].map(|()| rng.range(4e6, 9e6))),
        };
        let radii = ellipsoid.radii();
        let shortest = radii.into_iter().fold(f64::INFINITY, f64::min);
        let depth = if rng.chance(0.4) { 0.0 } else { 10_f64.powf(rng.range(0.0, 5.5)) };
        let level = if depth == 0.0 { 1.0 } else { 1.0 - depth / shortest };
        // Of ground that is low, some points are low.
        let low = 1.0 - (1.0 - level) * rng.unit();
        let points: Vec<[f64; 3]> = tile(rng)
            .into_iter()
            .map(|p| multiply(if rng.chance(0.5) { scale(p, low) } else { p }, radii))
            .collect();
        let radius = if rng.chance(0.5) { 0.0 } else { 10_f64.powf(rng.range(0.0, 6.0)) };
        let point = ellipsoid.occlusion_point(depth, &points, radius)?;
        Some(Self { ellipsoid, depth, level, points, radius, point })
    }

    /// Any point of the body.
    fn any(&self, rng: &mut Rng) -> [f64; 3] {
        let mut p = self.points[rng.index(self.points.len())];
        if rng.chance(0.5) {
            let q = self.points[rng.index(self.points.len())];
            let t = rng.unit();
            p = std::array::from_fn(|i| p[i] + (q[i] - p[i]) * t);
        }
        let u = rng.direction();
        std::array::from_fn(|i| p[i] + u[i] * self.radius)
    }
}

#[test]
fn no_part_of_a_body_is_seen_where_its_point_is_hidden() {
    let mut rng = Rng(2);
    let (mut hidden, mut nearly) = (0, 0);
    for _ in 0..cases(40_000) {
        let Some(case) = Case::random(&mut rng) else { continue };
        let radii = case.ellipsoid.radii();
        let ground = case.ellipsoid.lowered(case.depth).radii();
        for _ in 0..6 {
            let eye = multiply(eye_behind(&mut rng, case.point), radii);
            let horizon = Horizon::from_eye(&case.ellipsoid, eye);
            if !horizon.hides_occlusion_point(case.point) {
                continue;
            }
            hidden += 1;
            for _ in 0..12 {
                let p = case.any(&mut rng);
                let clear = clearance_ref(ground, eye, p);
                assert!(clear < 1e-14, "{p:?} is seen from {eye:?} by {clear:e}");
                nearly += u32::from(clear > -1e-3);
            }
        }
    }
    assert!(hidden > cases(40_000) && nearly > cases(40_000), "{hidden} {nearly}");
}

#[test]
fn points_are_no_higher_than_their_angles_say() {
    let mut rng = Rng(3);
    let mut count = 0;
    for _ in 0..cases(40_000) {
        let Some(case) = Case::random(&mut rng) else { continue };
        let radii = case.ellipsoid.radii();
        let shortest = radii.into_iter().fold(f64::INFINITY, f64::min);
        let scaled: Vec<[f64; 3]> = case.points.iter().map(|p| divide(*p, radii)).collect();
        let angle = angle_ref(case.point, &scaled, case.radius / shortest, case.level);
        let found = dot(case.point, case.point).sqrt().recip().acos();
        // The bound of rounding is an angle of two metres where the body is on the ground, and less above it.
        assert!(found > angle - 1e-7 && found < angle + 2e-7, "{found} {angle}");
        count += 1;
    }
    assert!(count > cases(40_000) / 2, "{count}");
}

#[test]
fn a_point_above_a_point_is_that_point() {
    for height in [0.1, 1.0, 5.0] {
        let p = [0.0, (1.0 + height) * 2.0, 0.0];
        let ellipsoid = Ellipsoid::new([1.0, 2.0, 3.0]);
        let point = ellipsoid.occlusion_point(0.0, &[p], 0.0).unwrap();
        let off = point[1] - (1.0 + height);
        assert!(point[0] == 0.0 && point[2] == 0.0 && off > 0.0 && off < 1e-12, "{point:?}");
    }
    // Two points above the surface at right angles, each with a cap of 30°: the point between has one of 75°.
    let height = 1.0 / 30_f64.to_radians().cos();
    let two = [[height, 0.0, 0.0], [0.0, height, 0.0]];
    let point = Ellipsoid::new([1.0; 3]).occlusion_point(0.0, &two, 0.0).unwrap();
    let expected = 0.5_f64.sqrt() / 75_f64.to_radians().cos();
    assert!((point[0] - expected).abs() < 1e-11 && point[0] == point[1], "{point:?} {expected}");
    // As far above the surface as it is below the other side of the touching plane, there is none.
    assert_eq!(
        Ellipsoid::new([1.0; 3]).occlusion_point(0.0, &[[-1.0, 0.0, 0.0], [1.2, 0.0, 0.0]], 0.0),
        None
    );
}

#[test]
fn lowered_points_hide_less_and_all_that_they_stand_for() {
    let mut rng = Rng(4);
    let (mut hidden, mut kept, mut same) = (0, 0, 0);
    for _ in 0..cases(20_000) {
        let Some(case) = Case::random(&mut rng) else { continue };
        let lower = case.depth.max(1.0) * rng.range(0.0, 4.0);
        let ground = case.ellipsoid.lowered(lower);
        let Some(point) = case.ellipsoid.lowered_occlusion_point(lower, case.point) else {
            continue;
        };
        let as_placed = multiply(point, ground.radii());
        assert!(dot(point, point) > 1.0 && dot(as_placed, case.point) > 0.0);
        for _ in 0..6 {
            let eye = multiply(eye_behind(&mut rng, point), ground.radii());
            if !Horizon::from_eye(&ground, eye).hides_occlusion_point(point) {
                continue;
            }
            hidden += 1;
            kept += u32::from(
                !Horizon::from_eye(&case.ellipsoid, eye).hides_occlusion_point(case.point),
            );
            for _ in 0..12 {
                let p = case.any(&mut rng);
                let clear = clearance_ref(ground.radii(), eye, p);
                assert!(clear < 1e-14, "{p:?} is seen from {eye:?} by {clear:e}");
            }
        }
        same += u32::from(lower > 0.0);
        assert_eq!(case.ellipsoid.lowered_occlusion_point(0.0, case.point), Some(case.point));
        assert_eq!(case.ellipsoid.lowered_occlusion_point(-5.0, case.point), Some(case.point));
    }
    // From eyes below the ellipsoid alone, its own horizon knows less than the lower one.
    assert!(hidden > cases(20_000) && kept < hidden / 2 && same > 0, "{hidden} {kept}");
}

#[test]
fn bodies_that_have_no_point_and_numbers_that_are_none_get_none() {
    let one = Ellipsoid::new([1.0; 3]);
    let p = [[0.0, 0.0, 1.5]];
    assert!(one.occlusion_point(0.0, &p, 0.1).is_some());
    assert_eq!(one.occlusion_point(0.0, &[], 0.0), None);
    // A globe, half of one, and one that the ball of a point reaches around.
    let corners: [[f64; 3]; 8] =
        std::array::from_fn(|i| std::array::from_fn(|a| if i >> a & 1 == 0 { -2.0 } else { 2.0 }));
    assert_eq!(one.occlusion_point(0.0, &corners, 0.0), None);
    assert_eq!(one.occlusion_point(0.0, &[[1.0, 0.0, 0.1], [-1.0, 0.0, 0.1]], 0.0), None);
    assert_eq!(one.occlusion_point(0.0, &p, 1.0), None);
    // All below the ground: just above it.
    let under = one.occlusion_point(0.0, &[[0.1, 0.0, 0.5]], 0.1).unwrap();
    assert!((dot(under, under) - 1.0).abs() < 1e-12 && dot(under, under) > 1.0);
    assert_eq!(one.occlusion_point(0.0, &[[0.0; 3]], 0.1), None);
    for odd in [f64::NAN, f64::INFINITY, -f64::INFINITY, 1e200, -1e308] {
        for a in 0..3 {
            let mut q = p[0];
            q[a] = odd;
            assert_eq!(one.occlusion_point(0.0, &[p[0], q], 0.0), None, "{q:?}");
            assert_eq!(one.occlusion_point(0.0, &[q, p[0]], 0.0), None, "{q:?}");
            for depth in [0.0, 0.1] {
                assert_eq!(one.lowered_occlusion_point(depth, q), None, "{q:?}");
            }
        }
    }
    for odd in [f64::NAN, f64::INFINITY, -1.0, -1e-9] {
        assert_eq!(one.occlusion_point(0.0, &p, odd), None, "radius {odd}");
    }
    for odd in [f64::NAN, f64::INFINITY, 1.0, 1e9] {
        assert_eq!(one.occlusion_point(odd, &p, 0.0), None, "depth {odd}");
        assert_eq!(one.lowered_occlusion_point(odd, p[0]), None, "depth {odd}");
    }
    for r in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(Ellipsoid::new([1.0, r, 1.0]).occlusion_point(0.0, &p, 0.0), None, "{r}");
        assert_eq!(Ellipsoid::new([r, 1.0, 1.0]).lowered_occlusion_point(0.1, p[0]), None, "{r}");
    }
    // Points inside stand for nothing.
    let horizon = Horizon::from_eye(&one, [0.0, 0.0, 3.0]);
    for inside in [[0.0; 3], [0.0, 0.0, -0.5], [0.6, 0.0, -0.7]] {
        assert!(!horizon.hides_occlusion_point(inside), "{inside:?}");
        assert_eq!(one.lowered_occlusion_point(0.1, inside), None);
    }
    assert!(horizon.hides_occlusion_point([0.0, 0.0, -1.0]));
}
