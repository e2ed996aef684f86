//! Times, and the streaming limit.

use std::hint::black_box;
use std::time::{Duration, Instant};

use fearless_simd::{dispatch, prelude::*};

/// The fastest pass of each of two workloads, in nanoseconds, taken in turns for `seconds` in all,
/// so that what disturbs one disturbs both. At least three passes each. The first is told the
/// number of its turn.
pub(super) fn fastest_of_both(
    seconds: f64,
    mut first: impl FnMut(usize),
    mut second: impl FnMut(),
) -> [f64; 2] {
    let mut best = [Duration::MAX; 2];
    let begin = Instant::now();
    let mut passes = 0;
    // A pass that takes less than the clock's own cost would measure the clock.
    const SHORTEST: Duration = Duration::from_nanos(1);
    while passes < 3 || begin.elapsed().as_secs_f64() < seconds {
        for turn in 0..4 {
            let start = Instant::now();
            first(turn);
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

/// The fastest pass of reading `bytes` bytes at the best level, and of something else, taken in
/// turns as [`fastest_of_both`] does.
pub(super) fn beside_reading(seconds: f64, bytes: usize, pass: impl FnMut()) -> [f64; 2] {
    let (level, floats) = (cullet::Simd::best(), vec![1.0_f32; bytes / 4]);
    fastest_of_both(seconds, |turn| stream(level, &floats, turn), pass)
}

/// Reads every number once, at the given level, and does as little as can be with it: a sum. Odd
/// turns read four quarters side by side, which memory likes better where they lie beyond the
/// caches; the limit is the faster of the two.
pub(super) fn stream(simd: cullet::Simd, floats: &[f32], turn: usize) {
    let quarter = (floats.len() / 4).next_multiple_of(QUARTER);
    if turn % 2 == 1 && quarter * 3 < floats.len() {
        let (a, rest) = floats.split_at(quarter);
        let (b, rest) = rest.split_at(quarter);
        let (c, d) = rest.split_at(quarter);
        black_box(dispatch!(simd.level(), simd => sum_of_four(simd, [a, b, c, d])));
    } else {
        black_box(dispatch!(simd.level(), simd => sum(simd, floats)));
    }
}

/// Enough sums that none waits for the one before.
const SUMS: usize = 8;
/// Quarters are whole numbers of what a step of [`sum_of_four`] takes of each, at any level.
const QUARTER: usize = 64;

#[inline(always)]
fn sum<S: Simd>(simd: S, floats: &[f32]) -> f32 {
    let lanes = S::f32s::LEN;
    let mut sums = [S::f32s::splat(simd, 0.0); SUMS];
    let mut chunks = floats.chunks_exact(SUMS * lanes);
    for chunk in &mut chunks {
        for (i, sum) in sums.iter_mut().enumerate() {
            *sum += S::f32s::from_slice(simd, &chunk[i * lanes..(i + 1) * lanes]);
        }
    }
    total::<S>(sums) + chunks.remainder().iter().sum::<f32>()
}

#[inline(always)]
fn sum_of_four<S: Simd>(simd: S, quarters: [&[f32]; 4]) -> f32 {
    let lanes = S::f32s::LEN;
    let step = lanes * SUMS / 4;
    let mut sums = [S::f32s::splat(simd, 0.0); SUMS];
    let shortest = quarters.map(<[f32]>::len).into_iter().min().unwrap_or(0);
    let even = shortest - shortest % step;
    for at in (0..even).step_by(step) {
        for (q, quarter) in quarters.iter().enumerate() {
            let part = &quarter[at..at + step];
            for (sum, part) in sums[q * 2..q * 2 + 2].iter_mut().zip(part.chunks_exact(lanes)) {
                *sum += S::f32s::from_slice(simd, part);
            }
        }
    }
    total::<S>(sums) + quarters.iter().flat_map(|q| &q[even..]).sum::<f32>()
}

#[inline(always)]
fn total<S: Simd>(sums: [S::f32s; SUMS]) -> f32 {
    sums.iter().map(|sum| sum.as_slice().iter().sum::<f32>()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sum_reads_every_number_once() {
        let floats: Vec<f32> = (0..1000).map(|v| v as f32).collect();
        for (name, level) in cullet_command::machine::levels() {
            let sum = dispatch!(level.level(), simd => sum(simd, &floats));
            assert_eq!(sum, 499_500.0, "{name}");
            let quarters = [&floats[..250], &floats[250..500], &floats[500..750], &floats[750..]];
            let sum = dispatch!(level.level(), simd => sum_of_four(simd, quarters));
            assert_eq!(sum, 499_500.0, "{name}, four at once");
        }
    }
}
