//! How far a mesh of fewer triangles is from the original: measured, both ways.
//! cargo run --example deviation -p cullet-bake

use cullet_draw::surface::SurfaceTree;
use cullet_draw::surface::deviation;

/// A ball of `rings` × 2 `rings` quads.
fn ball(rings: u32) -> (Vec<[f32; 3]>, Vec<u32>) {
    let around = rings * 2;
    let point = |r: u32, k: u32| {
        let (a, b) = (f64::from(r) / f64::from(rings), f64::from(k) / f64::from(around));
        let (s, c) = (a * std::f64::consts::PI).sin_cos();
        let (sin, cos) = (b * std::f64::consts::TAU).sin_cos();
        [s * cos, c, s * sin].map(|v| v as f32)
    };
    let positions = (0..=rings).flat_map(|r| (0..around).map(move |k| point(r, k))).collect();
    let at = |r: u32, k: u32| r * around + k % around;
    let quad = |r: u32, k: u32| {
        [at(r, k), at(r, k + 1), at(r + 1, k), at(r, k + 1), at(r + 1, k + 1), at(r + 1, k)]
    };
    let indices = (0..rings).flat_map(|r| (0..around).flat_map(move |k| quad(r, k))).collect();
    (positions, indices)
}

fn main() {
    let (fine, coarse) = (ball(200), ball(20));
    let surface = SurfaceTree::new(&coarse.0, &coarse.1);
    let (distance, triangle) = surface.nearest([0.0, 0.0, 2.0], 10.0).expect("within 10");
    println!("the point (0, 0, 2) is {distance:.4} from triangle {triangle} of the coarse ball");
    let found = deviation((&fine.0, &fine.1), (&coarse.0, &coarse.1), 100_000, 1);
    println!(
        "{} points: off by {:.5} at most, 99.9 % by {:.5}",
        found.points, found.max, found.p999
    );
}
