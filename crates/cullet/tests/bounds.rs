//! Bounds fitted to points, joined and converted: what they must hold they hold.

use cullet::Transform;
use cullet::bounds::{Aabb, Boxes, Plane, Side, Sphere};
use cullet_testkit::at_every_level;
use cullet_testkit::strategies::*;
use glam::{DMat3, DVec3};
use proptest::prelude::*;

type Points = Vec<[f32; 3]>;

/// Clouds of few or many points: round, flat, long, in one line or one point, at any scale, and far from the
/// origin by up to 1e7 times their size.
fn points() -> impl Strategy<Value = Points> {
    let scale = prop_oneof![Just(1e-30), Just(1e-3), Just(1.0), Just(1e7), Just(1e17), Just(1e30)];
    let away = prop_oneof![Just(0.0), Just(1.0), Just(1e3), Just(1e7)];
    let squash = || prop_oneof![3 => Just(1.0), 1 => Just(0.01), 1 => Just(0.0)];
    let cloud = proptest::collection::vec(vector(1.0), 1..60);
    (cloud, [squash(), squash(), squash()], rotation(), direction(), away, scale).prop_map(
        |(cloud, squash, q, direction, away, scale)| {
            let place = |p: DVec3| (q * (p * DVec3::from(squash)) + direction * away) * scale;
            cloud.into_iter().map(|p| place(p).as_vec3().to_array()).collect()
        },
    )
}

fn f64s(p: [f32; 3]) -> DVec3 {
    DVec3::from(p.map(f64::from))
}

/// The smallest ball by trying every pair, triple and quadruple of points.
fn smallest_radius(points: &[[f32; 3]]) -> f64 {
    let p: Vec<DVec3> = points.iter().map(|p| f64s(*p)).collect();
    let mut best = f64::INFINITY;
    let mut consider = |c: DVec3| {
        let r = p.iter().map(|q| q.distance(c)).fold(0.0, f64::max);
        // Dependent points have no centre, and `max` would pass over its NaN.
        if c.is_finite() {
            best = best.min(r);
        }
    };
    for (i, &a) in p.iter().enumerate() {
        consider(a);
        for (j, &b) in p[..i].iter().enumerate() {
            consider((a + b) * 0.5);
            for (k, &c) in p[..j].iter().enumerate() {
                let (u, v) = (b - a, c - a);
                let n = u.cross(v);
                let up = (n.cross(u) * v.length_squared() + v.cross(n) * u.length_squared())
                    / (2.0 * n.length_squared());
                consider(a + up);
                for &d in &p[..k] {
                    let m = DMat3::from_cols(u, v, d - a).transpose();
                    let half = DVec3::new(
                        u.length_squared(),
                        v.length_squared(),
                        (d - a).length_squared(),
                    );
                    consider(a + m.inverse() * (half * 0.5));
                }
            }
        }
    }
    best
}

proptest! {
    #![proptest_config(config(300))]

    #[test]
    fn a_sphere_holds_its_points(points in points()) {
        let s = Sphere::from_points(&points);
        for p in &points {
            // In f64 the distance of two f32 points is off by far less than half a unit of an f32.
            let off = f64s(*p).distance(f64s(s.center)) - f64::from(s.radius);
            prop_assert!(off <= 0.0, "{:?} is {:e} outside {:?}", p, off, s);
        }
    }

    #[test]
    fn a_sphere_is_the_smallest(points in points()) {
        let few = &points[..points.len().min(9)];
        let s = Sphere::from_points(few);
        let best = smallest_radius(few);
        // The centre may be off by half a unit of its f32 on each axis.
        let unit = f64s(s.center).length() * f64::from(f32::EPSILON);
        prop_assert!(f64::from(s.radius) <= best * 1.000_01 + unit, "{:e} not {:e}", s.radius, best);
    }

    #[test]
    fn an_aligned_box_holds_its_points_exactly(points in points()) {
        let b = Aabb::from_points(&points);
        prop_assert!(points.iter().all(|p| b.contains(*p)));
        for a in 0..3 {
            prop_assert!(points.iter().any(|p| p[a] == b.min[a]) && points.iter().any(|p| p[a] == b.max[a]));
        }
    }

    #[test]
    fn joining_and_converting_hold_what_was_held(a in points(), b in points()) {
        let (s, t) = (Sphere::from_points(&a), Sphere::from_points(&b));
        let joined = s.union(&t);
        let (x, y) = (Aabb::from_points(&a), Aabb::from_points(&b));
        let holds = |s: &Sphere, p: DVec3| p.distance(f64s(s.center)) <= f64::from(s.radius);
        for q in a.iter().chain(&b) {
            prop_assert!(holds(&joined, f64s(*q)), "{:?} in {:?}", q, joined);
            prop_assert!(x.union(&y).contains(*q));
        }
        // Spheres hold spheres: the farthest points of each, not only its own points.
        for s in [s, t] {
            let far = f64s(joined.center).distance(f64s(s.center)) + f64::from(s.radius);
            prop_assert!(far <= f64::from(joined.radius) * (1.0 + 1e-15));
        }
        let (of_box, around_sphere) = (Sphere::from(&x), Aabb::from(&s));
        for q in &a {
            prop_assert!(around_sphere.contains(*q) && holds(&of_box, f64s(*q)));
        }
        prop_assert!(x.corners().iter().all(|c| holds(&of_box, f64s(*c))));
    }

    #[test]
    fn transformed_bounds_hold_the_image(points in points(), t in transform(), origin in vector(1e3)) {
        let [x, y, z] = t.linear.map(f64s);
        let aligned = t.transform_box(&Aabb::from_points(&points), origin.into());
        for p in &points {
            let p = f64s(*p);
            let image = x * p.x + y * p.y + z * p.z + DVec3::from(t.translation) - origin;
            let inside = (0..3).all(|a| f64::from(aligned.min[a]) <= image[a] && image[a] <= f64::from(aligned.max[a]));
            prop_assert!(inside, "{:?} in {:?}", image, aligned);
        }
    }

    #[test]
    fn a_side_is_proved(points in points(), n in direction(), shift in -1.5..1.5_f64) {
        let b = Aabb::from_points(&points);
        let size = DVec3::from(b.half_extent()).length();
        let through = DVec3::from(b.center()) + n * (shift * size);
        let plane = Plane::from_point_normal(through, n).unwrap();
        let s = Sphere::from_points(&points);
        for side in [b.side(&plane), s.side(&plane)] {
            for p in &points {
                // The true sign, where plain f64 is sure of it.
                let wrong = match side {
                    Side::Outside => plane.side_of(f64s(*p)) == Side::Inside,
                    Side::Inside => plane.side_of(f64s(*p)) == Side::Outside,
                    Side::Straddling => false,
                };
                prop_assert!(!wrong, "{:?} is not {:?}", p, side);
            }
        }
        // And the answers are tight: the corners reach both ends of the span.
        let [low, high] = b.span(&plane);
        let at = b.corners().map(|c| plane.distance(f64s(c)));
        let (least, most) = at.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), v| (l.min(*v), m.max(*v)));
        let slack = 1e-13 * (through.length() + size) + 1e-300;
        prop_assert!(low <= least && least <= low + slack && high - slack <= most && most <= high);
    }
}

#[test]
fn what_is_not_finite_stays_everything() {
    let mut t = Transform::IDENTITY;
    t.translation[1] = f64::NAN;
    assert_eq!(t.transform_box(&Aabb::new([0.0; 3], [1.0; 3]), [0.0; 3]), Aabb::EVERYTHING);
    let t = Transform::IDENTITY;
    assert_eq!(t.transform_box(&Aabb::EVERYTHING, [0.0; 3]), Aabb::EVERYTHING);
    assert_eq!(t.transform_box(&Aabb::EMPTY, [0.0; 3]), Aabb::EMPTY);
}

#[test]
fn gathered_boxes_are_those_set_one_by_one() {
    let mut items: Vec<_> = (0..100)
        .map(|i| i as f32 * 1e-3 * (-1.5f32).powi(i))
        .map(|v| Aabb::new([v, -v.abs(), v], [v, v.abs() + 1.0, v + 1e-30]))
        .collect();
    items[40] = Aabb::EMPTY;
    items[41] = Aabb::EVERYTHING;
    items[42].max[1] = f32::NAN;
    items[60] = Aabb::new([1.0; 3], [1.0_f32.next_down(); 3]);
    items[90].min[2] = -1e18;
    let order: Vec<_> = (0..95).map(|i| i * 37 % 100).collect();
    at_every_level!(|level| {
        let mut gathered = Boxes::new();
        gathered.gather(level, &items, &order);
        let mut one_by_one = Boxes::new();
        order.iter().for_each(|&i| one_by_one.push(&items[i as usize]));
        assert_eq!(gathered.as_floats(), one_by_one.as_floats());
    });
}
