//! Distances to surfaces against a look at every triangle.

use cullet_draw::surface::{SurfaceTree, nearest_ref};
use cullet_testkit::soups::{self, Soup};
use cullet_testkit::{Rng, cases};

/// Surfaces of every kind: closed ones, triangles anywhere, slivers, and what has no area or does not exist.
fn surface(rng: &mut Rng) -> Soup {
    let (mut positions, mut indices) = match rng.below(4) {
        0 => soups::bumpy_ball(3 + rng.below(9) as u32, 0.3),
        1 => soups::scattered(rng.below(60) as u32),
        2 => soups::divided_block(1 + rng.below(5) as u32),
        _ => {
            let count = 3 + rng.below(60);
            let points = (0..count).map(|_| rng.vector(1.0).map(|v| v as f32)).collect();
            (points, (0..count * 3).map(|_| rng.below(count) as u32).collect())
        }
    };
    if rng.chance(0.3) {
        // Flat in one direction, so that there are slivers and triangles without area.
        let (axis, by) = (rng.index(3), [0.0, 1e-3, 1e-7][rng.index(3)]);
        positions.iter_mut().for_each(|p| p[axis] *= by);
    }
    if rng.chance(0.2) {
        positions.push([f32::NAN, 0.0, f32::INFINITY]);
        let last = positions.len() as u32;
        indices.extend([0, 1, last - 1, 0, 1, last, 0, 0, 0, 0]);
    }
    let (size, at) = match rng.below(5) {
        0 => (1e-25, 0.0),
        1 => (1e20, 0.0),
        2 => (1e4, 1e7),
        _ => (1.0, 0.0),
    };
    for p in positions.iter_mut().flatten() {
        *p = *p * size + at;
    }
    (positions, indices)
}

#[test]
fn the_nearest_is_as_near_as_that_of_all() {
    let mut rng = Rng(19);
    let mut measured = 0;
    let rounds = cases(300);
    for case in 0..rounds {
        let (positions, indices) = surface(&mut rng);
        let tree = SurfaceTree::new(&positions, &indices);
        let used: Vec<[f32; 3]> = indices
            .iter()
            .filter_map(|&i| positions.get(i as usize).copied())
            .filter(|p| p.iter().all(|v| v.is_finite()))
            .collect();
        assert_eq!(tree.is_empty(), nearest_ref(&positions, &indices, [0.0; 3]).is_none());
        if tree.is_empty() {
            assert_eq!(tree.nearest([0.0; 3], f32::INFINITY), None);
            continue;
        }
        let range = |a: usize| {
            used.iter().fold((f32::MAX, f32::MIN), |r, p| (r.0.min(p[a]), r.1.max(p[a])))
        };
        let half =
            (0..3).map(|a| f64::from(range(a).1) - f64::from(range(a).0)).fold(0.0, f64::max) * 0.5;
        for _ in 0..40 {
            let base = used[rng.index(used.len())];
            let reach = half * [0.0, 1e-3, 0.3, 2.0, 1e3, 1e17][rng.index(6)];
            let offset = rng.vector(reach);
            let point: [f32; 3] = std::array::from_fn(|a| (f64::from(base[a]) + offset[a]) as f32);
            let Some((exact, _)) = nearest_ref(&positions, &indices, point) else { continue };
            if !point.iter().all(|v| v.is_finite()) || exact > f64::from(f32::MAX) {
                continue;
            }
            let (found, triangle) = tree.nearest(point, f32::INFINITY).expect("not empty");
            let slack = 2e-6 * half + 2e-6 * exact;
            let found = f64::from(found);
            assert!((found - exact).abs() <= slack, "case {case}: {found} for {exact}");
            let alone = &indices[triangle as usize * 3..][..3];
            let (own, _) = nearest_ref(&positions, alone, point).expect("it exists");
            assert!((own - exact).abs() <= slack, "case {case}: triangle at {own} for {exact}");
            measured += 1;
            // Within a distance there is one just when the nearest is.
            let limit = (exact * [0.5, 0.99, 1.01, 3.0][rng.index(4)]) as f32;
            match tree.within(point, limit) {
                Some(t) => {
                    let one = &indices[t as usize * 3..][..3];
                    let (own, _) = nearest_ref(&positions, one, point).expect("it exists");
                    assert!(own <= f64::from(limit) + slack, "case {case}");
                }
                None => assert!(exact >= f64::from(limit) - slack, "case {case}"),
            }
            let is_within = tree.within(point, limit).is_some();
            assert_eq!(is_within, tree.nearest(point, limit).is_some());
            // Wherever something was found before.
            let mut last = [0, indices.len() as u32 / 13, u32::MAX][rng.index(3)];
            for _ in 0..2 {
                assert_eq!(is_within, tree.is_within(point, limit, &mut last));
                let farther = tree.farther(point, limit, &mut last).map(f64::from);
                assert_eq!(farther, (!is_within).then_some(found), "case {case}");
            }
        }
    }
    assert!(measured > rounds * 20, "{measured}");
}

#[test]
fn corners_and_what_is_equal_to_them_are_at_no_distance() {
    let (positions, indices) =
        soups::moved(soups::bumpy_ball(20, 0.2), |p| p.map(|v| v * 3.7 + 1e3));
    let tree = SurfaceTree::new(&positions, &indices);
    for p in &positions {
        assert_eq!(tree.nearest(*p, 0.0).map(|n| n.0), Some(0.0));
        assert!(tree.within(*p, 0.0).is_some());
    }
}

#[test]
fn invalid_questions_have_no_answer() {
    let (positions, indices) = soups::ball(4, 8);
    let tree = SurfaceTree::new(&positions, &indices);
    for limit in [f32::NAN, -1.0] {
        assert_eq!(tree.within([0.0; 3], limit), None);
        assert_eq!(tree.nearest([0.0; 3], limit), None);
        assert!(!tree.is_within([0.0; 3], limit, &mut 0));
    }
    for point in [[f32::NAN; 3], [f32::INFINITY, 0.0, 0.0]] {
        assert_eq!(tree.nearest(point, f32::INFINITY), None);
    }
    assert!(tree.nearest([f32::MAX; 3], f32::INFINITY).is_some());
    let none = SurfaceTree::new(&[], &[]);
    assert!(none.is_empty() && none.within([0.0; 3], f32::INFINITY).is_none());
    assert_eq!(none.farther([0.0; 3], 1.0, &mut 0), Some(f32::INFINITY));
}

#[test]
fn ten_thousand_triangles_in_one_place_are_a_tree_like_others() {
    let indices: Vec<u32> = (0..30_000).map(|i| i % 3).collect();
    let positions = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let tree = SurfaceTree::new(&positions, &indices);
    let (distance, _) = tree.nearest([1.0; 3], 10.0).expect("near");
    assert!((distance - 2.0 / 3.0_f32.sqrt()).abs() < 1e-6);
    let point = SurfaceTree::new(&positions, &[0; 3000]);
    assert_eq!(point.nearest([1.0, 3.0, 4.0], 10.0).map(|n| n.0), Some(5.0));
}
