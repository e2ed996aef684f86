//! Random numbers.

/// A generator of numbers (`SplitMix64`: Steele, Lea & Flood, *Fast Splittable Pseudorandom Number Generators*, 2014),
/// begun with a seed: the same numbers on every machine, so that a test that fails fails again.
#[derive(Clone, Debug)]
pub struct Rng(pub u64);

impl Rng {
    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ z >> 31
    }

    /// Uniform in 0..1.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in `low..high`.
    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Uniform in −1..1.
    pub fn signed(&mut self) -> f64 {
        self.range(-1.0, 1.0)
    }

    /// A number below `n`, which must not be 0.
    pub fn below(&mut self, n: u64) -> u64 {
        self.bits() % n
    }

    /// A place in a list of `len` items, of which there must be one.
    pub fn index(&mut self, len: usize) -> usize {
        self.below(len as u64) as usize
    }

    /// True with probability `p`.
    pub fn chance(&mut self, p: f64) -> bool {
        self.unit() < p
    }

    /// Uniform in the cube from −`size` to `size`.
    pub fn vector(&mut self, size: f64) -> [f64; 3] {
        std::array::from_fn(|_| self.range(-size, size))
    }

    /// Uniform among the vectors of unit length.
    pub fn direction(&mut self) -> [f64; 3] {
        loop {
            let v = self.vector(1.0);
            let length = v.map(|x| x * x).iter().sum::<f64>().sqrt();
            if (0.01..=1.0).contains(&length) {
                return v.map(|x| x / length);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_those_of_the_paper_and_within_their_ranges() {
        // As `java.util.SplittableRandom` begins with this seed.
        let mut rng = Rng(1_234_567);
        assert_eq!(
            [rng.bits(), rng.bits()],
            [6_457_827_717_110_365_317, 3_203_168_211_198_807_973]
        );
        let mut low = 0;
        for _ in 0..1000 {
            assert!((-3.0..5.0).contains(&rng.range(-3.0, 5.0)));
            assert!(rng.index(7) < 7);
            let length = rng.direction().map(|v| v * v).iter().sum::<f64>();
            assert!((length - 1.0).abs() < 1e-12);
            low += usize::from(rng.chance(0.25));
        }
        assert!((200..300).contains(&low), "{low}");
    }
}
