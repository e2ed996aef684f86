//! Drawing convex bodies: one that lies wholly in front of the near plane by its silhouette, eight
//! corners, and eight edges, at a time; any other face by face.

use alloc::vec::Vec;

use crate::array::Each;
#[cfg(not(feature = "std"))]
use crate::math::Float as _;
use crate::simd::dispatch;
use fearless_simd::prelude::*;
use glam::DVec4;

use super::super::super::raster::{
    Canvas, Clip, Doubt, Edges, ObjectScreen, OcclusionBuffer, Plane, ScreenBounds, Spot, clip_near,
};
use super::Convex;
use crate::bits;
use crate::transform::Transform;

/// Eight corners on the screen: columns, rows, nearness.
type Places = [[f64; 8]; 3];

/// Extent of the places of a body.
struct Extent {
    min: [f64; 2],
    max: [f64; 2],
    /// The nearest corner, and the least w.
    nearest: f64,
    w: f64,
}

impl Convex {
    /// Draws it into `buffer`. Nothing where a number is not finite, where the eye is within, and
    /// before [`OcclusionBuffer::begin`].
    pub fn draw(&self, simd: crate::Simd, buffer: &mut OcclusionBuffer, transform: &Transform) {
        self.draw_on(simd, &mut buffer.canvas(), transform);
    }

    /// Draws it onto a canvas.
    pub(crate) fn draw_on(
        &self,
        simd: crate::Simd,
        canvas: &mut Canvas<'_>,
        transform: &Transform,
    ) {
        let Some(screen) = canvas.object_screen(transform) else { return };
        if dispatch!(simd, simd => self.outline(simd, &screen, canvas)) {
            return canvas.fill(simd);
        }
        let mut clips = core::mem::take(&mut canvas.pen.clips);
        clips.clear();
        clips.extend(self.vertices.iter().map(|&p| screen.clip(p)));
        let is_known = |c: &Clip| c.is_finite() && (!c.is_in_front() || c.spot().is_finite());
        if clips.iter().all(is_known) && clips.iter().any(Clip::is_in_front) {
            self.draw_clipped(simd, &clips, &screen, canvas);
        }
        canvas.pen.clips = clips;
    }

    /// Outlines a body with the canvas's pen; `false`, and nothing, where a corner is not in front
    /// or a number is not finite.
    #[inline(always)]
    fn outline<S: Simd>(&self, simd: S, screen: &ObjectScreen, canvas: &mut Canvas<'_>) -> bool {
        let mut places = core::mem::take(&mut canvas.pen.places);
        let extent = place(simd, screen, self, &mut places);
        canvas.pen.outline.clear();
        if let Some(extent) = &extent {
            self.outline_placed(simd, screen, &places, extent, canvas);
        }
        canvas.pen.places = places;
        extent.is_some()
    }

    #[inline(always)]
    fn outline_placed<S: Simd>(
        &self,
        simd: S,
        screen: &ObjectScreen,
        places: &[Places],
        extent: &Extent,
        canvas: &mut Canvas<'_>,
    ) {
        let Extent { min, max, nearest, w } = *extent;
        let size = canvas.target.size;
        let last = size.each(|s| f64::from(s) - 1.0);
        if (0..2).any(|a| max[a] < 0.0 || min[a] > last[a] + 1.0) {
            return;
        }
        let reach = (min[0].abs().max(max[0].abs())).max(min[1].abs().max(max[1].abs()));
        let doubt = Doubt::within(&screen.error(self.reach), w, reach, nearest);
        let pixel = |v: f64, a: usize| v.max(0.0).min(last[a]) as u32;
        let nearest = ((nearest + doubt.nearness) * (1.0 + 2.0_f64.powi(-20))) as f32;
        let bounds = ScreenBounds {
            min: [pixel(min[0], 0), pixel(min[1], 1)],
            max: [pixel(max[0], 0), pixel(max[1], 1)],
            nearness: nearest,
        };
        if canvas.target.covers(simd, &bounds) {
            return;
        }
        let outline = &mut canvas.pen.outline;
        outline.begin(size, min, max, doubt.pixels);
        outline.come_no_nearer(nearest);
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
        // No area of three corners may be off by more.
        let slack = doubt.area_within(span);
        let mut seen = [0_u64; FACES / 64];
        for (word, faces) in self.spread.chunks(64).enumerate() {
            let mut bits = 0;
            for (face, corners) in faces.iter().enumerate() {
                let [a, b, c] = corners.each(spot);
                let area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
                bits |= u64::from(area * orient > slack) << face;
            }
            seen[word] = bits;
            for face in bits::ones(bits) {
                let corners = faces[face].each(spot);
                outline.plane(Plane::through(corners, span, size, &doubt));
            }
        }
        let is_seen = |face: u32| seen[face as usize / 64 % (FACES / 64)] >> (face % 64) & 1;
        for edges in self.edges.chunks(64) {
            let mut bits = 0;
            for (i, &[_, _, winds, other]) in edges.iter().enumerate() {
                bits |= (is_seen(winds) ^ is_seen(other)) << i;
            }
            while bits != 0 {
                let mut chunk = Edges::default();
                while bits != 0 && !chunk.is_full() {
                    let [from, to, winds, _] = edges[bits.trailing_zeros() as usize];
                    bits &= bits - 1;
                    let ends = if is_seen(winds) == 1 { [from, to] } else { [to, from] };
                    chunk.push(ends.each(spot));
                }
                outline.edges(simd, &chunk, orient);
            }
        }
    }

    /// One that crosses the near plane: each face by itself, since where the plane opens the body
    /// one looks through it.
    fn draw_clipped(
        &self,
        simd: crate::Simd,
        clips: &[Clip],
        screen: &ObjectScreen,
        canvas: &mut Canvas<'_>,
    ) {
        let orient = if screen.mirrored { 1.0 } else { -1.0 };
        let error = screen.error(self.reach);
        let (mut polygon, mut other) = (Vec::with_capacity(16), Vec::with_capacity(16));
        for face in 0..self.face_count() {
            let corners = self.face(face);
            polygon.clear();
            polygon.extend(corners.iter().map(|&v| clips[v as usize]));
            clip_near(&mut polygon, &mut other);
            let doubt = Doubt::of(&error, polygon.iter());
            let spots: Vec<Spot> = polygon.iter().map(Clip::spot).collect();
            draw_polygon(simd, &spots, orient, &doubt, canvas);
        }
    }
}

/// Draws a convex polygon by its own edges, where it winds as `orient` says.
fn draw_polygon(
    simd: crate::Simd,
    spots: &[Spot],
    orient: f64,
    doubt: &Doubt,
    canvas: &mut Canvas<'_>,
) {
    let size = canvas.target.size;
    let Some((min, max)) = on_screen(spots, size) else { return };
    // A clipped triangle has four corners at most; the largest fan triangle gives the plane.
    let fan = (1..spots.len().max(2) - 1).map(|k| [spots[0], spots[k], spots[k + 1]]);
    let Some(corners) = fan.max_by(|a, b| cross(*a).abs().total_cmp(&cross(*b).abs())) else {
        return;
    };
    if cross(corners) * orient <= doubt.area(corners) {
        return;
    }
    let reach = [max[0] - min[0], max[1] - min[1]];
    let plane = Plane::through(corners, reach, size, doubt);
    let outline = &mut canvas.pen.outline;
    outline.begin(size, min, max, doubt.pixels);
    outline.plane(plane);
    for k in 0..spots.len() {
        outline.edge(spots[k], spots[(k + 1) % spots.len()], orient);
    }
    canvas.fill(simd);
}

fn cross([a, b, c]: [Spot; 3]) -> f64 {
    (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)
}

/// The box around spots; `None` where it misses the screen, or a number is not finite.
fn on_screen(spots: &[Spot], size: [u32; 2]) -> Option<([f64; 2], [f64; 2])> {
    let (mut min, mut max) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for s in spots {
        (min, max) = ([min[0].min(s.x), min[1].min(s.y)], [max[0].max(s.x), max[1].max(s.y)]);
        if !(s.x.is_finite() && s.y.is_finite()) {
            return None;
        }
    }
    let [width, height] = size.each(f64::from);
    let on = max[0] >= -1.0 && max[1] >= -1.0 && min[0] <= width + 1.0 && min[1] <= height + 1.0;
    on.then_some((min, max))
}

/// The most faces, rounded up: a closed convex body of n corners has at most 2 n − 4.
const FACES: usize = Convex::MAX_VERTICES * 2;

/// Places a body's corners on the screen, eight at a time; `None` where one is not in front or not
/// finite.
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

/// A row at some points, in the order of [`ObjectScreen::clip`]. (No closure: what is not inlined
/// is compiled without the level's instructions.)
#[inline(always)]
fn sum<S: Simd>(simd: S, row: &DVec4, [x, y, z]: [S::f64s; 3]) -> S::f64s {
    x * S::f64s::splat(simd, row.x)
        + y * S::f64s::splat(simd, row.y)
        + z * S::f64s::splat(simd, row.z)
        + S::f64s::splat(simd, row.w)
}
