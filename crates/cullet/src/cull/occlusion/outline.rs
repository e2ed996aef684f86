//! Filling convex outlines: only pixels that lie wholly within all edges.

use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch, f32x8};

use super::buffer::{OcclusionBuffer, TILE, Tile};
use super::plane::Plane;
use super::screen::Spot;

/// Pixels by which every edge moves inward beyond what is exact: more than anything here is off by.
const SLACK: f64 = 1.0 / 1024.0;

/// An edge as a bound on the columns of a row of pixels: slope · row + start.
#[derive(Clone, Copy, Debug)]
struct Bound {
    slope: f32,
    start: f32,
}

/// A convex outline that is being built, and the planes of what fills it. Kept for its memory.
#[derive(Clone, Debug, Default)]
pub(super) struct Outline {
    left: Vec<Bound>,
    right: Vec<Bound>,
    /// The first and last row and column of pixels, inclusive.
    rows: [i32; 2],
    columns: [i32; 2],
    size: [i32; 2],
    /// What fills it is at each pixel as near as the farthest of these.
    planes: Vec<Plane>,
    /// The pixels that an edge moves inward by, because its ends are off by that much.
    doubt: f64,
}

impl Outline {
    /// Begins an outline within the box `min`..`max` of pixels on a screen of `size`; its corners are off
    /// by `doubt` pixels at most.
    pub(super) fn begin(&mut self, size: [u32; 2], min: [f64; 2], max: [f64; 2], doubt: f64) {
        self.left.clear();
        self.right.clear();
        self.planes.clear();
        self.size = size.map(|s| s as i32);
        self.doubt = doubt + SLACK;
        let first = |v: f64| (v + self.doubt).ceil().max(0.0) as i32;
        // Where a corner is off by more than an i32 holds, no pixel is certain.
        let last = |v: f64, size: i32| ((v - self.doubt).floor() as i32).clamp(0, size) - 1;
        self.columns = [first(min[0]), last(max[0], self.size[0])];
        self.rows = [first(min[1]), last(max[1], self.size[1])];
    }

    /// Adds the edge from `p` to `q`, whose inner side is `side` (1 or −1) times the left of it, where y grows
    /// downward as pixels do: that is where (q − p) × (r − p) has the sign of `side`.
    pub(super) fn edge(&mut self, p: Spot, q: Spot, side: f64) {
        let (a, b) = ((p.y - q.y) * side, (q.x - p.x) * side);
        if a == 0.0 && b == 0.0 {
            return;
        }
        // a·x + b·y + c ≥ 0 iff all of pixel (x, y) is inside.
        let c = -(a * p.x + b * p.y) + 0.5 * (a + b) - (0.5 + self.doubt) * (a.abs() + b.abs());
        if b.abs() > a.abs() * 1e5 {
            // So nearly level that it bounds rows alone.
            let worst = c + (a * f64::from(self.size[0])).min(0.0);
            let row = (-worst / b).clamp(-2.0, 1e6);
            if b > 0.0 {
                self.rows[0] = self.rows[0].max(row.ceil() as i32);
            } else {
                self.rows[1] = self.rows[1].min(row.floor() as i32);
            }
            return;
        }
        let (slope, start) = (-b / a, -c / a);
        // What f32 may be off by in slope · row + start.
        let slack = (slope.abs() * f64::from(self.size[1]) + start.abs() + 1.0) * 2.0_f64.powi(-21);
        if !(slope.is_finite() && start.is_finite()) {
            self.rows = [1, 0];
        } else if a > 0.0 {
            self.left.push(Bound { slope: slope as f32, start: (start + slack).min(1e30) as f32 });
        } else {
            self.right
                .push(Bound { slope: slope as f32, start: (start - slack).max(-1e30) as f32 });
        }
    }

    /// Adds a plane: what fills the outline is at each pixel at least as near as the farthest of all.
    pub(super) fn plane(&mut self, plane: Plane) {
        self.planes.push(plane);
    }

    /// Whether the box leaves room for no pixel.
    pub(super) fn is_thin(&self) -> bool {
        self.rows[0] > self.rows[1] || self.columns[0] > self.columns[1]
    }

    /// Whether no pixel can be covered.
    pub(super) fn is_empty(&self) -> bool {
        self.is_thin() || self.planes.is_empty()
    }
}

impl OcclusionBuffer {
    /// Covers what lies wholly within the outline that was built.
    pub(super) fn fill(&mut self, level: Level) {
        if self.outline.is_empty() {
            return;
        }
        let Self { size, columns, tiles, far, live, outline, .. } = self;
        let target = Target { size: *size, columns: *columns, tiles, far, live };
        // Boxes show one to three faces: with their number known, what is the same for all pixels of a tile is
        // reckoned once.
        dispatch!(level, simd => match outline.planes[..] {
            [a] => fill(simd, target, outline, &[a]),
            [a, b] => fill(simd, target, outline, &[a, b]),
            [a, b, c] => fill(simd, target, outline, &[a, b, c]),
            _ => fill(simd, target, outline, &outline.planes[..]),
        });
    }
}

struct Target<'a> {
    size: [u32; 2],
    columns: usize,
    tiles: &'a mut [Tile],
    far: &'a mut [f32],
    live: &'a mut [bool],
}

const LANES: [f32; TILE] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
const NOWHERE: f32 = 1e9;

/// A row of tiles at a time: first the columns that each of its rows of pixels spans, a row a lane; then
/// the tiles between the least and the most of them. Products and sums are never fused, so that every
/// level rounds alike.
#[inline(always)]
fn fill<S: Simd, P: AsRef<[Plane]> + ?Sized>(
    simd: S,
    target: Target<'_>,
    outline: &Outline,
    planes: &P,
) {
    let planes = planes.as_ref();
    let Target { size, columns, tiles, far, live } = target;
    let lanes = f32x8::from_slice(simd, &LANES);
    let [top, bottom] = outline.rows;
    let [leftmost, rightmost] = outline.columns;
    let tile = TILE as i32;
    for tile_row in top / tile..=bottom / tile {
        let y0 = (tile_row * tile) as f32;
        let rows = lanes + y0;
        let mut from = f32x8::splat(simd, leftmost as f32);
        let mut to = f32x8::splat(simd, rightmost as f32);
        for b in &outline.left {
            from = from.max(rows * b.slope + b.start);
        }
        for b in &outline.right {
            to = to.min(rows * b.slope + b.start);
        }
        let nowhere = f32x8::splat(simd, NOWHERE);
        let inside = rows.simd_ge(f32x8::splat(simd, top as f32))
            & rows.simd_le(f32x8::splat(simd, bottom as f32));
        from = inside.select(from.min(nowhere).ceil(), nowhere);
        to = to.floor();
        let any = from.simd_le(to);
        let first = any.select(from, nowhere).reduce_min();
        if first >= NOWHERE {
            continue;
        }
        let last = any.select(to, -nowhere).reduce_max();
        let (all_from, all_to) = (from.reduce_max(), to.reduce_min());
        let (from, to): ([f32; TILE], [f32; TILE]) = (from.into(), to.into());
        for column in first as usize / TILE..=last as usize / TILE {
            let x0 = (column * TILE) as f32;
            let t = tile_row as usize * columns + column;
            if best(planes, x0, y0) <= far[t] {
                continue;
            }
            OcclusionBuffer::wake(size, columns, tiles, live, t);
            let whole = all_from <= x0 && all_to >= x0 + (TILE - 1) as f32;
            let xs = lanes + x0;
            let pixels = &mut tiles[t].0;
            let mut least = f32x8::splat(simd, f32::INFINITY);
            for row in 0..TILE {
                let mut value = f32x8::splat(simd, f32::INFINITY);
                for p in planes {
                    let start =
                        p.value + ((x0 - p.column) * p.dx + (y0 + row as f32 - p.row) * p.dy);
                    value = value.min(lanes * p.dx + start);
                }
                let pixels = &mut pixels[row * TILE..][..TILE];
                let old = f32x8::from_slice(simd, pixels);
                let mut new = old.max(value);
                if !whole {
                    let span = xs.simd_ge(f32x8::splat(simd, from[row]))
                        & xs.simd_le(f32x8::splat(simd, to[row]));
                    new = span.select(new, old);
                }
                new.store_slice(pixels);
                least = least.min(new);
            }
            far[t] = least.reduce_min();
        }
    }
}

/// The most that the planes allow anywhere in a tile.
#[inline(always)]
fn best(planes: &[Plane], x0: f32, y0: f32) -> f32 {
    let edge = (TILE - 1) as f32;
    planes.iter().fold(f32::INFINITY, |least, p| {
        let corner = p.at(x0, y0) + ((p.dx * edge).max(0.0) + (p.dy * edge).max(0.0));
        // Its own rounding, so that no pixel is better than this.
        least.min(corner + corner.abs() * 1e-6)
    })
}
