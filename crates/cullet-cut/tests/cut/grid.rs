//! Closed soups on a coarse grid, where planes meet vertices, edges and faces all the time.

use cullet::bounds::Plane;
use cullet_cut::Keep;
use cullet_testkit::soups::{Soup, block, join, volume};
use proptest::prelude::*;

use crate::halves::{check_halves, open};

fn grid() -> impl Strategy<Value = [f32; 3]> {
    [-4i8..=4, -4i8..=4, -4i8..=4].prop_map(|p| p.map(f32::from))
}

fn planes() -> impl Strategy<Value = Vec<Plane>> {
    let plane = ([-2i8..=2, -2i8..=2, -2i8..=2], -8i8..=8)
        .prop_filter("a normal", |(n, _)| *n != [0; 3])
        .prop_map(|(n, d)| Plane::new(n.map(f64::from), f64::from(d) / 2.0));
    prop::collection::vec(plane, 1..4)
}

/// Tetrahedra, each closed, wound either way, through each other and flat ones too.
fn tetrahedra() -> impl Strategy<Value = Soup> {
    prop::collection::vec([grid(), grid(), grid(), grid()], 1..6).prop_map(|all| {
        let corners = [0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3];
        let indices = (0..all.len() as u32).flat_map(|t| corners.map(|i| t * 4 + i)).collect();
        (all.into_iter().flatten().collect(), indices)
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cullet_testkit::cases(400)))]

    #[test]
    fn closed_soups_stay_closed(shape in tetrahedra(), planes in planes()) {
        check_halves_of_any(&shape, &planes);
    }

    /// Triangles that an open cut keeps are inside, and those that it drops are not: by their centres.
    #[test]
    fn open_cuts_keep_the_right_side(shape in tetrahedra(), planes in planes()) {
        for (keep, sign) in [(Keep::Inside, 1.0), (Keep::Outside, -1.0)] {
            let half = open(&shape, &planes, keep);
            for t in half.indices.chunks_exact(3) {
                let corners = [0, 1, 2].map(|i| half.positions[t[i] as usize].map(f64::from));
                let centre = [0, 1, 2].map(|a| corners.iter().map(|c| c[a]).sum::<f64>() / 3.0);
                let greatest = planes.iter().map(|p| p.distance(centre)).fold(f64::MIN, f64::max);
                prop_assert!(greatest * sign < 1e-4, "{keep:?} {greatest}");
            }
        }
    }
}

/// Mixed signs may cancel to no volume at all, so the tolerance is that of the parts.
fn check_halves_of_any(shape: &Soup, planes: &[Plane]) {
    // One solid more, so that the whole has a volume of its own.
    let big = block([-9.0, -9.0, 20.0], [9.0, 9.0, 40.0]);
    let all = join([shape.clone(), big]);
    assert!(volume(&all.0, &all.1) > 0.0);
    check_halves(&all, planes, "tetrahedra");
}
