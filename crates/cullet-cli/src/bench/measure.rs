//! Times, and the streaming limit.

use std::hint::black_box;
use std::time::{Duration, Instant};

use cullet::Level;
use fearless_simd::{dispatch, prelude::*};

/// The fastest pass of each of two things, in nanoseconds, taken in turns for `seconds` in all, so that
/// what disturbs one disturbs both. At least three passes each.
pub(super) fn fastest_of_both(
    seconds: f64,
    mut first: impl FnMut(),
    mut second: impl FnMut(),
) -> [f64; 2] {
    let mut best = [Duration::MAX; 2];
    let begin = Instant::now();
    let mut passes = 0;
    // A pass that takes less than the clock's own cost would measure the clock.
    const SHORTEST: Duration = Duration::from_nanos(1);
    while passes < 3 || begin.elapsed().as_secs_f64() < seconds {
        for _ in 0..4 {
            let start = Instant::now();
            first();
            best[0] = best[0].min(start.elapsed().max(SHORTEST));
        }
        for _ in 0..4 {
            let start = Instant::now();
            second();
            best[1] = best[1].min(start.elapsed().max(SHORTEST));
        }
        passes += 1;
    }
    best.map(|d| d.as_nanos() as f64)
}

/// Reads every number once, at the given level, and does as little as can be with it: a sum.
pub(super) fn stream(level: Level, floats: &[f32]) {
    black_box(dispatch!(level, simd => sum(simd, floats)));
}

#[inline(always)]
fn sum<S: Simd>(simd: S, floats: &[f32]) -> f32 {
    // Enough sums that none waits for the one before.
    const SUMS: usize = 8;
    let lanes = S::f32s::LEN;
    let mut sums = [S::f32s::splat(simd, 0.0); SUMS];
    let mut chunks = floats.chunks_exact(SUMS * lanes);
    for chunk in &mut chunks {
        for (i, sum) in sums.iter_mut().enumerate() {
            *sum += S::f32s::from_slice(simd, &chunk[i * lanes..(i + 1) * lanes]);
        }
    }
    let mut total = chunks.remainder().iter().sum::<f32>();
    for sum in &sums {
        total += sum.as_slice().iter().sum::<f32>();
    }
    total
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sum_reads_every_number_once() {
        let floats: Vec<f32> = (0..1000).map(|v| v as f32).collect();
        for (name, level) in cullet::cull::frustum::batch::levels() {
            let sum = dispatch!(level, simd => sum(simd, &floats));
            assert_eq!(sum, 499_500.0, "{name}");
        }
    }
}
