//! Random numbers that depend on nothing but a key.

use crate::hash::mix;

/// Random numbers from a hash: the same for the same key, whoever draws them and when.
#[derive(Clone, Debug)]
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64, key: [u32; 2]) -> Self {
        let mut random = Self(seed);
        random.0 = random.next() ^ u64::from(key[0]);
        random.0 = random.next() ^ u64::from(key[1]);
        random
    }

    #[inline]
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        mix(self.0)
    }

    /// From 0 up to, not including, 1.
    #[inline]
    pub(crate) fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
    }

    #[inline]
    pub(crate) fn three(&mut self) -> [f64; 3] {
        [self.unit(), self.unit(), self.unit()]
    }

    /// Below a limit, which is not 0.
    #[inline]
    pub(crate) fn below(&mut self, limit: u32) -> u32 {
        (((self.next() >> 32) * u64::from(limit)) >> 32) as u32
    }
}
