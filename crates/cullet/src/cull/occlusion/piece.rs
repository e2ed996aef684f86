//! Setting up what a patch is drawn from: its triangles as the screen shows them, and its borders.
//!
//! Eight at a time, in f32: places are relative to a pixel near the patch, so that few digits are lost, and
//! what is lost is part of the margins.

use fearless_simd::f32x8;
use fearless_simd::prelude::*;

/// The column that bounds nothing from the right.
const NOWHERE: f32 = 1e9;

/// Triangles and borders that are set up together.
pub(super) const LANES: usize = 8;

/// Corners on the screen, relative to a pixel.
#[derive(Clone, Debug, Default)]
pub(super) struct Spots {
    pub(super) x: Vec<f32>,
    pub(super) y: Vec<f32>,
    pub(super) nearness: Vec<f32>,
}

impl Spots {
    pub(super) fn clear(&mut self) {
        self.x.clear();
        self.y.clear();
        self.nearness.clear();
    }

    #[inline(always)]
    fn gather<S: Simd>(&self, simd: S, vertices: [u32; LANES]) -> [f32x8<S>; 3] {
        // No closures given to `map`: the compiler leaves those calls.
        let mut places = [[0.0; LANES]; 3];
        for (lane, v) in vertices.into_iter().enumerate() {
            let v = v as usize;
            places[0][lane] = self.x[v];
            places[1][lane] = self.y[v];
            places[2][lane] = self.nearness[v];
        }
        let [x, y, n] = &places;
        [f32x8::from_slice(simd, x), f32x8::from_slice(simd, y), f32x8::from_slice(simd, n)]
    }
}

/// What holds for all of a patch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    /// Pixels by which corners may be off.
    pub(super) doubt: f32,
    /// Pixels by which anything here may be off: the corners, and what is reckoned from them.
    pub(super) margin: f32,
    /// What nearnesses may be off by.
    pub(super) nearness_doubt: f32,
    /// The largest of all coordinates, and of those of pixels that are asked about.
    pub(super) span: f32,
    /// First column and row, last column and row of the pixels that are wanted.
    pub(super) window: [f32; 4],
}

impl Frame {
    /// Where corners are `doubt` pixels off and coordinates reach `span`.
    pub(super) fn new(doubt: f64, nearness_doubt: f64, span: f64, window: [f32; 4]) -> Self {
        // A place is rounded once; an edge at a pixel takes some ten roundings of at most twice the span.
        let rounding = span.max(64.0) * 2.0_f64.powi(-19);
        Self {
            doubt: (doubt + span * 2.0_f64.powi(-24)) as f32 * 1.001,
            margin: (doubt + rounding) as f32 * 1.001,
            nearness_doubt: nearness_doubt as f32 * 1.001,
            span: span as f32,
            window,
        }
    }

    /// Half a pixel, and what triangles are drawn larger by: a triangle is taken to touch a pixel wherever it may,
    /// and only where it comes within twice the margin.
    fn touch(&self) -> f32 {
        0.5 + self.margin
    }

    /// That of borders: wherever one may come within twice the margin of a pixel.
    fn border(&self) -> f32 {
        0.5 + 3.0 * self.margin
    }
}

/// Twice the area of triangles, and how much of it may be an error.
#[inline(always)]
pub(super) fn areas<S: Simd>(
    simd: S,
    frame: &Frame,
    spots: &Spots,
    corners: [[u32; LANES]; 3],
) -> (f32x8<S>, f32x8<S>) {
    let [a, b, c] = corners;
    let (a, b, c) = (spots.gather(simd, a), spots.gather(simd, b), spots.gather(simd, c));
    let (bx, by, cx, cy) = (b[0] - a[0], b[1] - a[1], c[0] - a[0], c[1] - a[1]);
    let size = bx.abs() + by.abs() + cx.abs() + cy.abs();
    let slack =
        size * (size * 2.0_f32.powi(-21) + 4.0 * frame.doubt) + 8.0 * frame.doubt * frame.doubt;
    (bx * cy - by * cx, slack)
}

/// Eight convex pieces of the screen, each within three edges and a box, with a plane of nearness.
///
/// An edge is a·x + b·y + c, over the pixel in column x and row y; it is not below 0 where the piece may
/// touch the pixel, as far as that edge goes, and not below `inner` where the piece certainly holds all of it. Solved
/// for the column, it bounds a row of pixels at start + slope · row, from the left where a is above 0. A convex
/// polygon meets a square iff no edge of either parts them, so three edges and the box are all there is to ask.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pieces {
    pub(super) a: [[f32; LANES]; 3],
    pub(super) b: [[f32; LANES]; 3],
    pub(super) c: [[f32; LANES]; 3],
    pub(super) start: [[f32; LANES]; 3],
    pub(super) slope: [[f32; LANES]; 3],
    pub(super) inner: [[f32; LANES]; 3],
    /// How far `inner` is, in columns.
    pub(super) inward: [[f32; LANES]; 3],
    /// First column and row, last column and row of the pixels of the window that the box touches.
    pub(super) window: [[f32; LANES]; 4],
    /// How near all of the piece within a pixel is at least: value + dx·x + dy·y, but `far` at the least.
    pub(super) value: [f32; LANES],
    pub(super) dx: [f32; LANES],
    pub(super) dy: [f32; LANES],
    pub(super) far: [f32; LANES],
    /// No point of it is nearer.
    pub(super) near: [f32; LANES],
}

impl Pieces {
    /// Triangles whose area has the sign of `sign`, or hardly any.
    #[inline(always)]
    pub(super) fn triangles<S: Simd>(
        simd: S,
        frame: &Frame,
        spots: &Spots,
        corners: [[u32; LANES]; 3],
        sign: f32,
    ) -> Self {
        let [a, b, c] = corners;
        let p = [spots.gather(simd, a), spots.gather(simd, b), spots.gather(simd, c)];
        let edges = [edge(&p[0], &p[1], sign), edge(&p[1], &p[2], sign), edge(&p[2], &p[0], sign)];
        let touch = frame.touch();
        let width = |e: &Edge<S>| e.a.abs() + e.b.abs();
        let widths = [width(&edges[0]), width(&edges[1]), width(&edges[2])];
        let zero = f32x8::splat(simd, 0.0);

        let [ax, ay, an] = p[0];
        let (bx, by, bn) = (p[1][0] - ax, p[1][1] - ay, p[1][2] - an);
        let (cx, cy, cn) = (p[2][0] - ax, p[2][1] - ay, p[2][2] - an);
        let window = window(frame, [&p[0], &p[1], &p[2]], frame.margin);
        let low = an.min(p[1][2]).min(p[2][2]);
        let near = an.max(p[1][2]).max(p[2][2]);
        let far = (low * (1.0 - 2.0_f32.powi(-20)) - frame.nearness_doubt).max(zero);

        let share = f32x8::splat(simd, 1.0) / (bx * cy - cx * by);
        let gx = (bn * cy - cn * by) * share;
        let gy = (bx * cn - cx * bn) * share;
        // What rounding leaves in doubt of the gradients, times as far as they are followed.
        let unsure = ((bx * cy).abs() + (cx * by).abs()) * share.abs();
        let steep_x = ((bn * cy).abs() + (cn * by).abs()) * share.abs() + gx.abs() * unsure;
        let steep_y = ((bn * cx).abs() + (cn * bx).abs()) * share.abs() + gy.abs() * unsure;
        let width = bx.abs().max(cx.abs()) + 2.0;
        let height = by.abs().max(cy.abs()) + 2.0;
        let followed = (gx.abs() + gy.abs()) * frame.span + near;
        let rounding =
            (steep_x * width + steep_y * height) * 2.0_f32.powi(-20) + followed * 2.0_f32.powi(-20);
        let middle = an + (gx * (-ax + 0.5) + gy * (-ay + 0.5));
        let value = middle - (gx.abs() + gy.abs()) * touch - rounding - frame.nearness_doubt;
        // Slivers: no plane, only their farthest corner. The comparison is false for NaN too.
        let is_sure = rounding.simd_le(near);
        let flat = |v: f32x8<S>| is_sure.select(v, zero);

        let mut pieces = Self::blank();
        for (k, edge) in edges.iter().enumerate() {
            pieces.bound(simd, k, edge, widths[k] * touch, widths[k] * (touch + frame.border()));
        }
        pieces.window(window);
        pieces.value = flat(value).into();
        pieces.dx = flat(gx).into();
        pieces.dy = flat(gy).into();
        pieces.far = far.into();
        pieces.near = near.into();
        pieces
    }

    /// Borders: triangles of no area that are infinitely far, so that nothing is hidden where they are.
    #[inline(always)]
    pub(super) fn borders<S: Simd>(
        simd: S,
        frame: &Frame,
        spots: &Spots,
        ends: [[u32; LANES]; 2],
    ) -> Self {
        let [p, q] = [spots.gather(simd, ends[0]), spots.gather(simd, ends[1])];
        let e = edge(&p, &q, 1.0);
        let width = (e.a.abs() + e.b.abs()) * frame.border();
        let mut pieces = Self::blank();
        let never = f32x8::splat(simd, f32::INFINITY);
        pieces.bound(simd, 0, &e, width, never);
        pieces.bound(simd, 1, &Edge { a: -e.a, b: -e.b, c: -e.c }, width, never);
        pieces.window(window(frame, [&p, &p, &q], 3.0 * frame.margin));
        pieces
    }

    #[inline(always)]
    fn window<S: Simd>(&mut self, [x0, y0, x1, y1]: [f32x8<S>; 4]) {
        self.window = [x0.into(), y0.into(), x1.into(), y1.into()];
    }

    /// Takes an edge, moved outward.
    #[inline(always)]
    fn bound<S: Simd>(
        &mut self,
        simd: S,
        k: usize,
        edge: &Edge<S>,
        outward: f32x8<S>,
        inner: f32x8<S>,
    ) {
        let c = edge.c + outward;
        // An edge so level that it turns by less than rounding over all of the screen still has a slope.
        let least = edge.b.abs() * 2.0_f32.powi(-24);
        let a = edge.a.abs().simd_ge(least).select(edge.a, least);
        let is_edge = a.abs().simd_gt(f32x8::splat(simd, 0.0));
        let share = is_edge.select(f32x8::splat(simd, -1.0) / a, f32x8::splat(simd, 0.0));
        let start = is_edge.select(c * share, f32x8::splat(simd, NOWHERE));
        self.a[k] = a.into();
        self.b[k] = edge.b.into();
        self.c[k] = c.into();
        self.start[k] = start.into();
        self.slope[k] = (edge.b * share).into();
        self.inner[k] = inner.into();
        self.inward[k] = (inner * share.abs()).into();
    }

    #[inline(always)]
    fn blank() -> Self {
        let none = [0.0; LANES];
        Self {
            a: [none; 3],
            b: [none; 3],
            c: [none; 3],
            start: [[NOWHERE; LANES]; 3],
            slope: [none; 3],
            inner: [[f32::INFINITY; LANES]; 3],
            inward: [none; 3],
            window: [none; 4],
            value: none,
            dx: none,
            dy: none,
            far: none,
            near: none,
        }
    }
}

/// An edge over the middles of pixels.
struct Edge<S: Simd> {
    a: f32x8<S>,
    b: f32x8<S>,
    c: f32x8<S>,
}

#[inline(always)]
fn edge<S: Simd>(p: &[f32x8<S>; 3], q: &[f32x8<S>; 3], sign: f32) -> Edge<S> {
    let (a, b) = ((p[1] - q[1]) * sign, (q[0] - p[0]) * sign);
    Edge { a, b, c: a * (-p[0] + 0.5) + b * (-p[1] + 0.5) }
}

/// The pixels of the window that a box around three corners touches, `margin` on each side included.
#[inline(always)]
fn window<S: Simd>(frame: &Frame, p: [&[f32x8<S>; 3]; 3], margin: f32) -> [f32x8<S>; 4] {
    let [x0, y0, x1, y1] = frame.window;
    let low = |a: usize| (p[0][a].min(p[1][a]).min(p[2][a]) - margin).floor();
    let high = |a: usize| (p[0][a].max(p[1][a]).max(p[2][a]) + margin).floor();
    let splat = |v: f32| f32x8::splat(p[0][0].simd, v);
    [low(0).max(splat(x0)), low(1).max(splat(y0)), high(0).min(splat(x1)), high(1).min(splat(y1))]
}
