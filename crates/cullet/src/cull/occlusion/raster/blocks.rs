//! Blocks of 32 × 8 pixels, each of eight tiles of 8 × 4, four across and two down: tested by
//! rectangles, and drawn into.
//!
//! A tile is one number until something covers a part of it; from then on it has one for each
//! pixel. Most tests, and most of what is drawn, end at the eight numbers of a block, which are one
//! register. Planes kept in the place of pixels were exact to a pixel and took a third more of the
//! time of a city.

use alloc::vec::Vec;
use core::ops::Range;

use fearless_simd::prelude::*;
use fearless_simd::{f32x8, mask16x8, mask16x32, u16x8, u16x32, u32x8};

use super::bounds::ScreenBounds;
use super::steps::Scale;
use crate::array::Each;
use crate::bits;

/// Pixels of a block across and down.
pub(crate) const BLOCK: [usize; 2] = [32, 8];
/// Pixels of a tile across and down.
pub const TILE: [usize; 2] = [8, 4];
/// Tiles of a block; the first four are its upper row.
const TILES: usize = 8;
const ACROSS: usize = BLOCK[0] / TILE[0];

/// Pixels of a tile that lie no more than this apart have one number: 64 steps are 3 % of a
/// distance.
const FEW_STEPS: u16 = 64;

/// Tiles of a block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(16))]
pub(crate) struct Block {
    /// The farthest pixel of each tile, in steps.
    least: [u16; TILES],
}

impl Block {
    /// Fills the pixels right of and below so many, which lie beyond the edge of the buffer; gives
    /// which tiles have pixels.
    pub(super) fn fill_beyond(&mut self, pixels: &mut [Pixels], [across, down]: [usize; 2]) -> u8 {
        let mut parted = 0;
        for (tile, pixels) in pixels.iter_mut().enumerate() {
            let (x, y) = (tile % ACROSS * TILE[0], tile / ACROSS * TILE[1]);
            let is_there = |i: &usize| x + i % TILE[0] < across && y + i / TILE[0] < down;
            match (0..TILE[0] * TILE[1]).filter(is_there).count() {
                0 => self.least[tile] = u16::MAX,
                count if count == TILE[0] * TILE[1] => {}
                _ => {
                    *pixels = Pixels([u16::MAX; TILE[0] * TILE[1]]);
                    (0..TILE[0] * TILE[1]).filter(is_there).for_each(|i| pixels.0[i] = 0);
                    parted |= 1 << tile;
                }
            }
        }
        parted
    }
}

/// The pixels of a tile, row by row.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub(crate) struct Pixels([u16; TILE[0] * TILE[1]]);

impl Pixels {
    pub(super) const BLANK: Self = Self([0; TILE[0] * TILE[1]]);
}

/// Blocks of a buffer, to be read.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Blocks<'a> {
    pub(super) scale: Scale,
    /// Blocks in a row.
    pub(super) columns: usize,
    pub(super) blocks: &'a [Block],
    /// Masks, one per block, of the tiles that have a number for each pixel.
    pub(super) parted: &'a [u8],
    pub(super) pixels: &'a [Pixels],
}

impl Blocks<'_> {
    /// Whether the pixels of a rectangle are all nearer. The rectangle lies within the buffer.
    #[inline(always)]
    pub(crate) fn covers<S: Simd>(&self, simd: S, bounds: &ScreenBounds) -> bool {
        let ScreenBounds { min, max, nearness } = *bounds;
        let steps = self.scale.of_tested(nearness);
        let limit = u16x8::splat(simd, steps);
        let ([x0, y0], [x1, y1]) = (min.each(|v| v as usize), max.each(|v| v as usize));
        let [width, height] = BLOCK;
        for row in y0 / height..=y1 / height {
            let (top, bottom) =
                (y0.saturating_sub(row * height), (y1 - row * height).min(height - 1));
            let wanted_rows =
                if top < TILE[1] { 0x0f } else { 0 } | if bottom >= TILE[1] { 0xf0 } else { 0_u8 };
            for column in x0 / width..=x1 / width {
                let left = x0.saturating_sub(column * width);
                let right = (x1 - column * width).min(width - 1);
                let columns = (2_u8 << (right / TILE[0])) - (1 << (left / TILE[0]));
                let block = row * self.columns + column;
                let least = u16x8::from_slice(simd, &self.blocks[block].least);
                let open = !least.simd_gt(limit).to_bitmask() as u8
                    & wanted_rows
                    & (columns | columns << ACROSS);
                if open & !self.parted[block] != 0 {
                    return false;
                }
                for tile in bits::ones(u64::from(open)) {
                    let in_tile = Rectangle { left, right, top, bottom }.in_tile(tile);
                    if !self.covers_in_tile(simd, block * TILES + tile, in_tile, steps) {
                        return false;
                    }
                }
            }
        }
        true
    }

    /// Whether the pixels of a tile that are wanted, a bit each, are nearer.
    #[inline(always)]
    fn covers_in_tile<S: Simd>(&self, simd: S, tile: usize, wanted: u32, steps: u16) -> bool {
        let pixels = u16x32::from_slice(simd, &self.pixels[tile].0);
        let nearer = pixels.simd_gt(u16x32::splat(simd, steps)).to_bitmask();
        u64::from(wanted) & !nearer == 0
    }

    /// Steps of a pixel.
    pub(super) fn pixel(&self, x: usize, y: usize) -> u16 {
        let block = y / BLOCK[1] * self.columns + x / BLOCK[0];
        let tile = y % BLOCK[1] / TILE[1] * ACROSS + x % BLOCK[0] / TILE[0];
        if self.parted[block] >> tile & 1 == 1 {
            self.pixels[block * TILES + tile].0[y % TILE[1] * TILE[0] + x % TILE[0]]
        } else {
            self.blocks[block].least[tile]
        }
    }

    /// The steps of the farthest pixel of the tile around a pixel.
    pub(super) fn least_around(&self, x: usize, y: usize) -> u16 {
        let block = y / BLOCK[1] * self.columns + x / BLOCK[0];
        self.blocks[block].least[y % BLOCK[1] / TILE[1] * ACROSS + x % BLOCK[0] / TILE[0]]
    }

    /// Whether no tile that a rectangle touches has a pixel that hides what is as far as
    /// `farthest`; `most` is what [`most`](Self::most) found.
    #[inline(always)]
    pub(crate) fn is_before<S: Simd>(
        &self,
        simd: S,
        most: &[[u16; TILES]],
        bounds: &ScreenBounds,
        farthest: f32,
    ) -> bool {
        if farthest.is_nan() {
            return false;
        }
        let steps = self.scale.of_drawn(farthest);
        let (first, last) = (bounds.min.each(|v| v as usize), bounds.max.each(|v| v as usize));
        let limit = u16x8::splat(simd, steps);
        for row in first[1] / BLOCK[1]..=last[1] / BLOCK[1] {
            let top = first[1].saturating_sub(row * BLOCK[1]);
            let bottom = (last[1] - row * BLOCK[1]).min(BLOCK[1] - 1);
            let rows =
                if top < TILE[1] { 0x0f } else { 0 } | if bottom >= TILE[1] { 0xf0 } else { 0_u8 };
            for column in first[0] / BLOCK[0]..=last[0] / BLOCK[0] {
                let left = first[0].saturating_sub(column * BLOCK[0]) / TILE[0];
                let right = (last[0] - column * BLOCK[0]).min(BLOCK[0] - 1) / TILE[0];
                let columns = (2_u8 << right) - (1 << left);
                let most = u16x8::from_slice(simd, &most[row * self.columns + column]);
                let nearer = most.simd_gt(limit).to_bitmask() as u8;
                if nearer & rows & (columns | columns << ACROSS) != 0 {
                    return false;
                }
            }
        }
        true
    }

    /// The nearest pixel of each tile: costs a look at the pixels of those that have some.
    #[inline(always)]
    pub(crate) fn most<S: Simd>(&self, simd: S, most: &mut Vec<[u16; TILES]>) {
        most.clear();
        most.extend(self.blocks.iter().map(|b| b.least));
        for (block, (most, &parted)) in most.iter_mut().zip(self.parted).enumerate() {
            for tile in bits::ones(u64::from(parted)) {
                let pixels = u16x32::from_slice(simd, &self.pixels[block * TILES + tile].0);
                most[tile] = pixels.reduce_max();
            }
        }
    }
}

/// Columns and rows of a block, both ends inclusive.
struct Rectangle {
    left: usize,
    right: usize,
    top: usize,
    bottom: usize,
}

impl Rectangle {
    /// Its pixels in a tile, a bit each.
    fn in_tile(&self, tile: usize) -> u32 {
        let (x, y) = (tile % ACROSS * TILE[0], tile / ACROSS * TILE[1]);
        let (left, right) = (self.left.max(x) - x, self.right.min(x + TILE[0] - 1) - x);
        let (top, bottom) = (self.top.max(y) - y, self.bottom.min(y + TILE[1] - 1) - y);
        let row = (0xff_u32 << left) & (0xff >> (TILE[0] - 1 - right));
        let rows = 0x0101_0101_u32 << (top * TILE[0]);
        let rows = rows & (u32::MAX >> ((TILE[1] - 1 - bottom) * TILE[0]));
        row * rows
    }
}

/// Blocks of a buffer, or of a band of it, to be drawn into.
#[derive(Debug)]
pub(crate) struct BlocksMut<'a> {
    /// Size of the whole buffer, in pixels.
    pub(crate) size: [u32; 2],
    pub(super) scale: Scale,
    pub(super) columns: usize,
    /// Rows of blocks that are drawn into.
    pub(super) rows: Range<usize>,
    /// Blocks of those rows.
    pub(super) blocks: &'a mut [Block],
    pub(super) parted: &'a mut [u8],
    pub(super) pixels: &'a mut [Pixels],
}

impl BlocksMut<'_> {
    /// Whether all pixels of a rectangle that are in these rows are nearer; those of no rectangle
    /// are.
    #[inline(always)]
    pub(crate) fn covers<S: Simd>(&self, simd: S, bounds: &ScreenBounds) -> bool {
        let [first, end] = [self.rows.start, self.rows.end].each(|row| (row * BLOCK[1]) as u32);
        let (top, bottom) = (bounds.min[1].max(first), bounds.max[1].min(end - 1));
        if top > bottom {
            return true;
        }
        let ([left, _], [right, _]) = (bounds.min, bounds.max);
        let within =
            ScreenBounds { min: [left, top - first], max: [right, bottom - first], ..*bounds };
        let own = Blocks {
            scale: self.scale,
            columns: self.columns,
            blocks: self.blocks,
            parted: self.parted,
            pixels: self.pixels,
        };
        own.covers(simd, &within)
    }

    /// The number of a block among its own.
    #[inline(always)]
    fn number(&self, [column, row]: [usize; 2]) -> usize {
        (row - self.rows.start) * self.columns + column
    }

    /// Whether a tile of a block has a pixel that something as near as `nearness` would raise.
    #[inline(always)]
    pub(super) fn is_open<S: Simd>(&self, simd: S, at: [usize; 2], nearness: f32) -> bool {
        let least = u16x8::from_slice(simd, &self.blocks[self.number(at)].least);
        let steps = u16x8::splat(simd, self.scale.of_drawn(nearness));
        steps.simd_gt(least).to_bitmask() != 0
    }

    /// Raises the covered pixels of a block of the buffer: `covered` has the 32 of each tile, row
    /// by row, `nearness` one for each tile, none NaN. Pixels beyond the edge of the buffer may be
    /// covered or not.
    #[inline(always)]
    pub(super) fn raise<S: Simd>(
        &mut self,
        simd: S,
        at: [usize; 2],
        covered: u32x8<S>,
        nearness: f32x8<S>,
    ) {
        let block = self.number(at);
        let none = u32x8::splat(simd, 0);
        let touched = covered.simd_ne(none).to_bitmask() as u8;
        let steps = self.scale.of_eight_drawn(simd, nearness);
        let least = u16x8::from_slice(simd, &self.blocks[block].least);
        // Not nearer than all of the tile: nothing to add.
        let active = touched & steps.simd_gt(least).to_bitmask() as u8;
        if active == 0 {
            return;
        }
        let whole = covered.simd_eq(u32x8::splat(simd, u32::MAX)).to_bitmask() as u8;
        let at_once = active & whole & !self.parted[block];
        let chosen = mask16x8::from_bitmask(simd, u64::from(at_once));
        let raised = &mut self.blocks[block].least;
        chosen.select(steps, least).store_slice(raised);
        let (steps, covered): ([u16; TILES], [u32; TILES]) = (steps.into(), covered.into());
        for tile in bits::ones(u64::from(active & !at_once)) {
            let pixels = &mut self.pixels[block * TILES + tile];
            let held = if self.parted[block] >> tile & 1 == 1 {
                u16x32::from_slice(simd, &pixels.0)
            } else {
                u16x32::splat(simd, raised[tile])
            };
            let mask = mask16x32::from_bitmask(simd, u64::from(covered[tile]));
            let held = mask.select(held.max(u16x32::splat(simd, steps[tile])), held);
            held.store_slice(&mut pixels.0);
            raised[tile] = held.reduce_min();
            self.parted[block] |= 1 << tile;
        }
    }

    /// Returns a bit for each steep tile of a block. A tile is steep where one of its pixels is
    /// farther than `near`, and `far` and `near` are more than [`FEW_STEPS`] apart. `far` and
    /// `near` are the least and the greatest nearness that may be drawn in each tile.
    #[inline(always)]
    pub(super) fn steep<S: Simd>(
        &self,
        simd: S,
        at: [usize; 2],
        far: f32x8<S>,
        near: f32x8<S>,
    ) -> u8 {
        let block = self.number(at);
        let least = u16x8::from_slice(simd, &self.blocks[block].least);
        let (far, near) =
            (self.scale.of_eight_drawn(simd, far), self.scale.of_eight_drawn(simd, near));
        let open = near.simd_gt(least);
        let apart = (near.max(far) - far).simd_gt(u16x8::splat(simd, FEW_STEPS));
        (open & apart).to_bitmask() as u8
    }

    /// Raises the covered pixels of a tile, each to its own nearness, row by row; none is NaN.
    #[inline(always)]
    pub(super) fn raise_pixels<S: Simd>(
        &mut self,
        simd: S,
        at: [usize; 2],
        tile: usize,
        covered: u32,
        nearness: [f32x8<S>; 4],
    ) {
        let block = self.number(at);
        let [a, b, c, d] = nearness;
        let steps: u16x32<S> = {
            let [a, b] = [self.scale.of_eight_drawn(simd, a), self.scale.of_eight_drawn(simd, b)];
            let [c, d] = [self.scale.of_eight_drawn(simd, c), self.scale.of_eight_drawn(simd, d)];
            a.combine(b).combine(c.combine(d))
        };
        let pixels = &mut self.pixels[block * TILES + tile];
        let least = &mut self.blocks[block].least[tile];
        let held = if self.parted[block] >> tile & 1 == 1 {
            u16x32::from_slice(simd, &pixels.0)
        } else {
            u16x32::splat(simd, *least)
        };
        let mask = mask16x32::from_bitmask(simd, u64::from(covered));
        let held = mask.select(held.max(steps), held);
        held.store_slice(&mut pixels.0);
        *least = held.reduce_min();
        self.parted[block] |= 1 << tile;
    }
}
