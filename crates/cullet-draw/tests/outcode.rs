//! Outcodes against the exact oracle, over views of every kind.

use cullet::bounds::Side;
use cullet::cull::frustum::triangles::ObjectRegion;
use cullet::{Depth, Transform};
use cullet_draw::clip::{OutcodeRegion, OutcodeResult, Sorted};
use cullet_testkit::oracles::clip::outcode_ref;
use cullet_testkit::strategies::{corners, distant_transform, distant_view};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cullet_testkit::cases(2000)))]

    #[test]
    fn outside_and_inside_are_proofs(view in distant_view(), transform in distant_transform(), corners in corners()) {
        let frustum = view.frustum();
        let region = OutcodeRegion::new(&frustum, &transform);
        let codes = corners.map(|p| region.outcode(p));
        for (code, p) in codes.iter().zip(corners) {
            let [outside, not_inside] = outcode_ref(&frustum, &transform, p);
            prop_assert_eq!(code.outside & !outside, 0);
            prop_assert_eq!(not_inside & !code.not_inside, 0);
            prop_assert_eq!(code.outside & !code.not_inside, 0);
            // Where the two differ, the point is as good as on the plane.
            for (i, plane) in frustum.planes() {
                if (code.outside ^ outside | code.not_inside ^ not_inside) >> i & 1 == 1 {
                    let world: [f64; 3] = std::array::from_fn(|r| {
                        (0..3).map(|c| f64::from(transform.linear[c][r]) * f64::from(p[c])).sum::<f64>()
                            + transform.translation[r]
                    });
                    prop_assert!(plane.distance(world).abs() < 1e-5, "{}", plane.distance(world));
                }
            }
        }
        let shared = codes[0].outside & codes[1].outside & codes[2].outside;
        let expected = (shared != 0).then(|| shared.trailing_zeros() as u8);
        let culling = ObjectRegion::new(&frustum, &transform);
        prop_assert_eq!(culling.rejects(&corners, u32::MAX), expected);
        prop_assert_eq!(region.classify(&corners) == Side::Outside, shared != 0);
        let mut kept = Vec::new();
        culling.keep_into(&corners, &[0, 1, 2, 0, 1, 3], 0..2, u32::MAX, &mut kept);
        prop_assert_eq!(kept, if shared != 0 { vec![1] } else { vec![0, 1] });
    }

    /// A point that a renderer in f64 would find within the clip volume is outside of no plane.
    #[test]
    fn what_a_renderer_keeps_is_kept(view in distant_view(), transform in distant_transform(), corners in corners()) {
        let region = OutcodeRegion::new(&view.frustum(), &transform);
        let (m, t) = (view.clip_from_world(), transform.to_matrix());
        let entry = |r: usize, c: usize| (0..4).map(|k| m[k * 4 + r] * t[c * 4 + k]).sum::<f64>();
        for p in corners {
            let [x, y, z, w] = std::array::from_fn(|r| {
                (0..3).map(|c| entry(r, c) * f64::from(p[c])).sum::<f64>() + entry(r, 3)
            });
            let [near, far] = match view.depth() {
                Depth::Standard => [z, w - z],
                Depth::Reversed => [w - z, z],
            };
            let inside = [w + x, w - x, w + y, w - y, near, far];
            let outside = region.outcode(p).outside;
            for i in 0..6 {
                prop_assert!(outside >> i & 1 == 0 || inside[i] < 0.0, "plane {i}: {}", inside[i]);
            }
        }
    }

    /// Accepted, rejected or a candidate, in a batch as one by one; and of the candidates those that
    /// miss have no point that is inside.
    #[test]
    fn sorted_triangles_are_those_of_single_results(
        view in distant_view(),
        transform in distant_transform(),
        triangles in prop::collection::vec(corners(), 1..30),
        weights in prop::collection::vec(prop::array::uniform3(0.0..1.0f32), 20),
    ) {
        let region = OutcodeRegion::new(&view.frustum(), &transform);
        let points: Vec<_> = triangles.iter().copied().flatten().collect();
        let indices: Vec<u32> = (0..points.len() as u32).chain([0, 1, 9999]).collect();
        let mut sorted = Sorted::default();
        let count = indices.len() as u32 / 3;
        region.sort_into(&points, &indices, 0..count + 7, &mut sorted);
        let mut expected = [Vec::new(), Vec::new(), Vec::new()];
        for (t, corners) in (0..).zip(&triangles) {
            let kind = match region.test(corners) {
                OutcodeResult::Accepted => 0,
                OutcodeResult::Candidate(planes) => {
                    let xor = corners.iter().fold(0, |or, &p| or | region.outcode(p).not_inside);
                    prop_assert_eq!(planes, xor);
                    1
                }
                OutcodeResult::Rejected(_) => 2,
            };
            expected[kind].push(t);
        }
        expected[1].push(count - 1);
        prop_assert_eq!(&sorted.accepted, &expected[0]);
        prop_assert_eq!(&sorted.candidates, &expected[1]);
        prop_assert_eq!(sorted.rejected as usize, expected[2].len());
        let all = sorted.candidates.clone();
        region.resolve(&points, &indices, &mut sorted);
        prop_assert_eq!(all.len(), sorted.candidates.len() + sorted.false_positives as usize);
        for t in all.iter().filter(|t| !sorted.candidates.contains(t)) {
            let [a, b, c] = triangles[*t as usize];
            for w in &weights {
                let sum = w[0] + w[1] + w[2] + 1e-9;
                let p = [0, 1, 2].map(|i| (a[i] * w[0] + b[i] * w[1] + c[i] * w[2]) / sum);
                let code = region.outcode(p);
                prop_assert!(code.not_inside != 0, "{:?} is inside", p);
            }
        }
    }
}

/// Around a corner of a cube: no plane rejects it, clipping does.
#[test]
fn a_triangle_around_a_corner_is_a_false_positive() {
    let plane = |n: [f64; 3]| Some(cullet::bounds::Plane::new(n, 1.0));
    let cube = cullet::view::Frustum::from_planes([
        plane([-1.0, 0.0, 0.0]),
        plane([1.0, 0.0, 0.0]),
        plane([0.0, -1.0, 0.0]),
        plane([0.0, 1.0, 0.0]),
        plane([0.0, 0.0, -1.0]),
        plane([0.0, 0.0, 1.0]),
    ]);
    let region = OutcodeRegion::new(&cube, &Transform::IDENTITY);
    let points = [
        [3.0, 0.0, 0.0],
        [0.0, 3.0, 0.0],
        [2.0, 2.0, 0.0], // around an edge
        [3.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [2.0, 2.0, 0.0], // through it
        [0.0, 0.0, 0.0],
        [0.5, 0.0, 0.0],
        [0.0, 0.5, 0.0], // inside
        [5.0, 0.0, 0.0],
        [6.0, 0.0, 0.0],
        [5.0, 0.5, 0.0], // outside
        [f32::NAN, 3.0, 0.0],
        [0.0, 2.0, 0.0],
        [3.0, 2.0, 0.0], // undecided
    ];
    let indices: Vec<u32> = (0..15).collect();
    let mut sorted = Sorted::default();
    region.sort_into(&points, &indices, 0..5, &mut sorted);
    assert_eq!((&sorted.accepted[..], &sorted.candidates[..]), (&[2][..], &[0, 1, 4][..]));
    assert_eq!(region.test(&points[..3]), OutcodeResult::Candidate(0b1010));
    assert_eq!(region.test(&points[9..12]), OutcodeResult::Rejected(0b10));
    assert_eq!(region.test(&[[-3.0, 0.0, 0.0], [3.0, 0.5, 0.0]]), OutcodeResult::Candidate(0b11));
    region.resolve(&points, &indices, &mut sorted);
    assert_eq!((sorted.false_positives, &sorted.candidates[..]), (1, &[1, 4][..]));
    region.sort_into(&points, &indices, 4..4, &mut sorted);
    assert_eq!((sorted.candidates.len(), sorted.rejected, sorted.false_positives), (0, 0, 0));
}
