//! Many triangles against one [`BackfaceMask`].
//!
//! The test is a look-up in 256 bytes. With AVX-512 a byte permute looks 64 triangles up at once, and
//! the test runs at the speed at which two bytes a triangle are read. The other levels go through the
//! 16-byte rows of the table that are not zero: a row is looked up by the low four bits of the offset
//! where its high four bits name the row.

use fearless_simd::{Level, Simd, dispatch, prelude::*, u8x16};

use super::{BackfaceMask, NormalMasks};

/// Sets bit i of `culled` where triangle i is back-facing for the view of `mask`; bits beyond the last
/// triangle are 0. The answer is the same at every level.
pub fn cull_masked(level: Level, masks: &NormalMasks, mask: &BackfaceMask, culled: &mut Vec<u64>) {
    culled.clear();
    culled.resize(masks.len().div_ceil(64), 0);
    fill(level, masks, mask, 0, culled);
}

/// How many triangles are back-facing for the view of `mask`.
#[must_use]
pub fn count_masked(level: Level, masks: &NormalMasks, mask: &BackfaceMask) -> u64 {
    // Few enough words to stay in registers' reach, many enough to hide the calls.
    let mut block = [0; 64];
    let words = masks.len().div_ceil(64);
    let mut count = 0;
    for first in (0..words).step_by(block.len()) {
        let block = &mut block[..(words - first).min(64)];
        fill(level, masks, mask, first, block);
        count += block.iter().map(|w| u64::from(w.count_ones())).sum::<u64>();
    }
    count
}

/// Appends the numbers of the triangles that are *not* culled, ascending.
pub fn append_unmasked(
    level: Level,
    masks: &NormalMasks,
    mask: &BackfaceMask,
    kept: &mut Vec<u32>,
) {
    let mut block = [0; 64];
    let words = masks.len().div_ceil(64);
    for first in (0..words).step_by(block.len()) {
        let block = &mut block[..(words - first).min(64)];
        fill(level, masks, mask, first, block);
        for (word, culled) in (first..).zip(block) {
            let base = word * 64;
            let there = masks.len() - base;
            let mut bits = !*culled & if there < 64 { (1 << there) - 1 } else { !0 };
            while bits != 0 {
                kept.push(base as u32 + bits.trailing_zeros());
                bits &= bits - 1;
            }
        }
    }
}

/// The oracle: one triangle after the other.
#[must_use]
pub fn cull_masked_ref(masks: &NormalMasks, mask: &BackfaceMask) -> Vec<u64> {
    let mut culled = vec![0; masks.len().div_ceil(64)];
    for i in (0..masks.len()).filter(|&i| mask.culls(masks.get(i))) {
        culled[i / 64] |= 1 << (i % 64);
    }
    culled
}

/// Words `first..` of the answer, as many as `out` has.
fn fill(level: Level, masks: &NormalMasks, mask: &BackfaceMask, first: usize, out: &mut [u64]) {
    let range = first * 64..(first + out.len()) * 64;
    let offsets = masks.byte_offset[range.clone()].as_chunks::<64>().0;
    let bits = masks.bit_mask[range].as_chunks::<64>().0;
    #[cfg(target_arch = "x86_64")]
    if let Some(avx512) = level.as_avx512() {
        return fill_avx512(avx512, offsets, bits, mask.bytes(), out);
    }
    dispatch!(level, simd => fill_rows(simd, offsets, bits, mask.bytes(), out));
}

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

#[inline(always)]
fn fill_rows<S: Simd>(
    simd: S,
    offsets: &[[u8; 64]],
    bits: &[[u8; 64]],
    table: &[u8; 256],
    out: &mut [u64],
) {
    let rows = table.as_chunks::<16>().0;
    for ((offset, bit), out) in offsets.iter().zip(bits).zip(out) {
        *out = 0;
        for quarter in 0..4 {
            let at = quarter * 16..quarter * 16 + 16;
            let offset = u8x16::from_slice(simd, &offset[at.clone()]);
            let mut found = u8x16::splat(simd, 0);
            for (number, row) in rows.iter().enumerate() {
                if *row != [0; 16] {
                    // Offsets of another row wrap to 16 or more, for which the look-up gives 0.
                    let index = offset - u8x16::splat(simd, number as u8 * 16);
                    found |= u8x16::from_slice(simd, row).swizzle_dyn_precise(index);
                }
            }
            let culled = (found & u8x16::from_slice(simd, &bit[at])).simd_gt(u8x16::splat(simd, 0));
            *out |= culled.to_bitmask() << (quarter * 16);
        }
    }
}
