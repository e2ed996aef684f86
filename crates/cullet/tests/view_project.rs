//! Projected sizes against samples of the boxes and spheres themselves.

use cullet::bounds::{Aabb, Sphere};
use cullet::{Depth, Projection, View};
use cullet_testkit::strategies::*;
use cullet_testkit::vectors::fibonacci;
use glam::{DVec2, DVec3};
use proptest::prelude::*;

fn pixel(view: &View, p: DVec3) -> Option<[f64; 2]> {
    view.project_point(p).map(|[x, y, _]| [x, y])
}

proptest! {
    #![proptest_config(config(250))]

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
        let rect = view.project_box(&Aabb::from(&sphere), origin);
        let Some(rect) = rect else { return Err(TestCaseError::fail("no rectangle")) };
        for i in 0..200 {
            let u = DVec3::from(fibonacci(i, 200));
            let p = pixel(&view, center + u * f64::from(sphere.radius)).unwrap();
            prop_assert!(rect.contains(p), "{:?} outside {:?}", p, rect);
        }
    }
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
    let cube = |x: f32| Aabb::new([x - 1.0, -1.0, -1.0], [x + 1.0, 1.0, 1.0]);
    let r = view.project_box(&cube(5.0), [0.0; 3]).unwrap();
    assert!((r.width() - 20.0).abs() < 1e-9 && (r.max[0] - 110.0).abs() < 1e-9);
    let c = r.clipped([100, 100]).unwrap();
    assert!((c.width() - 10.0).abs() < 1e-9 && c.height() == r.height());
    let beyond = view.project_box(&cube(9.0), [0.0; 3]).unwrap();
    assert_eq!(beyond.clipped([100, 100]), None);
}
