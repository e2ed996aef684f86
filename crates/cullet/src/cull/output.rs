//! What becomes of the answer: a mask, a list of indices, or a count.

use std::ops::Deref;

use fearless_simd::prelude::*;

/// A list of indices that keeps its memory from call to call.
///
/// Its buffer stays filled to the largest size it ever had, so that a call neither allocates nor clears
/// what it is going to overwrite. Reads as a slice.
#[derive(Clone, Debug, Default)]
pub struct Indices {
    buffer: Vec<u32>,
    len: usize,
}

impl Indices {
    /// An empty list.
    #[must_use]
    pub const fn new() -> Self {
        Self { buffer: Vec::new(), len: 0 }
    }

    /// Lets `write` fill the list: it is given at least `room` entries and returns how many it wrote.
    pub(in crate::cull) fn fill(&mut self, room: usize, write: impl FnOnce(&mut [u32]) -> usize) {
        if self.buffer.len() < room {
            self.buffer.resize(room, 0);
        }
        self.len = write(&mut self.buffer);
    }
}

impl Deref for Indices {
    type Target = [u32];

    fn deref(&self) -> &[u32] {
        &self.buffer[..self.len]
    }
}

/// Takes the answer, sixty-four items a word, a set bit for each visible one.
pub(in crate::cull) trait Sink {
    /// `index` counts words from the start of the batch; each comes once, in order.
    fn word<S: Simd>(&mut self, simd: S, index: usize, visible: u64);
}

/// Keeps the words, from word `first` on.
pub(in crate::cull) struct Mask<'a> {
    pub(in crate::cull) first: usize,
    pub(in crate::cull) words: &'a mut [u64],
}

impl Sink for Mask<'_> {
    #[inline(always)]
    fn word<S: Simd>(&mut self, _: S, index: usize, visible: u64) {
        self.words[index - self.first] = visible;
    }
}

/// Counts.
pub(in crate::cull) struct Count(pub(super) usize);

impl Sink for Count {
    #[inline(always)]
    fn word<S: Simd>(&mut self, _: S, _: usize, visible: u64) {
        self.0 += visible.count_ones() as usize;
    }
}

/// Writes the numbers of the set bits. `out` holds 64 entries a word.
pub(in crate::cull) struct List<'a> {
    pub(in crate::cull) out: &'a mut [u32],
    pub(in crate::cull) len: usize,
}

/// The positions of the set bits of a byte, a byte each.
static POSITIONS: [u64; 256] = {
    let mut table = [0; 256];
    let mut byte = 0;
    while byte < 256 {
        let (mut bit, mut found) = (0, 0);
        while bit < 8 {
            if byte >> bit & 1 == 1 {
                table[byte] |= (bit as u64) << (8 * found);
                found += 1;
            }
            bit += 1;
        }
        byte += 1;
    }
    table
};

impl Sink for List<'_> {
    // Whole vectors are stored and overlap: the next store begins at the end of what counts. Storing
    // under a mask, or compressing into memory, is microcoded on Zen 4 and ten times slower.
    #[inline(always)]
    fn word<S: Simd>(&mut self, simd: S, index: usize, visible: u64) {
        let out = &mut self.out[self.len..self.len + 64];
        let base = (index * 64) as u32;
        let mut n = 0;
        if S::u32s::LEN == 16 {
            for part in 0..4 {
                let bits = visible >> (16 * part) & 0xffff;
                let numbers = iota(simd) + (base + 16 * part);
                numbers.compress(mask::<S>(simd, bits)).store_slice(&mut out[n..n + 16]);
                n += bits.count_ones() as usize;
            }
        } else {
            for part in 0..8 {
                let byte = (visible >> (8 * part)) as u8;
                let positions = POSITIONS[usize::from(byte)].to_le_bytes();
                let out: &mut [u32] = &mut out[n..n + 8];
                for (o, p) in out.iter_mut().zip(positions) {
                    *o = u32::from(p) + (base + 8 * part);
                }
                n += byte.count_ones() as usize;
            }
        }
        self.len += n;
    }
}

#[inline(always)]
fn iota<S: Simd>(simd: S) -> S::u32s {
    S::u32s::from_slice(
        simd,
        &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15][..S::u32s::LEN],
    )
}

#[inline(always)]
fn mask<S: Simd>(simd: S, bits: u64) -> S::mask32s {
    S::mask32s::from_bitmask(simd, bits)
}
