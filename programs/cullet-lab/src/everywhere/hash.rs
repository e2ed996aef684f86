//! Hashes of answers.

use std::fmt::{self, Debug, Write as _};

use cullet::Visible;

/// FNV-1a over the bytes of numbers, the lowest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Hash(u64);

impl Hash {
    pub(crate) fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    fn bytes(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    pub(crate) fn whole(&mut self, v: impl Into<u64>) {
        self.bytes(&v.into().to_le_bytes());
    }

    /// All NaN are one: their bits are the machine's.
    pub(crate) fn number(&mut self, v: impl Into<f64>) {
        let v = v.into();
        self.whole(if v.is_nan() { f64::NAN.to_bits() & (u64::MAX >> 1) } else { v.to_bits() });
    }

    /// A value as Rust writes it: numbers as the shortest text that reads back, the same
    /// everywhere.
    pub(crate) fn value(&mut self, v: &impl Debug) {
        let _ = write!(self, "{v:?}");
    }

    pub(crate) fn visible(&mut self, v: &Visible) {
        self.value(&(&v.whole, &v.partial, &v.triangle_ranges, &v.triangles, &v.reasons));
        self.value(&(v.triangle_count, v.instance_count, v.lod_pixels));
        for row in &v.funnel.rows {
            self.value(&(row.entered, row.left));
        }
    }

    /// Prints it.
    pub(crate) fn print(self, name: &str) {
        println!("{name}\t{:016x}", self.0);
    }
}

impl fmt::Write for Hash {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.bytes(text.as_bytes());
        Ok(())
    }
}

/// Prints the hash of what a function adds.
pub(crate) fn line(name: &str, add: impl FnOnce(&mut Hash)) {
    let mut hash = Hash::new();
    add(&mut hash);
    hash.print(name);
}
