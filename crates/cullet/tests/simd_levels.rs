//! Batch frustum tests: the same answer at every SIMD level, in every form, and never a false cull.

use cullet::bounds::{Aabb, Boxes, Plane, Side, Sphere, Spheres};
use cullet::cull::frustum::batch::{self, Indices, Planes, SpherePlanes, VISIBLE, mask_words};
use cullet::{Camera, Depth, Projection, View, view::Frustum};
use cullet_testkit::at_every_level;
use proptest::prelude::*;

/// Signed distance of the nearest and the farthest corner of a box along a plane's normal, in f64.
fn span(plane: &Plane, b: &Aabb) -> (f64, f64) {
    let (mut near, mut far) = (-plane.d, -plane.d);
    for axis in 0..3 {
        let n = plane.normal[axis];
        let (low, high) = (f64::from(b.min[axis]), f64::from(b.max[axis]));
        if n != 0.0 {
            near += if n > 0.0 { n * low } else { n * high };
            far += if n > 0.0 { n * high } else { n * low };
        }
    }
    (near, far)
}

fn side(outside: bool, inside: bool) -> Side {
    match (outside, inside) {
        (true, _) => Side::Outside,
        (_, true) => Side::Inside,
        _ => Side::Straddling,
    }
}

/// The oracle: corners in f64. An item that is not a number, or not finite, is straddling.
fn box_ref(frustum: &Frustum, b: &Aabb) -> Side {
    if !b.is_finite() {
        return Side::Straddling;
    }
    let spans: Vec<_> = frustum.planes().map(|(_, p)| span(p, b)).collect();
    side(spans.iter().any(|s| s.0 > 0.0), spans.iter().all(|s| s.1 <= 0.0))
}

fn sphere_ref(frustum: &Frustum, s: &Sphere) -> Side {
    if !(s.center.iter().all(|v| v.is_finite()) && s.radius.is_finite()) {
        return Side::Straddling;
    }
    let r = f64::from(s.radius);
    let distance = |p: &Plane| p.normalized().unwrap().distance(s.center.map(f64::from));
    let distances: Vec<_> = frustum.planes().map(|(_, p)| distance(p)).collect();
    side(distances.iter().any(|&d| d > r), distances.iter().all(|&d| d <= -r))
}

/// Where each box lies and the plane that rejects it, by every function at every level, which must agree.
fn box_answers(frustum: &Frustum, items: &[Aabb]) -> Vec<(Side, u8)> {
    let planes = Planes::new(frustum);
    let batch = Boxes::from_slice(items);
    let n = items.len();
    let words = mask_words(n);
    let lone: Vec<Side> = items.iter().map(|b| planes.classify_box(b)).collect();
    let expected = kept(lone.iter().map(|side| *side != Side::Outside));
    let mut reasons = Vec::new();
    at_every_level!(|level_name, level| {
        let mut list = Indices::new();
        batch::cull_boxes(level, &planes, &batch, &mut list);
        assert_eq!(*list, *expected, "list at {level_name}");
        assert_eq!(batch::count_boxes(level, &planes, &batch), expected.len(), "{level_name}");
        let (mut visible, mut inside) = (vec![0; words], vec![u64::MAX; words]);
        batch::classify_boxes(level, &planes, &batch, 0, &mut visible, &mut inside);
        let bit = |mask: &[u64], i: usize| mask[i / 64] >> (i % 64) & 1 == 1;
        for i in 0..words * 64 {
            if i < n {
                let got = side(!bit(&visible, i), bit(&inside, i));
                assert_eq!(got, lone[i], "item {i} at {level_name}: {:?}", items[i]);
            } else {
                assert!(!bit(&visible, i) && !bit(&inside, i), "bit {i} of {n}");
            }
        }
        // Part of a mask is the same as the whole.
        let mut part = vec![0; words - words / 2];
        batch::mask_boxes(level, &planes, &batch, words / 2, &mut part);
        assert_eq!(part, visible[words / 2..], "{level_name}");
        let mut these = vec![0; n];
        batch::reject_boxes(level, &planes, &batch, 0, &mut these);
        assert!(reasons.is_empty() || reasons == these, "reasons at {level_name}");
        reasons = these;
    });
    lone.into_iter().zip(reasons).collect()
}

/// Returns whether each sphere is rejected, one by one and listed at every level, which must agree.
fn rejected_spheres(frustum: &Frustum, items: &[Sphere]) -> Vec<bool> {
    let planes = SpherePlanes::new(frustum);
    let batch = Spheres::from_slice(items);
    let rejected: Vec<bool> = items.iter().map(|s| planes.rejects(s)).collect();
    let expected = kept(rejected.iter().map(|rejected| !rejected));
    at_every_level!(|level_name, level| {
        let mut list = Indices::new();
        batch::cull_spheres(level, &planes, &batch, &mut list);
        assert_eq!(*list, *expected, "list at {level_name}");
    });
    rejected
}

/// The numbers of those that are kept.
fn kept(all: impl Iterator<Item = bool>) -> Vec<u32> {
    (0..).zip(all).filter(|(_, kept)| *kept).map(|(i, _)| i).collect()
}

/// Never wrong: what is culled is outside and what is inside is inside, exactly; and the plane named
/// rejects. Never lazy: what is well away from every border is answered as the oracle does.
fn check_boxes(frustum: &Frustum, boxes: &[Aabb]) {
    // Slack is relative to the box and to the plane's distance.
    let moved = |by: f64| {
        let moved = |p: &Plane| Plane::new(p.normal, p.d + by * p.d.abs().max(1e-18));
        let mut f = Frustum::from_planes(std::array::from_fn(|i| {
            frustum.planes().find(|(number, _)| *number == i).map(|(_, p)| moved(p))
        }));
        for (_, p) in frustum.planes().filter(|(number, _)| *number >= 6) {
            f.push(moved(p)).unwrap();
        }
        f
    };
    let (roomy, tight) = (moved(1e-4), moved(-1e-4));
    for (b, (got, reason)) in boxes.iter().zip(box_answers(frustum, boxes)) {
        let exact = box_ref(frustum, b);
        let size = b.min.iter().chain(&b.max).fold(1e-18_f32, |a, v| a.max(v.abs())) * 1e-4;
        let wide = Aabb::new(b.min.map(|v| v - size), b.max.map(|v| v + size));
        match got {
            Side::Outside => assert_eq!(exact, Side::Outside, "{b:?} is culled"),
            Side::Inside => {
                // Of a box that is inverted and infinite anything is true: it holds no point.
                let is_inverted = (0..3).any(|a| b.min[a] > b.max[a]);
                assert!(exact == Side::Inside || is_inverted, "{b:?} is called inside: {exact:?}");
            }
            Side::Straddling => {
                assert_ne!(box_ref(&roomy, &wide), Side::Outside, "{b:?} is kept");
                assert_ne!(box_ref(&tight, &wide), Side::Inside, "{b:?} is called straddling");
            }
        }
        assert_eq!(reason == VISIBLE, got != Side::Outside, "{b:?}");
        if reason != VISIBLE {
            let (_, plane) = frustum.planes().find(|(i, _)| *i == usize::from(reason)).unwrap();
            assert!(b.is_empty() || span(plane, b).0 > 0.0, "{b:?} by plane {reason}");
        }
    }
}

fn check_spheres(frustum: &Frustum, spheres: &[Sphere]) {
    for (s, rejected) in spheres.iter().zip(rejected_spheres(frustum, spheres)) {
        if rejected {
            assert_eq!(sphere_ref(frustum, s), Side::Outside, "{s:?} is culled");
        } else {
            let size = s.center.iter().fold(s.radius.abs(), |a, v| a + v.abs());
            let reach = frustum.planes().fold(size, |a, (_, p)| a.max(p.d.abs() as f32));
            let radius = s.radius + reach * 1e-4 + 1e-18;
            let wide = Sphere { center: s.center, radius };
            assert_ne!(sphere_ref(frustum, &wide), Side::Outside, "{s:?} is kept");
        }
    }
}

fn vector(size: f64) -> impl Strategy<Value = [f64; 3]> + Clone {
    // Now and then zero: axis-aligned views are common, and have coefficients of zero.
    let part = prop_oneof![3 => -size..size, 1 => Just(0.0)];
    [part.clone(), part.clone(), part]
}

fn projection() -> impl Strategy<Value = Projection> {
    let far = prop_oneof![3 => 10.0..1e4, 1 => Just(f64::INFINITY)];
    let ranges = (0.01..3.0, 0.2..4.0, 1e-3..5.0, far);
    let window = (-2.0..-0.1, 0.1..2.0, -1.5..-0.1, 0.1..1.5);
    (0..3, ranges, window).prop_map(
        |(kind, (fov, aspect, near, far), (left, right, bottom, top))| match kind {
            0 => Projection::Perspective { fov_y_radians: fov, aspect, near, far },
            1 => Projection::OffCentre { left, right, bottom, top, near, far },
            _ => {
                let far = if far.is_finite() { far } else { 100.0 };
                let [left, right, bottom, top] = [left, right, bottom, top].map(|v| v * 20.0);
                Projection::Orthographic { left, right, bottom, top, near: -near, far }
            }
        },
    )
}

fn view_frustum() -> impl Strategy<Value = Frustum> {
    let mirror = prop_oneof![Just(1.0), Just(-1.0)];
    let all = (vector(30.0), vector(1.0), vector(1.0), projection(), any::<bool>(), mirror);
    all.prop_filter_map("no such view", |(eye, direction, up, projection, reversed, mirror)| {
        let camera = Camera { eye, direction, up, projection };
        let depth = if reversed { Depth::Reversed } else { Depth::Standard };
        let view = View::new(&camera, depth, [640, 480]).ok()?;
        let mut matrix = view.clip_from_world();
        (0..4).for_each(|c| matrix[c * 4] *= mirror);
        Some(View::from_matrix(matrix, depth, [640, 480]).ok()?.frustum())
    })
}

/// Planes in any place: none to six of the view's, and up to 26 more.
fn any_frustum() -> impl Strategy<Value = Frustum> {
    let plane = (vector(1.0), -20.0..20.0)
        .prop_map(|(n, d)| Plane::new(n, d).normalized().filter(|_| d < 15.0));
    let six =
        [plane.clone(), plane.clone(), plane.clone(), plane.clone(), plane.clone(), plane.clone()];
    let more = prop_oneof![2 => Just(0..1), 1 => Just(0..27)]
        .prop_flat_map(move |count| prop::collection::vec(plane.clone(), count));
    (six, more).prop_map(|(six, more)| {
        let mut f = Frustum::from_planes(six);
        for plane in more.into_iter().flatten() {
            f.push(plane).unwrap();
        }
        f
    })
}

/// Coordinates near the views of these tests, and of every other size.
fn number() -> impl Strategy<Value = f32> {
    prop_oneof![
        12 => -60.0f32..60.0,
        2 => -1e17f32..1e17,
        1 => -1e-30f32..1e-30,
        1 => Just(0.0),
    ]
}

fn any_box() -> impl Strategy<Value = Aabb> {
    let small = [0.0f32..3.0, 0.0f32..3.0, 0.0f32..3.0];
    let big = [0.0f32..80.0, 0.0f32..80.0, 0.0f32..80.0];
    let valid = ([number(), number(), number()], prop_oneof![small, big])
        .prop_map(|(min, size)| Aabb::new(min, std::array::from_fn(|a| min[a] + size[a])));
    let any = prop_oneof![
        Just(f32::NAN),
        Just(f32::INFINITY),
        Just(f32::NEG_INFINITY),
        Just(f32::MAX),
        -50.0f32..50.0
    ];
    let any = [any.clone(), any.clone(), any.clone(), any.clone(), any.clone(), any];
    let invalid = any.prop_map(|[a, b, c, d, e, f]| {
        let b = Aabb::new([a, b, c], [d, e, f]);
        let nan = b.min.iter().chain(&b.max).any(|v| v.is_nan());
        // Empty boxes have a test of their own; and what is finite but beyond the limit too.
        if nan || !b.is_empty() && !b.is_finite() { b } else { Aabb::EVERYTHING }
    });
    prop_oneof![15 => valid, 1 => invalid]
}

fn any_sphere() -> impl Strategy<Value = Sphere> {
    let radius = prop_oneof![
        8 => 0.0f32..5.0,
        2 => 0.0f32..100.0,
        1 => 0.0f32..1e-20,
        1 => Just(f32::NAN)
    ];
    ([number(), number(), number()], radius).prop_map(|(center, radius)| Sphere { center, radius })
}

fn cases() -> ProptestConfig {
    ProptestConfig {
        cases: cullet_testkit::cases(150),
        failure_persistence: None,
        ..Default::default()
    }
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn boxes_in_views(f in view_frustum(), b in prop::collection::vec(any_box(), 1..200)) {
        check_boxes(&f, &b);
    }

    #[test]
    fn boxes_in_any_planes(f in any_frustum(), b in prop::collection::vec(any_box(), 1..200)) {
        check_boxes(&f, &b);
    }

    #[test]
    fn spheres_in_views(f in view_frustum(), s in prop::collection::vec(any_sphere(), 1..200)) {
        check_spheres(&f, &s);
    }

    #[test]
    fn spheres_in_any_planes(f in any_frustum(), s in prop::collection::vec(any_sphere(), 1..200)) {
        check_spheres(&f, &s);
    }

    // A sphere that reaches just as far as the farthest of its planes, to the last bit of its radius.
    #[test]
    fn spheres_that_touch(
        f in view_frustum(),
        centers in prop::collection::vec([-60.0f32..60.0, -60.0f32..60.0, -60.0f32..60.0], 64),
    ) {
        let touching: Vec<_> = centers
            .into_iter()
            .map(|center| {
                let distance = |p: &Plane| p.distance(center.map(f64::from));
                let farthest = f.planes().map(|(_, p)| distance(p)).fold(f64::MIN, f64::max);
                Sphere { center, radius: (farthest.abs() as f32).next_up() }
            })
            .collect();
        check_spheres(&f, &touching);
    }

    // A corner that lies on a plane, up to the rounding of f64, is on the knife's edge.
    #[test]
    fn boxes_on_a_plane(
        n in vector(1.0),
        boxes in prop::collection::vec(any_box(), 32),
        corner in 0..8usize,
    ) {
        let normal = Plane::new(n, 0.0).normalized();
        prop_assume!(normal.is_some() && boxes[0].is_finite());
        let through = Plane::new(normal.unwrap().normal, 0.0);
        let d = through.distance(boxes[0].corners()[corner].map(f64::from));
        let plane = Plane::new(through.normal, d);
        check_boxes(&Frustum::from_planes([Some(plane), None, None, None, None, None]), &boxes);
    }
}

fn simple_view(far: f64) -> Frustum {
    let projection = Projection::Perspective { fov_y_radians: 1.0, aspect: 1.5, near: 0.1, far };
    Camera::look_at([1.0, 2.0, 3.0], [4.0, 1.0, -2.0], projection).frustum().unwrap()
}

/// Items all over, more than a word and not a whole number of words.
fn grid() -> Vec<Aabb> {
    let at = |i: usize, step: usize| (i / step % 11) as f32 * 4.0 - 20.0;
    (0..11 * 11 * 11)
        .map(|i| {
            let min = [at(i, 1), at(i, 11), at(i, 121)];
            Aabb::new(min, min.map(|v| v + 1.0))
        })
        .collect()
}

#[test]
fn every_level_of_this_machine_is_run() {
    let mut names = Vec::new();
    at_every_level!(|name, _| {
        names.push(name);
    });
    println!("levels: {names:?}");
    if !cfg!(target_arch = "aarch64") {
        println!("skipped: NEON; cargo xtask test platforms runs it");
    }
    if cfg!(feature = "force_support_fallback") {
        assert!(names.contains(&"scalar"), "{names:?}");
    } else {
        println!("skipped: the scalar level; run with --features force_support_fallback");
    }
    assert!(!names.is_empty());
}

#[test]
fn a_grid_is_split_by_a_view_with_and_without_an_end() {
    let boxes = grid();
    for far in [15.0, 1e6, f64::INFINITY] {
        let frustum = simple_view(far);
        check_boxes(&frustum, &boxes);
        let answers = box_answers(&frustum, &boxes);
        for side in [Side::Outside, Side::Straddling, Side::Inside] {
            assert!(answers.iter().any(|a| a.0 == side), "no box is {side:?} with far {far}");
        }
        let spheres: Vec<_> = boxes.iter().map(|b| Sphere { center: b.min, radius: 1.0 }).collect();
        check_spheres(&frustum, &spheres);
        let planes: &[u8] = if far == 15.0 { &[0, 1, 2, 3, 5] } else { &[0, 1, 2, 3] };
        for plane in planes {
            assert!(answers.iter().any(|a| a.1 == *plane), "plane {plane} takes none, far {far}");
        }
    }
}

#[test]
fn what_is_not_a_number_is_kept_and_what_is_empty_is_not() {
    let frustum = simple_view(100.0);
    let mut nan = Aabb::new([1e6; 3], [1e6 + 1.0; 3]);
    nan.min[2] = f32::NAN;
    let infinite = Aabb::new([1e6; 3], [1e6, f32::INFINITY, 1e6]);
    let huge = Aabb::new([1e18; 3], [2e18; 3]);
    let boxes = [nan, infinite, huge, Aabb::EVERYTHING, Aabb::EMPTY];
    let answers: Vec<_> = box_answers(&frustum, &boxes).iter().map(|a| a.0).collect();
    let keep = Side::Straddling;
    assert_eq!(answers, [keep, keep, keep, keep, Side::Outside]);
    let sphere = |center, radius| Sphere { center, radius };
    let spheres = [
        sphere([f32::NAN, 0.0, 0.0], 1.0),
        sphere([1e6; 3], f32::NAN),
        sphere([1e6; 3], f32::INFINITY),
        sphere([4.0, 1.0, -2.0], -1.0),
    ];
    assert_eq!(rejected_spheres(&frustum, &spheres), [false, false, false, true]);
}

#[test]
fn no_plane_and_bad_planes_reject_nothing() {
    let boxes = grid();
    let none = Frustum::from_planes([None; 6]);
    assert!(box_answers(&none, &boxes).iter().all(|a| a.0 == Side::Inside));
    for bad in [
        Plane::new([f64::NAN, 0.0, 1.0], 0.0),
        Plane::new([0.0; 3], -1.0),
        Plane::new([1.0, 0.0, 0.0], f64::NAN),
        Plane::new([1.0, 0.0, 0.0], f64::NEG_INFINITY),
    ] {
        let frustum = Frustum::from_planes([Some(bad), None, None, None, None, None]);
        assert!(box_answers(&frustum, &boxes).iter().all(|a| a.0 != Side::Outside), "{bad:?}");
        let spheres = [Sphere { center: [0.0; 3], radius: 1.0 }];
        assert_eq!(rejected_spheres(&frustum, &spheres), [false], "{bad:?}");
    }
}

#[test]
fn an_empty_batch_has_an_empty_answer() {
    assert!(box_answers(&simple_view(10.0), &[]).is_empty());
    assert!(rejected_spheres(&simple_view(10.0), &[]).is_empty());
}

#[test]
fn an_infinite_box_is_kept_by_a_plane_beyond_the_limit() {
    let wall = Plane::new([-1.0, 0.0, 0.0], -1e19);
    let frustum = Frustum::from_planes([Some(wall), None, None, None, None, None]);
    let boxes = [Aabb::new([0.0; 3], [f32::INFINITY, 1.0, 1.0])];
    assert_eq!(box_answers(&frustum, &boxes)[0].0, Side::Straddling);
}
