//! Filling convex outlines: only pixels that lie wholly within all edges.

use alloc::vec::Vec;

use fearless_simd::prelude::*;
use fearless_simd::{f32x8, mask32x8, u32x8};

use super::blocks::{BLOCK, BlocksMut, TILE};
use super::plane::Plane;
use super::screen::Spot;
use super::span::{ROWS, Span};
use crate::array::Each;
use crate::bits;
#[cfg(not(feature = "std"))]
use crate::math::Float as _;

/// Pixels by which every edge moves inward beyond what is exact: more than anything here is off by.
const SLACK: f64 = 1.0 / 1024.0;

/// Error bound of f32 in slope · row + start, as a share of the sizes of both.
const EDGE_SHARE: f64 = 1.0 / (1 << 21) as f64;

/// An edge that goes so many columns a row bounds rows alone.
const STEEPEST: f64 = 1e5;

/// A start beyond this bounds nothing that is on a screen, or all of it.
const FARTHEST: f64 = 1e30;

/// An edge as a bound on the columns of a row of pixels: slope · row + start.
#[derive(Clone, Copy, Debug)]
struct Bound {
    slope: f32,
    start: f32,
}

/// A convex outline that is being built, and the planes of what fills it. Kept for its memory.
#[derive(Clone, Debug, Default)]
pub(crate) struct Outline {
    left: Vec<Bound>,
    right: Vec<Bound>,
    /// The first and last row and column of pixels, inclusive.
    rows: [i32; 2],
    columns: [i32; 2],
    size: [i32; 2],
    /// Planes of what fills it: at each pixel it is as near as the farthest of these.
    planes: Vec<TilePlane>,
    /// No pixel is covered by what is nearer.
    nearest: f32,
    /// The pixels that an edge moves inward by, because its ends are off by that much.
    doubt: f64,
}

impl Outline {
    /// Empties it: it covers nothing.
    pub(crate) fn clear(&mut self) {
        self.left.clear();
        self.right.clear();
        self.planes.clear();
    }

    /// Begins an outline within the box `min`..`max` of pixels on a screen of `size`; its corners
    /// are off by `doubt` pixels at most.
    pub(crate) fn begin(&mut self, size: [u32; 2], min: [f64; 2], max: [f64; 2], doubt: f64) {
        self.clear();
        self.size = size.each(|s| s as i32);
        self.doubt = doubt + SLACK;
        self.nearest = f32::INFINITY;
        let first = |v: f64| (v + self.doubt).ceil().max(0.0) as i32;
        // Where a corner is off by more than an i32 holds, no pixel is certain.
        let last = |v: f64, size: i32| ((v - self.doubt).floor() as i32).clamp(0, size) - 1;
        self.columns = [first(min[0]), last(max[0], self.size[0])];
        self.rows = [first(min[1]), last(max[1], self.size[1])];
    }

    /// Says that what fills the outline is no nearer than `nearest`. Blocks that are at least so
    /// near are passed over.
    pub(crate) fn come_no_nearer(&mut self, nearest: f32) {
        self.nearest = nearest;
    }

    /// Adds the edge from `p` to `q`, whose inner side is `side` (1 or −1) times the left of it,
    /// where y grows downward as pixels do: that is where (q − p) × (r − p) has the sign of `side`.
    pub(crate) fn edge(&mut self, p: Spot, q: Spot, side: f64) {
        let (a, b) = ((p.y - q.y) * side, (q.x - p.x) * side);
        if a == 0.0 && b == 0.0 {
            return;
        }
        // a·x + b·y + c ≥ 0 iff all of pixel (x, y) is inside.
        let c = -(a * p.x + b * p.y) + 0.5 * (a + b) - (0.5 + self.doubt) * (a.abs() + b.abs());
        if b.abs() > a.abs() * STEEPEST {
            // So nearly horizontal that it bounds rows alone.
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
        // Error bound of f32 in slope · row + start.
        let slack = (slope.abs() * f64::from(self.size[1]) + start.abs() + 1.0) * EDGE_SHARE;
        if !(slope.is_finite() && start.is_finite()) {
            self.rows = [1, 0];
        } else if a > 0.0 {
            self.left
                .push(Bound { slope: slope as f32, start: (start + slack).min(FARTHEST) as f32 });
        } else {
            self.right
                .push(Bound { slope: slope as f32, start: (start - slack).max(-FARTHEST) as f32 });
        }
    }

    /// Adds a plane: what fills the outline is at each pixel at least as near as the farthest of
    /// all.
    pub(crate) fn plane(&mut self, plane: Plane) {
        self.planes.push(TilePlane::of(&plane));
    }

    /// Adds some edges at once, as [`edge`](Self::edge) does, all with the inner side `side`.
    #[inline(always)]
    pub(crate) fn edges<S: Simd>(&mut self, simd: S, edges: &Edges, side: f64) {
        let mut slopes = [0.0; 8];
        let mut starts = [[0.0; 8]; 2];
        let mut ordinary = 0_u64;
        let side_of = S::f64s::splat(simd, side);
        let half = S::f64s::splat(simd, 0.5);
        let inset = S::f64s::splat(simd, 0.5 + self.doubt);
        let height = S::f64s::splat(simd, f64::from(self.size[1]));
        let (one, share) = (S::f64s::splat(simd, 1.0), S::f64s::splat(simd, EDGE_SHARE));
        let infinite = S::f64s::splat(simd, f64::INFINITY);
        let mut at = 0;
        while at < edges.count {
            let lanes = at..at + S::f64s::LEN;
            let px = S::f64s::from_slice(simd, &edges.from[0][lanes.clone()]);
            let py = S::f64s::from_slice(simd, &edges.from[1][lanes.clone()]);
            let qx = S::f64s::from_slice(simd, &edges.to[0][lanes.clone()]);
            let qy = S::f64s::from_slice(simd, &edges.to[1][lanes.clone()]);
            let (a, b) = ((py - qy) * side_of, (qx - px) * side_of);
            let c = (a + b) * half - (a * px + b * py) - inset * (a.abs() + b.abs());
            let inverse = one / a;
            let (slope, start) = (-(b * inverse), -(c * inverse));
            let slack = (slope.abs() * height + start.abs() + one) * share;
            let is_ordinary = (b.abs().simd_le(a.abs() * S::f64s::splat(simd, STEEPEST)))
                & slope.abs().simd_lt(infinite)
                & start.abs().simd_lt(infinite);
            ordinary |= is_ordinary.to_bitmask() << at;
            // The one that bounds from the left where a > 0, and its sign.
            let is_left = a.simd_gt(S::f64s::splat(simd, 0.0));
            slope.store_slice(&mut slopes[lanes.clone()]);
            is_left.select(start + slack, start - slack).store_slice(&mut starts[0][lanes.clone()]);
            a.store_slice(&mut starts[1][lanes.clone()]);
            at += S::f64s::LEN;
        }
        for i in 0..edges.count {
            if ordinary >> i & 1 == 0 {
                let end = |e: &[[f64; 8]; 2]| Spot { x: e[0][i], y: e[1][i], nearness: 0.0 };
                self.edge(end(&edges.from), end(&edges.to), side);
            } else {
                let [start, a] = [starts[0][i], starts[1][i]];
                let start = start.clamp(-FARTHEST, FARTHEST) as f32;
                let bound = Bound { slope: slopes[i] as f32, start };
                if a > 0.0 { self.left.push(bound) } else { self.right.push(bound) }
            }
        }
    }

    /// Covers what lies wholly within the outline.
    #[inline(always)]
    pub(super) fn fill<S: Simd>(&self, simd: S, target: &mut BlocksMut<'_>) {
        if !self.is_empty() {
            fill(simd, target, self);
        }
    }

    /// Whether the box leaves room for no pixel.
    pub(crate) fn is_thin(&self) -> bool {
        self.rows[0] > self.rows[1] || self.columns[0] > self.columns[1]
    }

    /// Whether no pixel can be covered.
    fn is_empty(&self) -> bool {
        self.is_thin() || self.planes.is_empty()
    }
}

/// Up to eight edges: where each comes from and goes to.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Edges {
    from: [[f64; 8]; 2],
    to: [[f64; 8]; 2],
    count: usize,
}

impl Edges {
    #[inline(always)]
    pub(crate) fn push(&mut self, [from, to]: [Spot; 2]) {
        let i = self.count % 8;
        (self.from[0][i], self.from[1][i]) = (from.x, from.y);
        (self.to[0][i], self.to[1][i]) = (to.x, to.y);
        self.count = i + 1;
    }

    #[inline(always)]
    pub(crate) fn is_full(&self) -> bool {
        self.count == 8
    }
}

/// A plane over tiles: no nearer, anywhere within the tile that begins at a pixel, than value +
/// gradient · (that pixel).
#[derive(Clone, Copy, Debug)]
struct TilePlane {
    plane: Plane,
    /// The bound at `plane`'s own pixel, over a tile that begins there; over that pixel alone; and
    /// how far the bounds of the pixels of a tile lie apart.
    value: f32,
    pixel: f32,
    range: f32,
}

impl TilePlane {
    fn of(plane: &Plane) -> Self {
        let [width, height] = TILE.each(|t| (t - 1) as f32);
        // A tile may begin seven pixels before what the plane was made for, and rounds by as much
        // more.
        let pixel = plane.value - (plane.dx.abs() + plane.dy.abs()) * (1.0 / (1 << 17) as f32);
        let value = pixel + (plane.dx * width).min(0.0) + (plane.dy * height).min(0.0);
        // With more than what rounding adds.
        let range = (plane.dx * (width + 0.01)).abs() + (plane.dy * (height + 0.01)).abs();
        Self { plane: *plane, value, pixel, range }
    }

    /// Bounds of the pixels of a tile, row by row.
    #[inline(always)]
    fn pixels<S: Simd>(&self, simd: S, x: f32, y: f32) -> [f32x8<S>; 4] {
        let p = &self.plane;
        let start = (x - p.column) * p.dx + (y - p.row) * p.dy + self.pixel;
        let row = f32x8::simd_from(simd, ROWS) * p.dx + start;
        [row, row + p.dy, row + 2.0 * p.dy, row + 3.0 * p.dy]
    }

    /// Bounds of tiles, the first pixels of which are given.
    #[inline(always)]
    fn at<S: Simd>(&self, simd: S, x: f32x8<S>, y: f32x8<S>) -> f32x8<S> {
        let p = &self.plane;
        let value = f32x8::splat(simd, self.value);
        (x - p.column) * p.dx + (y - p.row) * p.dy + value
    }
}

/// A row of blocks at a time: first the columns that each of its rows of pixels spans, a row a
/// lane; then the blocks that any of them reaches. Products and sums are never fused, so that every
/// level rounds alike.
#[inline(always)]
fn fill<S: Simd>(simd: S, target: &mut BlocksMut<'_>, outline: &Outline) {
    let splat = |v: f32| f32x8::splat(simd, v);
    let [top, bottom] = outline.rows;
    let [leftmost, rightmost] = outline.columns;
    let across = f32x8::simd_from(simd, [0.0, 8.0, 16.0, 24.0, 0.0, 8.0, 16.0, 24.0]);
    let down = f32x8::simd_from(simd, [0.0, 0.0, 0.0, 0.0, 4.0, 4.0, 4.0, 4.0]);
    let (low, high) = (splat(leftmost as f32), splat(rightmost as f32 + 1.0));
    let (first, last) = (leftmost as usize / BLOCK[0], rightmost as usize / BLOCK[0]);
    let rows = top as usize / BLOCK[1]..bottom as usize / BLOCK[1] + 1;
    for row in rows.start.max(target.rows.start)..rows.end.min(target.rows.end) {
        let y0 = (row * BLOCK[1]) as f32;
        let y = f32x8::simd_from(simd, ROWS) + y0;
        let (mut from, mut to) = (low, high - 1.0);
        for b in &outline.left {
            from = from.max(y * b.slope + b.start);
        }
        for b in &outline.right {
            to = to.min(y * b.slope + b.start);
        }
        let inside = y.simd_ge(splat(top as f32)) & y.simd_le(splat(bottom as f32));
        let span = Span::new(simd, from.min(high).ceil(), to.floor() + 1.0, inside);
        let Some((from, to)) = span.blocks(simd, first, last) else { continue };
        let tile_y = down + y0;
        for column in from..=to {
            if !target.is_open(simd, [column, row], outline.nearest) {
                continue;
            }
            let tile_x = across + (column * BLOCK[0]) as f32;
            let (mut far, mut near) = (splat(f32::INFINITY), splat(f32::INFINITY));
            for plane in &outline.planes {
                let at = plane.at(simd, tile_x, tile_y);
                let most = at + at.abs() * (1.0 / (1 << 20) as f32) + plane.range;
                (far, near) = (far.min(at), near.min(most));
            }
            let covered = span.tiles(simd, column);
            let steep = target.steep(simd, [column, row], far, near);
            if steep == 0 {
                target.raise(simd, [column, row], covered, far);
                continue;
            }
            let of_steep = mask32x8::from_bitmask(simd, u64::from(steep));
            let others = of_steep.select(u32x8::splat(simd, 0), covered);
            target.raise(simd, [column, row], others, far);
            let covered: [u32; 8] = covered.into();
            for tile in bits::ones(u64::from(steep)).filter(|&tile| covered[tile] != 0) {
                let (x, y) =
                    (column * BLOCK[0] + tile % 4 * TILE[0], row * BLOCK[1] + tile / 4 * TILE[1]);
                let mut pixels = [splat(f32::INFINITY); 4];
                for plane in &outline.planes {
                    let of = plane.pixels(simd, x as f32, y as f32);
                    for k in 0..4 {
                        pixels[k] = pixels[k].min(of[k]);
                    }
                }
                target.raise_pixels(simd, [column, row], tile, covered[tile], pixels);
            }
        }
    }
}
