//! Back-face tests against the exact oracle, and against the form after projection.

use cullet::cull::backface::{Facing, ObjectEye, facing_ref, flips_winding, screen_facing};
use cullet::cull::degenerate::{self, Flattening};
use cullet::{Camera, CullFace, Depth, FrontFace, Projection, Transform, View};
use proptest::prelude::*;

fn unit() -> impl Strategy<Value = f64> {
    -1.0..1.0f64
}

fn vector() -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(unit())
}

/// Any projection there is: symmetric, off-centre, orthographic, mirrored, near or without an end.
fn projection() -> impl Strategy<Value = Projection> {
    let far = prop_oneof![Just(f64::INFINITY), 10.0..1e5];
    let window = || (0.01..2.0f64, 0.01..2.0f64, unit(), unit(), any::<bool>());
    prop_oneof![
        (0.05..3.0f64, 0.2..4.0f64, 0.001..1.0f64, far.clone()).prop_map(
            |(fov_y_radians, aspect, near, far)| Projection::Perspective {
                fov_y_radians,
                aspect,
                near,
                far
            }
        ),
        (window(), 0.01..1.0f64, far).prop_map(|((w, h, x, y, mirror), near, far)| {
            let (left, right) = (x - w, x + w);
            let (left, right) = if mirror { (right, left) } else { (left, right) };
            Projection::OffCentre { left, right, bottom: y - h, top: y + h, near, far }
        }),
        (window(), -5.0..5.0f64, 1.0..1e3f64).prop_map(|((w, h, x, y, mirror), near, depth)| {
            let (left, right) = if mirror { (x + w, x - w) } else { (x - w, x + w) };
            let far = near + depth;
            Projection::Orthographic { left, right, bottom: y - h, top: y + h, near, far }
        }),
    ]
}

fn view() -> impl Strategy<Value = View> {
    let place = (vector(), 0..8i32).prop_map(|(v, e)| v.map(|v| v * 10f64.powi(e)));
    let depth = prop_oneof![Just(Depth::Standard), Just(Depth::Reversed)];
    let front = prop_oneof![Just(FrontFace::CounterClockwise), Just(FrontFace::Clockwise)];
    (place, vector(), projection(), depth, front).prop_filter_map(
        "no orientation",
        |(eye, direction, projection, depth, front)| {
            let camera = Camera { eye, direction, up: [0.1, 1.0, 0.2], projection };
            let mut view = View::new(&camera, depth, [640, 480]).ok()?;
            view.front_face = front;
            Some(view)
        },
    )
}

/// Affine, mirrored and sheared, near the eye or anywhere.
fn transform() -> impl Strategy<Value = Transform> {
    let linear = prop::array::uniform3(prop::array::uniform3(-2.0..2.0f32));
    let place = (vector(), 0..8i32).prop_map(|(v, e)| v.map(|v| v * 10f64.powi(e)));
    let diagonal = prop::array::uniform3(prop_oneof![-3.0..3.0f32, Just(0.0f32), Just(1e-6f32)])
        .prop_map(|d| Transform::from_scale_translation(d, [0.0; 3]).linear);
    (prop_oneof![linear, diagonal], place)
        .prop_map(|(linear, translation)| Transform { linear, translation })
}

/// Triangles of any size and place, some of them slivers.
fn corners() -> impl Strategy<Value = [[f32; 3]; 3]> {
    let point = || prop::array::uniform3(-1.0..1.0f32);
    (point(), point(), point(), -6..6i32, -8..1i32, any::<bool>()).prop_map(
        |(a, b, c, place, size, sliver)| {
            let (place, size) = (10f32.powi(place), 10f32.powi(size));
            let c = if sliver { [0, 1, 2].map(|i| b[i] * 0.5 + c[i] * 1e-6) } else { c };
            let at = |p: [f32; 3]| [0, 1, 2].map(|i| (a[i] + p[i] * size) * place);
            [at([0.0; 3]), at(b), at(c)]
        },
    )
}

/// The corners in clip space, as a renderer in f64 would have them.
fn clip(view: &View, transform: &Transform, corners: &[[f32; 3]; 3]) -> [[f64; 4]; 3] {
    let m = view.clip_from_world();
    corners.map(|p| {
        let world: [f64; 3] = std::array::from_fn(|i| {
            (0..3).map(|j| f64::from(transform.linear[j][i]) * f64::from(p[j])).sum::<f64>()
                + transform.translation[i]
        });
        std::array::from_fn(|r| {
            m[r] * world[0] + m[4 + r] * world[1] + m[8 + r] * world[2] + m[12 + r]
        })
    })
}

/// The same from one combined matrix: other roundings.
fn clip_combined(view: &View, transform: &Transform, corners: &[[f32; 3]; 3]) -> [[f64; 4]; 3] {
    let (m, t) = (view.clip_from_world(), transform.to_matrix());
    let entry = |r: usize, c: usize| (0..4).map(|k| m[k * 4 + r] * t[c * 4 + k]).sum::<f64>();
    corners.map(|p| {
        std::array::from_fn(|r| {
            (0..3).map(|c| entry(r, c) * f64::from(p[c])).sum::<f64>() + entry(r, 3)
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cullet_testkit::cases(4000)))]

    /// Nothing is called front or back that the exact answer does not call so; nor, what matters to
    /// verification, that an f64 renderer might see the other way round.
    #[test]
    fn what_is_decided_is_right(view in view(), transform in transform(), corners in corners()) {
        let facing = ObjectEye::of_view(&view, &transform).facing(&corners);
        if facing != Facing::Edge {
            prop_assert_eq!(facing, facing_ref(&view, &transform, &corners));
            for clip in [clip, clip_combined] {
                let clip = clip(&view, &transform, &corners);
                let flipped = flips_winding(&view, &transform);
                let screen = screen_facing(&clip, flipped, view.front_face);
                prop_assert!(screen == facing || screen == Facing::Edge, "{screen:?}");
            }
        }
    }

    /// The two forms agree: after projection nothing is decided wrongly either, given coordinates that
    /// carry no rounding of their own (powers of two, and few of them).
    #[test]
    fn the_form_after_projection_is_equal(
        eye in prop::array::uniform3(-8..8i32), corners in
        prop::array::uniform3(prop::array::uniform3(-8..8i32)), mirror: bool, flip: bool, clockwise: bool
    ) {
        let x = if mirror { -1.0 } else { 1.0 };
        // Looks along −Z from `eye`, with a field of view of 90 degrees and no end.
        let e = eye.map(f64::from);
        let matrix = [
            x, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0, -1.0,
            -x * e[0], -e[1], e[2] - 1.0, e[2],
        ];
        let mut view = View::from_matrix(&matrix, Depth::Standard, [64, 64]).expect("a view");
        view.front_face = if clockwise { FrontFace::Clockwise } else { FrontFace::CounterClockwise };
        let scale = [if flip { -1.0 } else { 1.0 }, 2.0, 0.5];
        let transform = Transform::from_scale_translation(scale, [1.0, -2.0, 3.0]);
        let corners = corners.map(|p| p.map(|v| v as f32));
        let object = ObjectEye::of_view(&view, &transform).facing(&corners);
        let exact = facing_ref(&view, &transform, &corners);
        let clip = clip(&view, &transform, &corners);
        let screen = screen_facing(&clip, flips_winding(&view, &transform), view.front_face);
        prop_assert_eq!(object, exact);
        prop_assert_eq!(screen, exact);
        let eye = [e[0], e[1], e[2], 1.0];
        let given = ObjectEye::new(eye, &transform, view.front_face, CullFace::Back);
        prop_assert_eq!(given.facing(&corners), exact);
    }

    #[test]
    fn flattening_equals_the_oracle(transform in transform(), corners in corners(), snap: bool) {
        let corners = if snap { corners.map(|p| p.map(|v| (v * 2.0).round())) } else { corners };
        let flat = Flattening::of(&transform);
        prop_assert_eq!(flat.flattens(&corners), degenerate::flattens_ref(&transform, &corners));
        let none = Transform::IDENTITY;
        prop_assert_eq!(
            degenerate::is_zero_area(&corners), degenerate::flattens_ref(&none, &corners)
        );
        // What the flattened instance still shows is kept by the back-face test.
        if flat.rank() < 3 {
            let eye = [3.0, 4.0, 5.0, 1.0];
            let eye = ObjectEye::new(eye, &transform, FrontFace::default(), CullFace::Back);
            prop_assert_eq!(eye.facing(&corners), Facing::Edge);
        }
    }

    #[test]
    fn singular_by_rows_equals_the_oracle(
        rows in prop::array::uniform3(prop::array::uniform3(-3..4i8)), mix in prop::array::uniform2(-2..3i8),
        corners in prop::array::uniform3(prop::array::uniform3(-2..3i8))
    ) {
        // The third row is a mix of the others.
        let [a, b, _] = rows.map(|r| r.map(f32::from));
        let c = [0, 1, 2].map(|i| a[i] * f32::from(mix[0]) + b[i] * f32::from(mix[1]));
        let linear = [0, 1, 2].map(|j| [a[j], b[j], c[j]]);
        let transform = Transform { linear, translation: [0.0; 3] };
        let corners = corners.map(|p| p.map(f32::from));
        let flat = Flattening::of(&transform);
        prop_assert!(flat.rank() < 3);
        prop_assert_eq!(flat.flattens(&corners), degenerate::flattens_ref(&transform, &corners));
    }
}

fn sphere_of_triangles() -> (Vec<[f32; 3]>, Vec<u32>) {
    // Triangles that touch a ball at Fibonacci points, counter-clockwise from outside.
    let (mut positions, mut indices) = (Vec::new(), Vec::new());
    let n = 1000;
    for i in 0..n {
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(n);
        let (s, c) = (f64::from(i) * 2.399_963_229_728_653).sin_cos();
        let r = (1.0 - z * z).sqrt();
        let normal = glam::DVec3::new(r * c, r * s, z);
        let u = normal.any_orthonormal_vector();
        let v = normal.cross(u);
        for p in [normal, normal + u * 0.01, normal + v * 0.01] {
            indices.push(positions.len() as u32);
            positions.push(p.as_vec3().into());
        }
    }
    (positions, indices)
}

/// Keeping everything would be conservative too: at distance d the back takes (1 + 1/d) / 2 of a ball.
#[test]
fn it_culls_what_it_should() {
    let (positions, indices) = sphere_of_triangles();
    for distance in [1.5, 3.0, 1e6] {
        // Seen from the same place through a mirrored, stretched and moved instance.
        for scale in [[1.0, 1.0, 1.0], [-2.0, 3.0, 0.5]] {
            let at = [1e7, -1e7, 5.0];
            let transform = Transform::from_scale_translation(scale, at);
            let direction = [2.0 / 7.0, 3.0 / 7.0, 6.0 / 7.0];
            let eye: [f64; 3] =
                std::array::from_fn(|i| at[i] + f64::from(scale[i]) * direction[i] * distance);
            let eye = ObjectEye::new(
                [eye[0], eye[1], eye[2], 1.0],
                &transform,
                FrontFace::default(),
                CullFace::Back,
            );
            let mut mask = Vec::new();
            let kept = eye.mask_into(&positions, &indices, &mut mask);
            let culled = 1.0 - kept as f64 / 1000.0;
            let expected = (1.0 + 1.0 / distance) / 2.0;
            assert!((culled - expected).abs() < 0.01, "{culled} of {expected} at {distance}");
            let mut list = vec![7];
            assert_eq!(eye.keep_into(&positions, &indices, 0..1000, &mut list), kept);
            let bits = (0..1000).filter(|t| mask[*t as usize / 64] >> (t % 64) & 1 == 1);
            assert!(list[1..].iter().copied().eq(bits));
            assert_eq!(mask.len(), 16);
        }
    }
}

#[test]
fn front_culling_and_clockwise_fronts_take_the_other_half() {
    let (positions, indices) = sphere_of_triangles();
    let kept = |front_face, cull| {
        let eye = [0.0, 0.0, 1.0, 0.0];
        let eye = ObjectEye::new(eye, &Transform::IDENTITY, front_face, cull);
        let mut list = Vec::new();
        eye.keep_into(&positions, &indices, 0..u32::MAX, &mut list);
        list
    };
    let (ccw, cw) = (FrontFace::CounterClockwise, FrontFace::Clockwise);
    let (front, back) = (kept(ccw, CullFace::Back), kept(ccw, CullFace::Front));
    assert_eq!((front.len(), back.len()), (500, 500));
    assert_eq!(kept(cw, CullFace::Back), back);
    assert_eq!(kept(cw, CullFace::Front), front);
    assert_eq!(kept(ccw, CullFace::None).len(), 1000);
}

#[test]
fn what_is_not_known_is_kept() {
    let triangle = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]];
    let facing = |eye, transform: Transform| {
        ObjectEye::new(eye, &transform, FrontFace::default(), CullFace::Back).facing(&triangle)
    };
    assert_eq!(facing([0.0, 0.0, 5.0, 1.0], Transform::IDENTITY), Facing::Back);
    // Edge-on.
    assert_eq!(facing([5.0, 0.0, 0.0, 1.0], Transform::IDENTITY), Facing::Edge);
    assert_eq!(facing([f64::NAN, 0.0, 5.0, 1.0], Transform::IDENTITY), Facing::Edge);
    assert_eq!(facing([0.0, 0.0, f64::INFINITY, 1.0], Transform::IDENTITY), Facing::Edge);
    let broken = Transform { linear: [[f32::INFINITY; 3]; 3], ..Transform::IDENTITY };
    assert_eq!(facing([0.0, 0.0, 5.0, 1.0], broken), Facing::Edge);
    let moved = Transform::from_translation([f64::NAN; 3]);
    assert_eq!(facing([0.0, 0.0, 5.0, 1.0], moved), Facing::Edge);
    let eye = [0.0, 0.0, 5.0, 1.0];
    let eye = ObjectEye::new(eye, &Transform::IDENTITY, FrontFace::default(), CullFace::Back);
    assert!(!eye.culls(&[[f32::NAN; 3], triangle[1], triangle[2]]));
    assert!(!eye.culls(&[triangle[0]; 3]), "no area, no side");
    let mut kept = Vec::new();
    assert_eq!(eye.keep_into(&triangle, &[0, 1, 2, 0, 1, 3, 0], 0..9, &mut kept), 1);
    assert_eq!(kept, [1], "a vertex out of range");
    let mut mask = Vec::new();
    assert_eq!(eye.mask_into(&triangle, &[0, 1], &mut mask), 0);
    assert!(mask.is_empty());
}
