//! Cuts leave no open edge, halves add up, and defects of the input are reported.

mod data;
mod grid;
mod halves;

use cullet::bounds::Plane;
use cullet::mesh::MeshError;
use cullet_cut::{
    CapOptions, CutError, CutInput, CutOptions, Keep, NO_ORIGIN, box_planes, cut, cut_both,
    outline_area,
};
use cullet_testkit::Rng;
use cullet_testkit::soups::{Soup, ball_at, block, join, leaks, turned, unshared, volume};

use halves::{capped, check_halves, open, plane_near};

const Z: [f64; 3] = [0.0, 0.0, 1.0];

#[test]
fn random_planes_and_boxes_leave_spheres_closed() {
    let shape = ball_at([0.3, -0.2, 0.1], 1.0, 24);
    let mut rng = Rng(7);
    for i in 0..60 {
        let centre = [0.3, -0.2, 0.1];
        check_halves(&shape, &[plane_near(&mut rng, centre, [1.0; 3])], &format!("plane {i}"));
        let ends: [[f64; 2]; 3] = std::array::from_fn(|a| {
            let [p, q] = [0, 1].map(|_| centre[a] + rng.signed() * 1.1);
            [p.min(q), p.max(q)]
        });
        let planes = box_planes(ends.map(|e| e[0]), ends.map(|e| e[1]));
        check_halves(&shape, &planes, &format!("box {i}"));
        let several: Vec<Plane> = (0..7).map(|_| plane_near(&mut rng, centre, [1.0; 3])).collect();
        check_halves(&shape, &several, &format!("region {i}"));
    }
}

#[test]
fn planes_through_vertices_edges_and_faces() {
    // Rings of the sphere lie on such planes, meridians too, and the pole touches the last.
    let shape = ball_at([0.0; 3], 1.0, 16);
    for &[x, y, z] in shape.0.iter().step_by(5) {
        for normal in [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.3, 0.5, -0.7]] {
            let d = normal[0] * f64::from(x) + normal[1] * f64::from(y) + normal[2] * f64::from(z);
            check_halves(&shape, &[Plane::new(normal, d)], "a vertex");
        }
    }
    check_halves(&shape, &[Plane::new([1.0, 0.0, 0.0], 0.0)], "a meridian");
    let cube = block([0.0; 3], [1.0; 3]);
    // Coplanar with faces, along edges and diagonals, and each tangent from both sides.
    for (normal, d, inside) in [
        ([1.0, 0.0, 0.0], 0.0, 0.0),
        ([1.0, 0.0, 0.0], 1.0, 1.0),
        ([-1.0, 0.0, 0.0], 0.0, 1.0),
        ([-1.0, 0.0, 0.0], -1.0, 0.0),
        ([1.0, 1.0, 0.0], 1.0, 0.5),
        ([1.0, -1.0, 0.0], 0.0, 0.5),
        ([1.0, 1.0, 1.0], 0.0, 0.0),
        ([1.0, 1.0, 1.0], 3.0, 1.0),
        ([1.0, 1.0, 0.0], 2.0, 1.0),
        ([1.0, 1.0, 1.0], 1.0, 1.0 / 6.0),
        ([0.0, 0.0, 2.0], 0.5, 0.25),
    ] {
        let got = check_halves(&cube, &[Plane::new(normal, d)], "a cube");
        assert!((got - inside).abs() < 1e-7, "{normal:?} {d}: {got}");
    }
    // A box that is the cube: nothing is cut, nothing remains outside.
    let planes = box_planes([0.0; 3], [1.0; 3]);
    let inside = capped(&cube, &planes, Keep::Inside);
    assert_eq!((inside.untouched, inside.origin.len()), (12, 12));
    assert!(capped(&cube, &planes, Keep::Outside).indices.is_empty());
}

#[test]
fn a_plane_that_misses_changes_nothing_or_leaves_nothing() {
    let (positions, indices) = ball_at([0.0; 3], 1.0, 8);
    let shape = (positions.clone(), indices.clone());
    let all = capped(&shape, &[Plane::new(Z, 2.0)], Keep::Inside);
    assert_eq!((all.positions, all.indices), (positions, indices));
    assert!(all.caps.is_empty());
    let none = capped(&shape, &[Plane::new(Z, -2.0)], Keep::Inside);
    assert!(none.positions.is_empty() && none.indices.is_empty() && none.origin.is_empty());
    assert_eq!(open(&shape, &[], Keep::Inside).untouched, all.origin.len());
    assert!(open(&shape, &[], Keep::Outside).indices.is_empty());
    let empty = open(&Default::default(), &[Plane::new(Z, 0.0)], Keep::Inside);
    assert!(empty.indices.is_empty());
}

#[test]
fn cuts_of_cuts_stay_closed() {
    let mut shape = ball_at([0.0; 3], 1.0, 20);
    let mut rng = Rng(99);
    for i in 0..12 {
        let plane = plane_near(&mut rng, [0.0; 3], [1.0; 3]);
        // A second time along the very plane, whose cap now is rounded to either side of it.
        for plane in [plane, plane, plane.flipped()] {
            check_halves(&shape, &[plane], &format!("cut {i}"));
        }
        let half = capped(&shape, &[plane], Keep::Inside);
        if volume(&half.positions, &half.indices) > 0.05 {
            shape = (half.positions, half.indices);
        }
    }
}

#[test]
fn caps_follow_the_winding_of_nested_and_overlapping_solids() {
    let plane = [Plane::new(Z, 0.01)];
    let area = |shape: &Soup| {
        let half = capped(shape, &plane, Keep::Inside);
        let area = half.cap_area(&half.caps[0], &plane[0]);
        let outlines: f64 =
            half.outlines(&half.caps[0]).iter().map(|o| outline_area(o, &plane[0])).sum();
        assert!((area - outlines).abs() < 1e-6, "{area} {outlines}");
        area
    };
    let outer = ball_at([0.0; 3], 1.0, 24);
    let inner = ball_at([0.0; 3], 0.5, 24);
    let disc = area(&outer);
    let small = area(&inner);
    let hollow = join([outer.clone(), turned(inner.clone())]);
    check_halves(&hollow, &plane, "hollow");
    assert!((area(&hollow) - (disc - small)).abs() < 1e-6);
    // Inside another of the same winding: two sheets, so that volumes add up.
    let double = join([outer.clone(), inner]);
    check_halves(&double, &plane, "one in another");
    assert!((area(&double) - (disc + small)).abs() < 1e-6);
    let overlapping = join([outer.clone(), ball_at([0.9, 0.1, 0.0], 1.0, 24)]);
    check_halves(&overlapping, &plane, "overlapping");
    let half = capped(&overlapping, &plane, Keep::Inside);
    assert_eq!((half.report.crossings, half.report.folded), (2, 0));
    check_halves(&turned(outer.clone()), &plane, "inside out");
    let mut rng = Rng(3);
    for i in 0..20 {
        let planes: Vec<Plane> = (0..1 + i % 4)
            .map(|_| plane_near(&mut rng, [0.4, 0.0, 0.0], [1.4, 1.0, 1.0]))
            .collect();
        check_halves(&overlapping, &planes, &format!("overlapping, {i}"));
        check_halves(&hollow, &planes, &format!("hollow, {i}"));
    }
}

#[test]
fn soup_is_capped_like_the_welded_mesh() {
    let welded = ball_at([0.0; 3], 1.0, 16);
    let plane = [Plane::new([0.2, 0.3, 0.9], 0.1)];
    let loose = unshared(&welded);
    let volume_of = |shape: &Soup| check_halves(shape, &plane, "soup");
    assert!((volume_of(&welded) - volume_of(&loose)).abs() < 1e-9);
    assert_eq!(capped(&loose, &plane, Keep::Inside).report.open_chains, 0);
}

#[test]
fn duplicates_are_dropped_where_they_leave_the_surface_open() {
    let shape = ball_at([0.0; 3], 1.0, 12);
    let plane = [Plane::new([0.1, 0.2, 0.9], 0.1)];
    let one = capped(&shape, &plane, Keep::Inside);
    // Every other triangle a second time.
    let mut some = shape.clone();
    for t in shape.1.chunks_exact(3).step_by(2) {
        some.1.extend_from_slice(&[t[1], t[2], t[0]]);
    }
    let half = capped(&some, &plane, Keep::Inside);
    assert!(half.report.duplicates > 5 && half.report.open_chains == 0, "{:?}", half.report);
    assert_eq!(half.caps[0].triangles.len(), one.caps[0].triangles.len());
    // All of it twice is a surface that winds around its inside twice: nothing is open.
    let mut twice = shape.clone();
    twice.1.extend_from_slice(&shape.1);
    check_halves(&twice, &plane, "twice");
    let two = capped(&twice, &plane, Keep::Inside);
    assert_eq!(two.report.duplicates, 0);
    assert_eq!(two.caps[0].triangles.len(), 2 * one.caps[0].triangles.len());
}

#[test]
fn holes_leave_what_crosses_them_uncapped_unless_healed() {
    let mut shape = ball_at([0.0; 3], 1.0, 16);
    let plane = Plane::new(Z, 0.05);
    // Without the triangles near (1, 0, 0) the outline has a gap.
    let near = |t: &[u32]| t.iter().any(|&v| shape.0[v as usize][0] > 0.97);
    shape.1 = shape.1.chunks_exact(3).filter(|t| !near(t)).flatten().copied().collect();
    let half = capped(&shape, &[plane], Keep::Inside);
    assert_eq!((half.report.open_chains, half.caps.len()), (1, 0));
    assert!(half.report.open_edges > 10);
    let input = CutInput { positions: &shape.0, indices: &shape.1, ..CutInput::default() };
    let caps = Some(CapOptions { heal: 1.0, ..CapOptions::default() });
    let healed = cut(&input, &[plane], &CutOptions { caps, ..CutOptions::default() }).unwrap();
    assert_eq!((healed.report.open_chains, healed.report.healed), (0, 1));
    let area = healed.cap_area(&healed.caps[0], &plane);
    assert!(area > 3.0 && area < 3.13, "{area}");
    // A hole elsewhere is none of the cut's business.
    let apart = capped(&shape, &[Plane::new([1.0, 0.0, 0.0], 0.2)], Keep::Outside);
    assert_eq!((apart.report.open_chains, apart.caps.len()), (0, 1));
}

#[test]
fn seams_that_do_not_quite_meet_are_closed_on_request() {
    let whole = ball_at([0.0; 3], 1.0, 16);
    let mut torn = unshared(&whole);
    let mut rng = Rng(21);
    for p in torn.0.iter_mut().flatten() {
        *p += rng.signed() as f32 * 1e-4;
    }
    let plane = [Plane::new([0.2, 0.3, 0.9], 0.1)];
    let input = CutInput { positions: &torn.0, indices: &torn.1, ..CutInput::default() };
    let open = capped(&torn, &plane, Keep::Inside);
    assert!(open.report.open_chains > 0 && open.report.welded == 0);
    let caps = CapOptions { weld: 1e-3, ..CapOptions::default() };
    let [inside, outside] = cut_both(&input, &plane, Some(&caps)).unwrap();
    for half in [&inside, &outside] {
        assert_eq!((half.report.open_chains, half.caps.len()), (0, 1), "{:?}", half.report);
        assert!(half.report.welded > torn.0.len() / 2);
        assert_eq!(leaks(&half.positions, &half.indices), 0);
    }
    let sum = [&inside, &outside].map(|h| volume(&h.positions, &h.indices)).iter().sum::<f64>();
    assert!((sum - volume(&whole.0, &whole.1)).abs() < 1e-2, "{sum}");
    for weld in [f32::NAN, f32::INFINITY, -1.0] {
        let caps = Some(CapOptions { weld, ..CapOptions::default() });
        let done = cut(&input, &plane, &CutOptions { caps, ..CutOptions::default() }).unwrap();
        assert_eq!(done, open);
    }
}

#[test]
fn both_halves_at_once_are_those_of_two_cuts() {
    let shape = ball_at([0.0; 3], 1.0, 12);
    let planes = box_planes([-0.5; 3], [0.3, 0.9, 2.0]);
    let input = CutInput { positions: &shape.0, indices: &shape.1, ..CutInput::default() };
    let both = cut_both(&input, &planes, Some(&CapOptions::default())).unwrap();
    let single = [Keep::Inside, Keep::Outside].map(|keep| capped(&shape, &planes, keep));
    assert_eq!(both, single);
    let both = cut_both(&input, &planes, None).unwrap();
    assert_eq!(both, [Keep::Inside, Keep::Outside].map(|keep| open(&shape, &planes, keep)));
}

#[test]
fn mixed_winding_is_filled_by_the_even_odd_rule() {
    let mut shape = block([0.0; 3], [1.0; 3]);
    // One wall inside out.
    shape.1[0..6].reverse();
    let plane = Plane::new(Z, 0.5);
    let half = capped(&shape, &[plane], Keep::Inside);
    assert_eq!((half.report.even_odd, half.report.open_chains), (1, 0));
    assert!((half.cap_area(&half.caps[0], &plane) - 1.0).abs() < 1e-6);
}

#[test]
fn triangle_soup_ends_with_a_report() {
    let mut rng = Rng(5);
    let corner = |_| [rng.signed() as f32, rng.signed() as f32, rng.signed() as f32];
    let positions: Vec<[f32; 3]> = (0..6000).map(corner).collect();
    let shape = (positions, (0..6000).collect());
    let half = capped(&shape, &[Plane::new(Z, 0.0)], Keep::Inside);
    assert!(half.report.open_chains > 500 && half.caps.is_empty());
    // Closed, but tangled: tetrahedra of rng points.
    let mut indices = Vec::new();
    for t in (0..4000).step_by(4) {
        indices.extend([0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3].map(|i| i + t));
    }
    let tangle = (shape.0, indices);
    let planes = [Plane::new([0.1, 0.2, 0.9], 0.0), Plane::new([0.9, 0.0, 0.1], 0.1)];
    for keep in [Keep::Inside, Keep::Outside] {
        let half = capped(&tangle, &planes, keep);
        assert_eq!(leaks(&half.positions, &half.indices), 0, "{:?}", half.report);
    }
}

#[test]
fn attributes_origins_and_caps_are_told() {
    let (positions, indices) = block([0.0; 3], [1.0; 3]);
    // The position itself, twice as large, and a constant.
    let attributes: Vec<f32> = positions
        .iter()
        .flat_map(|p| [p[0] * 2.0, p[1] * 2.0, p[2] * 2.0, 7.0, 0.0, 0.0])
        .collect();
    let input =
        CutInput { positions: &positions, indices: &indices, attributes: &attributes, stride: 6 };
    let caps = CapOptions {
        normal_at: Some(0),
        uv_at: Some(4),
        template: vec![0.0, 0.0, 0.0, 9.0],
        ..CapOptions::default()
    };
    let options = CutOptions { caps: Some(caps), ..CutOptions::default() };
    let plane = Plane::new([0.0, 0.6, 0.8], 0.5);
    let half = cut(&input, &[plane], &options).unwrap();
    assert_eq!(half.attributes.len(), half.positions.len() * 6);
    let caps = half.caps[0].triangles.clone();
    for t in 0..half.origin.len() {
        assert_eq!(caps.contains(&t), half.origin[t] == NO_ORIGIN);
        for &v in &half.indices[t * 3..][..3] {
            let (p, a) = (half.positions[v as usize], &half.attributes[v as usize * 6..][..6]);
            if caps.contains(&t) {
                assert_eq!(&a[..4], &[0.0, 0.6, 0.8, 9.0]);
            } else {
                (0..3).for_each(|i| assert!((a[i] - 2.0 * p[i]).abs() < 1e-6));
                assert_eq!(a[3], 7.0);
            }
        }
    }
    assert!(half.origin[..half.untouched].is_sorted());
}

#[test]
fn what_is_wrong_is_named() {
    let (positions, indices) = block([0.0; 3], [1.0; 3]);
    let input = CutInput { positions: &positions, indices: &indices, ..CutInput::default() };
    let options = CutOptions::default();
    for normal in [[0.0; 3], [f64::NAN, 0.0, 1.0], [f64::INFINITY, 0.0, 0.0], [1e-320, 0.0, 0.0]] {
        let error = cut(&input, &[Plane::new(normal, 0.0)], &options).unwrap_err();
        assert!(matches!(error, CutError::Plane { plane: 0, .. }), "{error}");
    }
    let many = vec![Plane::new(Z, 0.5); 33];
    assert_eq!(cut(&input, &many, &options), Err(CutError::TooManyPlanes(33)));
    let bad = CutInput { indices: &[0, 1, 8], ..input };
    let error = CutError::Mesh(MeshError::Index { at: 2, index: 8, vertices: 8 });
    assert_eq!(cut(&bad, &[], &options), Err(error));
    let bad = CutInput { indices: &[0, 1], ..input };
    assert_eq!(cut(&bad, &[], &options), Err(CutError::Mesh(MeshError::NotTriangles(2))));
    for value in [f32::NAN, f32::INFINITY] {
        let mut broken = positions.clone();
        broken[3][1] = value;
        let bad = CutInput { positions: &broken, ..input };
        for planes in [&[][..], &[Plane::new(Z, 0.5)]] {
            let error = cut(&bad, planes, &options).unwrap_err();
            assert!(
                matches!(error, CutError::Mesh(MeshError::NotFinite { vertex: 3, .. })),
                "{error}"
            );
        }
    }
    let bad = CutInput { stride: 1, ..input };
    assert!(matches!(cut(&bad, &[], &options), Err(CutError::Attributes { .. })));
}
