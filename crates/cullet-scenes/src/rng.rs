//! Numbers that are the same on every machine: a small generator, and sine and cosine that do not
//! call the system's maths library, whose last bits differ from one system to the next.

use std::f64::consts::TAU;

/// `SplitMix64` (Steele, Lea, Flood, *Fast Splittable Pseudorandom Number Generators*, 2014).
#[derive(Clone, Debug)]
pub struct Rng(u64);

impl Rng {
    /// A generator for one purpose: the same seed with another `stream` gives unrelated numbers, so
    /// that changing how many are drawn for one purpose leaves all others alone.
    pub fn new(seed: u64, stream: u64) -> Self {
        let mut rng = Self(seed ^ stream.wrapping_mul(0xD6E8_FEB8_6659_FD93));
        rng.next_u64();
        rng
    }

    /// Returns 64 random bits.
    pub fn next_u64(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ z >> 31
    }

    /// Uniform in 0..1, 1 excluded.
    pub fn unit(&mut self) -> f64 {
        (self.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Uniform between two numbers.
    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Uniform in 0..n; 0 for n = 0.
    pub fn below(&mut self, n: usize) -> usize {
        ((self.unit() * n as f64) as usize).min(n.saturating_sub(1))
    }

    /// Returns true with a probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// Exponentially distributed, by comparisons alone, so without a logarithm (von Neumann,
    /// *Various Techniques Used in Connection with Random Digits*, 1951).
    pub fn exponential(&mut self, mean: f64) -> f64 {
        let mut whole = 0.0;
        loop {
            let first = self.unit();
            let mut last = first;
            let mut run = 1;
            loop {
                let next = self.unit();
                if next >= last {
                    break;
                }
                last = next;
                run += 1;
            }
            if run % 2 == 1 {
                return mean * (whole + first);
            }
            whole += 1.0;
        }
    }
}

/// Sine and cosine of an angle in turns. Exact at quarter turns; elsewhere within 2⁻⁵² or so, by
/// Taylor's series on an eighth of a turn. (0, 1) for what is not finite.
pub(crate) fn sin_cos(turns: f64) -> (f64, f64) {
    let t = turns - turns.floor();
    if !t.is_finite() {
        return (0.0, 1.0);
    }
    let quarter = (t * 4.0).round();
    let x = (t - quarter * 0.25) * TAU;
    let x2 = x * x;
    let (mut s, mut c) = (0.0, 0.0);
    // Innermost term first: s = x(1 − x²/2·3 (1 − x²/4·5 (…))), and the like for c.
    for k in (1..=9).rev() {
        let k = f64::from(2 * k);
        s = (1.0 + s) * -x2 / (k * (k + 1.0));
        c = (1.0 + c) * -x2 / (k * (k - 1.0));
    }
    let (s, c) = (x * (1.0 + s), 1.0 + c);
    match quarter as i64 & 3 {
        0 => (s, c),
        1 => (c, -s),
        2 => (-s, -c),
        _ => (-c, s),
    }
}

/// Every (x, z) of a `side` × `side` grid once, in an order that keeps neighbours near (Morton), so
/// that what is made cell by cell lands in slots near each other.
pub(crate) fn morton_grid(side: u32) -> impl Iterator<Item = (u32, u32)> {
    let even = |code: u64| {
        let mut v = code & 0x5555_5555_5555_5555;
        for (shift, mask) in [
            (1, 0x3333_3333_3333_3333),
            (2, 0x0F0F_0F0F_0F0F_0F0F),
            (4, 0x00FF_00FF_00FF_00FF),
            (8, 0x0000_FFFF_0000_FFFF),
            (16, 0x0000_0000_FFFF_FFFF),
        ] {
            v = (v | v >> shift) & mask;
        }
        v as u32
    };
    let padded = u64::from(side.next_power_of_two());
    (0..padded * padded)
        .map(move |code| (even(code), even(code >> 1)))
        .filter(move |&(x, z)| side > 0 && x < side && z < side)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stream_is_the_published_one() {
        // First outputs of SplitMix64 from state 1234567, as published with the reference code.
        let mut rng = Rng(1234567);
        assert_eq!(rng.next_u64(), 6457827717110365317);
        assert_eq!(rng.next_u64(), 3203168211198807973);
    }

    #[test]
    fn sine_and_cosine_agree_with_the_library() {
        for i in -4000..4000 {
            let turns = f64::from(i) / 1000.0;
            let (s, c) = sin_cos(turns);
            assert!((s - (turns * TAU).sin()).abs() < 4e-15, "{turns}");
            assert!((c - (turns * TAU).cos()).abs() < 4e-15, "{turns}");
        }
        assert_eq!(sin_cos(0.25), (1.0, 0.0));
        assert_eq!(sin_cos(-0.25).0, -1.0);
        assert_eq!(sin_cos(f64::NAN), (0.0, 1.0));
    }

    #[test]
    fn moments_are_as_they_should_be() {
        let mut rng = Rng::new(1, 2);
        let n = 200_000;
        let mean = (0..n).map(|_| rng.exponential(14.0)).sum::<f64>() / f64::from(n);
        assert!((mean - 14.0).abs() < 0.2, "{mean}");
        let mean = (0..n).map(|_| rng.range(-1.0, 3.0)).sum::<f64>() / f64::from(n);
        assert!((mean - 1.0).abs() < 0.02, "{mean}");
        assert_eq!(rng.below(0), 0);
        assert!((0..1000).all(|_| rng.below(7) < 7));
    }

    #[test]
    fn the_grid_is_covered_once() {
        for side in [0, 1, 5, 8] {
            let mut cells: Vec<_> = morton_grid(side).collect();
            assert_eq!(cells.len(), (side * side) as usize);
            cells.sort_unstable();
            cells.dedup();
            assert_eq!(cells.len(), (side * side) as usize);
        }
        let start: Vec<_> = morton_grid(4).take(4).collect();
        assert_eq!(start, [(0, 0), (1, 0), (0, 1), (1, 1)]);
    }
}
