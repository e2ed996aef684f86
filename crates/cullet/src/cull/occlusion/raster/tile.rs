//! Tiles of the buffer: pixels, or the planes that pixels would be made of.
//!
//! Of a picture of large occluders most tiles lie wholly within the first that is drawn there, and no test ever
//! reads a pixel of them: the least is all that it needs. Writing the 256 bytes of each took most of
//! the time of such a picture, since the buffer is larger than the caches next to a core. So a tile that one
//! outline covers keeps what fills it, and its pixels are worked out where something else crosses it.

use fearless_simd::f32x8;
use fearless_simd::prelude::*;

/// Pixels along an edge of a tile.
pub const TILE: usize = 8;

/// Contents of a tile.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Held {
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
pub(crate) struct Tile(pub(super) [f32; TILE * TILE]);

/// A plane within a tile. Of the pixel in column i and row j of the tile the bound is (i · dx + start) + j ·
/// dy, always in this order: each step rounds, but none turns the order of two numbers around, so the most and
/// the least of a tile are exactly those of two of its corners.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TilePlane {
    pub(super) dx: f32,
    pub(super) start: f32,
    pub(super) dy: f32,
}

/// The most planes that a tile keeps: a box shows no more faces.
pub(super) const PLANES: usize = 3;

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

    /// The least of the pixels between two, both included, of what the planes stand for: that of a corner.
    #[inline(always)]
    pub(super) fn least_of_planes(&self, from: [usize; 2], to: [usize; 2]) -> f32 {
        let mut value = f32::INFINITY;
        for p in self.planes() {
            let x = if p.dx < 0.0 { to[0] } else { from[0] };
            let y = if p.dy < 0.0 { to[1] } else { from[1] };
            let at = LANES[x] * p.dx + p.start + LANES[y] * p.dy;
            value = if at < value { at } else { value };
        }
        if value > 0.0 { value } else { 0.0 }
    }

    /// No pixel of what the planes stand for is more.
    #[inline(always)]
    fn most_of_planes(&self) -> f32 {
        let [a, b, c] = self.planes().map(|p| p.most());
        let most = if a < b { a } else { b };
        (if most < c { most } else { c }).max(0.0)
    }

    /// No pixel is more, and but for planes one is as much.
    #[inline(always)]
    pub(crate) fn most<S: Simd>(&self, simd: S, held: Held) -> f32 {
        match held {
            Held::Nothing => 0.0,
            Held::Planes => self.most_of_planes(),
            Held::Pixels => {
                let mut most = f32x8::splat(simd, 0.0);
                for row in 0..TILE {
                    most = most.max(self.row(simd, row));
                }
                most.reduce_max()
            }
        }
    }

    /// A row of its pixels.
    #[inline(always)]
    pub(super) fn row<S: Simd>(&self, simd: S, row: usize) -> f32x8<S> {
        f32x8::from_slice(simd, &self.0.as_chunks::<TILE>().0[row])
    }
}

/// Least of some planes at a pixel. (None of them is NaN.)
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
    use super::*;

    #[test]
    fn planes_unfold_to_the_pixels_that_they_stand_for() {
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
            for i in 0..TILE * TILE {
                let pixel = kept.pixel(Held::Planes, i % TILE, i / TILE);
                assert_eq!(pixel.to_bits(), pixels.0[i].to_bits());
            }
            for corners in [[0, 0, 7, 7], [2, 5, 2, 5], [1, 3, 6, 4], [0, 7, 7, 7]] {
                let [x0, y0, x1, y1] = corners;
                let inside = (y0..=y1).flat_map(|y| (x0..=x1).map(move |x| y * TILE + x));
                let least = inside.fold(f32::INFINITY, |least, i| least.min(pixels.0[i]));
                assert_eq!(kept.least_of_planes([x0, y0], [x1, y1]), least, "{corners:?}");
            }
            let ends = planes.map(|p| [p.least(), p.most()]);
            let least = ends.iter().fold(f32::INFINITY, |l, e| l.min(e[0])).max(0.0);
            let most = ends.iter().fold(f32::INFINITY, |m, e| m.min(e[1])).max(0.0);
            let range =
                pixels.0.iter().fold([f32::INFINITY, 0.0], |[l, m], &v| [v.min(l), v.max(m)]);
            assert_eq!(least, range[0], "no pixel is farther, and one is as far");
            assert!(range[1] <= most && range[1] > 0.0, "{range:?} {most}");
            assert_eq!(kept.most_of_planes(), most);
        }
    }
}
