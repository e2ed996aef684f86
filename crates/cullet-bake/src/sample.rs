//! Helpers of clusters and hierarchies: view points, places along a curve, and merged numbers.

use cullet::bounds::Aabb;
use cullet::math;
use glam::{DVec3, DVec4};

/// Homogeneous view points in units of the mesh's radius, from its middle: directions on a
/// Fibonacci spiral, at the distances in turn. An infinite distance is a direction.
#[must_use]
pub fn view_points(count: usize, distances: &[f64]) -> Vec<DVec4> {
    (0..count)
        .map(|i| {
            let d = fibonacci(i, count);
            // Rounded, so that the last bit of a platform's sine changes nothing.
            let d = (d * 4096.0).round() / 4096.0;
            match distances[i % distances.len()] {
                r if r.is_finite() => (d * r).extend(1.0),
                _ => d.extend(0.0),
            }
        })
        .collect()
}

/// Point `i` of `n` spread evenly over the unit sphere, along a spiral.
#[must_use]
pub fn fibonacci(i: usize, n: usize) -> DVec3 {
    // The golden angle, as a share of a turn.
    const GOLDEN: f64 = 0.381_966_011_250_105_1;
    let z = 1.0 - (2 * i + 1) as f64 / n as f64;
    let (sin, cos) = math::sin_cos((i as f64 * GOLDEN).fract() * std::f64::consts::TAU);
    let r = (1.0 - z * z).max(0.0).sqrt();
    DVec3::new(r * cos, r * sin, z)
}

/// The numbers of boxes, along a Morton curve through their middles; equal places by number.
#[must_use]
pub fn curve(boxes: &[Aabb]) -> Vec<u32> {
    let all = boxes.iter().fold(Aabb::EMPTY, |a, b| a.union(b));
    let (low, half) = (all.min, all.half_extent());
    let spread = |v: u64| {
        // Ten bits, each followed by two zeros.
        (0..10).fold(0u64, |s, i| s | (v >> i & 1) << (3 * i))
    };
    let key = |b: &Aabb| {
        let c = b.center();
        (0..3).fold(0, |code, k| {
            let share = (c[k] - f64::from(low[k])) / (2.0 * half[k]).max(f64::MIN_POSITIVE);
            code | spread((share * 1023.0) as u64) << k
        })
    };
    let mut order: Vec<(u64, u32)> = boxes.iter().zip(0..).map(|(b, i)| (key(b), i)).collect();
    order.sort_unstable();
    order.into_iter().map(|(_, i)| i).collect()
}

/// Pairs of clusters that follow each other closely along the curve: neighbours where nothing is
/// joined by edges, as leaves of a tree.
#[must_use]
pub fn nearby(boxes: &[Aabb]) -> Vec<(u32, u32)> {
    const REACH: usize = 6;
    let order = curve(boxes);
    let mut pairs = Vec::with_capacity(order.len() * REACH);
    for (i, &a) in order.iter().enumerate() {
        for &b in order.iter().skip(i + 1).take(REACH) {
            pairs.push((a.min(b), a.max(b)));
        }
    }
    pairs
}

/// The node that `c` is part of now, with path halving.
pub fn find(into: &mut [u32], mut c: u32) -> u32 {
    while into[c as usize] != c {
        into[c as usize] = into[into[c as usize] as usize];
        c = into[c as usize];
    }
    c
}
