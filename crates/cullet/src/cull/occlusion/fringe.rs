//! The fringe: pixels that several faces of a surface cover together.
//!
//! A pixel that an edge crosses is covered by no face alone, and shrinking every face would leave a crack along each edge
//! inside a surface. But take some faces of a surface that all show the same side, and a pixel that no edge of
//! their common border touches: then either all of the pixel is covered by them or nothing is, since how often a point
//! is covered changes only at the border. So where a face touches a pixel and no border does, the pixel is covered;
//! and the faces that cover it are among those that touch it, so it is at least as near as the farthest of them.
//!
//! A sheet of pixels beside the buffer holds that: the least nearness of the faces that touch a pixel, 0 for
//! ever once a border does. Pixels that lie wholly within one large face need no sheet: they go straight into the
//! buffer, and whatever else crosses them goes by the same argument without that face. When all of a side of a patch
//! is drawn, what is left on the sheet goes into the buffer.

use fearless_simd::f32x8;
use fearless_simd::prelude::*;

use super::buffer::{OcclusionBuffer, TILE, Tile};
use super::piece::Pieces;

/// The sheet.
#[derive(Clone, Debug)]
pub(super) struct Fringe {
    tiles: Vec<Tile>,
    /// The tiles that are not all infinite.
    touched: Vec<u32>,
    is_touched: Vec<bool>,
}

impl Fringe {
    pub(super) fn new(tiles: usize) -> Self {
        Self {
            tiles: vec![Tile::filled(f32::INFINITY); tiles],
            touched: Vec::new(),
            is_touched: vec![false; tiles],
        }
    }
}

/// Where pieces are drawn.
pub(super) struct Canvas<'a> {
    pub(super) size: [u32; 2],
    pub(super) columns: usize,
    pub(super) tiles: &'a mut [Tile],
    pub(super) far: &'a mut [f32],
    pub(super) live: &'a mut [bool],
    pub(super) fringe: &'a mut Fringe,
    /// The tile that places are relative to.
    pub(super) base: [usize; 2],
    /// Nothing of the patch is nearer: tiles that are covered by what is as near are left alone.
    pub(super) nearest: f32,
}

/// One of the pieces, in numbers that its tiles share.
struct Piece<S: Simd> {
    a: [f32; 3],
    b: [f32; 3],
    c: [f32; 3],
    inner: [f32; 3],
    /// What an edge gains and loses over a tile, from its first pixel on.
    gain: [f32; 3],
    loss: [f32; 3],
    across: [f32x8<S>; 3],
    nearer: f32x8<S>,
    value: f32,
    dx: f32,
    dy: f32,
    far: f32,
    near: f32,
    window: [i32; 4],
}

const EDGE: f32 = (TILE - 1) as f32;
const COLUMNS: [f32; TILE] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];

impl Canvas<'_> {
    /// Draws the first few of eight pieces. Products and sums are never fused, so that every level rounds alike.
    #[inline(always)]
    pub(super) fn draw<S: Simd>(&mut self, simd: S, pieces: &Pieces, count: usize) {
        let columns = f32x8::from_slice(simd, &COLUMNS);
        for lane in 0..count {
            let window = pieces.window.map(|v| v[lane] as i32);
            let [x0, y0, x1, y1] = window;
            if x0 > x1 || y0 > y1 {
                continue;
            }
            let [a, b, c, inner] =
                [&pieces.a, &pieces.b, &pieces.c, &pieces.inner].map(|v| v.map(|v| v[lane]));
            let piece = Piece {
                a,
                b,
                c,
                inner,
                gain: [0, 1, 2].map(|k| (a[k].max(0.0) + b[k].max(0.0)) * EDGE),
                loss: [0, 1, 2].map(|k| (a[k].min(0.0) + b[k].min(0.0)) * EDGE),
                across: a.map(|a| columns * a),
                nearer: columns * pieces.dx[lane],
                value: pieces.value[lane],
                dx: pieces.dx[lane],
                dy: pieces.dy[lane],
                far: pieces.far[lane],
                near: pieces.near[lane],
                window,
            };
            let tile = TILE as i32;
            // Small ones hold no whole pixel of note: all of theirs goes by the sheet.
            let is_large = x1 - x0 > tile && y1 - y0 > tile && inner[0].is_finite();
            for row in y0 / tile..=y1 / tile {
                for column in x0 / tile..=x1 / tile {
                    let t = (self.base[1] + row as usize) * self.columns
                        + self.base[0]
                        + column as usize;
                    if self.far[t] >= self.nearest {
                        continue;
                    }
                    if is_large {
                        self.tile::<S, true>(simd, &piece, t, [column * tile, row * tile]);
                    } else {
                        self.tile::<S, false>(simd, &piece, t, [column * tile, row * tile]);
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn tile<S: Simd, const LARGE: bool>(
        &mut self,
        simd: S,
        piece: &Piece<S>,
        t: usize,
        [left, top]: [i32; 2],
    ) {
        let (x, y) = (left as f32, top as f32);
        let c: [f32; 3] = std::array::from_fn(|k| piece.c[k] + (piece.a[k] * x + piece.b[k] * y));
        if (0..3).any(|k| c[k] + piece.gain[k] < 0.0) {
            return;
        }
        let value = piece.value + (piece.dx * x + piece.dy * y);
        let near = f32x8::splat(simd, piece.near);
        let far = f32x8::splat(simd, piece.far);
        if LARGE && (0..3).all(|k| c[k] + piece.loss[k] >= piece.inner[k]) {
            if self.far[t] < piece.near {
                OcclusionBuffer::wake(self.size, self.columns, self.tiles, self.live, t);
                let mut least = f32x8::splat(simd, f32::INFINITY);
                for (row, pixels) in self.tiles[t].0.chunks_exact_mut(TILE).enumerate() {
                    let value = piece.nearer + (value + piece.dy * row as f32);
                    let value = value.max(far).min(near);
                    let new = f32x8::from_slice(simd, pixels).max(value);
                    new.store_slice(pixels);
                    least = least.min(new);
                }
                self.far[t] = least.reduce_min();
            }
            return;
        }
        let [x0, y0, x1, y1] = piece.window;
        let columns = f32x8::from_slice(simd, &COLUMNS);
        let zero = f32x8::splat(simd, 0.0);
        let within = columns.simd_ge(f32x8::splat(simd, (x0 - left) as f32))
            & columns.simd_le(f32x8::splat(simd, (x1 - left) as f32));
        let within = within.select(f32x8::splat(simd, f32::INFINITY), f32x8::splat(simd, -1.0));
        let rows = (y0 - top).max(0) as usize..((y1 - top) as usize + 1).min(TILE);
        let mut is_filled = false;
        for row in rows {
            let down = row as f32;
            let e: [f32x8<S>; 3] =
                std::array::from_fn(|k| piece.across[k] + (c[k] + piece.b[k] * down));
            let touches = e[0].min(e[1]).min(e[2].min(within)).simd_ge(zero);
            let value = piece.nearer + (value + piece.dy * down);
            let value = value.max(far).min(near);
            let mut shared = touches;
            if LARGE {
                let depth = (e[0] - piece.inner[0]).min(e[1] - piece.inner[1]);
                let whole = depth.min(e[2] - piece.inner[2]).min(within).simd_ge(zero);
                if self.far[t] < piece.near && whole.any_true() {
                    if !is_filled {
                        is_filled = true;
                        OcclusionBuffer::wake(self.size, self.columns, self.tiles, self.live, t);
                    }
                    let pixels = &mut self.tiles[t].0[row * TILE..][..TILE];
                    let old = f32x8::from_slice(simd, pixels);
                    whole.select(old.max(value), old).store_slice(pixels);
                }
                shared = touches & !whole;
            }
            if shared.any_true() {
                if !self.fringe.is_touched[t] {
                    self.fringe.is_touched[t] = true;
                    self.fringe.touched.push(t as u32);
                }
                let pixels = &mut self.fringe.tiles[t].0[row * TILE..][..TILE];
                let old = f32x8::from_slice(simd, pixels);
                shared.select(old.min(value), old).store_slice(pixels);
            }
        }
        if is_filled {
            self.far[t] = least(simd, &self.tiles[t]);
        }
    }

    /// Takes what the sheet proved into the buffer, and blanks the sheet.
    #[inline(always)]
    pub(super) fn take_fringe<S: Simd>(&mut self, simd: S) {
        let infinite = f32x8::splat(simd, f32::INFINITY);
        let zero = f32x8::splat(simd, 0.0);
        for t in self.fringe.touched.drain(..) {
            let t = t as usize;
            self.fringe.is_touched[t] = false;
            OcclusionBuffer::wake(self.size, self.columns, self.tiles, self.live, t);
            let sheet = self.fringe.tiles[t].0.chunks_exact_mut(TILE);
            let mut least = infinite;
            for (pixels, proved) in self.tiles[t].0.chunks_exact_mut(TILE).zip(sheet) {
                let value = f32x8::from_slice(simd, proved);
                let value = value.simd_ge(infinite).select(zero, value);
                let new = f32x8::from_slice(simd, pixels).max(value);
                new.store_slice(pixels);
                infinite.store_slice(proved);
                least = least.min(new);
            }
            self.far[t] = least.reduce_min();
        }
    }
}

#[inline(always)]
fn least<S: Simd>(simd: S, tile: &Tile) -> f32 {
    let rows = tile.0.chunks_exact(TILE).map(|row| f32x8::from_slice(simd, row));
    rows.fold(f32x8::splat(simd, f32::INFINITY), |least, row| least.min(row)).reduce_min()
}
