//! Coverage: what facets cover of the blocks of a patch's window, and what silhouette edges remove.

use fearless_simd::prelude::*;
use fearless_simd::{f32x8, u32x8};

use super::super::blocks::BlocksMut;
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
        let mut columns = self.used[row] & run(from - window.block[0], to - from);
        while columns != 0 {
            let column = columns.trailing_zeros() as usize;
            columns &= columns - 1;
            let block = &mut self.blocks[row * window.across + column];
            let removed = u32x8::from_slice(simd, &block.removed);
            let removed = removed | span.tiles(simd, column + window.block[0]);
            removed.store_slice(&mut block.removed);
        }
    }

    /// The coverage of a block, which counts as used from now on.
    #[inline(always)]
    pub(super) fn block(
        &mut self,
        window: &Window,
        column: usize,
        row: usize,
    ) -> &mut BlockCoverage {
        let (column, row) = (column - window.block[0], row - window.block[1]);
        self.used[row] |= 1 << column;
        &mut self.blocks[row * window.across + column]
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
        let rows = (window.high[1] as usize / 8) - window.block[1] + 1;
        for row in 0..rows {
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

/// `more` + 1 bits from `first` on.
#[inline(always)]
fn run(first: usize, more: usize) -> u128 {
    (u128::MAX >> (127 - more)) << first
}
