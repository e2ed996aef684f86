//! Planes of the frustum, and spheres that touch them.

use cullet::bounds::{BoxBlock, Plane, Side, Sphere, SphereBlock};
use cullet::view::FrustumPlane;
use cullet::{Camera, Depth, Projection, View, view::Frustum};
use cullet_draw::PixelId;
use cullet_testkit::Rng;
use cullet_testkit::vectors::cross;

use crate::tools::{SIZE, Vec3, along, built, dot, draw, in_clip, minus, told};

/// Item 68: a sphere that touches a plane is in none of the three cases as written; it is kept, as
/// those are that are cut.
#[test]
fn a_sphere_that_touches_a_plane_is_cut_by_it() {
    let as_written = |distance: f64, radius: f64| match distance {
        d if d > radius => Some(Side::Outside),
        d if d < -radius => Some(Side::Inside),
        d => (-radius < d && d < radius).then_some(Side::Straddling),
    };
    let mut touching = 0;
    for (axis, exponent, sign) in (0..3)
        .flat_map(|axis| (-8..8).map(move |exponent| (axis, exponent)))
        .flat_map(|(axis, exponent)| [-1.0, 1.0].map(|sign| (axis, exponent, sign)))
    {
        let radius = 2.0_f32.powi(exponent);
        let (mut normal, mut center) = ([0.0; 3], [0.0; 3]);
        (normal[axis], center[axis]) = (1.0, 3.0 + sign * radius);
        let plane = Plane::new(normal, 3.0);
        let distance = plane.distance(center.map(f64::from));
        assert_eq!(distance.abs(), f64::from(radius));
        assert_eq!(as_written(distance, f64::from(radius)), None);
        assert_eq!(Sphere::new(center, radius).side(&plane), Side::Straddling);
        touching += 1;
    }
    let mut rng = Rng(68);
    const OTHERS: usize = 3000;
    for _ in 0..OTHERS {
        let plane = Plane::from_point_normal(rng.vector(9.0), rng.vector(1.0)).expect("a plane");
        let sphere = Sphere::new(rng.vector(20.0).map(|v| v as f32), rng.range(0.1, 10.0) as f32);
        let distance = plane.distance(sphere.center.map(f64::from));
        assert_eq!(as_written(distance, f64::from(sphere.radius)), Some(sphere.side(&plane)));
    }
    told(68, &[f64::from(touching), OTHERS as f64]);
}

/// Item 71: as written, right is left, and near and far look inward, so that all that is seen is
/// outside; mended, the planes are those of the matrix.
#[test]
fn planes_of_the_camera_point_out_once_right_is_d_cross_up() {
    let model = built("city:cells=6,objects=200");
    let (near, far, fov, aspect) = (0.5, 400.0, 1.0, 1.6);
    let (mut points, mut cameras, mut worst) = (0, 0, 0.0_f64);
    for view in crate::tools::views(&model, "walk", 6) {
        let ray = view.ray([160.0, 100.0]).expect("a line of sight");
        let projection = Projection::Perspective { fov_y_radians: fov, aspect, near, far };
        let [x, y, z, _] = view.eye();
        let p = [x, y, z];
        let camera = Camera { eye: p, direction: ray.direction, up: [0.0, 1.0, 0.0], projection };
        let view = View::new(&camera, Depth::Reversed, SIZE).expect("a view");
        let [_, up, back] = camera.basis().expect("three axes");
        let d = back.map(|v| -v);
        let height = 2.0 * near * (fov / 2.0_f64).tan();
        let (nc, fc) = (along(p, near, d), along(p, far, d));
        // From the eye to the middle of an edge of the near window.
        let edge = |to: Vec3, half: f64| minus(along(nc, half, to), p);
        let plane = |at: Vec3, n: Vec3| Plane::from_point_normal(at, n);

        let right = cross(up, d);
        let mut as_written = [None; 6];
        as_written[FrustumPlane::Right as usize] =
            plane(p, cross(up, edge(right, height * aspect / 2.0)));
        as_written[FrustumPlane::Near as usize] = plane(nc, d);
        as_written[FrustumPlane::Far as usize] = plane(fc, d.map(|v| -v));
        let own = view.frustum();
        let left = own.plane(FrustumPlane::Left).expect("a left plane").normal;
        let called_right = as_written[FrustumPlane::Right as usize].expect("a plane").normal;
        assert!(dot(left, called_right) > 1.0 - 1e-12);
        let as_written = Frustum::from_planes(as_written);

        let right = cross(d, up);
        let (half, half_up) = (height * aspect / 2.0, height / 2.0);
        let mended = Frustum::from_planes([
            plane(p, cross(up, edge(right, -half))),
            plane(p, cross(edge(right, half), up)),
            plane(p, cross(edge(up, -half_up), right)),
            plane(p, cross(right, edge(up, half_up))),
            plane(nc, d.map(|v| -v)),
            plane(fc, d),
        ]);
        for (which, a) in mended.planes() {
            for other in [&own, &camera.frustum().expect("planes")] {
                let (_, b) =
                    other.planes().find(|(other, _)| *other == which).expect("the same six");
                let off = (0..3).map(|i| (a.normal[i] - b.normal[i]).abs());
                worst = off.fold(worst, f64::max).max((a.d - b.d).abs());
            }
        }
        cameras += 1;
        let frame = draw(&model.scene, &view);
        for (at, _) in frame.ids.iter().enumerate().filter(|(_, id)| **id != PixelId::NONE) {
            let pixel =
                [at as u32 % frame.width, at as u32 / frame.width].map(|v| f64::from(v) + 0.5);
            let ray = view.ray(pixel).expect("a line of sight");
            // A point that is seen: on the line of sight, where the depth says.
            let s = reach(&view, ray.origin, ray.direction, frame.depth[at]);
            let point = along(ray.origin, s, ray.direction);
            points += 1;
            assert!(!as_written.contains(point) && mended.contains(point), "{point:?}");
        }
    }
    assert!(worst < 1e-9, "{worst}");
    told(71, &[f64::from(points), f64::from(cameras)]);
}

/// How far along a line from the near plane the depth in clip space is reached.
fn reach(view: &View, origin: Vec3, direction: Vec3, depth: f64) -> f64 {
    let [_, _, z0, w0] = in_clip(view, origin);
    let [_, _, z1, w1] = in_clip(view, along(origin, 1.0, direction));
    // (z0 + s (z1 − z0)) = depth (w0 + s (w1 − w0)).
    (depth * w0 - z0) / ((z1 - z0) - depth * (w1 - w0))
}

/// Items 64, 66, 85 and 86: a plane tells how far a point is and on which side, T·p is 0 on it, and
/// negative half-spaces meet in a convex region. A sphere is smaller than a box.
#[test]
fn a_plane_is_a_row_that_tells_distances_and_several_make_a_convex_region() {
    const CASES: usize = 2000;
    let mut rng = Rng(66);
    for _ in 0..CASES {
        let (p, n, distance) = (rng.vector(100.0), rng.vector(7.0), rng.range(-50.0, 50.0));
        let plane = Plane::from_point_normal(p, n).expect("a plane");
        // Along the plane in some direction, then off it.
        let on = along(p, rng.range(-50.0, 50.0), cross(plane.normal, rng.vector(1.0)));
        let x = along(on, distance, plane.normal);
        assert!((plane.distance(x) - distance).abs() < 2e-10 && plane.distance(on).abs() < 2e-10);
        assert!((dot(plane.normal, minus(x, p)) - distance).abs() < 2e-10);
        assert_eq!(plane.side_of(x), if distance > 0.0 { Side::Outside } else { Side::Inside });
        assert_eq!(plane.side_of(p), Side::Straddling);
        // T = [n −d]: the nearest point to the origin is d away along n, if n is of unit length.
        let nearest = plane.normal.map(|v| v * plane.d);
        assert!(plane.distance(nearest).abs() < 1e-12 * 200.0);
        assert!((dot(nearest, nearest).sqrt() - plane.d.abs()).abs() < 1e-10);
        let long = Plane::new(plane.normal.map(|v| v * 7.0), plane.d * 7.0);
        assert!(long.distance(long.normal.map(|v| v * long.d)).abs() > 1e-6 || long.d.abs() < 1e-6);
    }
    told(66, &[CASES as f64]);
    told(85, &[CASES as f64]);
    let frustum = Projection::Perspective { fov_y_radians: 1.0, aspect: 1.6, near: 0.5, far: 60.0 };
    let mut frustum = frustum.frustum().expect("six planes");
    let mut pairs = 0;
    for _ in 0..8 {
        let points = (0..2000).map(|_| along([0.0, 0.0, -30.0], 1.0, rng.vector(30.0)));
        let inside: Vec<Vec3> = points.filter(|p| frustum.contains(*p)).collect();
        pairs += inside.windows(2).count();
        let middle = |pair: &[Vec3]| along(pair[0].map(|v| v * 0.5), 0.5, pair[1]);
        assert!(inside.windows(2).all(|pair| frustum.contains(middle(pair))));
        let at = along([0.0, 0.0, -30.0], 1.0, rng.vector(10.0));
        frustum.push(Plane::from_point_normal(at, rng.vector(1.0)).expect("a plane")).expect("few");
    }
    told(86, &[pairs as f64]);
    let bytes = [size_of::<SphereBlock>(), size_of::<BoxBlock>()].map(|block| block / 16);
    assert_eq!(bytes, [16, 24]);
}
