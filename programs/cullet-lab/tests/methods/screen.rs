//! The form after projection against the exact oracle and the form in object space.

use cullet::cull::backface::{Facing, ObjectEye};
use cullet::{
    Depth, Transform, View,
    view::{CullFace, FrontFace},
};
use cullet_lab::methods::screen::{flips_winding, screen_facing};
use cullet_testkit::oracles::triangles::facing_ref;
use cullet_testkit::strategies::{corners, distant_transform, distant_view};
use proptest::prelude::*;

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

    /// Nothing is called front or back, what matters to verification, that an f64 renderer might
    /// see the other way round.
    #[test]
    fn what_is_decided_is_seen_so_after_projection(view in distant_view(), transform in distant_transform(), corners in corners()) {
        let facing = ObjectEye::of_view(&view, &transform).facing(&corners);
        if facing != Facing::Edge {
            for clip in [clip, clip_combined] {
                let clip = clip(&view, &transform, &corners);
                let flipped = flips_winding(&view, &transform);
                let screen = screen_facing(&clip, flipped, view.front_face);
                prop_assert!(screen == facing || screen == Facing::Edge, "{screen:?}");
            }
        }
    }

    /// The two forms agree: after projection nothing is decided wrongly either, given coordinates
    /// that carry no rounding of their own (powers of two, and few of them).
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
        let mut view = View::from_matrix(matrix, Depth::Standard, [64, 64]).expect("a view");
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
}
