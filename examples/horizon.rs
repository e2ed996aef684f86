//! Horizon culling of a globe's tiles, and the mask of what is left for a culler.

use cullet::bounds::Aabb;
use cullet::cull::horizon::{Ellipsoid, Horizon};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::time::Instant;

fn main() {
    // A million boxes of 25 km all around the earth, relative to its centre.
    let n = 1000;
    let boxes: Vec<Aabb> = (0..n * n)
        .map(|i| {
            let latitude = (f64::from(i / n) + 0.5) / f64::from(n) * PI - FRAC_PI_2;
            let (south, along) = latitude.sin_cos();
            let (east, north) = (f64::from(i % n) / f64::from(n) * TAU).sin_cos();
            let place = [along * north, along * east, south].map(|c| (c * 6.37e6) as f32);
            Aabb::new(place.map(|c| c - 12_500.0), place.map(|c| c + 12_500.0))
        })
        .collect();

    // The lowest dry land lies 430 m below the ellipsoid's height, or a little more.
    let ground = Ellipsoid::WGS84.lowered(500.0);
    let mut kept = Vec::new();
    for height in [10.0, 1_000.0, 100_000.0, 10_000_000.0] {
        let horizon = Horizon::from_eye(&ground, [6_378_137.0 + height, 0.0, 0.0]);
        // One bit a box: in the order of a scene's slots, candidates for `Culler::cull_among`.
        let start = Instant::now();
        horizon.keep_boxes([0.0; 3], &boxes, &mut kept);
        let nanoseconds = start.elapsed().as_secs_f64() * 1e9 / boxes.len() as f64;
        let left: u32 = kept.iter().map(|word| word.count_ones()).sum();
        println!("{height:>10} m: {left:>6} of {} left, {nanoseconds:.1} ns a box", boxes.len());
    }
}
