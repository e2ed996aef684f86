//! Clipping polygons, lines and triangles.

use std::collections::BTreeSet;

use cullet::view::FrustumPlane;
use cullet::{Depth, View};
use cullet_draw::clip::{
    Clipper, GuardBand, HalfSpace, Outcode, OutcodeResult, Region, Window, space,
};
use cullet_draw::{ClipPlace, RenderOptions, Selection, render_clipped, render_ref};
use cullet_testkit::Rng;
use cullet_testkit::oracles::clip::clip_line_ref;

use crate::tools::{SIZE, built, in_clip, told, triangles, views};

/// A point in the square from −`size` to `size`.
fn point(rng: &mut Rng, size: f64) -> [f64; 2] {
    [rng.range(-size, size), rng.range(-size, size)]
}

fn window() -> Window<f64, 2> {
    Window::new([-1.0, -1.0], [1.0, 1.0]).expect("a window")
}

/// Item 93: the walk around a polygon, case by case, gives the engine's polygon.
#[test]
fn four_cases_of_an_edge_make_the_polygon_that_is_left() {
    let (mut rng, mut clipper) = (Rng(93), Clipper::new());
    // Inside, leaving, outside, entering.
    let mut cases = [0_u32; 4];
    for _ in 0..2000 {
        let line = HalfSpace::new(point(&mut rng, 1.0), rng.range(-1.0, 1.0)).expect("a line");
        let (middle, size, first) = (point(&mut rng, 1.0), rng.range(0.3, 2.0), rng.unit());
        let corner = |i: u32| {
            let (sin, cos) = ((f64::from(i) + first) / 5.0 * std::f64::consts::TAU).sin_cos();
            [middle[0] + size * cos, middle[1] + size * sin]
        };
        let polygon: Vec<[f64; 2]> = (0..5).map(corner).collect();
        let mut walked = Vec::new();
        for (i, p) in polygon.iter().enumerate() {
            let q = polygon[(i + 1) % 5];
            let (from, to) = (line.height(p), line.height(&q));
            let t = from / (from - to);
            let crossing = [0, 1].map(|k| p[k] + t * (q[k] - p[k]));
            let (case, kept) = match (from > 0.0, to > 0.0) {
                (false, false) => (0, vec![q]),
                (false, true) => (1, vec![crossing]),
                (true, true) => (2, vec![]),
                (true, false) => (3, vec![crossing, q]),
            };
            cases[case] += 1;
            walked.extend(kept);
        }
        let region = Region::new([line]).expect("a half-plane");
        let found = clipper.clip(&region, &polygon);
        assert_eq!(found.len(), walked.len());
        // The walk begins its polygon at the end of the first edge.
        let near = |p: &[f64; 2], q: &[f64; 2]| (0..2).all(|k| (p[k] - q[k]).abs() < 1e-9);
        let turned = |first: usize| {
            let order = walked[first..].iter().chain(&walked[..first]);
            order.zip(found).all(|(p, q)| near(p, q))
        };
        assert!(walked.is_empty() || (0..walked.len()).any(turned), "{walked:?} {found:?}");
    }
    let [inside, leaving, outside, entering] = cases;
    assert_eq!(leaving, entering);
    told(93, &[inside, outside, leaving, entering].map(f64::from));
}

/// Item 95: the third case as written takes all that is inside as well; mended, each line and
/// triangle is in one case.
#[test]
fn the_third_case_of_outcodes_is_and_of_nothing_and_or_of_something() {
    let (region, window) = (window().region(), window());
    let (mut rng, mut clipper, mut regions) = (Rng(95), Clipper::new(), BTreeSet::new());
    let (mut inside, mut candidates, mut missing) = (0, 0, 0);
    for i in 0..6000 {
        let size = if i % 3 == 0 { 1.3 } else { 3.0 };
        let corners: [[f64; 2]; 3] = std::array::from_fn(|_| point(&mut rng, size));
        // A line in turn with a triangle.
        let points = &corners[..2 + i % 2];
        let codes: Vec<u32> = points.iter().map(|p| window.outcode(p)).collect();
        regions.extend(codes.iter().copied());
        let (or, and) = codes.iter().fold((0, u32::MAX), |(or, and), c| (or | c, and & c));
        let (is_left, is_whole) = match *points {
            [a, b] => {
                let cut = region.clip_line(&a, &b);
                (cut.is_some(), cut == Some([0.0, 1.0]))
            }
            _ => {
                let cut = clipper.clip(&region, points);
                (!cut.is_empty(), cut == points)
            }
        };
        assert_eq!(or == 0, is_whole);
        assert!(and == 0 || !is_left);
        // As written, the third case is AND = 0: also of what is inside.
        assert!(or != 0 || and == 0);
        inside += u32::from(or == 0);
        if and == 0 && or != 0 {
            candidates += 1;
            missing += u32::from(!is_left);
            assert!(codes.len() > 2 || codes[0] ^ codes[1] == or);
        }
        let expected = match (or, and) {
            (0, _) => OutcodeResult::Accepted,
            (_, 0) => OutcodeResult::Candidate(or),
            _ => OutcodeResult::Rejected(and),
        };
        let codes = codes.iter().map(|&code| Outcode { outside: code, not_inside: code });
        assert_eq!(OutcodeResult::of(codes), expected);
    }
    told(95, &[f64::from(inside), regions.len() as f64, f64::from(missing), f64::from(candidates)]);
}

/// Item 97: both places give the same picture and codes; in clip space products are fewer, and some
/// of them for nothing.
#[test]
fn in_clip_space_products_are_fewer_and_some_are_for_nothing() {
    let model = built("city:cells=4,objects=60");
    let options = RenderOptions::default();
    // Products: in the world, in clip space; and what is projected in clip space and then rejected.
    let (mut in_world, mut in_clip_space, mut for_nothing, mut all) = (0, 0, 0, 0);
    for view in views(&model, "walk", 3) {
        let whole = render_ref(&model.scene, &view, Selection::All, &options);
        for place in [ClipPlace::World, ClipPlace::Clip] {
            assert!(render_clipped(&model.scene, &view, place, &options).ids == whole.ids);
        }
        let region = Region::<f64, 3>::from(&view.frustum());
        // As wide as the view itself.
        let sides = GuardBand::new(view.depth(), 1.0).expect("a band");
        let planes = region.sides().count() as u64;
        for (_, _, triangle) in triangles(&model.scene) {
            let codes = triangle.map(|p| {
                let code = sides.outcodes(&in_clip(&view, p))[0];
                // What lies on a plane but for rounding is on either side.
                let on = region.sides().any(|(_, side)| side.height(&p).abs() < 1e-6);
                assert!(on || region.outcode(&p) == code);
                code
            });
            let is_rejected = codes[0] & codes[1] & codes[2] != 0;
            all += 1;
            for_nothing += u32::from(is_rejected);
            // A corner: three a plane, sixteen to project it less those by its fourth number, which
            // is 1.
            in_world += 3 * (3 * planes + if is_rejected { 0 } else { 12 });
            in_clip_space += 3 * 12;
        }
    }
    assert!(in_clip_space < in_world && for_nothing > 0);
    told(97, &[3 * all, in_clip_space, in_world, all, u64::from(for_nothing)].map(|n| n as f64));
}

/// Item 98: divided first, a segment that passes the eye is drawn where it is not; clipped first,
/// where it is.
#[test]
fn points_behind_the_eye_flip_unless_they_are_clipped_first() {
    const CASES: u32 = 2000;
    let view =
        View::perspective([0.0; 3], [0.0, 0.0, -1.0], 1.0, 0.1, 100.0, SIZE).expect("a view");
    let near = space::near::<f64>(view.depth());
    let mut rng = Rng(98);
    for _ in 0..CASES {
        let mut at = |low, high| [rng.range(-2.0, 2.0), rng.range(-2.0, 2.0), rng.range(low, high)];
        let [a, b] = [at(-9.0, -1.0), at(1.0, 9.0)].map(|p| in_clip(&view, p));
        assert_eq!(space::divide(&b), None);
        // x/w of what is behind has the other sign than x.
        assert!((b[0] / b[3] > 0.0) != (b[0] > 0.0));
        let [_, t] = near.clip_line(&a, &b).expect("it begins in front");
        let on_screen = |t: f64| {
            space::divide(&std::array::from_fn(|k| a[k] + t * (b[k] - a[k]))).expect("in front")[0]
        };
        let (start, seen, end) = (on_screen(0.0), on_screen(t * 0.5), on_screen(t));
        let holds = |end: f64| (start.min(end) - 1e-9..=start.max(end) + 1e-9).contains(&seen);
        assert!(holds(end) && !holds(b[0] / b[3]), "{start} {seen} {end}");
    }
    told(98, &[f64::from(CASES)]);
}

/// Item 99: outside of x = w is a comparison, and a line crosses at t = (w₀ − x₀) / ((w₀ − x₀) −
/// (w₁ − x₁)).
#[test]
fn a_line_crosses_the_right_side_where_the_formula_says() {
    const CASES: u32 = 2000;
    let full = space::full::<f64>(Depth::Standard);
    let right = full.clone().only(1 << FrustumPlane::Right as u32);
    let (mut rng, mut crossed) = (Rng(99), 0);
    for _ in 0..CASES {
        let [a, b]: [[f64; 4]; 2] = [(); 2].map(|()| std::array::from_fn(|_| rng.range(-3.0, 3.0)));
        for [x, y, z, w] in [a, b] {
            let past = [x < -w, x > w, y < -w, y > w, z < 0.0, z > w];
            let code = (0..).zip(past).fold(0, |code, (bit, past)| code | u32::from(past) << bit);
            assert_eq!(full.outcode(&[x, y, z, w]), code);
        }
        let sides = [a, b].map(|p| p[0] > p[3]);
        if sides[0] == sides[1] {
            continue;
        }
        crossed += 1;
        let t = (a[3] - a[0]) / ((a[3] - a[0]) - (b[3] - b[0]));
        for cut in [right.clip_line(&a, &b), clip_line_ref(&right.planes(), &a, &b)] {
            let [from, to] = cut.expect("one end is inside");
            assert!((t - if sides[0] { from } else { to }).abs() < 1e-9);
        }
    }
    told(99, &[f64::from(2 * CASES), f64::from(crossed)]);
}
