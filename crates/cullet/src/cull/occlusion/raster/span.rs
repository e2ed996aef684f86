//! Spans: from which column to which the rows of a block are touched, and the bits of its tiles
//! that these are.

use fearless_simd::prelude::*;
use fearless_simd::{f32x8, i32x8, mask32x8, u8x32, u32x8};

use super::blocks::BLOCK;

/// The rows of a block.
pub(super) const ROWS: [f32; 8] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];

/// The blocks, across or down, that eight pixels are of.
#[inline(always)]
pub(super) fn blocks<S: Simd>(pixels: f32x8<S>, axis: usize) -> [i32; 8] {
    let whole: i32x8<S> = pixels.to_int();
    (whole >> BLOCK[axis].ilog2()).into()
}

/// From which column to which each of eight rows is touched.
pub(super) struct Span<S: Simd> {
    left: i32x8<S>,
    /// One beyond the last; 0 for rows without.
    right: i32x8<S>,
}

impl<S: Simd> Span<S> {
    /// From whole columns, 0 or more, or fractions of which the whole is meant.
    #[inline(always)]
    pub(super) fn new(simd: S, left: f32x8<S>, right: f32x8<S>, inside: mask32x8<S>) -> Self {
        let left: i32x8<S> = left.to_int();
        let right: i32x8<S> = right.max(f32x8::splat(simd, 0.0)).to_int();
        Self { left, right: inside.select(right, i32x8::splat(simd, 0)) }
    }

    /// The first and the last block, between two, that any row touches.
    #[inline(always)]
    pub(super) fn blocks(&self, simd: S, first: usize, last: usize) -> Option<(usize, usize)> {
        if last <= first + 1 {
            return Some((first, last));
        }
        let live = self.right.simd_gt(self.left);
        let left = live.select(self.left, i32x8::splat(simd, 1 << 20)).reduce_min();
        let right = live.select(self.right, i32x8::splat(simd, 0)).reduce_max();
        let from = first.max(left as usize / BLOCK[0]);
        let to = last.min((right - 1).max(0) as usize / BLOCK[0]);
        (from <= to && right > 0).then_some((from, to))
    }

    /// The pixels of a block in a column of blocks, as those of its eight tiles.
    #[inline(always)]
    pub(super) fn tiles(&self, simd: S, column: usize) -> u32x8<S> {
        let start = i32x8::splat(simd, (column * BLOCK[0]) as i32);
        let (zero, all) = (i32x8::splat(simd, 0), i32x8::splat(simd, BLOCK[0] as i32));
        let (from, to) = ((self.left - start).max(zero), (self.right - start).min(all));
        // Only rows that are touched are shifted by less than 32; what others give differs by level.
        let is_touched = from.simd_lt(to);
        let (from, beyond): (u32x8<S>, u32x8<S>) = (from.bitcast(), (all - to).bitcast());
        let ones = u32x8::splat(simd, u32::MAX);
        let rows = is_touched.select((ones << from) & (ones >> beyond), u32x8::splat(simd, 0));
        // Bytes of four rows to bytes of four tiles.
        const ORDER: [u8; 32] = {
            let mut order = [0; 32];
            let mut i = 0;
            while i < 32 {
                order[i] = (i / 4 % 4 + i % 4 * 4) as u8;
                i += 1;
            }
            order
        };
        let bytes: u8x32<S> = rows.bitcast();
        bytes.swizzle_dyn_within_blocks(u8x32::simd_from(simd, ORDER)).bitcast()
    }
}
