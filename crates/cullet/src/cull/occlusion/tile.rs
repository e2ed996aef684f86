//! Tiles of the buffer: pixels, or the planes that pixels would be made of.
//!
//! Of a picture of large occluders most tiles lie wholly within the first that is drawn there, and no one ever asks for a
//! pixel of them: the least is all that questions need. Writing the 256 bytes of each took most of the time of such a
//! picture, since the buffer is larger than the caches next to a core. So a tile that one outline covers keeps what
//! fills it, and its pixels are worked out where something else crosses it.

use fearless_simd::f32x8;
use fearless_simd::prelude::*;

use super::buffer::TILE;

/// What a tile holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Held {
    /// Nothing of this frame.
    #[default]
    Nothing,
    /// Its pixels.
    Pixels,
    /// Three planes: each pixel is as near as the farthest of them.
    Planes,
}

/// Sixty-four pixels, row by row: 0 where nothing is proved to cover the whole pixel. Or planes, at the front of
/// them: see [`Held`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub(super) struct Tile(pub(super) [f32; TILE * TILE]);

/// A plane within a tile. Of the pixel in column i and row j of the tile the bound is (i · dx + start) + j · dy, always in this
/// order: each step rounds, but none turns the order of two numbers around, so the most and the least of a tile are
/// exactly those of two of its corners.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TilePlane {
    pub(super) dx: f32,
    pub(super) start: f32,
    pub(super) dy: f32,
}

/// The most planes that a tile keeps: a box shows no more faces.
pub(super) const PLANES: usize = 3;

/// Rows of tiles of a buffer, to be read.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tiles<'a> {
    pub(super) columns: usize,
    /// The first, and the one beyond the last.
    pub(super) rows: [usize; 2],
    pub(super) tiles: &'a [Tile],
    pub(super) far: &'a [f32],
    pub(super) live: &'a [Held],
}

/// The columns of a tile, and its rows.
pub(super) const LANES: [f32; TILE] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
const EDGE: f32 = (TILE - 1) as f32;

impl Tile {
    pub(super) const fn filled(value: f32) -> Self {
        Self([value; TILE * TILE])
    }

    /// Keeps planes in the place of pixels.
    #[inline(always)]
    pub(super) fn keep(&mut self, planes: [TilePlane; PLANES]) {
        let kept = self.0.as_chunks_mut::<PLANES>().0;
        for (kept, p) in kept.iter_mut().zip(planes) {
            *kept = [p.dx, p.start, p.dy];
        }
    }

    /// The planes that it keeps.
    #[inline(always)]
    pub(super) fn planes(&self) -> [TilePlane; PLANES] {
        let mut planes = [TilePlane::default(); PLANES];
        for (plane, &[dx, start, dy]) in planes.iter_mut().zip(self.0.as_chunks::<PLANES>().0) {
            *plane = TilePlane { dx, start, dy };
        }
        planes
    }

    /// The pixels that the planes stand for.
    #[inline(always)]
    pub(super) fn unfold(&mut self) {
        let planes = self.planes();
        for (row, pixels) in self.0.as_chunks_mut::<TILE>().0.iter_mut().enumerate() {
            for (column, pixel) in pixels.iter_mut().enumerate() {
                *pixel = least(&planes, column, row);
            }
        }
    }

    /// The pixel in a column and a row.
    pub(super) fn pixel(&self, held: Held, column: usize, row: usize) -> f32 {
        match held {
            Held::Nothing => 0.0,
            Held::Pixels => self.0[row * TILE + column],
            Held::Planes => least(&self.planes(), column, row),
        }
    }

    /// A row of pixels of a tile that holds something.
    #[inline(always)]
    pub(super) fn row<S: Simd>(&self, simd: S, held: Held, row: usize) -> f32x8<S> {
        if held != Held::Planes {
            return f32x8::from_slice(simd, &self.0.as_chunks::<TILE>().0[row]);
        }
        let lanes = f32x8::from_slice(simd, &LANES);
        let mut value = f32x8::splat(simd, f32::INFINITY);
        for p in self.planes() {
            value = value.min(lanes * p.dx + p.start + LANES[row] * p.dy);
        }
        value.max(f32x8::splat(simd, 0.0))
    }
}

/// What planes leave of a pixel. (As vectors have it, without a thought for NaN.)
#[inline(always)]
fn least(planes: &[TilePlane; PLANES], column: usize, row: usize) -> f32 {
    let mut value = f32::INFINITY;
    for p in planes {
        let at = LANES[column] * p.dx + p.start + LANES[row] * p.dy;
        value = if at < value { at } else { value };
    }
    if value > 0.0 { value } else { 0.0 }
}

impl TilePlane {
    /// The least over the tile.
    #[inline(always)]
    pub(super) fn least(&self) -> f32 {
        self.start + (self.dx * EDGE).min(0.0) + (self.dy * EDGE).min(0.0)
    }

    /// The most over the tile.
    #[inline(always)]
    pub(super) fn most(&self) -> f32 {
        self.start + (self.dx * EDGE).max(0.0) + (self.dy * EDGE).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::dispatch;

    use super::*;
    use crate::cull::frustum::batch::levels;

    #[test]
    fn planes_unfold_to_the_same_pixels_at_each_level() {
        let plane = |dx: f32, start: f32, dy: f32| TilePlane { dx, start, dy };
        let some = [
            [plane(0.013, 0.2, -0.007), plane(-0.02, 0.3, 0.001), plane(0.0, 0.19, 0.0)],
            [plane(1e-7, 1.0 / 3.0, -3e-8); 3],
            // Below nothing in part.
            [plane(0.1, -0.2, 0.03), plane(0.0, 9.0, 0.0), plane(0.0, 9.0, 0.0)],
        ];
        for planes in some {
            let mut kept = Tile::filled(f32::NAN);
            kept.keep(planes);
            let mut pixels = kept;
            pixels.unfold();
            for (name, level) in levels() {
                dispatch!(level, simd => {
                    for row in 0..TILE {
                        let found: [f32; TILE] = kept.row(simd, Held::Planes, row).into();
                        let same: [f32; TILE] = pixels.row(simd, Held::Pixels, row).into();
                        assert_eq!(found.map(f32::to_bits), same.map(f32::to_bits), "{name} {row}");
                    }
                });
            }
            for i in 0..TILE * TILE {
                let pixel = kept.pixel(Held::Planes, i % TILE, i / TILE);
                assert_eq!(pixel.to_bits(), pixels.0[i].to_bits());
            }
            let ends = planes.map(|p| [p.least(), p.most()]);
            let least = ends.iter().fold(f32::INFINITY, |l, e| l.min(e[0])).max(0.0);
            let most = ends.iter().fold(f32::INFINITY, |m, e| m.min(e[1])).max(0.0);
            let range =
                pixels.0.iter().fold([f32::INFINITY, 0.0], |[l, m], &v| [v.min(l), v.max(m)]);
            assert_eq!(least, range[0], "no pixel is farther, and one is as far");
            assert!(range[1] <= most && range[1] > 0.0, "{range:?} {most}");
        }
    }
}
