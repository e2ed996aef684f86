//! Drawing convex bodies that lie wholly in front of the near plane: eight corners, and eight edges, at a time.

use fearless_simd::prelude::*;
use glam::DVec4;

use super::ask::covered;
use super::band::Band;
use super::convex::Convex;
use super::outline::Edges;
use super::plane::Plane;
use super::screen::{Doubt, ObjectScreen, Spot};
use crate::bits;

/// Eight points, an array for each axis.
pub(super) type Points = [[f32; 8]; 3];

/// Where eight points are on the screen: columns, rows, nearness.
pub(super) type Places = [[f64; 8]; 3];

/// What the places of a body lie within.
struct Extent {
    min: [f64; 2],
    max: [f64; 2],
    /// The nearest corner, and the least w.
    nearest: f64,
    w: f64,
}

impl Band<'_> {
    /// Draws a body; `false`, and nothing, where a corner is not in front or a number is not finite.
    #[inline(always)]
    pub(super) fn whole_convex<S: Simd>(
        &mut self,
        simd: S,
        occluder: &Convex,
        screen: &ObjectScreen,
    ) -> bool {
        let mut places = std::mem::take(&mut self.pen.places);
        let extent = place(simd, screen, occluder, &mut places);
        if let Some(extent) = &extent {
            self.placed(simd, occluder, screen, &places, extent);
        }
        self.pen.places = places;
        extent.is_some()
    }

    #[inline(always)]
    fn placed<S: Simd>(
        &mut self,
        simd: S,
        occluder: &Convex,
        screen: &ObjectScreen,
        places: &[Places],
        extent: &Extent,
    ) {
        let Extent { min, max, nearest, w } = *extent;
        let last = self.size.map(|s| f64::from(s) - 1.0);
        if (0..2).any(|a| max[a] < 0.0 || min[a] > last[a] + 1.0) {
            return;
        }
        let reach = (min[0].abs().max(max[0].abs())).max(min[1].abs().max(max[1].abs()));
        let doubt = Doubt::within(&screen.error(occluder.reach), w, reach, nearest);
        let pixel = |v: f64, a: usize| v.max(0.0).min(last[a]) as usize;
        let nearest = ((nearest + doubt.nearness) * (1.0 + 2.0_f64.powi(-20))) as f32;
        let window = [min, max].map(|c| [pixel(c[0], 0), pixel(c[1], 1)]);
        if covered(simd, self.as_tiles(), window[0], window[1], nearest) {
            return;
        }
        let rows = self.pixel_rows();
        let outline = &mut self.pen.outline;
        outline.begin(self.size, rows, min, max, doubt.pixels);
        if outline.is_thin() {
            return;
        }
        let orient = if screen.mirrored { 1.0 } else { -1.0 };
        let spot = |v: u32| {
            let [x, y, nearness] = &places[v as usize / 8];
            let lane = v as usize % 8;
            Spot { x: x[lane], y: y[lane], nearness: nearness[lane] }
        };
        let span = [max[0] - min[0], max[1] - min[1]];
        // What no area of three corners may be off by.
        let slack = doubt.area_within(span);
        let mut seen = [0_u64; FACES / 64];
        for (word, faces) in occluder.spread.chunks(64).enumerate() {
            let mut bits = 0;
            for (face, corners) in faces.iter().enumerate() {
                let [a, b, c] = corners.map(spot);
                let area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
                bits |= u64::from(area * orient > slack) << face;
            }
            seen[word] = bits;
            for face in bits::ones(bits) {
                let corners = faces[face].map(spot);
                outline.plane(Plane::through(corners, span, self.size, &doubt));
            }
        }
        let is_seen = |face: u32| seen[face as usize / 64 % (FACES / 64)] >> (face % 64) & 1;
        for edges in occluder.edges.chunks(64) {
            let mut bits = 0;
            for (i, &[_, _, winds, other]) in edges.iter().enumerate() {
                bits |= (is_seen(winds) ^ is_seen(other)) << i;
            }
            let mut chunk = Edges::default();
            for edge in bits::ones(bits) {
                let [from, to, winds, _] = edges[edge];
                let ends = if is_seen(winds) == 1 { [from, to] } else { [to, from] };
                chunk.push(ends.map(spot));
                if chunk.is_full() {
                    outline.edges(simd, &chunk, orient);
                    chunk.clear();
                }
            }
            outline.edges(simd, &chunk, orient);
        }
        self.fill_with(simd);
    }
}

/// The most faces, rounded up: a closed convex body of n corners has at most 2 n − 4.
const FACES: usize = Convex::MAX_VERTICES * 2;

/// Places a body's corners on the screen, eight at a time; `None` where one is not in front or not finite.
#[inline(always)]
fn place<S: Simd>(
    simd: S,
    screen: &ObjectScreen,
    occluder: &Convex,
    places: &mut Vec<Places>,
) -> Option<Extent> {
    places.resize(1 + occluder.more.len(), [[0.0; 8]; 3]);
    let rows = screen.rows();
    let (zero, one) = (S::f64s::splat(simd, 0.0), S::f64s::splat(simd, 1.0));
    let mut min = [S::f64s::splat(simd, f64::INFINITY); 2];
    let mut max = [S::f64s::splat(simd, f64::NEG_INFINITY); 2];
    let (mut nearest, mut least_w) = (max[0], min[0]);
    // Anything times zero is zero, unless it is not finite.
    let mut nothing = zero;
    let mut in_front = true;
    for (i, places) in places.iter_mut().enumerate() {
        let points = if i == 0 { &occluder.points } else { &occluder.more[i - 1] };
        let points = [widened(&points[0]), widened(&points[1]), widened(&points[2])];
        let mut at = 0;
        while at < 8 {
            let lanes = at..at + S::f64s::LEN;
            let x = S::f64s::from_slice(simd, &points[0][lanes.clone()]);
            let y = S::f64s::from_slice(simd, &points[1][lanes.clone()]);
            let z = S::f64s::from_slice(simd, &points[2][lanes.clone()]);
            let p = [x, y, z];
            let (near, w) = (sum(simd, &rows[3], p), sum(simd, &rows[4], p));
            in_front &= (near.simd_ge(zero) & w.simd_gt(zero)).all_true();
            let inverse = one / w;
            let mut place = [zero; 3];
            for a in 0..3 {
                place[a] = sum(simd, &rows[a], p) * inverse;
                place[a].store_slice(&mut places[a][lanes.clone()]);
                nothing += place[a] * zero;
            }
            for a in 0..2 {
                min[a] = min[a].min(place[a]);
                max[a] = max[a].max(place[a]);
            }
            nearest = nearest.max(place[2]);
            least_w = least_w.min(w);
            at += S::f64s::LEN;
        }
    }
    if !(in_front && nothing.simd_eq(zero).all_true()) {
        return None;
    }
    Some(Extent {
        min: [min[0].reduce_min(), min[1].reduce_min()],
        max: [max[0].reduce_max(), max[1].reduce_max()],
        nearest: nearest.reduce_max(),
        w: least_w.reduce_min(),
    })
}

#[inline(always)]
fn widened(v: &[f32; 8]) -> [f64; 8] {
    let mut out = [0.0; 8];
    for i in 0..8 {
        out[i] = f64::from(v[i]);
    }
    out
}

/// A row at some points, in the order of [`ObjectScreen::clip`]. (No closure: what is not inlined is compiled without the
/// level's instructions.)
#[inline(always)]
fn sum<S: Simd>(simd: S, row: &DVec4, [x, y, z]: [S::f64s; 3]) -> S::f64s {
    x * S::f64s::splat(simd, row.x)
        + y * S::f64s::splat(simd, row.y)
        + z * S::f64s::splat(simd, row.z)
        + S::f64s::splat(simd, row.w)
}
