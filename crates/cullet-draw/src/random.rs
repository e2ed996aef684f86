//! Random numbers that depend on nothing but a key.

/// Random numbers from a hash: the same for the same key, whoever draws them and when.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// The generator of a key: unrelated to those of other keys and seeds.
    #[must_use]
    pub fn new(seed: u64, key: [u32; 2]) -> Self {
        let mut random = Self(seed);
        random.0 = random.next() ^ u64::from(key[0]);
        random.0 = random.next() ^ u64::from(key[1]);
        random
    }

    /// Returns 64 random bits.
    #[inline]
    #[expect(
        clippy::should_implement_trait,
        reason = "an iterator would wrap each number in an option"
    )]
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        // Steele, Lea and Flood, *Fast Splittable Pseudorandom Number Generators*, 2014.
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    /// Returns a number from 0 up to, not including, 1.
    #[inline]
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
    }

    /// Returns three numbers from 0 up to, not including, 1.
    #[inline]
    pub fn three(&mut self) -> [f64; 3] {
        [self.unit(), self.unit(), self.unit()]
    }

    /// Returns a number below `limit`, which is not 0.
    #[inline]
    pub fn below(&mut self, limit: u32) -> u32 {
        (((self.next() >> 32) * u64::from(limit)) >> 32) as u32
    }
}
