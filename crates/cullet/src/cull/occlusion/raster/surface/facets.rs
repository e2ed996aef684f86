//! Facets: which of eight show the side that is drawn, where their sides bound rows of pixels, how
//! near they are, and what each covers.

use core::ops::Range;

use fearless_simd::prelude::*;
use fearless_simd::{f32x8, mask32x8, u32x8};

use super::super::blocks::{BLOCK, BlocksMut};
use super::super::connected::LANES;
use super::super::span::{ROWS, Span, blocks};
use super::{Surface, Window};
use crate::array::Each;
use crate::bits;

/// A side that is more level than this is given this slope, through its first end.
const LEVEL: f32 = 1.0 / 4_194_304.0;

/// Columns beyond any screen.
const NOWHERE: f32 = 1e9;

/// Pixels across and down from which on a facet is looked through for whole tiles.
const LARGE: [f32; 2] = [16.0, 8.0];

/// Eight facets of N sides. A side bounds the columns of row y from the left or the right: slope ·
/// y + start.
#[repr(align(32))]
struct Facets<const N: usize> {
    slope: [[f32; LANES]; N],
    start: [[f32; LANES]; N],
    /// Large where the side bounds from the left, −large where from the right.
    cap: [[f32; LANES]; N],
    /// First column and row; one beyond the last column, and the last row.
    low: [[f32; LANES]; 2],
    high: [[f32; LANES]; 2],
    /// First and last column of blocks; first and last row.
    columns: [[i32; LANES]; 2],
    rows: [[i32; LANES]; 2],
    /// No nearer than the facet anywhere within a tile: base + gradient · (its first column and
    /// row), but at least `least`.
    base: [f32; LANES],
    gradient: [[f32; LANES]; 2],
    least: [f32; LANES],
    /// One bit a facet: large enough to have tiles wholly within.
    large: u64,
}

/// A facet as it is covered: its numbers in all lanes.
struct Facet<S: Simd, const N: usize> {
    sides: Sides<S, N>,
    /// First column of pixels, and one beyond the last; the first and the last row.
    low: f32x8<S>,
    high: f32x8<S>,
    top: f32x8<S>,
    bottom: f32x8<S>,
    /// The first and the last column of blocks, the bits of those between in the window, and the
    /// rows of blocks.
    first: usize,
    last: usize,
    columns: u64,
    rows: Range<usize>,
    /// Nearness of the tiles of the block at the buffer's first column and row, and by what it
    /// grows for each pixel.
    base: f32x8<S>,
    gradient: [f32; 2],
    least: f32x8<S>,
    cap: f32x8<S>,
}

impl<S: Simd, const N: usize> Facet<S, N> {
    #[inline(always)]
    fn new(simd: S, of: &Facets<N>, lane: usize, window: &Window) -> Self {
        let splat = |v: f32| f32x8::splat(simd, v);
        let [x0, x1] = [of.low[0][lane], of.high[0][lane]];
        let [y0, y1] = [of.low[1][lane], of.high[1][lane]];
        let [first, last] = of.columns.each(|all| all[lane] as u32 as usize);
        let [top, bottom] = of.rows.each(|all| all[lane] as u32 as usize);
        let (low, high) = (splat(x0), splat(x1));
        let mut sides = Sides { slope: [low; N], start: [low; N], cap: [low; N] };
        for k in 0..N {
            sides.slope[k] = splat(of.slope[k][lane]);
            sides.start[k] = splat(of.start[k][lane]);
            sides.cap[k] = splat(of.cap[k][lane]);
        }
        let gradient = [of.gradient[0][lane], of.gradient[1][lane]];
        let across = f32x8::simd_from(simd, [0.0, 8.0, 16.0, 24.0, 0.0, 8.0, 16.0, 24.0]);
        let down = f32x8::simd_from(simd, [0.0, 0.0, 0.0, 0.0, 4.0, 4.0, 4.0, 4.0]);
        Self {
            sides,
            low,
            high,
            top: splat(y0),
            bottom: splat(y1),
            first,
            last,
            columns: window.run([first, last]),
            rows: top..bottom + 1,
            base: across * gradient[0] + (down * gradient[1] + of.base[lane]),
            gradient,
            least: splat(of.least[lane]),
            cap: splat(window.cap),
        }
    }

    /// The rows of pixels of a row of blocks, and which of them the facet may touch.
    #[inline(always)]
    fn row(&self, simd: S, row: usize) -> (f32x8<S>, mask32x8<S>) {
        let y = f32x8::simd_from(simd, ROWS) + pixels(row, 1);
        (y, y.simd_ge(self.top) & y.simd_le(self.bottom))
    }

    /// Nearness of the tiles of a block of a row whose first block has `of_row`.
    #[inline(always)]
    fn nearness(&self, of_row: f32x8<S>, column: usize) -> f32x8<S> {
        let along = self.gradient[0] * pixels(column, 0);
        (of_row + along).max(self.least).min(self.cap)
    }
}

/// A facet as it is covered: its sides in all lanes.
struct Sides<S: Simd, const N: usize> {
    slope: [f32x8<S>; N],
    start: [f32x8<S>; N],
    cap: [f32x8<S>; N],
}

impl<S: Simd, const N: usize> Sides<S, N> {
    /// Between which columns eight rows are touched.
    #[inline(always)]
    fn columns(&self, y: f32x8<S>, mut left: f32x8<S>, mut right: f32x8<S>) -> [f32x8<S>; 2] {
        for k in 0..N {
            let at = self.slope[k] * y + self.start[k];
            left = left.max(at.min(self.cap[k]));
            right = right.min(at.max(self.cap[k]));
        }
        [left, right]
    }

    /// Between which columns pixels of eight rows lie wholly within the facet.
    #[inline(always)]
    fn inner_columns(
        &self,
        y: f32x8<S>,
        inset: &[f32x8<S>; N],
        mut left: f32x8<S>,
        mut right: f32x8<S>,
    ) -> [f32x8<S>; 2] {
        for k in 0..N {
            let at = self.slope[k] * y + self.start[k];
            left = left.max((at + inset[k]).min(self.cap[k]));
            right = right.min((at - inset[k]).max(self.cap[k]));
        }
        [left, right]
    }
}

/// Pixels before a column of blocks, or before a row.
#[inline(always)]
fn pixels(block: usize, axis: usize) -> f32 {
    // A conversion from 32 bits is a single instruction.
    (block * BLOCK[axis]) as i32 as f32
}

#[inline(always)]
fn least<S: Simd, const N: usize>(v: &[f32x8<S>; N]) -> f32x8<S> {
    let least = v[0].min(v[1]).min(v[2]);
    if N == 4 { least.min(v[N - 1]) } else { least }
}

#[inline(always)]
fn most<S: Simd, const N: usize>(v: &[f32x8<S>; N]) -> f32x8<S> {
    let most = v[0].max(v[1]).max(v[2]);
    if N == 4 { most.max(v[N - 1]) } else { most }
}

impl Surface {
    /// Covers what a group of eight facets touches. With `number`, that of the first, those that
    /// are turned the right way for certain are noted as drawn; without, it is known that all are.
    #[inline(always)]
    pub(super) fn group<S: Simd, const N: usize>(
        &mut self,
        simd: S,
        window: &Window,
        corners: &[[u16; LANES]; N],
        turned: bool,
        number: Option<usize>,
        target: &mut BlocksMut<'_>,
    ) {
        simd.vectorize(
            #[inline(always)]
            || self.group_of(simd, window, corners, turned, number, target),
        );
    }

    #[inline(always)]
    fn group_of<S: Simd, const N: usize>(
        &mut self,
        simd: S,
        window: &Window,
        corners: &[[u16; LANES]; N],
        turned: bool,
        number: Option<usize>,
        target: &mut BlocksMut<'_>,
    ) {
        let splat = |v: f32| f32x8::splat(simd, v);
        let zero = splat(0.0);
        let (mut x, mut y, mut n, mut rows) = ([zero; N], [zero; N], [zero; N], *corners);
        for k in 0..N {
            // A diagonal stays between the first corner and the third.
            rows[k] = corners[if turned && k > 0 { N - k } else { k }];
            [x[k], y[k], n[k]] = self.spots.gather(simd, &rows[k]);
        }
        let (low, high) = ([least(&x), least(&y)], [most(&x), most(&y)]);
        let mut lanes;
        if let Some(number) = number {
            let margin = splat(window.margin);
            let size = (high[0] - low[0] + (high[1] - low[1])) * 2.0;
            // Twice an area of corners that are off by the margin is off by no more.
            let slack =
                size * (size * splat(1.0 / 2_097_152.0) + margin * 2.0) + margin * margin * 8.0;
            let mut drawn = turn(&x, &y, [0, 1, 2]).simd_gt(slack);
            if N == 4 {
                drawn &= turn(&x, &y, [0, 2, N - 1]).simd_gt(slack);
            }
            lanes = drawn.to_bitmask();
            self.drawn[number..number + LANES].copy_from_slice(&bytes(lanes));
            if N == 4 && lanes != 0 {
                // Both triangles show, and together they are a quad on the screen.
                let convex = turn(&x, &y, [N - 1, 0, 1]).simd_gt(slack)
                    & turn(&x, &y, [1, 2, N - 1]).simd_gt(slack);
                let halved = lanes & !convex.to_bitmask();
                for lane in bits::ones(halved) {
                    let [a, b, c, d] = [0, 1, 2, N - 1].each(|k| rows[k][lane]);
                    self.halves.push([a, b, c]);
                    self.halves.push([a, c, d]);
                }
                lanes &= !halved;
            }
        } else {
            // What is left of a facet may have no area: it covers nothing.
            lanes = !turn(&x, &y, [0, 1, 2]).simd_eq(zero).to_bitmask() & 0xff;
        }
        if lanes != 0 {
            self.cover_group(simd, window, [&x, &y, &n], (low, high), lanes, target);
        }
    }

    /// Covers what some of eight facets touch.
    #[inline(always)]
    fn cover_group<S: Simd, const N: usize>(
        &mut self,
        simd: S,
        window: &Window,
        [x, y, n]: [&[f32x8<S>; N]; 3],
        (low, high): ([f32x8<S>; 2], [f32x8<S>; 2]),
        mut lanes: u64,
        target: &mut BlocksMut<'_>,
    ) {
        let splat = |v: f32| f32x8::splat(simd, v);
        let (zero, margin) = (splat(0.0), splat(window.margin));
        let left = (low[0] - margin).floor().max(splat(window.columns[0]));
        let right = ((high[0] + margin).floor() + 1.0).min(splat(window.columns[1]));
        // What is drawn must not depend on how far the window was narrowed.
        let large =
            (right - left).simd_ge(splat(LARGE[0])) & (high[1] - low[1]).simd_ge(splat(LARGE[1]));
        let low =
            [left.max(splat(window.low[0])), (low[1] - margin).floor().max(splat(window.low[1]))];
        let high = [
            right.min(splat(window.high[0])),
            (high[1] + margin).floor().min(splat(window.high[1])),
        ];
        lanes &= (low[0].simd_lt(high[0]) & low[1].simd_le(high[1])).to_bitmask();
        if lanes == 0 {
            return;
        }
        let mut made = Facets::<N> {
            slope: [[0.0; LANES]; N],
            start: [[0.0; LANES]; N],
            cap: [[0.0; LANES]; N],
            low: [low[0].into(), low[1].into()],
            high: [high[0].into(), high[1].into()],
            columns: [blocks(low[0], 0), blocks(high[0] - 1.0, 0)],
            rows: [blocks(low[1], 1), blocks(high[1], 1)],
            base: [0.0; LANES],
            gradient: [[0.0; LANES]; 2],
            least: [0.0; LANES],
            large: large.to_bitmask(),
        };
        for k in 0..N {
            let next = (k + 1) % N;
            let (dx, dy) = (x[next] - x[k], y[next] - y[k]);
            let is_left = dy.simd_gt(zero);
            let sign = is_left.select(splat(1.0), splat(-1.0));
            let down = dy.abs().max(dx.abs() * LEVEL + 1e-20) * sign;
            let slope = dx / down;
            let wide = slope.abs() * (margin + 0.5) + margin;
            let through = x[k] - slope * (y[k] - 0.5);
            slope.store_slice(&mut made.slope[k]);
            is_left.select(through - wide, through + wide + 1.0).store_slice(&mut made.start[k]);
            (sign * NOWHERE).store_slice(&mut made.cap[k]);
        }
        // A plane of any gradient that is nowhere nearer than a corner is behind all of the facet.
        let (far, near) = (least(n), most(n));
        let (c, d) = if N == 4 { ([0, 2], [1, N - 1]) } else { ([0, 1], [0, 2]) };
        let (ux, uy, un) = (x[c[1]] - x[c[0]], y[c[1]] - y[c[0]], n[c[1]] - n[c[0]]);
        let (tx, ty, tn) = (x[d[1]] - x[d[0]], y[d[1]] - y[d[0]], n[d[1]] - n[d[0]]);
        let inverse = splat(1.0) / (ux * ty - tx * uy);
        let (gx, gy) = ((un * ty - tn * uy) * inverse, (ux * tn - tx * un) * inverse);
        let mut base = n[0] - gx * x[0] - gy * y[0];
        for k in 1..N {
            base = base.min(n[k] - gx * x[k] - gy * y[k]);
        }
        let (share, beside) = (splat(window.share), splat(window.nearness));
        let error = (gx.abs() + gy.abs()) * splat(window.steep) + near.abs() * share + beside;
        // Slivers: no plane, only their farthest corner. The comparison is false for NaN too.
        let is_sure = error.simd_lt(splat(1e12));
        let far = far - far.abs() * share - beside;
        let (gx, gy) = (is_sure.select(gx, zero), is_sure.select(gy, zero));
        // At the farthest corner of a tile.
        let farthest = zero.min(gx * 8.0) + zero.min(gy * 4.0);
        is_sure.select(base - error + farthest, far).store_slice(&mut made.base);
        gx.store_slice(&mut made.gradient[0]);
        gy.store_slice(&mut made.gradient[1]);
        far.store_slice(&mut made.least);
        for lane in bits::ones(lanes & !made.large) {
            self.cover_facet::<S, N>(simd, window, &made, lane);
        }
        for lane in bits::ones(lanes & made.large) {
            simd.vectorize(
                #[inline(always)]
                || self.cover_large::<S, N>(simd, window, &made, lane, target),
            );
        }
    }

    /// Covers what a facet touches.
    #[inline(always)]
    fn cover_facet<S: Simd, const N: usize>(
        &mut self,
        simd: S,
        window: &Window,
        of: &Facets<N>,
        lane: usize,
    ) {
        let facet = Facet::new(simd, of, lane, window);
        for row in facet.rows.clone() {
            let at = row - window.block[1];
            let open = self.open[at] & facet.columns;
            if open == 0 {
                continue;
            }
            let (y, inside) = facet.row(simd, row);
            let [left, right] = facet.sides.columns(y, facet.low, facet.high);
            let span = Span::new(simd, left.min(facet.high), right, inside);
            let Some((from, to)) = span.blocks(simd, facet.first, facet.last) else { continue };
            let mut columns = open & window.run([from, to]);
            self.used[at] |= columns;
            let covers = &mut self.blocks[at * window.across..][..window.across];
            let nearness = facet.base + facet.gradient[1] * pixels(row, 1);
            while columns != 0 {
                let column = columns.trailing_zeros() as usize;
                columns &= columns - 1;
                let nearness = facet.nearness(nearness, column + window.block[0]);
                let touched = span.tiles(simd, column + window.block[0]);
                covers[column].cover(simd, touched, nearness);
            }
        }
    }

    /// Covers what a large facet touches: tiles that lie wholly within it at once, whatever else
    /// touches them.
    #[inline(always)]
    fn cover_large<S: Simd, const N: usize>(
        &mut self,
        simd: S,
        window: &Window,
        of: &Facets<N>,
        lane: usize,
        target: &mut BlocksMut<'_>,
    ) {
        let facet = Facet::new(simd, of, lane, window);
        let mut inset = [facet.low; N];
        for k in 0..N {
            let by = (of.slope[k][lane].abs() + 1.0) * (1.0 + 4.0 * window.margin);
            inset[k] = f32x8::splat(simd, by);
        }
        let (all, none) = (u32x8::splat(simd, u32::MAX), u32x8::splat(simd, 0));
        for row in facet.rows.clone() {
            let at = row - window.block[1];
            let open = self.open[at] & facet.columns;
            if open == 0 {
                continue;
            }
            let (y, inside) = facet.row(simd, row);
            let [left, right] = facet.sides.columns(y, facet.low, facet.high);
            let span = Span::new(simd, left.min(facet.high), right, inside);
            let Some((from, to)) = span.blocks(simd, facet.first, facet.last) else { continue };
            let [left, right] = facet.sides.inner_columns(y, &inset, facet.low, facet.high);
            let inner = Span::new(simd, left.min(facet.high), right, inside);
            let mut columns = open & window.run([from, to]);
            let nearness = facet.base + facet.gradient[1] * pixels(row, 1);
            while columns != 0 {
                let column = columns.trailing_zeros() as usize;
                columns &= columns - 1;
                let at_buffer = column + window.block[0];
                let nearness = facet.nearness(nearness, at_buffer);
                let mut touched = span.tiles(simd, at_buffer);
                let whole = inner.tiles(simd, at_buffer).simd_eq(all);
                // (`any_true` of a sum of masks is what LLVM 22 cannot select for WebAssembly.)
                if whole.to_bitmask() != 0 {
                    let whole = whole.select(all, none);
                    target.raise(simd, [at_buffer, row], whole, nearness);
                    touched &= !whole;
                }
                if touched.simd_ne(none).to_bitmask() != 0 {
                    self.used[at] |= 1 << column;
                    self.blocks[at * window.across + column].cover(simd, touched, nearness);
                }
            }
        }
    }

    /// Draws the triangles of quads that are not convex for certain.
    #[inline(always)]
    pub(super) fn draw_halves<S: Simd>(
        &mut self,
        simd: S,
        window: &Window,
        target: &mut BlocksMut<'_>,
    ) {
        let halves = core::mem::take(&mut self.halves);
        self.draw_triangles(simd, window, &halves, target);
        self.halves = halves;
    }

    /// Draws triangles, all of which show the side that is drawn.
    #[inline(always)]
    pub(super) fn draw_triangles<S: Simd>(
        &mut self,
        simd: S,
        window: &Window,
        triangles: &[[u16; 3]],
        target: &mut BlocksMut<'_>,
    ) {
        for eight in triangles.chunks(LANES) {
            // What fills up has one corner throughout, and no area.
            let mut rows = [[eight[0][0]; LANES]; 3];
            for (lane, corners) in eight.iter().enumerate() {
                for k in 0..3 {
                    rows[k][lane] = corners[k];
                }
            }
            self.group::<S, 3>(simd, window, &rows, false, None, target);
        }
    }
}

/// A byte for each of eight bits, 255 where it is set.
fn bytes(bits: u64) -> [u8; LANES] {
    let apart = ((bits & 0xff) * 0x0101_0101_0101_0101) & 0x8040_2010_0804_0201;
    // A byte that is not zero reaches its highest bit.
    let ones = (apart + 0x7f7f_7f7f_7f7f_7f7f) >> 7 & 0x0101_0101_0101_0101;
    (ones * 0xff).to_le_bytes()
}

/// Twice the area of triangles of some corners: above 0 where these run counter-clockwise, y
/// upward.
#[inline(always)]
fn turn<S: Simd, const N: usize>(
    x: &[f32x8<S>; N],
    y: &[f32x8<S>; N],
    [a, b, c]: [usize; 3],
) -> f32x8<S> {
    (x[c] - x[a]) * (y[b] - y[a]) - (x[b] - x[a]) * (y[c] - y[a])
}
