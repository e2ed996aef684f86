//! Setting up primitives: triangles of a surface as the screen shows them, and its silhouette edges.
//!
//! Eight at a time, in f32: places are relative to a pixel near the surface, so that few digits are lost, and
//! what is lost is part of the margins.

use fearless_simd::prelude::*;
use fearless_simd::{f32x8, i32x8, mask32x8};

/// The column that bounds nothing from the right.
const NOWHERE: f32 = 1e9;

/// Triangles, or silhouette edges, that are set up together.
pub(crate) const LANES: usize = 8;

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

    /// Columns, rows and nearnesses of eight.
    #[inline(always)]
    pub(super) fn gather<S: Simd>(&self, simd: S, vertices: &[u32; LANES]) -> [f32x8<S>; 3] {
        // No closures given to `map`: the compiler leaves those calls.
        let mut places = [[0.0; LANES]; 3];
        for (lane, v) in vertices.iter().enumerate() {
            let v = *v as usize;
            places[0][lane] = self.x[v];
            places[1][lane] = self.y[v];
            places[2][lane] = self.nearness[v];
        }
        let [x, y, n] = &places;
        [f32x8::from_slice(simd, x), f32x8::from_slice(simd, y), f32x8::from_slice(simd, n)]
    }
}

/// Margins and limits that hold for all of a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Setup {
    /// Pixels by which corners may be off.
    pub(super) doubt: f32,
    /// Pixels by which anything here may be off: the corners, and what is computed from them.
    pub(super) margin: f32,
    /// Error of nearnesses.
    pub(super) nearness_doubt: f32,
    /// The largest of all coordinates, and of those of the pixels of the window.
    pub(super) span: f32,
    /// First column and row, last column and row of the pixels that are wanted.
    pub(super) window: [f32; 4],
    /// Nothing is to be drawn nearer.
    pub(super) nearest: f32,
}

impl Setup {
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
            nearest: f32::INFINITY,
        }
    }

    /// Half a pixel, and what triangles are drawn larger by: a triangle is taken to touch a pixel wherever it may,
    /// and only where it comes within twice the margin.
    fn touch(&self) -> f32 {
        0.5 + self.margin
    }

    /// That of silhouette edges: wherever one may come within twice the margin of a pixel.
    fn edge_touch(&self) -> f32 {
        0.5 + 3.0 * self.margin
    }
}

/// Eight triangles, corner by corner, as [`Spots::gather`] gives them.
pub(super) type Corners<S> = [[f32x8<S>; 3]; 3];

/// Twice the area of triangles, and how much of it may be an error.
#[inline(always)]
pub(super) fn areas<S: Simd>(setup: &Setup, [a, b, c]: &Corners<S>) -> (f32x8<S>, f32x8<S>) {
    let (bx, by, cx, cy) = (b[0] - a[0], b[1] - a[1], c[0] - a[0], c[1] - a[1]);
    let size = bx.abs() + by.abs() + cx.abs() + cy.abs();
    let slack =
        size * (size * 2.0_f32.powi(-21) + 4.0 * setup.doubt) + 8.0 * setup.doubt * setup.doubt;
    (bx * cy - by * cx, slack)
}

/// Where an edge bounds rows of pixels: at column start + slope · row a primitive begins, or ends, to touch a pixel; by
/// `inward` columns further in all of the pixel is certainly within, as far as that edge goes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bound {
    pub(super) start: [f32; LANES],
    pub(super) slope: [f32; LANES],
    pub(super) inward: [f32; LANES],
}

/// Eight triangles or silhouette edges on the screen, each within three edges and a box, with a plane of nearness.
///
/// An edge is a·x + b·y + c, over the pixel in column x and row y; it is not below 0 where the primitive may
/// touch the pixel, as far as that edge goes. Solved for the column, it bounds rows of pixels from the left where a is
/// above 0, else from the right. A convex polygon meets a square iff no edge of either parts them, so three edges and
/// the box decide.
#[derive(Clone, Copy, Debug)]
pub(super) struct Primitives {
    /// The edges that bound from the left, and from the right: of three there are two and one.
    pub(super) left: [Bound; 2],
    pub(super) right: [Bound; 2],
    /// A bit for each primitive of which rounding alone puts all edges on one side, so that nothing is certain of it.
    pub(super) uncertain: u32,
    /// A bit for each primitive that may touch a pixel of the window.
    pub(super) present: u32,
    /// First column and row, last column and row of the pixels of the window that the box touches.
    pub(super) window: [[i32; LANES]; 4],
    /// How near all of the primitive within a pixel is at least: value + dx·x + dy·y, but `far` at the least.
    pub(super) value: [f32; LANES],
    pub(super) dx: [f32; LANES],
    pub(super) dy: [f32; LANES],
    pub(super) far: [f32; LANES],
    /// No point of it is taken to be nearer.
    pub(super) near: [f32; LANES],
}

impl Primitives {
    /// Triangles whose areas have the signs of `sign`.
    ///
    /// A function of its own, as [`silhouettes`](Self::silhouettes) is: all in one took a compiler minutes, without vectors.
    #[inline(always)]
    pub(super) fn triangles<S: Simd>(
        simd: S,
        setup: &Setup,
        p: &Corners<S>,
        sign: f32x8<S>,
    ) -> Self {
        simd.vectorize(
            #[inline(always)]
            || Self::triangles_of(simd, setup, p, sign),
        )
    }

    #[inline(always)]
    fn triangles_of<S: Simd>(simd: S, setup: &Setup, p: &Corners<S>, sign: f32x8<S>) -> Self {
        let edges = [edge(&p[0], &p[1], sign), edge(&p[1], &p[2], sign), edge(&p[2], &p[0], sign)];
        let touch = setup.touch();
        let widths = [edges[0].width(), edges[1].width(), edges[2].width()];
        let zero = f32x8::splat(simd, 0.0);

        let [ax, ay, an] = p[0];
        let (bx, by, bn) = (p[1][0] - ax, p[1][1] - ay, p[1][2] - an);
        let (cx, cy, cn) = (p[2][0] - ax, p[2][1] - ay, p[2][2] - an);
        let (window, present) = window(setup, [&p[0], &p[1], &p[2]], setup.margin);
        let low = an.min(p[1][2]).min(p[2][2]);
        let near = an.max(p[1][2]).max(p[2][2]);
        let far = (low * (1.0 - 2.0_f32.powi(-20)) - setup.nearness_doubt).max(zero);

        let share = f32x8::splat(simd, 1.0) / (bx * cy - cx * by);
        let gx = (bn * cy - cn * by) * share;
        let gy = (bx * cn - cx * bn) * share;
        // Rounding error of the gradients, times the distance that they are followed.
        let unsure = ((bx * cy).abs() + (cx * by).abs()) * share.abs();
        let steep_x = ((bn * cy).abs() + (cn * by).abs()) * share.abs() + gx.abs() * unsure;
        let steep_y = ((bn * cx).abs() + (cn * bx).abs()) * share.abs() + gy.abs() * unsure;
        let width = bx.abs().max(cx.abs()) + 2.0;
        let height = by.abs().max(cy.abs()) + 2.0;
        let followed = (gx.abs() + gy.abs()) * setup.span + near;
        let rounding =
            (steep_x * width + steep_y * height) * 2.0_f32.powi(-20) + followed * 2.0_f32.powi(-20);
        let middle = an + (gx * (-ax + 0.5) + gy * (-ay + 0.5));
        let value = middle - (gx.abs() + gy.abs()) * touch - rounding - setup.nearness_doubt;
        // Slivers: no plane, only their farthest corner. The comparison is false for NaN too.
        let is_sure = rounding.simd_le(near);

        let inner = touch + setup.edge_touch();
        let (left, right, uncertain) = sides(
            simd,
            [
                solve(simd, &edges[0], widths[0] * touch, widths[0] * inner),
                solve(simd, &edges[1], widths[1] * touch, widths[1] * inner),
                solve(simd, &edges[2], widths[2] * touch, widths[2] * inner),
            ],
        );
        Self {
            left,
            right,
            uncertain,
            present,
            window,
            value: is_sure.select(value, far).into(),
            dx: is_sure.select(gx, zero).into(),
            dy: is_sure.select(gy, zero).into(),
            far: far.into(),
            near: near.min(f32x8::splat(simd, setup.nearest)).into(),
        }
    }

    /// Silhouette edges: triangles of no area that are infinitely far, so that nothing is hidden where they are.
    #[inline(always)]
    pub(super) fn silhouettes<S: Simd>(
        simd: S,
        setup: &Setup,
        spots: &Spots,
        ends: [[u32; LANES]; 2],
    ) -> Self {
        simd.vectorize(
            #[inline(always)]
            || Self::silhouettes_of(simd, setup, spots, ends),
        )
    }

    #[inline(always)]
    fn silhouettes_of<S: Simd>(
        simd: S,
        setup: &Setup,
        spots: &Spots,
        ends: [[u32; LANES]; 2],
    ) -> Self {
        let [p, q] = [spots.gather(simd, &ends[0]), spots.gather(simd, &ends[1])];
        let e = edge(&p, &q, f32x8::splat(simd, 1.0));
        let width = e.width() * setup.edge_touch();
        let never = f32x8::splat(simd, f32::INFINITY);
        let opposite = Edge { a: -e.a, b: -e.b, c: -e.c };
        let [e, opposite] = [solve(simd, &e, width, never), solve(simd, &opposite, width, never)];
        let (left, right, _) = sides(simd, [e, opposite, Solved::nowhere(simd)]);
        let (window, present) = window(setup, [&p, &p, &q], 3.0 * setup.margin);
        let none = [0.0; LANES];
        Self {
            left,
            right,
            uncertain: 0,
            present,
            window,
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

impl<S: Simd> Edge<S> {
    /// By how much it changes from one pixel to the next across and the next down.
    #[inline(always)]
    fn width(&self) -> f32x8<S> {
        self.a.abs() + self.b.abs()
    }
}

#[inline(always)]
fn edge<S: Simd>(p: &[f32x8<S>; 3], q: &[f32x8<S>; 3], sign: f32x8<S>) -> Edge<S> {
    let (a, b) = ((p[1] - q[1]) * sign, (q[0] - p[0]) * sign);
    Edge { a, b, c: a * (-p[0] + 0.5) + b * (-p[1] + 0.5) }
}

/// An edge solved for the column.
#[derive(Clone, Copy)]
struct Solved<S: Simd> {
    start: f32x8<S>,
    slope: f32x8<S>,
    inward: f32x8<S>,
    is_left: mask32x8<S>,
}

impl<S: Simd> Solved<S> {
    /// No bound, from the right.
    #[inline(always)]
    fn nowhere(simd: S) -> Self {
        let zero = f32x8::splat(simd, 0.0);
        let start = f32x8::splat(simd, NOWHERE);
        Self { start, slope: zero, inward: zero, is_left: zero.simd_gt(zero) }
    }

    /// No bound, from the left.
    #[inline(always)]
    fn nowhere_left(simd: S) -> Self {
        Self { start: f32x8::splat(simd, -NOWHERE), ..Self::nowhere(simd) }
    }

    #[inline(always)]
    fn or(self, is_self: mask32x8<S>, other: Self) -> Self {
        Self {
            start: is_self.select(self.start, other.start),
            slope: is_self.select(self.slope, other.slope),
            inward: is_self.select(self.inward, other.inward),
            is_left: other.is_left,
        }
    }

    #[inline(always)]
    fn bound(self) -> Bound {
        Bound { start: self.start.into(), slope: self.slope.into(), inward: self.inward.into() }
    }
}

/// Solves an edge, moved outward, for the column.
#[inline(always)]
fn solve<S: Simd>(simd: S, edge: &Edge<S>, outward: f32x8<S>, inner: f32x8<S>) -> Solved<S> {
    let zero = f32x8::splat(simd, 0.0);
    // An edge so level that it turns by less than rounding over all of the screen still has a slope.
    let least = edge.b.abs() * 2.0_f32.powi(-24);
    let a = edge.a.abs().simd_ge(least).select(edge.a, least);
    let is_edge = a.abs().simd_gt(zero);
    let share = is_edge.select(f32x8::splat(simd, -1.0) / a, zero);
    let start = is_edge.select((edge.c + outward) * share, f32x8::splat(simd, NOWHERE));
    let (slope, inward) = (edge.b * share, inner * share.abs());
    Solved { start, slope, inward, is_left: a.simd_gt(zero) }
}

/// Sorts three edges by the side that they bound, without branches, which no processor could predict.
#[inline(always)]
fn sides<S: Simd>(simd: S, [e, f, g]: [Solved<S>; 3]) -> ([Bound; 2], [Bound; 2], u32) {
    let [l, m, n] = [e.is_left, f.is_left, g.is_left];
    let left = two([e, f, g], [l, m, n], Solved::nowhere_left(simd));
    let right = two([e, f, g], [!l, !m, !n], Solved::nowhere(simd));
    let uncertain = ((l & m & n) | (!l & !m & !n)).to_bitmask();
    (left, right, uncertain as u32)
}

/// The first two of three edges that are some.
#[inline(always)]
fn two<S: Simd>(
    [e, f, g]: [Solved<S>; 3],
    [is_e, is_f, is_g]: [mask32x8<S>; 3],
    none: Solved<S>,
) -> [Bound; 2] {
    let first = e.or(is_e, f.or(is_f, g.or(is_g, none)));
    let second = f.or(is_e & is_f, g.or((is_e | is_f) & is_g, none));
    [first.bound(), second.bound()]
}

/// The pixels of the window that a box around three corners touches, `margin` on each side included; a bit for
/// each that touches any.
#[inline(always)]
fn window<S: Simd>(setup: &Setup, p: [&[f32x8<S>; 3]; 3], margin: f32) -> ([[i32; LANES]; 4], u32) {
    let [x0, y0, x1, y1] = setup.window;
    let [(left, right), (top, bottom)] = [range(p, 0, margin), range(p, 1, margin)];
    let simd = p[0][0].simd;
    let [left, top] = [left.max(f32x8::splat(simd, x0)), top.max(f32x8::splat(simd, y0))];
    let [right, bottom] = [right.min(f32x8::splat(simd, x1)), bottom.min(f32x8::splat(simd, y1))];
    let present = (left.simd_le(right) & top.simd_le(bottom)).to_bitmask() as u32;
    let window = [
        i32x8::truncate_from(left).into(),
        i32x8::truncate_from(top).into(),
        i32x8::truncate_from(right).into(),
        i32x8::truncate_from(bottom).into(),
    ];
    (window, present)
}

/// The first and the last pixel along an axis.
#[inline(always)]
fn range<S: Simd>(p: [&[f32x8<S>; 3]; 3], axis: usize, margin: f32) -> (f32x8<S>, f32x8<S>) {
    let [a, b, c] = [p[0][axis], p[1][axis], p[2][axis]];
    ((a.min(b).min(c) - margin).floor(), (a.max(b).max(c) + margin).floor())
}
