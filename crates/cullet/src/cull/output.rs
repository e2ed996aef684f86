//! From the mask to a list of indices.

use alloc::vec::Vec;
use core::ops::Deref;

use crate::simd::dispatch_256;
use fearless_simd::prelude::*;
use fearless_simd::u32x8;

/// A list of indices that keeps its memory from call to call.
///
/// Its buffer stays filled to the largest size it ever had, so that a call neither allocates nor
/// clears what it is going to overwrite. Reads as a slice.
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

    /// Empties the list.
    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// Appends the numbers of the set bits of `words`, ascending; bit 0 of the first is number
    /// `base`. The same at every level.
    pub fn append_ones(&mut self, simd: crate::Simd, words: &[u64], base: u32) {
        let room = self.len + words.len() * 64;
        if self.buffer.len() < room {
            self.buffer.resize(room, 0);
        }
        self.len += expand(simd, words, base, &mut self.buffer[self.len..]);
    }

    /// Lets `write` fill the list: it is given at least `room` entries and returns how many it
    /// wrote.
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

/// The positions of the set bits of a byte, then zeros.
static POSITIONS: [[u32; 8]; 256] = {
    let mut table = [[0; 8]; 256];
    let mut byte = 0;
    while byte < 256 {
        let (mut bit, mut found) = (0, 0);
        while bit < 8 {
            if byte >> bit & 1 == 1 {
                table[byte][found] = bit;
                found += 1;
            }
            bit += 1;
        }
        byte += 1;
    }
    table
};

/// Writes the numbers of the set bits of `words`, whose first bit is number `base`, to `out`, which
/// holds 64 entries a word; returns how many there are.
///
/// Whole vectors are stored and overlap: the next begins at the end of what counts. Storing under a
/// mask, or compressing into memory, is microcoded on Zen 4 and ten times slower. A pass of its own
/// over some words is faster than doing this as each word is found, which costs the tests
/// registers.
pub(in crate::cull) fn expand(
    simd: crate::Simd,
    words: &[u64],
    base: u32,
    out: &mut [u32],
) -> usize {
    dispatch_256!(simd, simd => expand_with(simd, words, base, out))
}

/// Appends those of an ascending `list` whose bit in `culled` is not set; bit 0 of the first word
/// is number 64 · `base`, and numbers beyond the last word are kept. No number may be below the
/// first word.
///
/// Where the list runs to the end of a word without a gap, as lists of whole ranges do, the word is
/// expanded; the rest goes number by number.
pub(crate) fn keep_listed(
    simd: crate::Simd,
    list: &[u32],
    base: u32,
    culled: &[u64],
    kept: &mut Vec<u32>,
) {
    let before = kept.len();
    // Room for the last word to be stored whole.
    kept.resize(before + list.len() + 64, 0);
    let out = &mut kept[before..];
    let (mut len, mut i) = (0, 0);
    let mut words = [0; 16];
    while let Some(&first) = list.get(i) {
        // Words that the list fills from `first` to their end.
        let start = first % 64;
        let mut full = 0;
        while full < words.len() {
            let to_end = (full + 1) * 64 - start as usize;
            if list.get(i + to_end - 1) != Some(&(first + to_end as u32 - 1)) {
                break;
            }
            let word = (first / 64 - base) as usize + full;
            words[full] = !culled.get(word).copied().unwrap_or(0);
            full += 1;
        }
        if full > 0 {
            words[0] &= u64::MAX << start;
            len += expand(simd, &words[..full], first - start, &mut out[len..]);
            i += full * 64 - start as usize;
        } else {
            // Half of them go, in no order that a branch could guess.
            let word = culled.get((first / 64 - base) as usize).copied().unwrap_or(0);
            out[len] = first;
            len += usize::from(word >> start & 1 == 0);
            i += 1;
        }
    }
    kept.truncate(before + len);
}

#[inline(always)]
fn expand_with<S: Simd>(simd: S, words: &[u64], base: u32, out: &mut [u32]) -> usize {
    let mut len = 0;
    for (index, &bits) in words.iter().enumerate() {
        // Neighbours share their answers: most words are none or all. Without the two short ways a
        // word of a ball took 4.2 ns and not 1.5; words of random bits lose nothing by them (3.5
        // and 3.7). Bytes compressed as one vector of 64, widened and stored as far as there are
        // any, with AVX-512 alone, take 1.8 and 3.0; the same all stored, 4.6 and 4.4.
        if bits == 0 {
            continue;
        }
        let out = &mut out[len..len + 64];
        let base = base + (index * 64) as u32;
        if bits == u64::MAX {
            for (start, out) in (0..).step_by(S::u32s::LEN).zip(out.chunks_exact_mut(S::u32s::LEN))
            {
                (iota(simd) + (base + start)).store_slice(out);
            }
        // Counted afresh for each part and not added up: no part waits for the one before.
        } else if S::u32s::LEN == 16 {
            for part in 0..4 {
                let n = (bits & ((1 << (16 * part)) - 1)).count_ones() as usize;
                let numbers = iota(simd) + (base + 16 * part);
                let mask = S::mask32s::from_bitmask(simd, bits >> (16 * part) & 0xffff);
                numbers.compress(mask).store_slice(&mut out[n..n + 16]);
            }
        } else {
            for part in 0..8 {
                let n = (bits & ((1 << (8 * part)) - 1)).count_ones() as usize;
                let byte = usize::from((bits >> (8 * part)) as u8);
                let positions = u32x8::from_slice(simd, &POSITIONS[byte]);
                (positions + (base + 8 * part)).store_slice(&mut out[n..n + 8]);
            }
        }
        len += bits.count_ones() as usize;
    }
    len
}

#[inline(always)]
fn iota<S: Simd>(simd: S) -> S::u32s {
    S::u32s::from_slice(
        simd,
        &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15][..S::u32s::LEN],
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_loses_what_is_culled() {
        let culled: Vec<u64> = (1..8_u64).map(|i| i.wrapping_mul(0x9E37_79B9_7F4A_7C15)).collect();
        let is_culled =
            |t: u32| culled.get(t as usize / 64 - 2).is_some_and(|w| w >> (t % 64) & 1 == 1);
        let gaps: [&[u32]; 6] = [
            &[],
            &[128, 1000],
            &[130, 131, 191, 192, 192, 256, 260, 300],
            &[191, 449],
            &[140, 150, 180, 320, 575, 579],
            &[200, 5000],
        ];
        for ranges in gaps {
            let list: Vec<u32> = ranges.chunks(2).flat_map(|r| r[0]..r[1]).collect();
            let mut kept = vec![7];
            keep_listed(crate::Simd::best(), &list, 2, &culled, &mut kept);
            let expected = list.iter().copied().filter(|&t| !is_culled(t));
            assert_eq!(kept, [7].into_iter().chain(expected).collect::<Vec<_>>(), "{ranges:?}");
        }
    }
}
