//! Views and frusta: properties over every kind of projection.

use cullet::bounds::{Plane, Side};
use cullet::view::ViewError;
use cullet::{Camera, Depth, Projection, Transform, View, view::Frustum};
use cullet_testkit::strategies::*;
use glam::{DMat4, DVec3, DVec4};
use proptest::prelude::*;

/// How far two planes are apart at these points, relative to the size of the coordinates.
fn apart(a: &Plane, b: &Plane, points: &[DVec3]) -> f64 {
    let off = points.iter().map(|p| (a.distance(*p) - b.distance(*p)).abs());
    let size = points.iter().map(|p| p.length()).fold(0.0, f64::max);
    off.fold(0.0, f64::max) / size
}

proptest! {
    #![proptest_config(config(400))]

    #[test]
    fn the_geometric_construction_equals_the_matrix(
        c in camera(20.0), depth in depth(), s in scale(),
    ) {
        let c = scaled(&c, s);
        let by_matrix = view_of(&c, depth).frustum();
        let by_camera = c.frustum().unwrap();
        prop_assert_eq!(by_matrix.present(), by_camera.present());
        let points: Vec<DVec3> = (0..8)
            .map(|i| point_in(&c, [f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)]))
            .collect();
        for ((i, a), (_, b)) in by_matrix.planes().zip(by_camera.planes()) {
            prop_assert!((DVec3::from(a.normal).length() - 1.0).abs() < 1e-14);
            // The far plane is the difference of two rows, far/near times as large, and gives way by that.
            let tolerance = if i == 5 { 1e-7 } else { 1e-11 };
            let off = apart(a, b, &points);
            prop_assert!(off < tolerance, "plane {}: {:?} and {:?} apart by {:e}", i, a, b, off);
        }
    }

    #[test]
    fn points_are_inside_where_the_construction_says(
        c in camera(20.0), depth in depth(), s in scale(), at in [-0.5..1.5, -0.5..1.5, -0.5..1.5],
    ) {
        let c = scaled(&c, s);
        let p = point_in(&c, at);
        let margin = at.iter().map(|v: &f64| v.abs().min((v - 1.0).abs())).fold(1.0, f64::min);
        prop_assume!(margin > 1e-6);
        // `point_in` counts to 51 times the near distance where the far plane is beyond.
        let deep_enough = match c.projection {
            Projection::Perspective { near, far, .. } | Projection::OffCentre { near, far, .. } => {
                let distance = near + (far.min(near * 51.0) - near) * at[2];
                prop_assume!((distance / far - 1.0).abs() > 1e-6);
                distance < far
            }
            Projection::Orthographic { .. } => at[2] < 1.0,
        };
        let inside = at.iter().enumerate().all(|(i, &v)| v > 0.0 && (i == 2 || v < 1.0)) && deep_enough;
        prop_assert_eq!(view_of(&c, depth).frustum().contains(p), inside);
        prop_assert_eq!(c.frustum().unwrap().contains(p), inside);
    }

    #[test]
    fn corners_are_where_the_camera_puts_them(c in camera(20.0), depth in depth(), s in scale()) {
        let c = scaled(&c, s);
        for f in [view_of(&c, depth).frustum(), c.frustum().unwrap()] {
            let corners = f.corners().expect("every camera's frustum has corners");
            for (i, corner) in corners.into_iter().enumerate() {
                let bit = |b: usize| (i >> b & 1) as f64;
                let near = point_in(&c, [bit(0), bit(1), 0.0]);
                let corner = DVec4::from(corner);
                if i < 4 {
                    let off = corner.truncate().distance(near) / near.length();
                    prop_assert!(corner.w == 1.0 && off < 1e-8, "{}: {:?} not {:?}", i, corner, near);
                } else if corner.w == 0.0 {
                    let along = (near - DVec3::from(c.eye)).normalize();
                    prop_assert!(corner.truncate().distance(along) < 1e-9, "{}: {:?}", i, corner);
                    prop_assert!(c.frustum().unwrap().present() >> 5 == 0);
                } else {
                    let far = c.frustum().unwrap().plane(cullet::view::FrustumPlane::Far).copied();
                    let off = far.map(|p| p.distance(corner.truncate()).abs() / corner.length());
                    prop_assert!(off.is_some_and(|o| o < 1e-7));
                }
            }
        }
    }

    #[test]
    fn the_eye_is_found_in_the_matrix(c in camera(20.0), depth in depth(), s in scale()) {
        let c = scaled(&c, s);
        let view = view_of(&c, depth);
        let [x, y, z, w] = view.eye();
        let found = DVec3::new(x, y, z);
        if let Projection::Orthographic { .. } = c.projection {
            prop_assert!(view.is_orthographic() && w == 0.0);
            let back = -DVec3::from(c.direction).normalize();
            prop_assert!(found.distance(back) < 1e-12, "{:?} not {:?}", found, back);
        } else {
            prop_assert!(w == 1.0);
            let eye = DVec3::from(c.eye);
            prop_assert!(found.distance(eye) / eye.length() < 1e-11, "{:?} not {:?}", found, eye);
        }
    }

    #[test]
    fn winding_on_the_screen_is_that_from_the_eye_unless_mirrored(
        c in camera(20.0), depth in depth(), s in scale(),
        at in [[0.05..0.95, 0.05..0.95, 0.01..0.9], [0.05..0.95, 0.05..0.95, 0.01..0.9], [0.05..0.95, 0.05..0.95, 0.01..0.9]],
    ) {
        let c = scaled(&c, s);
        let view = view_of(&c, depth);
        let [p, q, r] = at.map(|a| point_in(&c, a));
        let screen = |p: DVec3| {
            let clip = clip_from_world(&view) * p.extend(1.0);
            (clip.truncate() / clip.w).truncate()
        };
        let area = (screen(q) - screen(p)).perp_dot(screen(r) - screen(p));
        prop_assume!(area.abs() > 1e-6);
        let n = (q - p).cross(r - p);
        let e = DVec4::from(view.eye());
        let front = n.dot(e.truncate()) - n.dot(p) * e.w > 0.0;
        prop_assert_eq!(area > 0.0, front != view.is_mirrored());
        // The window given backwards in one direction, and only that, mirrors.
        let flipped = match c.projection {
            Projection::OffCentre { left, right, bottom, top, .. }
            | Projection::Orthographic { left, right, bottom, top, .. } => (right < left) != (top < bottom),
            Projection::Perspective { .. } => false,
        };
        prop_assert_eq!(view.is_mirrored(), flipped);
    }

    #[test]
    fn a_positive_factor_changes_nothing(c in camera(20.0), depth in depth(), k in prop_oneof![Just(1e-120), Just(1e-9), Just(1e120)]) {
        let view = view_of(&c, depth);
        let m = view.clip_from_world().map(|v| v * k);
        let same = View::from_matrix(m, depth, [640, 480]).unwrap();
        prop_assert_eq!(same.is_mirrored(), view.is_mirrored());
        prop_assert!(DVec4::from(same.eye()).distance(view.eye().into()) < 1e-11 * 20.0);
        for ((_, a), (_, b)) in same.frustum().planes().zip(view.frustum().planes()) {
            prop_assert!(DVec3::from(a.normal).distance(b.normal.into()) < 1e-9, "{:?} {:?}", a, b);
        }
    }

    #[test]
    fn any_invertible_matrix_shows_what_clip_space_keeps(
        m in proptest::array::uniform16(-2.0..2.0), depth in depth(), p in vector(3.0),
    ) {
        let Ok(view) = View::from_matrix(m, depth, [640, 480]) else { return Ok(()) };
        let clip = clip_from_world(&view) * p.extend(1.0);
        let inside = [clip.w + clip.x, clip.w - clip.x, clip.w + clip.y, clip.w - clip.y, clip.z, clip.w - clip.z];
        let margin = inside.iter().fold(f64::INFINITY, |m: f64, v| m.min(v.abs()));
        prop_assume!(margin > 1e-9);
        let f = view.frustum();
        prop_assert_eq!(f.contains(p), inside.iter().all(|&v| v > 0.0));
        // Where it has corners, they span it: no point inside is beyond all of them.
        if let Some(corners) = f.corners().filter(|c| c.iter().all(|c| c[3] == 1.0)) {
            let low = corners.iter().fold(DVec3::INFINITY, |l, c| l.min(DVec4::from(*c).truncate()));
            let high = corners.iter().fold(DVec3::NEG_INFINITY, |h, c| h.max(DVec4::from(*c).truncate()));
            if f.contains(p) {
                prop_assert!(p.cmpge(low - 1e-9).all() && p.cmple(high + 1e-9).all());
            }
        }
    }

    #[test]
    fn pixels_and_points_go_both_ways(
        c in camera(20.0), depth in depth(), s in scale(), at in [0.01..0.99, 0.01..0.99, 0.01..0.99],
    ) {
        let c = scaled(&c, s);
        let view = view_of(&c, depth);
        let p = point_in(&c, at);
        let [x, y, _] = view.project_point(p).unwrap();
        // Window coordinates that are given backwards run backwards on the screen too.
        prop_assert!((x / 640.0 - at[0]).abs() < 1e-9 && ((480.0 - y) / 480.0 - at[1]).abs() < 1e-9);
        let ray = view.ray([x, y]).unwrap();
        let (o, d) = (DVec3::from(ray.origin), DVec3::from(ray.direction));
        prop_assert!((p - o).dot(d) > 0.0, "the ray goes away from the viewer");
        prop_assert!((p - o).cross(d).length() / p.length() < 1e-10);
        let near = point_in(&c, [at[0], at[1], 0.0]);
        prop_assert!(o.distance(near) / near.length() < 1e-10, "{:?} not {:?}", o, near);
    }

    #[test]
    fn relative_to_an_origin_is_the_same_region(
        c in camera(20.0), s in scale(), at in [-0.5..1.5, -0.5..1.5, -0.5..1.5], origin in vector(20.0),
    ) {
        let c = scaled(&c, s);
        let (f, p) = (view_of(&c, Depth::Standard).frustum(), point_in(&c, at));
        let origin = origin * s;
        let g = f.relative_to(origin.into());
        for ((_, a), (_, b)) in f.planes().zip(g.planes()) {
            let off = (a.distance(p) - b.distance(p - origin)).abs();
            prop_assert!(off <= 1e-14 * (p.length() + origin.length() + a.d.abs()), "{:e}", off);
        }
    }

    #[test]
    fn object_space_holds_a_point_iff_the_world_holds_its_image(
        c in camera(20.0), t in transform(), p in vector(3.0), at in [0.0..1.0, 0.0..1.0, 0.0..1.0],
    ) {
        let f = view_of(&c, Depth::Reversed).frustum();
        // The object is put where the view looks, so that both answers occur.
        let mut t = t;
        t.translation = (point_in(&c, at)).into();
        let [x, y, z] = t.linear.map(|v| DVec3::from(v.map(f64::from)));
        let image = x * p.x + y * p.y + z * p.z + DVec3::from(t.translation);
        let object = f.to_object_space(&t);
        for (i, plane) in f.planes() {
            let distance = plane.distance(image);
            prop_assume!(distance.abs() > 1e-9);
            match object.planes().find(|(j, _)| *j == i) {
                Some((_, o)) => {
                    prop_assert!((DVec3::from(o.normal).length() - 1.0).abs() < 1e-14);
                    prop_assert_eq!(o.distance(p) > 0.0, distance > 0.0, "plane {}", i);
                }
                // Left out only where the normal vanishes: no component survives the transform.
                None => {
                    let n = DVec3::from(plane.normal);
                    prop_assert!([x, y, z].iter().all(|a| n.dot(*a).abs() < 1e-14));
                }
            }
        }
    }
}

#[test]
fn all_six_normals_point_out() {
    // Right is direction × up, not up × direction as some texts have it.
    let projection =
        Projection::Perspective { fov_y_radians: 1.0, aspect: 1.5, near: 1.0, far: 10.0 };
    let c = Camera::look_at([5.0, 6.0, 7.0], [5.0, 6.0, -7.0], projection);
    let [r, u, b] = c.basis().unwrap();
    assert_eq!((r, u, b), ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]));
    for f in [c.frustum().unwrap(), view_of(&c, Depth::Standard).frustum()] {
        let expected = [(0, -1.0), (0, 1.0), (1, -1.0), (1, 1.0), (2, 1.0), (2, -1.0)];
        for ((i, plane), (axis, sign)) in f.planes().zip(expected) {
            assert!(plane.normal[axis] * sign > 0.5, "plane {i}: {plane:?}");
        }
        let signed = |i: usize, p: [f64; 3]| f.planes().nth(i).unwrap().1.distance(p);
        assert!((0..6).all(|i| signed(i, [5.0, 6.0, 2.0]) < 0.0));
        assert!((signed(4, [5.0, 6.0, 6.5]) - 0.5).abs() < 1e-12, "half a unit before near");
        assert!((signed(5, [5.0, 6.0, -4.0]) - 1.0).abs() < 1e-12, "one unit beyond far");
    }
}

#[test]
fn near_width_and_distance_say_the_same_as_a_field_of_view() {
    let (near, far, aspect) = (0.5, 40.0, 1.6);
    let fov_y_radians = 0.9_f64;
    let height = 2.0 * near * (fov_y_radians / 2.0).tan();
    let [a, b] = [
        Projection::Perspective { fov_y_radians, aspect, near, far },
        Projection::OffCentre {
            left: -height * aspect / 2.0,
            right: height * aspect / 2.0,
            bottom: -height / 2.0,
            top: height / 2.0,
            near,
            far,
        },
    ]
    .map(|p| Camera::look_at([1.0, 2.0, 3.0], [4.0, 4.0, 4.0], p).frustum().unwrap());
    for ((_, a), (_, b)) in a.planes().zip(b.planes()) {
        assert!(
            DVec3::from(a.normal).distance(b.normal.into()) < 1e-14 && (a.d - b.d).abs() < 1e-14
        );
    }
}

#[test]
fn a_view_without_an_end_has_no_far_plane_and_rejects_nothing_by_it() {
    for depth in [Depth::Standard, Depth::Reversed] {
        let c = Camera::look_at(
            [1e3, -2e3, 3e3],
            [0.0; 3],
            Projection::Perspective {
                fov_y_radians: 1.0,
                aspect: 1.0,
                near: 0.01,
                far: f64::INFINITY,
            },
        );
        let f = view_of(&c, depth).frustum();
        assert_eq!(f.present(), 0b01_1111);
        let ahead = DVec3::from(c.eye) + DVec3::from(c.direction) * 1e20;
        assert!(f.contains(ahead));
    }
}

#[test]
fn a_far_plane_at_a_great_ratio_stays() {
    // 1e12 times the near distance: the row that holds it is 1e-12 of its parents, and still said.
    let projection =
        Projection::Perspective { fov_y_radians: 1.0, aspect: 1.0, near: 1e-3, far: 1e9 };
    let c = Camera::look_at([0.0; 3], [0.0, 0.0, -1.0], projection);
    for depth in [Depth::Standard, Depth::Reversed] {
        let f = view_of(&c, depth).frustum();
        assert!(f.contains([0.0, 0.0, -0.999e9]), "{depth:?}");
        assert!(!f.contains([0.0, 0.0, -1.02e9]), "{depth:?}: gives way by at most 2 %");
    }
}

#[test]
fn no_point_that_clip_space_keeps_after_rounding_is_rejected() {
    // In f64, z ≤ w lets through points that are beyond the far plane by the rounding of z and w.
    let projection =
        Projection::Perspective { fov_y_radians: 1.1, aspect: 1.7, near: 1e-3, far: 1e6 };
    let c = Camera::look_at([123.4, 5.6, 78.9], [1.0, 2.0, 3.0], projection);
    let view = view_of(&c, Depth::Standard);
    let (m, f) = (clip_from_world(&view), view.frustum());
    let far = m.row(3) - m.row(2);
    let mut slipped = 0;
    for i in 0..20_000 {
        let t = f64::from(i) / 20_000.0;
        let ray = view.ray([640.0 * (t * 37.0).fract(), 480.0 * (t * 11.0).fract()]).unwrap();
        let (o, d) = (DVec3::from(ray.origin), DVec3::from(ray.direction));
        // Where the plane of the rows' difference meets the line of sight, and a little farther.
        let meet = -far.dot(o.extend(1.0)) / far.truncate().dot(d);
        let p = o + d * (meet + 0.2 * (t * 101.0).fract());
        let clip: DVec4 = m * p.extend(1.0);
        if clip.z <= clip.w {
            assert!(f.contains(p), "{p:?} is kept by clip space");
            slipped += usize::from(far.dot(p.extend(1.0)) < 0.0);
        }
    }
    assert!(slipped > 100, "the test meets what it is about: {slipped}");
}

#[test]
fn there_are_thirty_two_planes_and_no_more() {
    let mut f = Frustum::everything();
    for i in 0..26 {
        assert_eq!(f.push(Plane::new([0.0, 3.0, 0.0], 3.0 * f64::from(i))), Ok(6 + i as usize));
    }
    assert_eq!(f.planes().count(), 26);
    assert!(f.planes().all(|(_, p)| p.normal == [0.0, 1.0, 0.0]), "normalised");
    let refused = f.push(Plane::new([0.0, 1.0, 0.0], 1.0));
    assert_eq!(refused, Err(ViewError::TooManyPlanes { limit: 32 }));
    let nothing = Plane::new([0.0; 3], 1.0);
    assert_eq!(Frustum::everything().push(nothing), Err(ViewError::NoPlane(nothing)));
    let nan = Plane::new([1.0, f64::NAN, 0.0], 1.0);
    assert!(Frustum::everything().push(nan).is_err());
    // Taken as they are, such planes count as absent, and nothing is lost by them.
    let f = Frustum::from_planes([Some(nan), Some(nothing), None, None, None, None]);
    assert_eq!(f.present(), 0);
    let mut cut =
        View::perspective([0.0; 3], [1.0, 0.0, 0.0], 1.0, 1.0, 9.0, [8, 8]).unwrap().frustum();
    cut.push(Plane::new([1.0, 0.0, 0.0], 5.0)).unwrap();
    assert!(cut.contains([4.0, 0.0, 0.0]) && !cut.contains([6.0, 0.0, 0.0]));
}

#[test]
fn a_transform_that_flattens_or_is_not_finite_rejects_nothing_by_what_it_lost() {
    let f = View::perspective([0.0; 3], [0.0, 0.0, -1.0], 1.0, 1.0, 9.0, [8, 8]).unwrap().frustum();
    // All of the object lies in the plane z = −5: near and far say nothing about its points.
    let flat = Transform::from_scale_translation([1.0, 1.0, 0.0], [0.0, 0.0, -5.0]);
    let object = f.to_object_space(&flat);
    assert_eq!(object.present(), 0b00_1111);
    assert!(object.contains([1.0, 1.0, 1e30]) && !object.contains([9.0, 0.0, 0.0]));
    let mut broken = Transform::IDENTITY;
    broken.linear[1][1] = f32::NAN;
    assert_eq!(f.to_object_space(&broken).present(), 0);
    let mirror = Transform::from_scale_translation([-2.0, 1.0, 1.0], [0.0; 3]);
    let (m, p) = (f.to_object_space(&mirror), [-0.9, 0.0, -4.0]);
    assert!(m.contains(p) && f.contains([1.8, 0.0, -4.0]));
    assert_eq!(m.planes().next().unwrap().1.side_of([5.0, 0.0, -4.0]), Side::Outside);
}

#[test]
fn far_from_the_origin_a_view_stays_or_says_that_it_cannot() {
    let at = |eye: f64, near: f64, depth: Depth| {
        let projection =
            Projection::Perspective { fov_y_radians: 1.0, aspect: 1.5, near, far: near * 1e5 };
        let c = Camera {
            eye: [eye, -eye, eye],
            direction: [1.0, 2.0, 3.0],
            up: [0.0, 1.0, 0.0],
            projection,
        };
        View::new(&c, depth, [640, 480])
    };
    let view = at(1e7, 0.01, Depth::Reversed).unwrap();
    let eye = DVec4::from(view.eye());
    assert!(eye.distance(DVec4::new(1e7, -1e7, 1e7, 1.0)) < 1e-6, "{eye:?}");
    assert!(at(1e7, 0.01, Depth::Standard).is_ok());
    assert!(matches!(at(1e17, 0.1, Depth::Standard), Err(ViewError::Singular(_))));
    assert!(at(1e17, 1e15, Depth::Standard).is_ok());
}

#[test]
fn a_singular_matrix_is_refused() {
    for depth in [Depth::Standard, Depth::Reversed] {
        for m in [DMat4::ZERO, DMat4::from_cols(DVec4::X, DVec4::X, DVec4::Z, DVec4::W)] {
            let refused = View::from_matrix(m.to_cols_array(), depth, [8, 8]);
            assert!(matches!(refused, Err(ViewError::Singular(_))), "{refused:?}");
        }
        // Rank 3 but for rounding: each row a mix of three others.
        let mut m = DMat4::from_cols_array(&std::array::from_fn(|i| (i as f64 * 1.7).sin()));
        m.w_axis = m.x_axis * 0.3 + m.y_axis * 0.7 - m.z_axis / 3.0;
        let refused = View::from_matrix(m.to_cols_array(), depth, [8, 8]);
        assert!(matches!(refused, Err(ViewError::Singular(_))), "{refused:?}");
    }
}

#[test]
fn bad_numbers_are_named() {
    let view = |fov, near, far, size| View::perspective([0.0; 3], [1.0; 3], fov, near, far, size);
    assert_eq!(view(1.0, 1.0, 9.0, [0, 8]), Err(ViewError::Viewport(0, 8)));
    let text = |v: Result<View, ViewError>| v.unwrap_err().to_string();
    assert!(text(view(4.0, 1.0, 9.0, [8, 8])).starts_with("field of view is 4"));
    assert!(text(view(1.0, 0.0, 9.0, [8, 8])).starts_with("near is 0"));
    assert!(text(view(1.0, 1.0, 0.5, [8, 8])).starts_with("far is 0.5"));
    assert!(text(view(1.0, 1.0, f64::NAN, [8, 8])).starts_with("far is NaN"));
    let same = View::perspective([1.0; 3], [1.0; 3], 1.0, 1.0, 9.0, [8, 8]);
    assert!(matches!(same, Err(ViewError::NoOrientation { .. })));
    let flat = View::orthographic([0.0; 3], [1.0; 3], 0.0, 0.0, 9.0, [8, 8]);
    assert!(text(flat).starts_with("window width is 0"));
    let endless = View::orthographic([0.0; 3], [1.0; 3], 1.0, 0.0, f64::INFINITY, [8, 8]);
    assert!(text(endless).starts_with("far is inf"));
}

#[test]
fn shortcuts_fill_the_viewport() {
    let o = View::orthographic([0.0, 0.0, 9.0], [0.0; 3], 4.0, 0.0, 20.0, [200, 100]).unwrap();
    assert_eq!(o.project_point([4.0, 2.0, 0.0]).map(|p| [p[0], p[1]]), Some([200.0, 0.0]));
    let p = View::perspective([0.0; 3], [0.0, 0.0, -1.0], 1.0, 1.0, 9.0, [200, 100]).unwrap();
    let top = 0.5_f64.tan() * 5.0;
    let [x, y, _] = p.project_point([2.0 * top, top, -5.0]).unwrap();
    assert!((x - 200.0).abs() < 1e-9 && y.abs() < 1e-9, "{x} {y}");
    let m = DMat4::from_cols_array(&p.world_from_clip()) * clip_from_world(&p);
    assert!(m.abs_diff_eq(DMat4::IDENTITY, 1e-12));
}

proptest! {
    #![proptest_config(config(200))]

    /// A slice shows the points of its view between two distances, and no others.
    #[test]
    fn a_slice_shows_what_lies_between_two_distances(
        c in camera(20.0), depth in depth(), cut in 0.2..0.8_f64, at in [-0.2..1.2, -0.2..1.2, 0.01..0.99],
    ) {
        let view = view_of(&c, depth);
        let along = DVec3::from(c.direction).normalize();
        let near = point_in(&c, [0.5, 0.5, 0.0]);
        let from = if view.is_orthographic() { near } else { DVec3::from(c.eye) };
        let distance = |p: DVec3| -> f64 { (p - from).dot(along) };
        let far = distance(point_in(&c, [0.5, 0.5, 1.0]));
        let split = distance(near) + (far - distance(near)) * cut;
        let point = point_in(&c, at);
        prop_assume!((distance(point) - split).abs() > 1e-6 * split.abs());
        let slices = view.slices(&[distance(near), split, far]).unwrap();
        let inside = view.frustum().contains(point);
        let found = [&slices[0], &slices[1]].map(|slice: &View| slice.frustum().contains(point));
        let expected = [inside && distance(point) < split, inside && distance(point) > split];
        prop_assert_eq!(found, expected);
        prop_assert_eq!((slices[0].depth(), slices[0].layers), (depth, view.layers));
    }

    /// A matrix for depth −1..1 makes the view of its volume, and none of the other depth.
    #[test]
    fn a_matrix_for_depth_from_minus_one_makes_the_same_view(c in camera(20.0), depth in depth()) {
        let view = view_of(&c, depth);
        let mut m = view.clip_from_world();
        m.chunks_exact_mut(4).for_each(|column| column[2] = 2.0 * column[2] - column[3]);
        let of_gl = View::from_gl_matrix(m, depth, view.viewport()).unwrap();
        let apart = of_gl.clip_from_world().iter().zip(view.clip_from_world())
            .map(|(a, b)| (a - b).abs() / b.abs().max(1.0)).fold(0.0, f64::max);
        prop_assert!(apart < 1e-12, "{apart:e}");
        let other = if depth == Depth::Standard { Depth::Reversed } else { Depth::Standard };
        let stated_wrong = View::from_matrix(view.clip_from_world(), other, view.viewport());
        if !view.is_orthographic() {
            prop_assert_eq!(stated_wrong, Err(ViewError::Depth { stated: other, found: depth }));
        }
    }
}

#[test]
fn slices_refuse_distances_that_bound_nothing() {
    let view = View::perspective([0.0; 3], [0.0, 0.0, -1.0], 1.0, 0.1, 100.0, [8, 8]).unwrap();
    for (near, far) in [(0.0, 1.0), (-1.0, 1.0), (2.0, 2.0), (3.0, 2.0), (1.0, f64::NAN)] {
        let refused = view.slice(near, far);
        assert!(matches!(refused, Err(ViewError::Range { .. })), "{near} to {far}: {refused:?}");
    }
    assert!(
        view.slice(f64::NAN, 1.0).is_err() && view.slice(f64::INFINITY, f64::INFINITY).is_err()
    );
    let endless = view.slice(5.0, f64::INFINITY).unwrap();
    assert!(endless.frustum().contains([0.0, 0.0, -1e9]));
    assert!(!endless.frustum().contains([0.0, 0.0, -4.9]));
    assert!(view.slices(&[1.0]).unwrap().is_empty());
    let plan = View::orthographic([0.0; 3], [0.0, 0.0, -1.0], 2.0, -5.0, 5.0, [8, 8]).unwrap();
    assert!(plan.slice(1.0, f64::INFINITY).is_err());
    assert!(plan.slice(0.0, 1.0).unwrap().frustum().contains([0.0, 0.0, 4.5]));
}
