//! Capped cuts of the closed shared models leave no open edge.

use cullet::bounds::Plane;
use cullet_cut::{Keep, box_planes, outline_area};
use cullet_testkit::Rng;
use cullet_testkit::models::model;
use cullet_testkit::soups::Soup;

use crate::halves::{capped, check_halves, plane_near};

/// The models, and how many rounds of each take a few seconds.
const CLOSED: [(&str, usize); 6] = [
    ("stanford-bunny/bunny-closed-7k.off", 20),
    ("classic-meshes/spot.obj", 20),
    ("classic-meshes/cow.obj", 20),
    ("classic-meshes/fandisk.obj", 12),
    ("classic-meshes/rocker-arm.obj", 8),
    ("armadillo/armadillo.obj", 2),
];

/// Both halves at one plane or region: closed, with volumes that add up, and at one plane with caps of the
/// area that their outlines enclose.
fn check_one(shape: &Soup, planes: &[Plane], size: f64, what: &str) {
    check_halves(shape, planes, what);
    let [plane] = planes else { return };
    let half = capped(shape, planes, Keep::Inside);
    let area: f64 = half.caps.iter().map(|c| half.cap_area(c, plane)).sum();
    let outlines = half.caps.iter().flat_map(|c| half.outlines(c));
    let enclosed: f64 = outlines.map(|o| outline_area(&o, plane)).sum();
    assert!((area - enclosed).abs() <= 1e-6 * size * size, "{what}: {area} is not {enclosed}");
}

/// One of each a round: a plane in general position, through a vertex, along an edge, in a face, tangent,
/// missing, a box, and a cut of the cut.
fn check(name: &str, seed: u64, rounds: usize) {
    let Some(shape) = model(name) else { return };
    let mut rng = Rng(0x5EED_0000 + seed);
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in &shape.0 {
        for a in 0..3 {
            low[a] = low[a].min(f64::from(p[a]));
            high[a] = high[a].max(f64::from(p[a]));
        }
    }
    let centre = [0, 1, 2].map(|a| (low[a] + high[a]) * 0.5);
    let half = [0, 1, 2].map(|a| (high[a] - low[a]) * 0.5);
    let size = half.iter().fold(0.0, |m, &h| f64::max(m, h)) * 2.0;
    let along = |n: [f64; 3], p: [f64; 3]| n[0] * p[0] + n[1] * p[1] + n[2] * p[2];
    let through = |n: [f64; 3], p: [f64; 3]| Plane::new(n, along(n, p));
    for round in 0..rounds {
        let told = |kind: &str| format!("{name}, round {round}, {kind}");
        let plane = plane_near(&mut rng, centre, half);
        check_one(&shape, &[plane], size, &told("anywhere"));
        let t = rng.index(shape.1.len() / 3) * 3;
        let [a, b, c] = [0, 1, 2].map(|i| shape.0[shape.1[t + i] as usize].map(f64::from));
        check_one(&shape, &[through(plane.normal, a)], size, &told("through a vertex"));
        let axis = rng.index(3);
        let mut normal = [0.0; 3];
        normal[axis] = 1.0;
        check_one(&shape, &[through(normal, b)], size, &told("level, through a vertex"));
        // Exact where the difference is: the edge then lies in the plane to the last bit.
        let edge = [0, 1, 2].map(|i| c[i] - b[i]);
        let side = [edge[1], -edge[0], 0.0];
        if side != [0.0; 3] {
            check_one(&shape, &[through(side, b)], size, &told("along an edge"));
        }
        if let Some(face) = Plane::from_points(a, b, c) {
            check_one(&shape, &[face], size, &told("in a face"));
        }
        let top = shape.0.iter().map(|p| along(plane.normal, p.map(f64::from)));
        let top = top.fold(f64::NEG_INFINITY, f64::max);
        let tangent = Plane::new(plane.normal, top);
        check_one(&shape, &[tangent], size, &told("tangent"));
        let missing = Plane::new(plane.normal, top + top.abs() * 1e-6 + size * 1e-6);
        let whole = capped(&shape, &[missing], Keep::Inside);
        assert_eq!(whole.untouched * 3, shape.1.len(), "{}", told("missing"));
        assert!(capped(&shape, &[missing], Keep::Outside).indices.is_empty());
        let ends: [[f64; 2]; 3] = std::array::from_fn(|a| {
            let [p, q] = [0, 1].map(|_| centre[a] + rng.signed() * half[a]);
            [p.min(q), p.max(q)]
        });
        let cube = box_planes(ends.map(|e| e[0]), ends.map(|e| e[1]));
        check_one(&shape, &cube, size, &told("a box"));
        // The result is cut again, and along the same plane, whose cap is rounded to either side of it.
        let once = capped(&shape, &[plane], Keep::Inside);
        let once = (once.positions, once.indices);
        let again = plane_near(&mut rng, centre, half);
        check_one(&once, &[plane], size, &told("the same again"));
        check_one(&once, &[again], size, &told("a cut of the cut"));
        let twice = capped(&once, &[again], Keep::Outside);
        let twice = (twice.positions, twice.indices);
        check_one(&twice, &[plane_near(&mut rng, centre, half)], size, &told("a third cut"));
    }
}

/// In seconds. `CULLET_ROUNDS=100 cargo test --profile checked -p cullet-cut --test cut data` runs so many
/// rounds of each model, of ten planes and a box each.
#[test]
fn closed_models_stay_closed() {
    let rounds_set = std::env::var("CULLET_ROUNDS").ok();
    let rounds_set = rounds_set.map(|n| n.parse::<usize>().expect("CULLET_ROUNDS is a number"));
    for (seed, (name, rounds)) in (1..).zip(CLOSED) {
        check(name, seed, rounds_set.unwrap_or(rounds));
    }
}
