//! Capped cuts of the closed shared models leave no open edge.

#[path = "cut_common/mod.rs"]
mod common;
#[path = "mesh_support/mod.rs"]
mod support;

use common::{Random, check_halves};
use cullet::bounds::Plane;
use cullet::clip::cut::box_planes;
use support::read;

const CLOSED: [&str; 6] = [
    "stanford-bunny/bunny-closed-7k.off",
    "classic-meshes/spot.obj",
    "classic-meshes/cow.obj",
    "classic-meshes/fandisk.obj",
    "classic-meshes/rocker-arm.obj",
    "armadillo/armadillo.obj",
];

/// Planes in general position, through a vertex, along an edge and in a face, and boxes: one of each a
/// round.
fn check(name: &str, rounds: usize) {
    let Some(shape) = read(name) else { return };
    let mut random = Random(0x5EED);
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in &shape.0 {
        for a in 0..3 {
            low[a] = low[a].min(f64::from(p[a]));
            high[a] = high[a].max(f64::from(p[a]));
        }
    }
    let centre = [0, 1, 2].map(|a| (low[a] + high[a]) * 0.5);
    let half = [0, 1, 2].map(|a| (high[a] - low[a]) * 0.5);
    for _ in 0..rounds {
        let plane = random.plane(centre, half);
        check_halves(&shape, &[plane], name);
        let t = random.below(shape.1.len() / 3) * 3;
        let [a, b, c] = [0, 1, 2].map(|i| shape.0[shape.1[t + i] as usize].map(f64::from));
        let through =
            |n: [f64; 3], p: [f64; 3]| Plane::new(n, n[0] * p[0] + n[1] * p[1] + n[2] * p[2]);
        check_halves(&shape, &[through(plane.normal, a)], name);
        let axis = random.below(3);
        let mut normal = [0.0; 3];
        normal[axis] = 1.0;
        check_halves(&shape, &[through(normal, b)], name);
        if let Some(face) = Plane::from_points(a, b, c) {
            check_halves(&shape, &[face], name);
        }
        let ends: [[f64; 2]; 3] = std::array::from_fn(|a| {
            let [p, q] = [0, 1].map(|_| centre[a] + random.next() * half[a]);
            [p.min(q), p.max(q)]
        });
        check_halves(&shape, &box_planes(ends.map(|e| e[0]), ends.map(|e| e[1])), name);
    }
}

#[test]
fn closed_models_stay_closed() {
    for name in CLOSED {
        check(name, if name.contains("armadillo") { 2 } else { 8 });
    }
}

/// Minutes: `cargo test --profile checked -p cullet --test cut_data -- --ignored`.
#[test]
#[ignore = "a thousand rounds a model take minutes"]
fn closed_models_stay_closed_a_thousand_times() {
    for name in CLOSED {
        check(name, 1000);
    }
}
