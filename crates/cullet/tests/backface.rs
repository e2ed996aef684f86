//! Back-face tests against the exact oracle.

use cullet::cull::backface::{ClusterPlanes, Facing, ObjectEye};
use cullet::cull::degenerate::{self, Flattening};
use cullet::{
    Transform,
    view::{CullFace, FrontFace},
};
use cullet_testkit::oracles::triangles::{facing_ref, flattens_ref};
use cullet_testkit::strategies::{corners, distant_transform, distant_view};
use cullet_testkit::vectors::fibonacci;
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cullet_testkit::cases(4000)))]

    /// Nothing is called front or back that the exact answer does not call so. (That no renderer in f64 sees it
    /// the other way round is tested in `cullet-lab`, with the form after projection.)
    #[test]
    fn what_is_decided_is_right(view in distant_view(), transform in distant_transform(), corners in corners()) {
        let facing = ObjectEye::of_view(&view, &transform).facing(&corners);
        if facing != Facing::Edge {
            prop_assert_eq!(facing, facing_ref(&view, &transform, &corners));
        }
    }

    #[test]
    fn flattening_equals_the_oracle(transform in distant_transform(), corners in corners(), snap: bool) {
        let corners = if snap { corners.map(|p| p.map(|v| (v * 2.0).round())) } else { corners };
        let flat = Flattening::of(&transform);
        prop_assert_eq!(flat.flattens(&corners), flattens_ref(&transform, &corners));
        let none = Transform::IDENTITY;
        prop_assert_eq!(
            degenerate::is_zero_area(&corners), flattens_ref(&none, &corners)
        );
        // Triangles that the flattened instance still shows are kept by the back-face test.
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
        prop_assert_eq!(flat.flattens(&corners), flattens_ref(&transform, &corners));
    }
}

#[test]
fn an_eye_is_behind_a_cluster_when_it_is_behind_each_of_its_planes() {
    // One faces +z, the other +x.
    let corners = |s: f32| {
        let [o, x, y, z] = [[0.0; 3], [s, 0.0, 0.0], [0.0, s, 0.0], [0.0, 0.0, s]];
        [[o, x, y], [o, y, z]]
    };
    let planes = ClusterPlanes::new(corners(1.0));
    assert_eq!(planes.height([2.0, 0.0, -3.0, 1.0]), 2.0);
    assert_eq!(planes.height([-2.0, 0.0, -3.0, 1.0]), -2.0);
    for weight in [0.0, 1.0] {
        assert!(planes.is_behind([-2.0, 9.0, -3.0, weight]));
        assert!(!planes.is_behind([2.0, 9.0, -3.0, weight]));
        assert!(!planes.is_behind([-2.0, 9.0, 3.0, weight]));
        assert!(!planes.is_behind([-2.0, f64::NAN, -3.0, weight]));
    }
    assert!(!planes.is_behind([-2.0, 9.0, -3.0, -1.0]));
    assert!(ClusterPlanes::default().height([-2.0, 9.0, -3.0, 1.0]).is_infinite());
    // Boxes of both have a corner at zero: the other is what limits them.
    assert_eq!(planes.largest(), 1.0);
    assert!(planes.is_usable() && !ClusterPlanes::new(corners(2e14)).is_usable());
}

fn sphere_of_triangles() -> (Vec<[f32; 3]>, Vec<u32>) {
    // Triangles that touch a ball at Fibonacci points, counter-clockwise from outside.
    let (mut positions, mut indices) = (Vec::new(), Vec::new());
    let n = 1000;
    for i in 0..n {
        let normal = glam::DVec3::from(fibonacci(i, n));
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
