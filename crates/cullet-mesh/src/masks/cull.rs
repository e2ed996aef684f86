//! Many triangles against one [`BackfaceMask`].
//!
//! The test is a look-up in 256 bytes. With AVX-512 a byte permute looks 64 triangles up at once,
//! and the test runs at the speed at which two bytes a triangle are read. The other levels go
//! through the 16-byte rows of the table that are not zero: a row is looked up by the low four bits
//! of the offset where its high four bits name the row.

use fearless_simd::{Simd, dispatch, prelude::*, u8x16};

use super::{BackfaceMask, NormalMasks, narrow};

impl NormalMasks {
    /// The oracle of [`cull_words`](Self::cull_words): all words, one triangle after the other.
    #[must_use]
    pub fn cull_ref(&self, mask: &BackfaceMask) -> Vec<u64> {
        let mut culled = vec![0; self.len().div_ceil(64)];
        for i in (0..self.len()).filter(|&i| mask.culls(self.get(i))) {
            culled[i / 64] |= 1 << (i % 64);
        }
        culled
    }

    /// Fills words `first..` of the mask of culled triangles, as many as `culled` has: bit i of
    /// word w is set where triangle 64 · w + i is back-facing for the view of `mask`; bits beyond
    /// the last triangle are 0. The same at every level.
    ///
    /// # Panics
    /// If the words reach beyond the last triangle's.
    pub fn cull_words(
        &self,
        simd: cullet::Simd,
        mask: &BackfaceMask,
        first: usize,
        culled: &mut [u64],
    ) {
        fill(simd, self, mask, first, culled);
    }
}

fn fill(
    simd: cullet::Simd,
    masks: &NormalMasks,
    mask: &BackfaceMask,
    first: usize,
    out: &mut [u64],
) {
    let range = first * 64..(first + out.len()) * 64;
    let offsets = masks.byte_offset[range.clone()].as_chunks::<64>().0;
    let bits = masks.bit_mask[range].as_chunks::<64>().0;
    let table = mask.bytes();
    #[cfg(target_arch = "x86_64")]
    if let Some(avx512) = simd.level().as_avx512() {
        return fill_avx512(avx512, offsets, bits, table, out);
    }
    #[cfg(target_arch = "x86_64")]
    if let Some(avx2) = simd.level().as_avx2() {
        return fill_avx2(avx2, offsets, bits, &Table::new(table), out);
    }
    // Without a byte shuffle a row look-up would be sixteen look-ups.
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    let shuffles = simd.level().as_sse4_2().is_some();
    #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
    let shuffles = !simd.level().is_fallback();
    if shuffles {
        let table = Table::new(table);
        dispatch!(narrow(simd), simd => fill_rows(simd, offsets, bits, &table, out));
    } else {
        dispatch!(narrow(simd), simd => fill_bytes(simd, offsets, bits, table, out));
    }
}

/// The rows of a mask that are not zero.
struct Table {
    rows: [[u8; 16]; 16],
    /// First number of the row, subtracted from an offset to count within it.
    starts: [u8; 16],
    len: usize,
}

impl Table {
    fn new(table: &[u8; 256]) -> Self {
        let mut this = Self { rows: [[0; 16]; 16], starts: [0; 16], len: 0 };
        for (number, row) in table.as_chunks::<16>().0.iter().enumerate() {
            if *row != [0; 16] {
                this.rows[this.len] = *row;
                this.starts[this.len] = number as u8 * 16;
                this.len += 1;
            }
        }
        this
    }
}

#[cfg(target_arch = "x86_64")]
fearless_simd::kernel!(
    fn fill_avx512(
        avx512: Avx512,
        offsets: &[[u8; 64]],
        bits: &[[u8; 64]],
        table: &[u8; 256],
        out: &mut [u64],
    ) {
        use core::arch::x86_64::*;
        use fearless_simd::u8x64;
        let load = |bytes: &[u8]| -> __m512i { u8x64::from_slice(avx512, bytes).into() };
        let rows: [__m512i; 4] = std::array::from_fn(|i| load(&table[i * 64..i * 64 + 64]));
        for ((offset, bit), out) in offsets.iter().zip(bits).zip(out) {
            let offset = load(offset);
            let low = _mm512_permutex2var_epi8(rows[0], offset, rows[1]);
            let high = _mm512_permutex2var_epi8(rows[2], offset, rows[3]);
            // A permute of two registers takes seven bits of the offset; the eighth chooses.
            let found = _mm512_mask_blend_epi8(_mm512_movepi8_mask(offset), low, high);
            *out = _mm512_test_epi8_mask(found, load(bit));
        }
    }
);

#[cfg(target_arch = "x86_64")]
fearless_simd::kernel!(
    fn fill_avx2(
        avx2: Avx2,
        offsets: &[[u8; 64]],
        bits: &[[u8; 64]],
        table: &Table,
        out: &mut [u64],
    ) {
        use core::arch::x86_64::*;
        use fearless_simd::{u8x16, u8x32};
        let load = |bytes: &[u8]| -> __m256i { u8x32::from_slice(avx2, bytes).into() };
        let sixteen = _mm256_set1_epi8(0x70);
        let zero = _mm256_setzero_si256();
        for ((offset, bit), out) in offsets.iter().zip(bits).zip(out) {
            let offset = [load(&offset[..32]), load(&offset[32..])];
            let mut found = [zero; 2];
            for (row, start) in table.rows[..table.len].iter().zip(&table.starts) {
                let row: __m128i = u8x16::from_slice(avx2, row).into();
                let row = _mm256_broadcastsi128_si256(row);
                let start = _mm256_set1_epi8(*start as i8);
                for half in 0..2 {
                    // 16..=127 over the row saturates into bit 7, for which a shuffle gives 0.
                    let index = _mm256_adds_epu8(_mm256_sub_epi8(offset[half], start), sixteen);
                    found[half] = _mm256_or_si256(found[half], _mm256_shuffle_epi8(row, index));
                }
            }
            let mut word = 0;
            for half in 0..2 {
                let culled = _mm256_and_si256(found[half], load(&bit[half * 32..][..32]));
                let kept = _mm256_movemask_epi8(_mm256_cmpeq_epi8(culled, zero)) as u32;
                word |= u64::from(!kept) << (half * 32);
            }
            *out = word;
        }
    }
);

#[inline(always)]
fn fill_rows<S: Simd>(
    simd: S,
    offsets: &[[u8; 64]],
    bits: &[[u8; 64]],
    table: &Table,
    out: &mut [u64],
) {
    for ((offset, bit), out) in offsets.iter().zip(bits).zip(out) {
        let at = |i: usize| i * 16..i * 16 + 16;
        let offset = [0, 1, 2, 3].map(|i| u8x16::from_slice(simd, &offset[at(i)]));
        let mut found = [u8x16::splat(simd, 0); 4];
        for (row, start) in table.rows[..table.len].iter().zip(&table.starts) {
            let row = u8x16::from_slice(simd, row);
            let start = u8x16::splat(simd, *start);
            for i in 0..4 {
                // Offsets of another row wrap to 16 or more, for which the look-up gives 0.
                found[i] |= row.swizzle_dyn_precise(offset[i] - start);
            }
        }
        *out = 0;
        for i in 0..4 {
            let culled =
                (found[i] & u8x16::from_slice(simd, &bit[at(i)])).simd_gt(u8x16::splat(simd, 0));
            *out |= culled.to_bitmask() << (i * 16);
        }
    }
}

/// Byte after byte from the table, then the comparison sixteen at a time: some words later, for a
/// vector read from bytes just written waits for all of them.
#[inline(always)]
fn fill_bytes<S: Simd>(
    simd: S,
    offsets: &[[u8; 64]],
    bits: &[[u8; 64]],
    table: &[u8; 256],
    out: &mut [u64],
) {
    const AT_ONCE: usize = 16;
    let mut found = [[0_u8; 64]; AT_ONCE];
    let zero = u8x16::splat(simd, 0);
    let chunks = offsets.chunks(AT_ONCE).zip(bits.chunks(AT_ONCE));
    for ((offsets, bits), out) in chunks.zip(out.chunks_mut(AT_ONCE)) {
        for (found, offset) in found.iter_mut().zip(offsets) {
            // Eight offsets a load: with one each it took 0.35 ns a triangle and not 0.29. Results
            // put together in registers too were no faster, or 0.41 with the comparison done in
            // them as well.
            let eights = offset.as_chunks::<8>().0;
            for (f, o) in found.as_chunks_mut::<8>().0.iter_mut().zip(eights) {
                let o = u64::from_le_bytes(*o);
                for (k, f) in f.iter_mut().enumerate() {
                    *f = table[usize::from((o >> (8 * k)) as u8)];
                }
            }
        }
        for ((found, bit), out) in found.iter().zip(bits).zip(out) {
            let mut kept = 0;
            for i in 0..4 {
                let f = u8x16::from_slice(simd, &found[i * 16..i * 16 + 16]);
                let b = u8x16::from_slice(simd, &bit[i * 16..i * 16 + 16]);
                kept |= (f & b).simd_eq(zero).to_bitmask() << (i * 16);
            }
            *out = !kept;
        }
    }
}
