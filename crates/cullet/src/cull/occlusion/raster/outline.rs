//! Filling convex outlines: only pixels that lie wholly within all edges.

use fearless_simd::f32x8;
use fearless_simd::prelude::*;

use super::plane::Plane;
use super::screen::Spot;
use super::tile::{Held, LANES, PLANES, TILE, TilePlane};
use super::tiles::TilesMut;
use crate::bits;

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
    planes: Vec<Slope>,
    /// The pixels that an edge moves inward by, because its ends are off by that much.
    doubt: f64,
}

impl Outline {
    /// Begins an outline within the box `min`..`max` of pixels on a screen of `size`, of which these `rows`,
    /// from the first to the last, are to be filled; its corners are off by `doubt` pixels at most.
    pub(crate) fn begin(
        &mut self,
        size: [u32; 2],
        rows: [usize; 2],
        min: [f64; 2],
        max: [f64; 2],
        doubt: f64,
    ) {
        self.left.clear();
        self.right.clear();
        self.planes.clear();
        self.size = size.map(|s| s as i32);
        self.doubt = doubt + SLACK;
        let first = |v: f64| (v + self.doubt).ceil().max(0.0) as i32;
        // Where a corner is off by more than an i32 holds, no pixel is certain.
        let last = |v: f64, size: i32| ((v - self.doubt).floor() as i32).clamp(0, size) - 1;
        self.columns = [first(min[0]), last(max[0], self.size[0])];
        self.rows =
            [first(min[1]).max(rows[0] as i32), last(max[1], self.size[1]).min(rows[1] as i32)];
    }

    /// Adds the edge from `p` to `q`, whose inner side is `side` (1 or −1) times the left of it, where y grows
    /// downward as pixels do: that is where (q − p) × (r − p) has the sign of `side`.
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

    /// Adds a plane: what fills the outline is at each pixel at least as near as the farthest of all.
    pub(crate) fn plane(&mut self, plane: Plane) {
        self.planes.push(Slope::of(&plane));
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
    pub(super) fn fill<S: Simd>(&self, simd: S, tiles: TilesMut<'_>) {
        if self.is_empty() {
            return;
        }
        // Boxes show one to three faces: with their number known, what is the same for all pixels of a tile is
        // computed once.
        match self.planes[..] {
            [a] => fill(simd, tiles, self, &[a]),
            [a, b] => fill(simd, tiles, self, &[a, b]),
            [a, b, c] => fill(simd, tiles, self, &[a, b, c]),
            _ => fill(simd, tiles, self, &self.planes[..]),
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

    #[inline(always)]
    pub(crate) fn clear(&mut self) {
        self.count = 0;
    }
}

/// A plane as tiles are filled with it; see [`TilePlane`].
#[derive(Clone, Copy, Debug)]
struct Slope {
    plane: Plane,
    /// 0 dy to 7 dy.
    down: [f32; TILE],
    /// Where it is nearest: the larger of 0 and 7 dx, and of 0 and 7 dy.
    high: [f32; 2],
}

impl Slope {
    #[inline(always)]
    fn of(plane: &Plane) -> Self {
        let edge = (TILE - 1) as f32;
        let across = [plane.dx * edge, plane.dy * edge];
        let mut down = LANES;
        for v in &mut down {
            *v *= plane.dy;
        }
        // A tile may begin seven pixels before what the plane was made for, and rounds by as much more.
        let value = plane.value - (plane.dx.abs() + plane.dy.abs()) * (1.0 / (1 << 17) as f32);
        Self {
            plane: Plane { value, ..*plane },
            down,
            high: [across[0].max(0.0), across[1].max(0.0)],
        }
    }

    /// The plane within a tile.
    #[inline(always)]
    fn within(&self, x0: f32, y0: f32) -> TilePlane {
        TilePlane { dx: self.plane.dx, start: self.start(x0, y0), dy: self.plane.dy }
    }

    /// The bound in the first pixel of a tile.
    #[inline(always)]
    fn start(&self, x0: f32, y0: f32) -> f32 {
        let p = &self.plane;
        p.value + ((x0 - p.column) * p.dx + (y0 - p.row) * p.dy)
    }
}

const NOWHERE: f32 = 1e9;

/// A row of tiles at a time: first the columns that each of its rows of pixels spans, a row a lane; then, eight
/// at a time, the tiles between the least and the most of them that have something farther. Products and sums
/// are never fused, so that every level rounds alike.
#[inline(always)]
fn fill<S: Simd, P: AsRef<[Slope]> + ?Sized>(
    simd: S,
    mut target: TilesMut<'_>,
    outline: &Outline,
    planes: &P,
) {
    let planes = planes.as_ref();
    let lanes = f32x8::from_slice(simd, &LANES);
    let [top, bottom] = outline.rows;
    let [leftmost, rightmost] = outline.columns;
    let nowhere = f32x8::splat(simd, NOWHERE);
    for tile_row in top as usize / TILE..=bottom as usize / TILE {
        let y0 = (tile_row * TILE) as f32;
        let rows = lanes + y0;
        let mut from = f32x8::splat(simd, leftmost as f32);
        let mut to = f32x8::splat(simd, rightmost as f32);
        for b in &outline.left {
            from = from.max(rows * b.slope + b.start);
        }
        for b in &outline.right {
            to = to.min(rows * b.slope + b.start);
        }
        let inside = rows.simd_ge(f32x8::splat(simd, top as f32))
            & rows.simd_le(f32x8::splat(simd, bottom as f32));
        from = inside.select(from.min(nowhere).ceil(), nowhere);
        to = to.floor();
        let any = from.simd_le(to);
        let first = any.select(from, nowhere).reduce_min();
        if first >= NOWHERE {
            continue;
        }
        let last = any.select(to, -nowhere).reduce_max() as usize / TILE;
        let whole = [from.reduce_max(), to.reduce_min() - (TILE - 1) as f32];
        let (from, to): ([f32; TILE], [f32; TILE]) = (from.into(), to.into());
        let mut column = first as usize / TILE;
        while column <= last {
            let count = (last - column + 1).min(TILE);
            let t = (tile_row - target.rows[0]) * target.columns + column;
            let x0 = (lanes + column as f32) * TILE as f32;
            let mut best = f32x8::splat(simd, f32::INFINITY);
            for s in planes {
                let p = &s.plane;
                let start = (x0 - p.column) * p.dx + (y0 - p.row) * p.dy + p.value;
                best = best.min(start + s.high[0] + s.high[1]);
            }
            let far = match target.far.get(t..t + TILE) {
                Some(far) => f32x8::from_slice(simd, far),
                // The last tiles of the buffer.
                None => {
                    let mut far = [0.0; TILE];
                    far[..count].copy_from_slice(&target.far[t..t + count]);
                    f32x8::from_slice(simd, &far)
                }
            };
            let open = best.simd_gt(far).to_bitmask() & u64::MAX >> (64 - count);
            for i in bits::ones(open) {
                let x0 = ((column + i) * TILE) as f32;
                if whole[0] <= x0 && whole[1] >= x0 {
                    cover(simd, &mut target, planes, t + i, x0, y0);
                } else {
                    cover_part(simd, &mut target, planes, t + i, x0, y0, (&from, &to));
                }
            }
            column += count;
        }
    }
}

/// Covers all of a tile.
#[inline(always)]
fn cover<S: Simd>(
    simd: S,
    target: &mut TilesMut<'_>,
    planes: &[Slope],
    t: usize,
    x0: f32,
    y0: f32,
) {
    let mut least = f32::INFINITY;
    for s in planes {
        least = least.min(s.within(x0, y0).least());
    }
    if !target.is_behind(t, least) {
        let rows = ([f32::NEG_INFINITY; TILE], [f32::INFINITY; TILE]);
        cover_part(simd, target, planes, t, x0, y0, (&rows.0, &rows.1));
        return;
    }
    // All of it is on the screen: nothing that was here need be read.
    if let [first, ..] = planes
        && planes.len() <= PLANES
    {
        let mut kept = [first.within(x0, y0); PLANES];
        for (kept, s) in kept.iter_mut().zip(planes) {
            *kept = s.within(x0, y0);
        }
        target.hold(t, kept, least);
        return;
    }
    target.far[t] = least.max(0.0);
    target.held[t] = Held::Pixels;
    let lanes = f32x8::from_slice(simd, &LANES);
    let zero = f32x8::splat(simd, 0.0);
    for (row, pixels) in target.tiles[t].0.as_chunks_mut::<TILE>().0.iter_mut().enumerate() {
        let mut value = f32x8::splat(simd, f32::INFINITY);
        for s in planes {
            value = value.min(lanes * s.plane.dx + s.start(x0, y0) + s.down[row]);
        }
        value.max(zero).store_slice(pixels);
    }
}

/// Covers in each row of a tile the pixels between two columns.
#[inline(always)]
fn cover_part<S: Simd>(
    simd: S,
    target: &mut TilesMut<'_>,
    planes: &[Slope],
    t: usize,
    x0: f32,
    y0: f32,
    (from, to): (&[f32; TILE], &[f32; TILE]),
) {
    target.wake(t);
    let lanes = f32x8::from_slice(simd, &LANES);
    let xs = lanes + x0;
    let mut least = f32x8::splat(simd, f32::INFINITY);
    for (row, pixels) in target.tiles[t].0.as_chunks_mut::<TILE>().0.iter_mut().enumerate() {
        let mut value = f32x8::splat(simd, f32::INFINITY);
        for s in planes {
            value = value.min(lanes * s.plane.dx + s.start(x0, y0) + s.down[row]);
        }
        let old = f32x8::from_slice(simd, pixels);
        let span =
            xs.simd_ge(f32x8::splat(simd, from[row])) & xs.simd_le(f32x8::splat(simd, to[row]));
        let new = span.select(old.max(value), old);
        new.store_slice(pixels);
        least = least.min(new);
    }
    target.far[t] = least.reduce_min();
}
