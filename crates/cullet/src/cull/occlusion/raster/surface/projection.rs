//! Projecting the vertices of a patch, eight at a time in f32, and how far they may be off.
//!
//! A vertex is off by E in x·w, and by F in w, with E ≤ Σ ε |p − e| + δ; see [`Row`]. What lies on
//! the screen or within a guard band around it lies in a cone from the eye, so that |p − e| is
//! bounded by w: where M has the three rows and c are their constants, p − e = M⁻¹ ((x·w, y·w, w) −
//! c), and |p − e| / w ≤ Σ |M⁻¹| (|x| + |c| / w), taken of x, y and 1. Without that the error of a
//! wall near the eye would be that of its far end at the w of its near one.

use fearless_simd::prelude::*;
use fearless_simd::{f32x8, i32x8};
use glam::{DMat3, DVec3};

use super::super::blocks::BLOCK;
use super::super::connected::{Connected, LANES};
use super::super::row::{Row, meet};
use super::super::screen::ObjectScreen;
use super::{Surface, Window};
use crate::array::Each;
use crate::bounds::Aabb;
#[cfg(not(feature = "std"))]
use crate::math::Float as _;

/// Pixels beyond each edge of the screen up to which vertices keep their digits; what reaches
/// farther is clipped.
pub(super) const GUARD: f64 = 4096.0;

/// Planes: the near one, and the four sides of the guard band.
pub(super) const PLANES: usize = 5;

/// Set in the code of a vertex that is before the near plane, too far off the screen, or too near
/// the eye. Beside it stand the planes beyond which it certainly is, a bit each.
pub(super) const UNUSABLE: i32 = 1 << PLANES;

/// Error of a quotient, as a share of what its parts are off by: enough where w is 16 times as
/// large as its own.
const QUOTIENT: f64 = 1.125;

/// The map from an object's space to the screen, in f32.
#[derive(Clone, Debug)]
pub(crate) struct Projection {
    /// Point that coordinates are taken relative to.
    base: [f32; 3],
    /// x·w, y·w, w (perspective) or nearness (parallel), height over the near plane.
    rows: [Row; 4],
    perspective: bool,
    /// In perspective the errors of x·w, y·w and w, over w, for each pixel from the edge in x, in
    /// y, and for one.
    shares: [[f64; 3]; 3],
    /// The eye, and 1; or the direction of view, and 0.
    eye: [f64; 4],
    /// Whether fronts look clockwise on a screen whose y grows upward.
    mirrored: bool,
    size: [f64; 2],
}

impl Projection {
    /// Returns the projection of an object onto a screen of `size` pixels. `None` where its numbers
    /// are too large for f32, or where the object is flat.
    pub(crate) fn new(screen: &ObjectScreen, size: [u32; 2]) -> Option<Self> {
        let perspective = screen.perspective;
        let order = [0, 1, if perspective { 4 } else { 2 }, 3];
        let rows = order.each(|i| screen.rows()[i].to_array());
        let of = order.each(|i| screen.sizes[i].to_array());
        let base = meet([rows[0], rows[1], rows[2]]).unwrap_or_default();
        let row = |i: usize| Row::new(rows[i], of[i], base, screen.apart[order[i]]);
        let [x, y, third] = [0, 1, 2].each(|i| DVec3::new(rows[i][0], rows[i][1], rows[i][2]));
        let inverse = DMat3::from_cols(x, y, third).transpose().inverse();
        let rows = [row(0)?, row(1)?, row(2)?, row(3)?];
        let shares = [0, 1, 2].each(|i: usize| {
            [0, 1, 2].each(|j: usize| {
                let each = |a: usize| f64::from(rows[i].k_error[a]) * inverse.col(j)[a].abs();
                each(0) + each(1) + each(2)
            })
        });
        let eye = if perspective {
            let c = [0, 1, 2].each(|i| screen.rows()[order[i]].w);
            (inverse * -DVec3::from(c)).extend(1.0)
        } else {
            let along = x.cross(y);
            let away = if along.dot(third) > 0.0 { -along } else { along };
            away.normalize().extend(0.0)
        };
        let is_finite = eye.is_finite() && shares.as_flattened().iter().all(|v| v.is_finite());
        is_finite.then_some(Self {
            base,
            rows,
            perspective,
            shares,
            eye: eye.into(),
            mirrored: screen.mirrored,
            size: size.each(f64::from),
        })
    }

    pub(super) fn is_mirrored(&self) -> bool {
        self.mirrored
    }

    /// Pixels of the screen.
    pub(super) fn size(&self) -> [f64; 2] {
        self.size
    }

    /// Whether all own triangles of a patch show their backs; or with `sign` −1, their fronts.
    pub(super) fn faces_away(&self, patch: &Connected, sign: f64) -> bool {
        let [ex, ey, ez, one] = self.eye;
        let axis = DVec3::from(patch.axis.each(f64::from)) * sign;
        let sine = f64::from(patch.sine);
        let eye = DVec3::new(ex, ey, ez);
        if one == 0.0 {
            return eye.dot(axis) > sine;
        }
        let (min, max) = (DVec3::from(patch.bounds.min.each(f64::from)), patch.bounds.max);
        let max = DVec3::from(max.each(f64::from));
        let (to, radius) = ((min + max) * 0.5 - eye, (max - min).length() * 0.5);
        to.dot(axis) >= sine * to.length() + radius * 1.0001
    }

    /// The largest distance from the base along each axis.
    fn reach(&self, b: &Aabb) -> [f64; 3] {
        let base = self.base.each(f64::from);
        [0, 1, 2].each(|a: usize| {
            (f64::from(b.min[a]) - base[a]).abs().max((f64::from(b.max[a]) - base[a]).abs())
        })
    }

    fn error(&self, row: usize, reach: [f64; 3]) -> f64 {
        let Row { k_error, c_error, .. } = &self.rows[row];
        let each = |a: usize| f64::from(k_error[a]) * reach[a];
        f64::from(*c_error) + each(0) + each(1) + each(2)
    }

    /// The least that a row may be over a box.
    fn least(&self, row: usize, b: &Aabb) -> f64 {
        let Row { k, c, .. } = &self.rows[row];
        let each = |a: usize| {
            let (k, base) = (f64::from(k[a]), f64::from(self.base[a]));
            (k * (f64::from(b.min[a]) - base)).min(k * (f64::from(b.max[a]) - base))
        };
        f64::from(*c) + each(0) + each(1) + each(2)
    }

    #[inline(always)]
    fn row<S: Simd>(&self, simd: S, row: usize, [x, y, z]: [f32x8<S>; 3]) -> f32x8<S> {
        let Row { k, c, .. } = &self.rows[row];
        let splat = |v: f32| f32x8::splat(simd, v);
        x * splat(k[0]) + y * splat(k[1]) + z * splat(k[2]) + splat(*c)
    }

    /// Errors of vertices no farther than `g` pixels from the top left corner, whose w is `w` at
    /// least.
    fn doubt(&self, g: [f64; 2], w: f64, reach: [f64; 3]) -> VertexDoubt {
        let far = g[0].max(g[1]);
        if !self.perspective {
            let [x, y, n] = [0, 1, 2].each(|row| QUOTIENT * self.error(row, reach));
            let pixels = x.max(y) + far * 2.0_f64.powi(-22);
            return VertexDoubt { pixels, share: 2.0_f64.powi(-22), nearness: n };
        }
        let places = [g[0], g[1], 1.0];
        let at = [0, 1, 2].each(|j: usize| places[j] + f64::from(self.rows[j].c.abs()) / w);
        let of = |i: usize| {
            let each = |j: usize| self.shares[i][j] * at[j];
            each(0) + each(1) + each(2) + f64::from(self.rows[i].c_error) / w
        };
        let of_w = of(2);
        let pixels = (of(0) + g[0] * of_w).max(of(1) + g[1] * of_w);
        VertexDoubt {
            pixels: QUOTIENT * pixels + far * 2.0_f64.powi(-21),
            share: QUOTIENT * of_w + 2.0_f64.powi(-21),
            nearness: 0.0,
        }
    }
}

/// How far projected vertices may be off: in pixels, in nearness as a share of it, and beside that.
struct VertexDoubt {
    pixels: f64,
    share: f64,
    nearness: f64,
}

impl Surface {
    /// Projects the vertices of a patch, of which those before the near plane or far off the screen
    /// become NaN, and clips the facets that have one. The part of the screen on which its own
    /// facets lie; `None` where there is none.
    #[inline(always)]
    pub(super) fn project<S: Simd>(
        &mut self,
        simd: S,
        screen: &ObjectScreen,
        projection: &Projection,
        patch: &Connected,
    ) -> Option<Window> {
        let splat = |v: f32| f32x8::splat(simd, v);
        let reach = projection.reach(&patch.around);
        let near_error = projection.error(3, reach);
        let least_height = projection.least(3, &patch.around);
        let may_be_near = least_height <= near_error * 2.0 || least_height.is_nan();
        let least_w = if projection.perspective { 16.0 * projection.error(2, reach) } else { 0.0 };
        let least_w = splat((least_w as f32).next_up().max(1e-18));
        let near_error = splat((near_error as f32).next_up());
        let guard = projection.size.each(|s| splat((s + GUARD) as f32));
        let (infinite, nan) = (splat(f32::INFINITY), splat(f32::NAN));
        let lanes = f32x8::simd_from(simd, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        let (mut low, mut high) = ([infinite; 2], [-infinite; 2]);
        let (mut own, mut smallest_w) = ((low, high), infinite);
        let (mut is_clipped, mut nearest) = (false, -infinite);
        let mut all_codes = i32x8::splat(simd, !0);
        let beyond = Beyond::new(projection, reach, near_error.into());
        let count = patch.places[0].len();
        let base = projection.base;
        for i in (0..count).step_by(LANES) {
            let at =
                |a: usize| f32x8::from_slice(simd, &patch.places[a][i..i + LANES]) - splat(base[a]);
            let p = [at(0), at(1), at(2)];
            let third = projection.row(simd, 2, p);
            let (mut x, mut y) = (projection.row(simd, 0, p), projection.row(simd, 1, p));
            let mut n = third;
            let mut usable = x.simd_eq(x);
            if projection.perspective {
                n = splat(1.0) / third;
                (x, y) = (x * n, y * n);
                usable = third.simd_gt(least_w);
            }
            let height = if may_be_near { projection.row(simd, 3, p) } else { infinite };
            usable &= height.simd_ge(near_error);
            usable &= x.abs().simd_lt(guard[0]) & y.abs().simd_lt(guard[1]);
            let mut codes = i32x8::splat(simd, 0);
            if usable.to_bitmask() != 0xff {
                is_clipped = true;
                codes = usable.select(codes, beyond.codes(simd, projection, p, height));
            }
            codes.store_slice(&mut self.codes[i..i + LANES]);
            (x, y) = (usable.select(x, nan), usable.select(y, nan));
            let before = (low, high);
            (low, high) = grown(before, [x, y]);
            smallest_w = (usable & third.simd_lt(smallest_w)).select(third, smallest_w);
            self.spots.set(simd, i, [x, y, n]);
            if i < patch.own_vertices {
                // The last of its own share their eight with some around.
                let is_own = lanes.simd_lt(splat((patch.own_vertices - i) as f32));
                own = grown(before, [x, y].each(|v| is_own.select(v, nan)));
                nearest = nearest.max(is_own.select(n, -infinite));
                all_codes &= codes;
            }
        }
        let all_codes: [i32; LANES] = all_codes.into();
        if all_codes.iter().fold(!0, |all, code| all & code) & !UNUSABLE != 0 {
            return None;
        }
        let (low, high) = (least(low), most(high));
        let mut own = [least(own.0), most(own.1)];
        self.cut.begin(count);
        if is_clipped {
            self.cut_facets(screen, projection, patch, &mut own);
        }
        let [own_low, own_high] = own;
        if own_low[0] > own_high[0] {
            return None;
        }
        // Where no vertex is usable there are no bounds.
        let far = |a: usize| if low[a] <= high[a] { low[a].abs().max(high[a].abs()) } else { 0.0 };
        let g = [far(0), far(1)].each(|g| f64::from(g) * 1.01 + 2.0);
        let w = f64::from(smallest_w.reduce_min());
        let doubt = projection.doubt(g, w, reach);
        let padded = [self.columns * BLOCK[0], self.used.len() * BLOCK[1]].each(|s| s as f64);
        let mut span = g[0].max(g[1]).max(padded[0]).max(padded[1]);
        if is_clipped {
            span = span.max(projection.size[0].max(projection.size[1]) + GUARD + 1.0);
        }
        // An edge at a row takes some twelve roundings of at most the span, in units of 2⁻²⁴.
        let margin = (doubt.pixels * 1.01 + span * 2.0_f64.powi(-20)) as f32 + 2.0_f32.powi(-12);
        if margin >= 1.0 || margin.is_nan() {
            return None;
        }
        let end = padded.each(|v| v as f32);
        // The pixels that its own facets touch for certain. What they may touch beside those is of
        // the patches around it; so it draws nothing beyond its box, by which it may be passed
        // over.
        let low = [0, 1].each(|a| (own_low[a] + margin).floor().max(0.0));
        let high = [
            ((own_high[0] - margin).floor() + 1.0).min(end[0]),
            (own_high[1] - margin).floor().min(end[1] - 1.0),
        ];
        if !(low[0] < high[0] && low[1] <= high[1]) {
            return None;
        }
        let block = [low[0] as usize / BLOCK[0], low[1] as usize / BLOCK[1]];
        let across = (high[0] as usize - 1) / BLOCK[0] - block[0] + 1;
        let share = (doubt.share + 2.0_f64.powi(-19)) as f32;
        let nearness = (doubt.nearness * 1.001) as f32;
        let nearest = nearest.reduce_max();
        let cap =
            if is_clipped { f32::INFINITY } else { nearest - nearest.abs() * share - nearness };
        Some(Window {
            low,
            high,
            columns: [low[0], high[0]],
            block,
            across,
            margin,
            steep: margin + (span * 2.0_f64.powi(-19)) as f32,
            share,
            nearness,
            cap,
            is_clipped,
        })
    }
}

/// How far vertices must lie beyond the planes to do so for certain.
struct Beyond {
    near: f32,
    sides: [f32; 2],
}

impl Beyond {
    fn new(projection: &Projection, reach: [f64; 3], near: [f32; LANES]) -> Self {
        let of_w = if projection.perspective { projection.error(2, reach) } else { 0.0 };
        let side = |a: usize| {
            let far = projection.size[a] + GUARD;
            // The sums are rounded too, of which the errors of their terms take account twice over.
            ((projection.error(a, reach) + far * of_w) * 2.0) as f32
        };
        Self { near: near[0], sides: [side(0).next_up(), side(1).next_up()] }
    }

    /// The planes beyond which eight vertices certainly are, and that they are unusable.
    #[inline(always)]
    fn codes<S: Simd>(
        &self,
        simd: S,
        projection: &Projection,
        p: [f32x8<S>; 3],
        height: f32x8<S>,
    ) -> i32x8<S> {
        let splat = |v: f32| f32x8::splat(simd, v);
        let w = if projection.perspective { projection.row(simd, 2, p) } else { splat(1.0) };
        let none = i32x8::splat(simd, 0);
        let bit = |plane: i32| i32x8::splat(simd, 1 << plane);
        let mut codes = i32x8::splat(simd, UNUSABLE);
        codes |= height.simd_lt(splat(-self.near)).select(bit(0), none);
        for a in 0..2 {
            let at = projection.row(simd, a, p);
            let (low, high) = (GUARD as f32, (projection.size[a] + GUARD) as f32);
            let error = splat(self.sides[a]);
            let plane = 1 + 2 * a as i32;
            codes |= (at + w * low + error).simd_lt(splat(0.0)).select(bit(plane), none);
            codes |= (w * high - at + error).simd_lt(splat(0.0)).select(bit(plane + 1), none);
        }
        codes
    }
}

/// The least and the most of eight places, and of some before; NaN counts for neither.
#[inline(always)]
fn grown<S: Simd>(
    (low, high): ([f32x8<S>; 2], [f32x8<S>; 2]),
    [x, y]: [f32x8<S>; 2],
) -> ([f32x8<S>; 2], [f32x8<S>; 2]) {
    // Comparisons with a NaN are false.
    let low = [x.simd_lt(low[0]).select(x, low[0]), y.simd_lt(low[1]).select(y, low[1])];
    let high = [x.simd_gt(high[0]).select(x, high[0]), y.simd_gt(high[1]).select(y, high[1])];
    (low, high)
}

#[inline(always)]
fn least<S: Simd>(v: [f32x8<S>; 2]) -> [f32; 2] {
    [v[0].reduce_min(), v[1].reduce_min()]
}

#[inline(always)]
fn most<S: Simd>(v: [f32x8<S>; 2]) -> [f32; 2] {
    [v[0].reduce_max(), v[1].reduce_max()]
}
