//! Bounds against frusta: the certain answers are true, the `_ref` forms agree, and enough is culled.

use cullet::bounds::{Aabb, Plane, Side, Sphere};
use cullet::cull::frustum::exact::ExactFrustum;
use cullet::view::FrustumPlane;
use cullet::{Camera, Projection, view::Frustum};
use cullet_testkit::Rng;
use cullet_testkit::oracles::frustum::{
    classify_aabb, classify_aabb_ref, classify_sphere, classify_sphere_ref, intersects_ref,
};
use cullet_testkit::strategies::*;
use glam::DVec3;
use proptest::prelude::*;

/// A camera at any scale, its frustum, and a box and a sphere somewhere around it.
#[derive(Debug, Clone)]
struct Case {
    camera: Camera,
    frustum: Frustum,
    aabb: Aabb,
    sphere: Sphere,
    scale: f64,
}

fn case() -> impl Strategy<Value = Case> {
    case_of(scale())
}

fn case_of(scale: impl Strategy<Value = f64>) -> impl Strategy<Value = Case> {
    let half = || prop_oneof![0.001..0.1, 0.1..3.0, 3.0..60.0];
    let at = [-1.0..2.0, -1.0..2.0, -0.5..1.5];
    (camera(20.0), depth(), scale, at, [half(), half(), half()]).prop_map(
        |(camera, depth, scale, at, half): (Camera, _, f64, [f64; 3], [f64; 3])| {
            let center = point_in(&camera, at) * scale;
            let half = DVec3::from(half) * scale;
            let camera = scaled(&camera, scale);
            let rounded = |v: DVec3| v.as_vec3().to_array();
            Case {
                frustum: view_of(&camera, depth).frustum(),
                camera,
                aabb: Aabb::rounded_out((center - half).into(), (center + half).into()),
                sphere: Sphere::new(rounded(center), half.x as f32),
                scale,
            }
        },
    )
}

/// The coordinates of a point as the camera sees it: right, up, and backwards.
fn in_camera_space(camera: &Camera, point: DVec3) -> [f64; 3] {
    let axes = camera.basis().expect("the camera has one");
    axes.map(|axis| DVec3::from(axis).dot(point - DVec3::from(camera.eye)))
}

/// How near to zero any plane's distance to any of these points comes, in units of the scene's size.
fn margin(case: &Case, points: &[DVec3], radius: f64) -> f64 {
    let f = case.frustum.planes();
    f.flat_map(|(_, p)| {
        points.iter().flat_map(move |q| {
            let d = p.distance(*q);
            [(d - radius).abs(), (d + radius).abs()]
        })
    })
    .fold(f64::INFINITY, f64::min)
        / case.scale
}

fn check(
    frustum: &Frustum,
    side: Side,
    plane: Option<u8>,
    points: &[DVec3],
) -> Result<(), TestCaseError> {
    match side {
        Side::Outside => {
            let rejecting =
                frustum.planes().find(|(i, _)| Some(*i as u8) == plane).map(|(_, p)| *p);
            let rejecting = rejecting.ok_or_else(|| TestCaseError::fail("no plane is named"))?;
            for p in points {
                prop_assert!(rejecting.side_of(*p) != Side::Inside, "{:?}", p);
            }
        }
        Side::Inside => {
            for p in points {
                prop_assert!(frustum.planes().all(|(_, plane)| plane.side_of(*p) != Side::Outside));
            }
        }
        Side::Straddling => {}
    }
    Ok(())
}

proptest! {
    #![proptest_config(config(600))]

    #[test]
    fn certain_answers_about_boxes_are_true_and_those_of_the_ref(c in case()) {
        let corners = c.aabb.corners().map(|c| DVec3::from(c.map(f64::from)));
        let (side, plane) = classify_aabb(&c.frustum, &c.aabb);
        check(&c.frustum, side, plane, &corners)?;
        if margin(&c, &corners, 0.0) > 1e-9 {
            prop_assert_eq!(side, classify_aabb_ref(&c.frustum, &c.aabb));
        }
    }

    #[test]
    fn certain_answers_about_spheres_are_true_and_those_of_the_lecture(c in case()) {
        let center = DVec3::from(c.sphere.center.map(f64::from));
        let r = f64::from(c.sphere.radius);
        let (side, plane) = classify_sphere(&c.frustum, &c.sphere);
        let tips: Vec<DVec3> = c.frustum.planes()
            .flat_map(|(_, p)| [1.0, -1.0].map(|s| center + DVec3::from(p.normal) * r * s * (1.0 - 1e-12)))
            .collect();
        check(&c.frustum, side, plane, &tips)?;
        let camera_space = c.camera.projection.frustum().unwrap();
        let there = in_camera_space(&c.camera, center);
        let lecture = classify_sphere_ref(&camera_space, there, r);
        // The far plane of a matrix gives way by some 1e-9 of the distance.
        if margin(&c, &[center], r) > 1e-6 {
            prop_assert_eq!(side, lecture);
        }
    }

    #[test]
    fn the_exact_test_is_the_truth(c in case()) {
        let exact = ExactFrustum::new(&c.frustum);
        prop_assert!(exact.has_corners());
        let dropped = exact.is_outside(&c.aabb);
        let plane_test = classify_aabb(&c.frustum, &c.aabb).0 == Side::Outside;
        prop_assert!(dropped || !plane_test, "it knows all that the plane test knows");
        prop_assert_eq!(dropped, plane_test || exact.is_outside_beyond_planes(&c.aabb));
        let resized = |by: f64| {
            let (m, h) = (DVec3::from(c.aabb.center()), DVec3::from(c.aabb.half_extent()));
            let h = (h + DVec3::splat(by * c.scale)).max(DVec3::ZERO);
            Aabb::new((m - h).as_vec3().into(), (m + h).as_vec3().into())
        };
        if dropped {
            prop_assert_eq!(intersects_ref(&c.frustum, &resized(-1e-4)), Some(false));
        } else if c.frustum.present() == 0b11_1111 {
            // With all corners at hand it drops whatever is clear of the frustum.
            prop_assert_eq!(intersects_ref(&c.frustum, &resized(1e-2)), Some(true));
        }
    }

    #[test]
    fn in_object_space_the_answers_still_hold(c in case_of(Just(1.0)), t in transform()) {
        let f = c.frustum.to_object_space(&t);
        let [x, y, z] = t.linear.map(|v| DVec3::from(v.map(f64::from)));
        let (side, _) = classify_aabb(&f, &c.aabb);
        for corner in c.aabb.corners().map(|c| c.map(f64::from)) {
            let image = x * corner[0] + y * corner[1] + z * corner[2] + DVec3::from(t.translation);
            let slack = 1e-12 * (1.0 + image.length() + DVec3::from(corner).length() * 5.0);
            if side == Side::Inside && f.present() == c.frustum.present() {
                prop_assert!(c.frustum.planes().all(|(_, p)| p.distance(image) < slack));
            }
            if side == Side::Outside {
                prop_assert!(c.frustum.planes().any(|(_, p)| p.distance(image) > -slack));
            }
        }
        let exact = ExactFrustum::new(&f);
        if exact.is_outside(&c.aabb) && t.determinant().abs() > 1e-3 {
            prop_assert_eq!(intersects_ref(&f, &c.aabb).unwrap_or(false), false);
        }
    }

    #[test]
    fn one_more_plane_only_takes_away(c in case(), n in direction(), at in -0.5..1.5) {
        let through = point_in(&c.camera, [0.5, 0.5, at]);
        let mut cut = c.frustum.clone();
        prop_assert!(cut.push(Plane::from_point_normal(through, n).unwrap()).is_ok());
        let (before, after) = (classify_aabb(&c.frustum, &c.aabb), classify_aabb(&cut, &c.aabb));
        match before.0 {
            Side::Outside => prop_assert_eq!(before, after),
            Side::Straddling => prop_assert!(after.0 != Side::Inside),
            Side::Inside => {}
        }
        let (a, b) = (ExactFrustum::new(&c.frustum), ExactFrustum::new(&cut));
        prop_assert!(!a.is_outside(&c.aabb) || b.is_outside(&c.aabb));
    }
}

#[test]
fn enough_is_culled_and_the_exact_test_leaves_none_in_vain() {
    // Keeping everything would pass every test above; these floors are what was measured, less a little.
    let view = cullet::View::perspective([0.0; 3], [0.3, 0.2, -1.0], 1.0, 0.5, 200.0, [1280, 720])
        .unwrap();
    let f = view.frustum();
    let exact = ExactFrustum::new(&f);
    let mut rng = Rng(7);
    let (mut outside, mut by_planes, mut by_exact, mut by_spheres, total) = (0, 0, 0, 0, 20_000);
    for _ in 0..total {
        let mut coordinate = |reach: f64| rng.range(-reach, reach);
        let m = DVec3::new(coordinate(150.0), coordinate(150.0), coordinate(150.0));
        let h = DVec3::new(coordinate(40.0), coordinate(40.0), coordinate(40.0)).abs();
        let b = Aabb::rounded_out((m - h).into(), (m + h).into());
        let truly = intersects_ref(&f, &b) == Some(false);
        outside += u32::from(truly);
        by_planes += u32::from(classify_aabb(&f, &b).0 == Side::Outside);
        by_spheres += u32::from(classify_sphere(&f, &Sphere::from(&b)).0 == Side::Outside);
        by_exact += u32::from(exact.is_outside(&b));
        assert!(truly || !exact.is_outside(&b));
    }
    println!(
        "{total} big boxes: {outside} outside; found by spheres {by_spheres}, by planes {by_planes}, exactly {by_exact}"
    );
    assert_eq!(by_exact, outside, "none is kept without need");
    assert!(by_planes < by_exact, "there are boxes that only the exact test drops");
    assert!(f64::from(by_planes) > 0.95 * f64::from(outside));
    assert!(f64::from(by_spheres) > 0.85 * f64::from(outside));
}

fn unit_cube() -> Frustum {
    let p = Projection::Orthographic {
        left: -1.0,
        right: 1.0,
        bottom: -1.0,
        top: 1.0,
        near: -1.0,
        far: 1.0,
    };
    Camera::look_at([0.0; 3], [0.0, 0.0, -1.0], p).frustum().unwrap()
}

#[test]
fn each_plane_of_a_cube_rejects_what_is_beyond_it() {
    let f = unit_cube();
    let beyond = [
        (FrustumPlane::Left, [-3.0, 0.0, 0.0]),
        (FrustumPlane::Right, [3.0, 0.0, 0.0]),
        (FrustumPlane::Bottom, [0.0, -3.0, 0.0]),
        (FrustumPlane::Top, [0.0, 3.0, 0.0]),
        (FrustumPlane::Near, [0.0, 0.0, 3.0]),
        (FrustumPlane::Far, [0.0, 0.0, -3.0]),
    ];
    for (plane, c) in beyond {
        let expected = (Side::Outside, Some(plane as u8));
        let b = Aabb::new(c.map(|v| v - 1.0), c.map(|v| v + 1.0));
        assert_eq!(classify_aabb(&f, &b), expected);
        assert_eq!(classify_sphere(&f, &Sphere::new(c, 1.0)), expected);
    }
}

#[test]
fn inside_only_when_inside_all() {
    let f = unit_cube();
    assert_eq!(classify_sphere(&f, &Sphere::new([0.0; 3], 0.5)), (Side::Inside, None));
    assert_eq!(classify_sphere(&f, &Sphere::new([0.6, 0.0, 0.0], 0.5)), (Side::Straddling, None));
    let b = Aabb::new([-0.5; 3], [0.5; 3]);
    assert_eq!(classify_aabb(&f, &b), (Side::Inside, None));
}

#[test]
fn empty_nan_and_infinite_things() {
    for f in [unit_cube(), Frustum::everything()] {
        assert_eq!(classify_aabb(&f, &Aabb::EMPTY), (Side::Outside, None));
        assert_eq!(classify_sphere(&f, &Sphere::EMPTY), (Side::Outside, None));
        assert_eq!(classify_aabb(&f, &Aabb::EVERYTHING), (Side::Straddling, None));
        assert_eq!(classify_sphere(&f, &Sphere::EVERYTHING), (Side::Straddling, None));
        let nan = Aabb::new([f32::NAN, 9.0, 9.0], [9.0; 3]);
        assert_eq!(classify_aabb(&f, &nan), (Side::Straddling, None));
    }
}
