//! Rows of tiles: tested by rectangles, and drawn into.

use fearless_simd::f32x8;
use fearless_simd::prelude::*;

use super::bounds::ScreenBounds;
use super::tile::{Held, PLANES, TILE, Tile, TilePlane};
use crate::bits;

/// Rows of tiles of a buffer, to be read.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tiles<'a> {
    pub(crate) columns: usize,
    /// The first, and the one beyond the last.
    pub(crate) rows: [usize; 2],
    pub(crate) tiles: &'a [Tile],
    /// The least pixel of each tile.
    pub(crate) far: &'a [f32],
    pub(crate) held: &'a [Held],
}

impl Tiles<'_> {
    /// Whether those pixels of a rectangle that lie in these tiles are all nearer: whole tiles first, a vector of
    /// them at a time. The rectangle lies within the buffer.
    #[inline(always)]
    pub(crate) fn covers<S: Simd>(&self, simd: S, bounds: &ScreenBounds) -> bool {
        let ScreenBounds { min, max, nearness } = *bounds;
        let limit = S::f32s::splat(simd, nearness);
        let (min, max) = ([min[0] as usize, min[1] as usize], [max[0] as usize, max[1] as usize]);
        let (first, last) = ([min[0] / TILE, min[1] / TILE], [max[0] / TILE, max[1] / TILE]);
        for row in first[1].max(self.rows[0])..=last[1].min(self.rows[1] - 1) {
            let mut column = first[0];
            while column <= last[0] {
                let count = (last[0] - column + 1).min(S::f32s::LEN);
                let t = (row - self.rows[0]) * self.columns + column;
                let wanted = u64::MAX >> (64 - count);
                let open = match self.far.get(t..t + S::f32s::LEN) {
                    Some(far) => {
                        wanted & !S::f32s::from_slice(simd, far).simd_gt(limit).to_bitmask()
                    }
                    // The last tiles of the buffer: there is no whole vector of them.
                    None => {
                        let nearer = |i: &usize| self.far[t + i] > nearness;
                        wanted & !(0..count).filter(nearer).fold(0, |near, i| near | 1 << i)
                    }
                };
                for i in bits::ones(open) {
                    if !self.covers_in_tile(simd, [column + i, row], min, max, nearness) {
                        return false;
                    }
                }
                column += count;
            }
        }
        true
    }

    /// Whether the pixels of a tile that are in a rectangle are nearer.
    #[inline(always)]
    fn covers_in_tile<S: Simd>(
        &self,
        simd: S,
        tile: [usize; 2],
        min: [usize; 2],
        max: [usize; 2],
        nearness: f32,
    ) -> bool {
        let t = (tile[1] - self.rows[0]) * self.columns + tile[0];
        let held = self.held[t];
        if held == Held::Nothing {
            return 0.0 > nearness;
        }
        let from = [0, 1].map(|a| min[a].max(tile[a] * TILE) % TILE);
        let to = [0, 1].map(|a| max[a].min(tile[a] * TILE + TILE - 1) % TILE);
        let wanted = 0xff_u64 >> (TILE - 1 - to[0]) & 0xff << from[0];
        if held == Held::Planes {
            return self.tiles[t].least_of_planes(from, to) > nearness;
        }
        let limit = f32x8::splat(simd, nearness);
        for row in from[1]..=to[1] {
            let nearer = self.tiles[t].row(simd, row).simd_gt(limit).to_bitmask();
            if nearer & wanted != wanted {
                return false;
            }
        }
        true
    }
}

/// Rows of tiles of a buffer, to be drawn into.
#[derive(Debug)]
pub(crate) struct TilesMut<'a> {
    /// That of the whole buffer, in pixels.
    pub(crate) size: [u32; 2],
    pub(crate) columns: usize,
    /// The first, and the one beyond the last.
    pub(crate) rows: [usize; 2],
    pub(crate) tiles: &'a mut [Tile],
    /// The least pixel of each tile.
    pub(crate) far: &'a mut [f32],
    pub(crate) held: &'a mut [Held],
}

impl TilesMut<'_> {
    /// The same, to be read.
    #[inline(always)]
    pub(crate) fn read(&self) -> Tiles<'_> {
        Tiles {
            columns: self.columns,
            rows: self.rows,
            tiles: self.tiles,
            far: self.far,
            held: self.held,
        }
    }

    /// The same for a while.
    #[inline(always)]
    pub(super) fn lend(&mut self) -> TilesMut<'_> {
        TilesMut {
            size: self.size,
            columns: self.columns,
            rows: self.rows,
            tiles: self.tiles,
            far: self.far,
            held: self.held,
        }
    }

    /// Its first and its last row of pixels.
    pub(crate) fn pixel_rows(&self) -> [usize; 2] {
        [self.rows[0] * TILE, self.rows[1] * TILE - 1]
    }

    /// Has a tile hold its pixels. Where nothing was, they are 0, and infinitely near beyond the buffer's edge, so that
    /// what is not there never counts as open.
    #[inline(always)]
    pub(super) fn wake(&mut self, t: usize) {
        match std::mem::replace(&mut self.held[t], Held::Pixels) {
            Held::Nothing => {}
            Held::Pixels => return,
            Held::Planes => return self.tiles[t].unfold(),
        }
        self.tiles[t] = Tile::filled(0.0);
        let (x, y) = (t % self.columns * TILE, (t / self.columns + self.rows[0]) * TILE);
        let [width, height] = self.size.map(|s| s as usize);
        if x + TILE > width || y + TILE > height {
            for (i, pixel) in self.tiles[t].0.iter_mut().enumerate() {
                if x + i % TILE >= width || y + i / TILE >= height {
                    *pixel = f32::INFINITY;
                }
            }
        }
    }

    /// Whether no pixel of a tile is nearer than `least`, as far as that is known without looking at pixels.
    #[inline(always)]
    pub(super) fn is_behind(&self, t: usize, least: f32) -> bool {
        match self.held[t] {
            Held::Nothing => true,
            Held::Pixels => false,
            // Wherever the tile is as near as the farthest of what it keeps.
            Held::Planes => self.tiles[t].planes().iter().any(|p| p.most() <= least),
        }
    }

    /// Has a tile hold planes, the least of which is `least`, in place of all that it held.
    #[inline(always)]
    pub(super) fn hold(&mut self, t: usize, planes: [TilePlane; PLANES], least: f32) {
        self.tiles[t].keep(planes);
        self.held[t] = Held::Planes;
        self.far[t] = least.max(0.0);
    }
}
