//! Lines clipped in every way, against exact fractions and against each other.

use cullet::Depth;
use cullet_draw::clip::line::at;
use cullet_draw::clip::{HalfSpace, Region, Window, space};
use cullet_testkit::oracles::clip::clip_line_ref;
use cullet_testkit::strategies::{number, point};
use proptest::prelude::*;

/// Equal but for rounding; a sliver that rounding hides may be there or not.
fn alike(found: Option<[f64; 2]>, exact: Option<[f64; 2]>) -> bool {
    const SLACK: f64 = 1e-12;
    match (found, exact) {
        (None, None) => true,
        (Some(t), Some(u)) => (t[0] - u[0]).abs() < SLACK && (t[1] - u[1]).abs() < SLACK,
        (Some(t), None) | (None, Some(t)) => (t[1] - t[0]).abs() < SLACK,
    }
}

fn windows<const D: usize>(
    a: [f64; D],
    b: [f64; D],
    p: [f64; D],
    q: [f64; D],
) -> Result<(), TestCaseError> {
    let low = std::array::from_fn(|i| p[i].min(q[i]));
    let high = std::array::from_fn(|i| p[i].max(q[i]));
    let window = Window::new(low, high).unwrap();
    let exact = clip_line_ref(&window.region().planes(), &a, &b);
    let found = [
        window.cohen_sutherland(&a, &b),
        window.liang_barsky(&a, &b),
        window.region().clip_line(&a, &b),
    ];
    for (way, t) in found.into_iter().enumerate() {
        prop_assert!(alike(t, exact), "way {way}: {t:?}, exact {exact:?}");
        for t in t.into_iter().flatten() {
            let p = at(&a, &b, t);
            prop_assert!((0..D).all(|i| p[i] > low[i] - 1e-11 && p[i] < high[i] + 1e-11));
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cullet_testkit::cases(3000)))]

    #[test]
    fn three_ways_in_the_plane([a, b, p, q] in prop::array::uniform4(point::<2>())) {
        windows(a, b, p, q)?;
    }

    #[test]
    fn three_ways_in_space([a, b, p, q] in prop::array::uniform4(point::<3>())) {
        windows(a, b, p, q)?;
    }

    #[test]
    fn any_planes(
        a in point::<3>(),
        b in point::<3>(),
        sides in prop::collection::vec((point::<3>(), number()), 0..8),
    ) {
        let sides = sides.into_iter().filter_map(|(n, d)| HalfSpace::new(n, d).ok());
        let region = Region::new(sides).unwrap();
        let (found, exact) = (region.clip_line(&a, &b), clip_line_ref(&region.planes(), &a, &b));
        prop_assert!(alike(found, exact), "{found:?}, exact {exact:?}");
        for (_, side) in region.sides() {
            let one = Region::new([*side]).unwrap();
            prop_assert_eq!(side.clip_line(&a, &b), one.clip_line(&a, &b));
        }
    }

    #[test]
    fn before_the_divide([a, b] in prop::array::uniform2(point::<4>())) {
        let full = space::full::<f64>(Depth::Reversed);
        let found = full.clip_line(&a, &b);
        prop_assert!(alike(found, clip_line_ref(&full.planes(), &a, &b)));
        for t in found.into_iter().flatten() {
            prop_assert!(at(&a, &b, t)[3] > -1e-12);
        }
    }
}

#[test]
fn hostile_numbers_end() {
    let window = Window::new([0.0, 0.0], [1.0, 1.0]).unwrap();
    let hostile = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, f64::MIN, 5e-324, -0.0];
    for x in hostile {
        for y in hostile {
            for (a, b) in [([x, y], [0.5, 0.5]), ([y, 0.5], [x, x]), ([x, y], [y, x])] {
                let _ = window.cohen_sutherland(&a, &b);
                let _ = window.liang_barsky(&a, &b);
            }
        }
    }
    let whole = Some([0.0, 1.0]);
    assert_eq!(
        window.liang_barsky(&[f64::NAN, 0.5], &[0.5, 0.5]),
        whole,
        "what is unknown is kept"
    );
    assert_eq!(window.cohen_sutherland(&[f64::NAN, 0.5], &[0.5, 0.5]), whole);
}
