//! Projected sizes against samples of the things themselves.

use cullet::bounds::{Aabb, Sphere};
use cullet::{Depth, Projection, View};
use cullet_testkit::strategies::*;
use cullet_testkit::vectors::fibonacci;
use glam::{DVec2, DVec3};
use proptest::prelude::*;

fn pixel(view: &View, p: DVec3) -> Option<[f64; 2]> {
    view.project_point(p).map(|[x, y, _]| [x, y])
}

/// The farthest that the picture of a sphere reaches along a direction of the screen: from the best of
/// some points of it, downhill in ever smaller steps.
fn reach(view: &View, center: DVec3, radius: f64, along: DVec2) -> f64 {
    let value = |u: DVec3| {
        pixel(view, center + u * radius).map_or(f64::NEG_INFINITY, |p| along.dot(p.into()))
    };
    let spiral = (0..400).map(|i| DVec3::from(fibonacci(i, 400)));
    let mut best = spiral.max_by(|a, b| value(*a).total_cmp(&value(*b))).unwrap();
    let mut step = 0.1;
    while step > 1e-9 {
        let (a, b) = best.any_orthonormal_pair();
        let next = [a, -a, b, -b].map(|d| (best + d * step).normalize());
        let next = next.into_iter().max_by(|a, b| value(*a).total_cmp(&value(*b))).unwrap();
        if value(next) > value(best) {
            best = next;
        } else {
            step *= 0.5;
        }
    }
    value(best)
}

proptest! {
    #![proptest_config(config(250))]

    #[test]
    fn a_sphere_fills_its_rectangle_and_no_more(
        c in camera(20.0), depth in depth(), at in [-0.5..1.5, -0.5..1.5, 0.1..1.0], size in 0.05..0.95,
    ) {
        let view = view_of(&c, depth);
        let f = c.frustum().unwrap();
        let p = point_in(&c, at).as_vec3();
        let center = p.as_dvec3();
        // Up to almost touching the near plane.
        let near = f.plane(cullet::view::FrustumPlane::Near).unwrap();
        let radius = (-near.distance(center) * size) as f32;
        prop_assume!(radius > 1e-3);
        let rect = view.project_sphere(&Sphere::new(p.into(), radius), [0.0; 3]);
        let rect = rect.expect("a sphere beyond the near plane has a rectangle");
        let radius = f64::from(radius);
        let [left, right] = [DVec2::NEG_X, DVec2::X].map(|a| a.x * reach(&view, center, radius, a));
        let [top, bottom] = [DVec2::NEG_Y, DVec2::Y].map(|a| a.y * reach(&view, center, radius, a));
        let edges = [
            (left - rect.min[0], rect.width()),
            (rect.max[0] - right, rect.width()),
            (top - rect.min[1], rect.height()),
            (rect.max[1] - bottom, rect.height()),
        ];
        for (slack, extent) in edges {
            prop_assert!(slack >= 0.0, "{:e} pixels of it are outside {:?}", -slack, rect);
            prop_assert!(slack <= extent * 1e-6, "{:e} of {:e} pixels too far", slack, extent);
        }
    }

    #[test]
    fn a_box_fills_its_rectangle_and_no_more(
        c in camera(20.0), depth in depth(), at in [-0.5..1.5, -0.5..1.5, 0.1..1.0],
        half in [0.01..2.0, 0.01..2.0, 0.01..2.0], inner in [[-1.0..1.0, -1.0..1.0, -1.0..1.0], [-1.0..1.0, -1.0..1.0, -1.0..1.0]],
    ) {
        let view = view_of(&c, depth);
        let center = point_in(&c, at);
        let half = DVec3::from(half);
        let b = Aabb::rounded_out((center - half).into(), (center + half).into());
        let near = *c.frustum().unwrap().plane(cullet::view::FrustumPlane::Near).unwrap();
        let nearest = b.corners().iter().map(|c| -near.distance(c.map(f64::from))).fold(f64::INFINITY, f64::min);
        prop_assume!(nearest.abs() > 1e-6);
        let rect = view.project_box(&b, [0.0; 3]);
        prop_assert_eq!(rect.is_some(), nearest > 0.0, "it must and may be known beyond the near plane");
        let Some(rect) = rect else { return Ok(()) };
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for corner in b.corners() {
            let p = pixel(&view, DVec3::from(corner.map(f64::from))).unwrap();
            prop_assert!(rect.contains(p));
            (low, high) = (low.min(p.into()), high.max(p.into()));
        }
        for t in inner {
            let p = DVec3::from(b.center()) + DVec3::from(b.half_extent()) * DVec3::from(t);
            prop_assert!(rect.contains(pixel(&view, p).unwrap()));
        }
        let tolerance = 1e-9 * (1.0 + high.abs().max(low.abs()).max_element());
        prop_assert!((low - DVec2::from(rect.min)).max_element() <= tolerance);
        prop_assert!((DVec2::from(rect.max) - high).max_element() <= tolerance);
    }

    #[test]
    fn far_from_the_origin_nothing_sticks_out(
        c in camera(20.0), depth in depth(), at in [0.0..1.0, 0.0..1.0, 0.1..1.0], size in 0.05..0.5, s in 0..2,
    ) {
        // The same small view at 1e7 units, or all of it 1e17 times as large.
        let (c, origin) = if s == 0 {
            (cullet::Camera { eye: c.eye.map(|v| v + 1e7), ..c }, [1e7; 3])
        } else {
            (scaled(&c, 1e17), [0.0; 3])
        };
        let view = view_of(&c, depth);
        let center = point_in(&c, at);
        let p = (center - DVec3::from(origin)).as_vec3();
        let near = *c.frustum().unwrap().plane(cullet::view::FrustumPlane::Near).unwrap();
        let center = p.as_dvec3() + DVec3::from(origin);
        let radius = -near.distance(center) * size;
        prop_assume!(radius > 0.0);
        let sphere = Sphere::new(p.into(), radius as f32);
        let Some(rect) = view.project_sphere(&sphere, origin) else { return Err(TestCaseError::fail("no rectangle")) };
        let rect_of_box = view.project_box(&Aabb::from(&sphere), origin);
        for i in 0..200 {
            let u = DVec3::from(fibonacci(i, 200));
            let p = pixel(&view, center + u * f64::from(sphere.radius)).unwrap();
            prop_assert!(rect.contains(p), "{:?} outside {:?}", p, rect);
            prop_assert!(rect_of_box.is_none_or(|r| r.contains(p)));
        }
    }
}

#[test]
fn a_sphere_off_axis_is_wider_than_one_on_it() {
    let view = View::perspective([0.0; 3], [0.0, 0.0, -1.0], 2.0, 0.1, 1e3, [1000, 1000]).unwrap();
    let size = |x: f32| {
        let r = view.project_sphere(&Sphere::new([x, 0.0, -10.0], 1.0), [0.0; 3]).unwrap();
        (r.width(), r.height())
    };
    let scale = 500.0 / 1.0_f64.tan();
    let (w, h) = size(0.0);
    // On the axis the outline is the circle of half angle asin(r / distance).
    assert!(
        (w - 2.0 * scale * 0.1_f64.asin().tan()).abs() < 1e-9 && (w - h).abs() < 1e-9,
        "{w} {h}"
    );
    let (w, h) = size(10.0);
    // At 45° off the axis, by angles: tan(45° ± asin(r / distance)).
    let a = (1.0 / 200.0_f64.sqrt()).asin();
    let quarter = std::f64::consts::FRAC_PI_4;
    assert!((w - scale * ((quarter + a).tan() - (quarter - a).tan())).abs() < 1e-9, "{w}");
    assert!(w > h * 1.3, "it looks like an egg: {w} x {h}");
}

#[test]
fn what_has_no_size_gets_none() {
    for depth in [Depth::Standard, Depth::Reversed] {
        let projection = Projection::Perspective {
            fov_y_radians: 1.0,
            aspect: 1.0,
            near: 1.0,
            far: f64::INFINITY,
        };
        let c = cullet::Camera::look_at([0.0; 3], [0.0, 0.0, -1.0], projection);
        let view = view_of(&c, depth);
        let sphere = |z: f32, r: f32| view.project_sphere(&Sphere::new([0.0, 0.0, z], r), [0.0; 3]);
        assert!(sphere(-5.0, 3.9).is_some());
        assert!(sphere(-5.0, 4.1).is_none(), "crosses the near plane");
        assert!(sphere(-5.0, 6.0).is_none(), "holds the eye");
        assert!(sphere(5.0, 1.0).is_none(), "behind");
        assert!(sphere(-5.0, -1.0).is_none(), "empty");
        assert!(sphere(-5.0, f32::INFINITY).is_none() && sphere(f32::NAN, 1.0).is_none());
        let boxed = |min: f32, max: f32| {
            view.project_box(&Aabb::new([-1.0, -1.0, min], [1.0, 1.0, max]), [0.0; 3])
        };
        assert!(
            boxed(-9.0, -1.1).is_some() && boxed(-9.0, -0.9).is_none() && boxed(5.0, 9.0).is_none()
        );
        assert!(boxed(-1.0, -9.0).is_none() && boxed(f32::NAN, -2.0).is_none());
        assert!(view.project_box(&Aabb::EVERYTHING, [0.0; 3]).is_none());
    }
}

#[test]
fn a_rectangle_is_clipped_to_the_viewport() {
    let view = View::orthographic([0.0, 0.0, 9.0], [0.0; 3], 10.0, 0.0, 20.0, [100, 100]).unwrap();
    let r = view.project_sphere(&Sphere::new([5.0, 0.0, 0.0], 1.0), [0.0; 3]).unwrap();
    assert!((r.width() - 20.0).abs() < 1e-9 && (r.max[0] - 110.0).abs() < 1e-9);
    let c = r.clipped([100, 100]).unwrap();
    assert!((c.width() - 10.0).abs() < 1e-9 && c.height() == r.height());
    let beyond = view.project_sphere(&Sphere::new([9.0, 0.0, 0.0], 1.0), [0.0; 3]).unwrap();
    assert_eq!(beyond.clipped([100, 100]), None);
}
