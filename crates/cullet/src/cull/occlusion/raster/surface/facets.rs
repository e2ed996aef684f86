//! Facets: which of eight show the side that is drawn, where their sides bound rows of pixels, how
//! near they are, and what each covers.

use fearless_simd::prelude::*;
use fearless_simd::{f32x8, u32x8};

use super::super::blocks::{BLOCK, BlocksMut};
use super::super::connected::{LANES, NUMBERS};
use super::super::span::{ROWS, Span};
use super::{Numbers, Surface, Window};
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
    /// No nearer than the facet anywhere within a tile: base + gradient · (its first column and
    /// row), but at least `least`.
    base: [f32; LANES],
    gradient: [[f32; LANES]; 2],
    least: [f32; LANES],
    /// One bit a facet: large enough to have tiles wholly within.
    large: u64,
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

#[inline(always)]
fn gather<S: Simd>(simd: S, from: &Numbers<f32>, at: &[u16; LANES]) -> f32x8<S> {
    let mut of = [0.0; LANES];
    for lane in 0..LANES {
        of[lane] = from[usize::from(at[lane]) % NUMBERS];
    }
    f32x8::simd_from(simd, of)
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
        let (mut x, mut y, mut rows) = ([zero; N], [zero; N], *corners);
        for k in 0..N {
            // A diagonal stays between the first corner and the third.
            rows[k] = corners[if turned && k > 0 { N - k } else { k }];
            x[k] = gather(simd, &self.x, &rows[k]);
            y[k] = gather(simd, &self.y, &rows[k]);
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
            let mut words = [0; LANES];
            for (lane, word) in words.iter_mut().enumerate() {
                *word = 0_u32.wrapping_sub((lanes >> lane & 1) as u32);
            }
            self.drawn[number..number + LANES].copy_from_slice(&words);
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
            self.cover_group(simd, window, &rows, (&x, &y), (low, high), lanes, target);
        }
    }

    /// Covers what some of eight facets touch.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "all of it is in registers")]
    fn cover_group<S: Simd, const N: usize>(
        &mut self,
        simd: S,
        window: &Window,
        rows: &[[u16; LANES]; N],
        (x, y): (&[f32x8<S>; N], &[f32x8<S>; N]),
        (low, high): ([f32x8<S>; 2], [f32x8<S>; 2]),
        mut lanes: u64,
        target: &mut BlocksMut<'_>,
    ) {
        let splat = |v: f32| f32x8::splat(simd, v);
        let (zero, margin) = (splat(0.0), splat(window.margin));
        // By all of its height: what is drawn must not depend on where a band ends.
        let height = high[1] - low[1];
        let low = [
            (low[0] - margin).floor().max(splat(window.low[0])),
            (low[1] - margin).floor().max(splat(window.low[1])),
        ];
        let high = [
            ((high[0] + margin).floor() + 1.0).min(splat(window.high[0])),
            (high[1] + margin).floor().min(splat(window.high[1])),
        ];
        lanes &= (low[0].simd_lt(high[0]) & low[1].simd_le(high[1])).to_bitmask();
        if lanes == 0 {
            return;
        }
        let mut n = [zero; N];
        for k in 0..N {
            n[k] = gather(simd, &self.n, &rows[k]);
        }
        let mut made = Facets::<N> {
            slope: [[0.0; LANES]; N],
            start: [[0.0; LANES]; N],
            cap: [[0.0; LANES]; N],
            low: [low[0].into(), low[1].into()],
            high: [high[0].into(), high[1].into()],
            base: [0.0; LANES],
            gradient: [[0.0; LANES]; 2],
            least: [0.0; LANES],
            large: ((high[0] - low[0]).simd_ge(splat(LARGE[0])) & height.simd_ge(splat(LARGE[1])))
                .to_bitmask(),
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
        let (far, near) = (least(&n), most(&n));
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
        for lane in bits::ones(lanes) {
            self.cover_facet::<S, N>(simd, window, &made, lane, target);
        }
    }

    /// Covers what a facet touches: tiles that lie wholly within a large one at once, whatever else
    /// touches them.
    #[inline(always)]
    fn cover_facet<S: Simd, const N: usize>(
        &mut self,
        simd: S,
        window: &Window,
        of: &Facets<N>,
        lane: usize,
        target: &mut BlocksMut<'_>,
    ) {
        let splat = |v: f32| f32x8::splat(simd, v);
        let [x0, x1] = [of.low[0][lane], of.high[0][lane]];
        let [y0, y1] = [of.low[1][lane], of.high[1][lane]];
        let is_large = of.large >> lane & 1 == 1;
        let (first, last) = (x0 as usize / BLOCK[0], (x1 as usize - 1) / BLOCK[0]);
        let (low, high) = (splat(x0), splat(x1));
        let mut sides = Sides { slope: [low; N], start: [low; N], cap: [low; N] };
        let mut inset = [low; N];
        for k in 0..N {
            sides.slope[k] = splat(of.slope[k][lane]);
            sides.start[k] = splat(of.start[k][lane]);
            sides.cap[k] = splat(of.cap[k][lane]);
            inset[k] = splat((of.slope[k][lane].abs() + 1.0) * (1.0 + 4.0 * window.margin));
        }
        let (gx, gy) = (of.gradient[0][lane], of.gradient[1][lane]);
        let (least, cap) = (splat(of.least[lane]), splat(window.cap));
        let across = f32x8::simd_from(simd, [0.0, 8.0, 16.0, 24.0, 0.0, 8.0, 16.0, 24.0]);
        let down = f32x8::simd_from(simd, [0.0, 0.0, 0.0, 0.0, 4.0, 4.0, 4.0, 4.0]);
        let base = across * gx + (down * gy + of.base[lane]);
        for row in y0 as usize / BLOCK[1]..=y1 as usize / BLOCK[1] {
            let top = (row * BLOCK[1]) as f32;
            let y = f32x8::simd_from(simd, ROWS) + top;
            let inside = y.simd_ge(splat(y0)) & y.simd_le(splat(y1));
            let [left, right] = sides.columns(y, low, high);
            let span = Span::new(simd, left.min(high), right, inside);
            let Some((from, to)) = span.blocks(simd, first, last) else { continue };
            let nearness = base + gy * top;
            if is_large {
                let [left, right] = sides.inner_columns(y, &inset, low, high);
                let inner = Span::new(simd, left.min(high), right, inside);
                for column in from..=to {
                    let n = (nearness + gx * (column * BLOCK[0]) as f32).max(least).min(cap);
                    let mut pixels = span.tiles(simd, column);
                    let all = u32x8::splat(simd, u32::MAX);
                    let whole = inner.tiles(simd, column).simd_eq(all);
                    // (`any_true` of a sum of masks is what LLVM 22 cannot select for WebAssembly.)
                    if whole.to_bitmask() != 0 {
                        let whole = whole.select(all, u32x8::splat(simd, 0));
                        target.raise(simd, [column, row], whole, n);
                        pixels &= !whole;
                    }
                    if pixels.simd_ne(u32x8::splat(simd, 0)).to_bitmask() != 0 {
                        self.block(window, column, row).cover(simd, pixels, n);
                    }
                }
                continue;
            }
            for column in from..=to {
                let n = (nearness + gx * (column * BLOCK[0]) as f32).max(least).min(cap);
                let pixels = span.tiles(simd, column);
                self.block(window, column, row).cover(simd, pixels, n);
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
