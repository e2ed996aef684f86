//! The projection of sixteen boxes at once, in f32, with bounds on what rounding does to it.
//!
//! A row of the screen takes a point to a number, k · p + c. It is worked out from p − e, where e is a point of f32
//! numbers near the eye, so that what is far from the origin but near the eye loses nothing: p − e is rounded once, and
//! what e leaves is in the constant, which is summed in f64. With u = 2⁻²⁴: k and p − e are off by u each, the
//! product by u and its sum by at most 3 u, so that the number is off by less than 7 u (Σ |k||p − e| + |c|). [`Row`]
//! takes 9 u, of which the rest pays for the rounding of the bound itself, and adds what f64 did to the rows.
//!
//! Then with X and w off by E and F at most, X / w is off by (E + |X / w| F) / w, the |X / w| being the true one. Boxes
//! whose w is not above 16 F are left as visible, so that the true one is at most 16/15 (|X / w| + E / w) as computed, and
//! 9/8 (E + |X / w| F) / w holds all of it.

use fearless_simd::prelude::*;

use super::super::screen::Screen;
use crate::bounds::{BoxBlock, Boxes, LANES};
use crate::transform::Transform;

/// What rounding a row may cost, as a share of the sizes of its terms: 9 u.
const SHARE: f64 = 9.0 / (1 << 24) as f64;

/// How far rows and their constants may be off in f64: twice what the test of single boxes takes.
const SHARE64: f64 = 64.0 * f64::EPSILON;

/// A coefficient beyond this could overflow on a box that is stored as the whole of space.
const STEEPEST: f64 = 1e18;

/// The least w that has a reciprocal whose products do not overflow, and the largest pixel.
const LEAST_W: f32 = 1e-18;
const FARTHEST: f32 = 1e30;

/// An affine function of points, and how far its value may be off.
#[derive(Clone, Copy, Debug)]
struct Row {
    k: [f32; 3],
    c: f32,
    /// The error is at most that of these, taken of the absolute coordinates.
    k_error: [f32; 3],
    c_error: f32,
}

impl Row {
    /// A row for points relative to `e`, of which each number was summed from terms of the sizes `of`; `None` where a
    /// number may overflow.
    fn new(r: [f64; 4], of: [f64; 4], e: [f32; 3]) -> Option<Self> {
        let at = |r: [f64; 4], a: usize| r[a] * f64::from(e[a]);
        let c = r[3] + at(r, 0) + at(r, 1) + at(r, 2);
        let size = of[3] + at(of, 0).abs() + at(of, 1).abs() + at(of, 2).abs();
        if !(of[..3].iter().all(|&k| k < STEEPEST) && size < STEEPEST * 1e18) {
            return None;
        }
        // The smallest normal number is for coefficients and products that underflow.
        let up = |v: f64| (v as f32).next_up() + f32::MIN_POSITIVE;
        Some(Self {
            k: [r[0] as f32, r[1] as f32, r[2] as f32],
            c: c as f32,
            k_error: [0, 1, 2].map(|a| up(r[a].abs() * SHARE + of[a] * SHARE64)),
            c_error: up(c.abs() * SHARE + size * SHARE64),
        })
    }
}

/// The pixels that sixteen boxes may touch, and how near they come.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Rectangles {
    /// First and last columns and rows, inclusive.
    pub(super) min: [[i32; LANES]; 2],
    pub(super) max: [[i32; LANES]; 2],
    pub(super) nearness: [f32; LANES],
    /// One bit a box: it reaches some pixel, and the rest stands for it. Not so where it is outside, crosses the near plane or
    /// is not finite.
    pub(super) bounded: u32,
    /// One bit a box: it is empty, or beyond an edge of the screen.
    pub(super) outside: u32,
}

impl Rectangles {
    pub(super) const NONE: Self = Self {
        min: [[0; LANES]; 2],
        max: [[0; LANES]; 2],
        nearness: [0.0; LANES],
        bounded: 0,
        outside: 0,
    };
}

/// A screen as the projection of batches uses it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lens {
    /// What coordinates are taken relative to.
    base: [f32; 3],
    /// x·w, y·w, w (perspective) or nearness (orthographic), height over the near plane.
    rows: [Row; 4],
    size: [f32; 2],
    perspective: bool,
}

impl Lens {
    /// For boxes relative to the origin of the screen. `None` where its numbers are too large for f32: then all
    /// boxes are visible.
    pub(super) fn new(screen: &Screen) -> Option<Self> {
        let rows = screen.rows();
        Self::of_rows(screen, rows, rows.map(|r| r.map(f64::abs)))
    }

    /// For boxes in the space of an object, the screen being relative to `origin`.
    pub(super) fn of_object(
        screen: &Screen,
        transform: &Transform,
        origin: [f64; 3],
    ) -> Option<Self> {
        let m = transform.to_matrix();
        let mut rows = screen.rows();
        let mut sizes = rows;
        for (row, size) in rows.iter_mut().zip(&mut sizes) {
            let r = *row;
            for column in 0..3 {
                let terms = [0, 1, 2].map(|a| r[a] * m[column * 4 + a]);
                row[column] = terms.iter().sum();
                size[column] = terms.map(f64::abs).iter().sum();
            }
            let terms = [0, 1, 2].map(|a| r[a] * (m[12 + a] - origin[a]));
            row[3] = r[3] + terms.iter().sum::<f64>();
            size[3] = r[3].abs() + terms.map(f64::abs).iter().sum::<f64>();
        }
        Self::of_rows(screen, rows, sizes)
    }

    fn of_rows(screen: &Screen, rows: [[f64; 4]; 5], sizes: [[f64; 4]; 5]) -> Option<Self> {
        let perspective = screen.perspective;
        if !perspective && rows[4] != [0.0, 0.0, 0.0, 1.0] {
            return None;
        }
        // x, y, w or nearness, near.
        let order = [0, 1, if perspective { 4 } else { 2 }, 3];
        let base = meet([0, 1, 2].map(|i| rows[order[i]])).unwrap_or_default();
        let row = |i: usize| Row::new(rows[order[i]], sizes[order[i]], base);
        let rows = [row(0)?, row(1)?, row(2)?, row(3)?];
        Some(Self { base, rows, size: screen.size.map(|s| s as f32), perspective })
    }

    /// Projects a block, with `slack` times the doubt.
    ///
    /// A box within another has its rectangle within, and is no nearer, if the other is projected with four times the doubt or
    /// more: each number is off by less than its own doubt, and that of the smaller box is the smaller.
    #[inline(always)]
    pub(super) fn project<S: Simd>(
        &self,
        simd: S,
        block: &BoxBlock,
        slack: f32,
        out: &mut Rectangles,
    ) {
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
        let splat = |v: f32| S::f32s::splat(simd, v);
        let load = |row: usize| S::f32s::from_slice(simd, &block.0[row][at..at + S::f32s::LEN]);
        // Negated lower corners and upper ones, from the base on.
        let low: [S::f32s; 3] = std::array::from_fn(|a| load(a) + splat(self.base[a]));
        let high: [S::f32s; 3] = std::array::from_fn(|a| load(a + 3) - splat(self.base[a]));
        let reach: [S::f32s; 3] = std::array::from_fn(|a| low[a].abs().max(high[a].abs()));
        let error = |row: &Row| {
            splat(row.c_error)
                + (reach[0] * splat(row.k_error[0])
                    + reach[1] * splat(row.k_error[1])
                    + reach[2] * splat(row.k_error[2]))
        };
        let terms = |row: &Row| -> [[S::f32s; 2]; 3] {
            std::array::from_fn(|a| [low[a] * splat(-row.k[a]), high[a] * splat(row.k[a])])
        };
        let least = |row: &Row| {
            let t = terms(row).map(|[p, q]| p.min(q));
            splat(row.c) + t[0] + t[1] + t[2]
        };
        let most = |row: &Row| {
            let t = terms(row).map(|[p, q]| p.max(q));
            splat(row.c) + t[0] + t[1] + t[2]
        };
        let [x, y, third, near] = &self.rows;
        let near_error = error(near) * splat(slack);
        // A NaN fails: such a box is visible.
        let mut sure = least(near).simd_ge(near_error);
        // No other box has its upper corners there.
        let empty = load(3).simd_eq(splat(-Boxes::LIMIT));
        let third_error = error(third) * splat(slack);

        let mut bounds = [[splat(0.0); 2]; 2];
        let nearness;
        if PERSPECTIVE {
            let w = corners::<S>(splat(third.c), &terms(third));
            let inverse = w.map(|w| splat(1.0) / w);
            let nearest = smallest::<S>(&w);
            sure =
                sure & nearest.simd_gt(third_error * splat(16.0)) & nearest.simd_gt(splat(LEAST_W));
            // The division is rounded up by more than its three roundings.
            let rounded = splat(1.0 + slack * (1.0 / (1 << 21) as f32));
            nearness = splat(1.0) / (nearest - third_error) * rounded;
            let largest = splat(1.0) / nearest;
            for (bounds, row) in bounds.iter_mut().zip([x, y]) {
                let all = corners::<S>(splat(row.c), &terms(row));
                let all: [S::f32s; 8] = std::array::from_fn(|i| all[i] * inverse[i]);
                let (min, max) = (smallest::<S>(&all), greatest::<S>(&all));
                let size = min.abs().max(max.abs());
                let doubt =
                    (error(row) * splat(slack) + size * third_error) * largest * splat(1.125)
                        + size * splat(slack * (1.0 / (1 << 22) as f32));
                *bounds = [min - doubt, max + doubt];
            }
        } else {
            let most = most(third) + third_error;
            nearness = most + most.abs() * splat(slack * (1.0 / (1 << 21) as f32));
            for (bounds, row) in bounds.iter_mut().zip([x, y]) {
                let (min, max) = (least(row), most_of::<S>(splat(row.c), &terms(row)));
                let doubt = error(row) * splat(slack * 1.125);
                *bounds = [min - doubt, max + doubt];
            }
        }
        let mut off_screen = empty;
        for (a, [min, max]) in bounds.into_iter().enumerate() {
            let size = splat(self.size[a]);
            let farthest = splat(FARTHEST);
            sure = sure & min.abs().simd_lt(farthest) & max.abs().simd_lt(farthest);
            off_screen = off_screen | max.simd_lt(splat(0.0)) | min.simd_gt(size);
            let last = size - splat(1.0);
            let pixel = |v: S::f32s| v.max(splat(0.0)).min(last).to_int::<S::i32s>();
            pixel(min).store_slice(&mut out.min[a][at..at + S::f32s::LEN]);
            pixel(max).store_slice(&mut out.max[a][at..at + S::f32s::LEN]);
        }
        sure = sure & nearness.abs().simd_lt(splat(f32::INFINITY));
        nearness.store_slice(&mut out.nearness[at..at + S::f32s::LEN]);
        let outside = empty | (sure & off_screen);
        ((sure & !outside).to_bitmask(), outside.to_bitmask())
    }
}

/// The values of a row at the eight corners.
#[inline(always)]
fn corners<S: Simd>(c: S::f32s, [x, y, z]: &[[S::f32s; 2]; 3]) -> [S::f32s; 8] {
    std::array::from_fn(|i| c + x[i & 1] + y[i >> 1 & 1] + z[i >> 2])
}

#[inline(always)]
fn most_of<S: Simd>(c: S::f32s, terms: &[[S::f32s; 2]; 3]) -> S::f32s {
    let t = terms.map(|[p, q]| p.max(q));
    c + t[0] + t[1] + t[2]
}

#[inline(always)]
fn smallest<S: Simd>(v: &[S::f32s; 8]) -> S::f32s {
    let pair = |i: usize| v[i].min(v[i + 4]);
    (pair(0).min(pair(1))).min(pair(2).min(pair(3)))
}

#[inline(always)]
fn greatest<S: Simd>(v: &[S::f32s; 8]) -> S::f32s {
    let pair = |i: usize| v[i].max(v[i + 4]);
    (pair(0).max(pair(1))).max(pair(2).max(pair(3)))
}

/// The point where three rows are zero, the eye where they are those of a perspective view, as near as f32 has it.
fn meet(rows: [[f64; 4]; 3]) -> Option<[f32; 3]> {
    let [a, b, c] = rows.map(|r| glam::DVec3::new(r[0], r[1], r[2]));
    let d = [rows[0][3], rows[1][3], rows[2][3]];
    let determinant = a.dot(b.cross(c));
    let p = -(b.cross(c) * d[0] + c.cross(a) * d[1] + a.cross(b) * d[2]) / determinant;
    let p = p.to_array().map(|v| v as f32);
    p.iter().all(|v| v.abs() < Boxes::LIMIT).then_some(p)
}
