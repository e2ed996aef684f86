//! Coverage: what facets cover of the blocks of a patch's window, and what silhouette edges remove.

use fearless_simd::prelude::*;
use fearless_simd::{f32x8, u32x8};

use super::super::blocks::{BLOCK, BlocksMut};
use super::super::span::Span;
use super::{Surface, Window};

/// Coverage of a block by the patch that is drawn: a word, and a number, for each of its eight
/// tiles.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub(super) struct BlockCoverage {
    covered: [u32; 8],
    removed: [u32; 8],
    /// The least nearness of all that covers some of it.
    nearness: [f32; 8],
}

impl BlockCoverage {
    pub(super) const NONE: Self =
        Self { covered: [0; 8], removed: [0; 8], nearness: [f32::INFINITY; 8] };

    /// Covers some pixels.
    #[inline(always)]
    pub(super) fn cover<S: Simd>(&mut self, simd: S, pixels: u32x8<S>, nearness: f32x8<S>) {
        (u32x8::from_slice(simd, &self.covered) | pixels).store_slice(&mut self.covered);
        let held = f32x8::from_slice(simd, &self.nearness);
        let none = pixels.simd_eq(u32x8::splat(simd, 0));
        none.select(held, held.min(nearness)).store_slice(&mut self.nearness);
    }
}

impl Surface {
    /// Removes the pixels of a span from those blocks of a row, between two columns of blocks, that
    /// have coverage.
    #[inline(always)]
    pub(super) fn remove<S: Simd>(
        &mut self,
        simd: S,
        window: &Window,
        row: usize,
        [from, to]: [usize; 2],
        span: &Span<S>,
    ) {
        let row = row - window.block[1];
        let mut columns = self.used[row] & window.run([from, to]);
        while columns != 0 {
            let column = columns.trailing_zeros() as usize;
            columns &= columns - 1;
            let block = &mut self.blocks[row * window.across + column];
            let removed = u32x8::from_slice(simd, &block.removed);
            let removed = removed | span.tiles(simd, column + window.block[0]);
            removed.store_slice(&mut block.removed);
        }
    }

    /// Lists the blocks of a window in which the patch may come nearer than what was drawn before,
    /// and narrows the window to those. `None` where there is none.
    #[inline(always)]
    pub(super) fn opened<S: Simd>(
        &mut self,
        simd: S,
        mut window: Window,
        target: &BlocksMut<'_>,
    ) -> Option<Window> {
        let (mut columns, mut first, mut last) = (0, usize::MAX, 0);
        for row in 0..window.rows() {
            let mut open = 0;
            let is_own = target.rows.contains(&(row + window.block[1]));
            for column in 0..if is_own { window.across } else { 0 } {
                let at = [column + window.block[0], row + window.block[1]];
                open |= u64::from(target.is_open(simd, at, window.cap)) << column;
            }
            self.open[row] = open;
            if open != 0 {
                (columns, first, last) = (columns | open, first.min(row), row);
            }
        }
        if columns == 0 {
            return None;
        }
        let edge = |block: usize, a: usize| ((block + window.block[a]) * BLOCK[a]) as f32;
        let left = columns.trailing_zeros() as usize;
        let right = 64 - columns.leading_zeros() as usize;
        window.low = [window.low[0].max(edge(left, 0)), window.low[1].max(edge(first, 1))];
        window.high =
            [window.high[0].min(edge(right, 0)), window.high[1].min(edge(last + 1, 1) - 1.0)];
        Some(window)
    }

    /// Takes what is covered and not removed into the buffer, where there is one, and blanks all
    /// coverage.
    #[inline(always)]
    pub(super) fn resolve<S: Simd>(
        &mut self,
        simd: S,
        window: &Window,
        mut target: Option<&mut BlocksMut<'_>>,
    ) {
        for row in 0..window.rows() {
            let mut columns = core::mem::take(&mut self.used[row]);
            while columns != 0 {
                let column = columns.trailing_zeros() as usize;
                columns &= columns - 1;
                let block = &mut self.blocks[row * window.across + column];
                if let Some(target) = &mut target {
                    let covered = u32x8::from_slice(simd, &block.covered)
                        & !u32x8::from_slice(simd, &block.removed);
                    let at = [column + window.block[0], row + window.block[1]];
                    target.raise(simd, at, covered, f32x8::from_slice(simd, &block.nearness));
                }
                *block = BlockCoverage::NONE;
            }
        }
    }
}

impl Window {
    /// Bits of the columns of blocks of the buffer from one to another.
    #[inline(always)]
    pub(super) fn run(&self, [from, to]: [usize; 2]) -> u64 {
        // A shift by more than 63 would be of columns that the window has not.
        (u64::MAX >> ((63 + from - to) & 63)) << ((from - self.block[0]) & 63)
    }
}
