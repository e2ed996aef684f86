//! The projection of sixteen boxes at once, in f32, with bounds on what rounding does to it.
//!
//! Numbers X and w of corners are off by E and F at most; see [`Row`].
//!
//! Then with X and w off by E and F at most, X / w is off by (E + |X / w| F) / w, the |X / w| being
//! the true one. Boxes whose w is not above 16 F are left as visible, so that the true one is at
//! most 16/15 (|X / w| + E / w) as computed, and 9/8 (E + |X / w| F) / w holds all of it.

use fearless_simd::prelude::*;

use super::super::occluder::{cross, dot};
use super::super::raster::{ObjectScreen, Rectangles, Row, Screen, ScreenBounds, meet};
use crate::array::Each;
use crate::bounds::{BoxBlock, Boxes, LANES};
use crate::simd::dispatch;

/// The least w that has a reciprocal whose products do not overflow, and the largest pixel.
const LEAST_W: f32 = 1e-18;
const FARTHEST: f32 = 1e30;

/// Projector of boxes in batches.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BoxProjector {
    /// Point that coordinates are taken relative to.
    base: [f32; 3],
    /// x·w, y·w, w (perspective) or nearness (orthographic), height over the near plane.
    rows: [Row; 4],
    size: [f32; 2],
    perspective: bool,
    /// Whether outward windings look clockwise where they face the eye.
    mirrored: bool,
}

impl BoxProjector {
    /// For boxes relative to the origin of the screen. `None` where its numbers are too large for
    /// f32: then all boxes are visible.
    pub(crate) fn new(screen: &Screen) -> Option<Self> {
        let rows = screen.rows();
        Self::of_rows(screen, rows, rows.each(|r| r.each(f64::abs)), screen.mirrored)
    }

    /// For boxes in the space of an object.
    pub(crate) fn of_object(screen: &Screen, object: &ObjectScreen) -> Option<Self> {
        let rows = object.rows().each(Into::into);
        Self::of_rows(screen, rows, object.sizes.each(Into::into), object.mirrored)
    }

    fn of_rows(
        screen: &Screen,
        rows: [[f64; 4]; 5],
        sizes: [[f64; 4]; 5],
        mirrored: bool,
    ) -> Option<Self> {
        let perspective = screen.perspective;
        if !perspective && rows[4] != [0.0, 0.0, 0.0, 1.0] {
            return None;
        }
        // x, y, w or nearness, near.
        let order = [0, 1, if perspective { 4 } else { 2 }, 3];
        let base = meet([0, 1, 2].each(|i| rows[order[i]])).unwrap_or_default();
        let apart = screen.apart();
        let row = |i: usize| Row::new(rows[order[i]], sizes[order[i]], base, apart[order[i]]);
        let rows = [row(0)?, row(1)?, row(2)?, row(3)?];
        let size = screen.size.each(|s| s as f32);
        Some(Self { base, rows, size, perspective, mirrored })
    }

    /// No box has more pixels that lies within a box of such screen bounds, and is no larger than
    /// `sizes` along each axis.
    ///
    /// Between two points on the screen x = X/w differs by (ΔX − x·Δw)/w, with x one of the two, so
    /// that it is between those of the bounds, and w the other's.
    pub(super) fn most_pixels(&self, f: &ScreenBounds, sizes: [f32; 3]) -> f32 {
        let [x, y, third, _] = &self.rows;
        let (inverse, w) = if self.perspective { (f.nearness, third.k) } else { (1.0, [0.0; 3]) };
        let mut pixels = 1.0;
        for (axis, row) in [x, y].into_iter().enumerate() {
            let (first, end) = (f.min[axis] as f32, (f.max[axis] + 1) as f32);
            let (middle, half) = ((first + end) * 0.5, (end - first) * 0.5);
            let length: f32 = (0..3)
                .map(|a| ((row.k[a] - middle * w[a]).abs() + half * w[a].abs()) * sizes[a])
                .sum();
            // Two pixels are touched in part, and another for what is in doubt.
            pixels *= (length * inverse * 1.001 + 3.0).min(end - first);
        }
        pixels
    }

    /// Vector v with which a triangle around the point `p`, whose area vector is a (half the cross
    /// product of its edges), has about a·v pixels; more than 0 where it faces the eye.
    ///
    /// The rows take the corners to X, Y and W, and the determinant of those is twice the area on
    /// the screen times the three W. It is also 2 a · (X kʸ×kʷ + Y kʷ×kˣ + W kˣ×kʸ), with X, Y and W
    /// those of any point of the triangle's plane.
    pub(super) fn pixels_of_area(&self, p: [f32; 3]) -> [f32; 3] {
        let [x, y, third, _] = &self.rows;
        let p = [0, 1, 2].each(|a| p[a] - self.base[a]);
        let value = |row: &Row| dot(row.k, p) + row.c;
        let (k, w) = if self.perspective { (third.k, value(third)) } else { ([0.0; 3], 1.0) };
        let terms = [(cross(y.k, k), value(x)), (cross(k, x.k), value(y)), (cross(x.k, y.k), w)];
        let scale = if self.mirrored { 1.0 } else { -1.0 } / (w * w * w);
        [0, 1, 2].each(|a| terms.iter().map(|(k, v)| k[a] * v).sum::<f32>() * scale)
    }

    /// Projects a block, with `slack` times the doubt.
    ///
    /// A box within another has its rectangle within, and is neither nearer nor farther, if the
    /// other is projected with four times the doubt or more: each number is off by less than its
    /// own doubt, and that of the smaller box is the smaller.
    // One copy for all callers: their callbacks would each have one of every SIMD level.
    #[inline(never)]
    pub(crate) fn project(&self, simd: crate::Simd, block: &BoxBlock, slack: f32) -> Rectangles {
        let mut all = Rectangles::NONE;
        dispatch!(simd, simd => self.project_with(simd, block, slack, &mut all));
        all
    }

    #[inline(always)]
    fn project_with<S: Simd>(&self, simd: S, block: &BoxBlock, slack: f32, out: &mut Rectangles) {
        (out.bounded, out.outside) = (0, 0);
        let mut at = 0;
        while at < LANES {
            let (bounded, outside) = if self.perspective {
                self.part::<S, true>(simd, block, at, slack, out)
            } else {
                self.part::<S, false>(simd, block, at, slack, out)
            };
            out.bounded |= (bounded as u32) << at;
            out.outside |= (outside as u32) << at;
            at += S::f32s::LEN;
        }
    }

    #[inline(always)]
    fn part<S: Simd, const PERSPECTIVE: bool>(
        &self,
        simd: S,
        block: &BoxBlock,
        at: usize,
        slack: f32,
        out: &mut Rectangles,
    ) -> (u64, u64) {
        let [x, y, third, near] = &self.rows;
        let reach = Reach::<S>::new(simd, block, at, self.base);
        let near_error = reach.error(simd, near) * S::f32s::splat(simd, slack);
        let heights = reach.terms(simd, near);
        // A NaN fails: such a box is visible.
        let mut sure = heights.least().simd_ge(near_error);
        let behind = (heights.most() + near_error).simd_lt(S::f32s::splat(simd, 0.0));
        // No other box has its upper corners there.
        let upper = S::f32s::from_slice(simd, &block.0[3][at..at + S::f32s::LEN]);
        let empty = upper.simd_eq(S::f32s::splat(simd, -Boxes::LIMIT));
        let third_error = reach.error(simd, third) * S::f32s::splat(simd, slack);
        let terms = reach.terms(simd, third);

        let mut bounds = [[third_error; 2]; 2];
        let (nearness, remotest);
        if PERSPECTIVE {
            let one = S::f32s::splat(simd, 1.0);
            let mut inverse = terms.corners();
            let nearest = smallest::<S>(&inverse);
            let most = greatest::<S>(&inverse);
            for w in &mut inverse {
                *w = one / *w;
            }
            sure = sure
                & nearest.simd_gt(third_error * S::f32s::splat(simd, 16.0))
                & nearest.simd_gt(S::f32s::splat(simd, LEAST_W));
            // The division is rounded up by more than its three roundings.
            let rounded = S::f32s::splat(simd, 1.0 + slack * (1.0 / (1 << 21) as f32));
            nearness = one / (nearest - third_error) * rounded;
            let shortened = S::f32s::splat(simd, 1.0 - slack * (1.0 / (1 << 21) as f32));
            remotest = one / (most + third_error) * shortened;
            let largest = one / nearest;
            for (bounds, row) in bounds.iter_mut().zip([x, y]) {
                let mut all = reach.terms(simd, row).corners();
                for (v, inverse) in all.iter_mut().zip(&inverse) {
                    *v *= *inverse;
                }
                let (min, max) = (smallest::<S>(&all), greatest::<S>(&all));
                let size = min.abs().max(max.abs());
                let error = reach.error(simd, row) * S::f32s::splat(simd, slack);
                let doubt = (error + size * third_error) * largest * S::f32s::splat(simd, 1.125)
                    + size * S::f32s::splat(simd, slack * (1.0 / (1 << 22) as f32));
                *bounds = [min - doubt, max + doubt];
            }
        } else {
            let most = terms.most() + third_error;
            let rounding = S::f32s::splat(simd, slack * (1.0 / (1 << 21) as f32));
            nearness = most + most.abs() * rounding;
            let least = terms.least() - third_error;
            remotest = least - least.abs() * rounding;
            for (bounds, row) in bounds.iter_mut().zip([x, y]) {
                let terms = reach.terms(simd, row);
                let doubt = reach.error(simd, row) * S::f32s::splat(simd, slack * 1.125);
                *bounds = [terms.least() - doubt, terms.most() + doubt];
            }
        }
        let mut off_screen = empty;
        let (zero, farthest) = (S::f32s::splat(simd, 0.0), S::f32s::splat(simd, FARTHEST));
        for a in 0..2 {
            let [min, max] = bounds[a];
            let size = S::f32s::splat(simd, self.size[a]);
            sure = sure & min.abs().simd_lt(farthest) & max.abs().simd_lt(farthest);
            off_screen = off_screen | max.simd_lt(zero) | min.simd_gt(size);
            let last = size - S::f32s::splat(simd, 1.0);
            let first: S::i32s = min.max(zero).min(last).to_int();
            let last: S::i32s = max.max(zero).min(last).to_int();
            first.store_slice(&mut out.min[a][at..at + S::f32s::LEN]);
            last.store_slice(&mut out.max[a][at..at + S::f32s::LEN]);
        }
        sure &= nearness.abs().simd_lt(S::f32s::splat(simd, f32::INFINITY));
        nearness.store_slice(&mut out.nearness[at..at + S::f32s::LEN]);
        remotest.store_slice(&mut out.farthest[at..at + S::f32s::LEN]);
        let outside = empty | behind | (sure & off_screen);
        ((sure & !outside).to_bitmask(), outside.to_bitmask())
    }
}

/// Some boxes, from the base on. (No closures here, nor calls that take one: what is not inlined is
/// compiled without the level's instructions, at several times the cost.)
struct Reach<S: Simd> {
    /// Negated lower corners, and upper ones.
    low: [S::f32s; 3],
    high: [S::f32s; 3],
    /// The larger of their absolute values.
    size: [S::f32s; 3],
}

impl<S: Simd> Reach<S> {
    #[inline(always)]
    fn new(simd: S, block: &BoxBlock, at: usize, base: [f32; 3]) -> Self {
        let zero = S::f32s::splat(simd, 0.0);
        let (mut low, mut high, mut size) = ([zero; 3], [zero; 3], [zero; 3]);
        for a in 0..3 {
            let base = S::f32s::splat(simd, base[a]);
            low[a] = S::f32s::from_slice(simd, &block.0[a][at..at + S::f32s::LEN]) + base;
            high[a] = S::f32s::from_slice(simd, &block.0[a + 3][at..at + S::f32s::LEN]) - base;
            size[a] = low[a].abs().max(high[a].abs());
        }
        Self { low, high, size }
    }

    /// How far the values of a row may be off.
    #[inline(always)]
    fn error(&self, simd: S, row: &Row) -> S::f32s {
        let [x, y, z] = self.size;
        S::f32s::splat(simd, row.c_error)
            + (x * S::f32s::splat(simd, row.k_error[0])
                + y * S::f32s::splat(simd, row.k_error[1])
                + z * S::f32s::splat(simd, row.k_error[2]))
    }

    #[inline(always)]
    fn terms(&self, simd: S, row: &Row) -> Terms<S> {
        let c = S::f32s::splat(simd, row.c);
        let mut of = [[c; 2]; 3];
        for a in 0..3 {
            let (minus, plus) = (S::f32s::splat(simd, -row.k[a]), S::f32s::splat(simd, row.k[a]));
            of[a] = [self.low[a] * minus, self.high[a] * plus];
        }
        Terms { c, of }
    }
}

/// The terms of a row: its constant, and one for each face of a box. Always summed in one order, so
/// that the least and the most are those of the corners.
struct Terms<S: Simd> {
    c: S::f32s,
    of: [[S::f32s; 2]; 3],
}

impl<S: Simd> Terms<S> {
    #[inline(always)]
    fn least(&self) -> S::f32s {
        let [[a, b], [c, d], [e, f]] = self.of;
        self.c + a.min(b) + c.min(d) + e.min(f)
    }

    #[inline(always)]
    fn most(&self) -> S::f32s {
        let [[a, b], [c, d], [e, f]] = self.of;
        self.c + a.max(b) + c.max(d) + e.max(f)
    }

    /// The values at the eight corners.
    #[inline(always)]
    fn corners(&self) -> [S::f32s; 8] {
        let [[a, b], [c, d], [e, f]] = self.of;
        let (a, b) = (self.c + a, self.c + b);
        let (p, q, r, s) = (a + c, b + c, a + d, b + d);
        [p + e, q + e, r + e, s + e, p + f, q + f, r + f, s + f]
    }
}

#[inline(always)]
fn smallest<S: Simd>(v: &[S::f32s; 8]) -> S::f32s {
    let [a, b, c, d, e, f, g, h] = *v;
    (a.min(b).min(c.min(d))).min(e.min(f).min(g.min(h)))
}

#[inline(always)]
fn greatest<S: Simd>(v: &[S::f32s; 8]) -> S::f32s {
    let [a, b, c, d, e, f, g, h] = *v;
    (a.max(b).max(c.max(d))).max(e.max(f).max(g.max(h)))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::super::OcclusionBuffer;
    use super::super::BoxTests;
    use crate::bounds::{Aabb, Boxes, LANES};
    use crate::hierarchy::Nodes;
    use crate::{Camera, Depth, Projection, View};

    fn boxes() -> impl Strategy<Value = Vec<Aabb>> {
        let place = [-20.0..20.0_f64, -9.0..9.0, -30.0..4.0];
        let spread = prop_oneof![Just(0.3), Just(4.0), Just(30.0)];
        let each = ([-1.0..1.0_f64, -1.0..1.0, -1.0..1.0], [0.0..2.0_f64, 0.0..5.0, 0.0..0.5]);
        (place, spread, prop::collection::vec(each, 1..=LANES)).prop_map(|(place, spread, all)| {
            let each = |(at, size): ([f64; 3], [f64; 3])| {
                let min = [0, 1, 2].map(|a| place[a] + at[a] * spread);
                Aabb::new(min.map(|v| v as f32), [0, 1, 2].map(|a| (min[a] + size[a]) as f32))
            };
            all.into_iter().map(each).collect()
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(256))]

        #[test]
        fn nothing_below_a_node_has_more_pixels_than_the_largest_may(
            all in boxes(),
            eye in [-3.0..3.0_f64, -3.0..3.0, 6.0..40.0],
            orthographic in any::<bool>(),
        ) {
            let projection = if orthographic {
                let (near, far) = (0.1, 200.0);
                Projection::Orthographic { left: -9.0, right: 9.0, bottom: -5.0, top: 5.0, near, far }
            } else {
                Projection::Perspective { fov_y_radians: 1.2, aspect: 1.6, near: 0.1, far: 200.0 }
            };
            let camera = Camera::look_at(eye, [0.0; 3], projection);
            let view = View::new(&camera, Depth::Reversed, [320, 200]).unwrap();
            let mut buffer = OcclusionBuffer::new([320, 200]).unwrap();
            buffer.begin(&view, [0.0; 3]);
            let level = crate::Simd::best();
            // More than sixteen, so that there is a node above the first.
            let mut all = all;
            all.resize(LANES, all[0]);
            all.push(all[0]);
            let boxes = Boxes::from_slice(&all);
            let nodes = Nodes::over(level, &boxes);
            let tests = BoxTests::new(&buffer, level);
            let mut of_node = None;
            let block = &nodes.levels()[0].blocks()[0];
            tests.bounds_of_nodes(block, 1, 0.0, |_, bounds| of_node = bounds);
            let Some(of_node) = of_node else { return Ok(()) };
            let most = tests.most_pixels(&of_node, nodes.largest_below(0, 0));
            prop_assert!(most <= of_node.pixels());
            for i in 0..LANES {
                if let Ok(f) = tests.bounds(&boxes, i) {
                    prop_assert!(f.pixels() <= most, "{f:?} has more than {most}");
                }
            }
        }
    }
}
