//! Drawing patches of a surface: which of their triangles show which side, and where those end.

use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch, f32x8, f64x4};
use glam::DVec4;

use super::ask::Footprint;
use super::band::Band;
use super::buffer::{OcclusionBuffer, TILE};
use super::cut::{Cuts, Guard};
use super::fringe::{Canvas, Kind, WIDTH};
use super::patch::{Patch, Side};
use super::piece::{self, Corners, Frame, LANES, Pieces, Spots};
use super::screen::{Clip, Doubt, ObjectScreen, Spot};
use crate::transform::Transform;

/// A patch on the screen; kept for its memory.
#[derive(Clone, Debug, Default)]
pub(super) struct Surface {
    x: Vec<f64>,
    y: Vec<f64>,
    nearness: Vec<f64>,
    spots: Spots,
    placed: Placed,
    cuts: Cuts,
    /// Of each group of faces those that show their front, a bit each, and those that show their back: of what was not
    /// cut, and of all.
    shown: Vec<[u32; 2]>,
    sides: Vec<[u32; 2]>,
    /// Where what shows its front ends, and what shows its back.
    ends: [Ends; 2],
}

/// Where faces that show one side end.
#[derive(Clone, Debug, Default)]
struct Ends {
    /// What is left of faces that were cut: of the patch itself, and of what is around it.
    own: Vec<[u32; 3]>,
    around: Vec<[u32; 3]>,
    borders: Vec<[u32; 2]>,
}

impl OcclusionBuffer {
    /// Draws a patch of a surface. Nothing where a number is not finite, and before
    /// [`begin`](Self::begin).
    pub fn draw_patch(&mut self, level: Level, patch: &Patch, transform: &Transform) {
        self.band().draw_patch(level, patch, transform);
    }
}

impl Band<'_> {
    /// Draws what lies in it of a patch of a surface, as [`OcclusionBuffer::draw_patch`] does.
    pub fn draw_patch(&mut self, level: Level, patch: &Patch, transform: &Transform) {
        let Some(screen) = self.object_screen(transform) else { return };
        let error = screen.error(patch.reach);
        let ahead = Ahead::of(&screen, patch, &error);
        if ahead.as_ref().is_some_and(|a| self.is_box_covered(a)) {
            return;
        }
        let mut surface = std::mem::take(&mut self.pen.surface);
        surface.place(level, patch, &screen);
        self.draw_surface(level, patch, &screen, &error, ahead.as_ref(), &mut surface);
        self.pen.surface = surface;
    }

    /// Whether nothing within the box around a patch can add to the buffer.
    fn is_box_covered(&self, ahead: &Ahead) -> bool {
        let Ahead { low, high, nearness, doubt } = *ahead;
        let near = (nearness + doubt.nearness) * (1.0 + 2.0_f64.powi(-20));
        let out = |v: f64, by: f64| (v + by * (doubt.pixels + 1.0 / 64.0)).floor() as i32;
        let window = [low.map(|v| out(v, -1.0)), high.map(|v| out(v, 1.0))];
        near.is_finite() && self.is_covered(window, near as f32)
    }

    /// Whether nothing at most so near can add to the pixels of a window: no need to draw it.
    pub(super) fn is_covered(&self, [min, max]: [[i32; 2]; 2], nearest: f32) -> bool {
        let last = self.size.map(|s| s as i32 - 1);
        if (0..2).any(|a| max[a] < 0 || min[a] > last[a]) {
            return true;
        }
        let pixel = |v: i32, a: usize| v.clamp(0, last[a]) as u32;
        let footprint = Footprint {
            min: [pixel(min[0], 0), pixel(min[1], 1)],
            max: [pixel(max[0], 0), pixel(max[1], 1)],
            nearness: nearest,
        };
        self.as_tiles().first_open(&footprint).is_none()
    }

    fn draw_surface(
        &mut self,
        level: Level,
        patch: &Patch,
        screen: &ObjectScreen,
        error: &Clip,
        ahead: Option<&Ahead>,
        surface: &mut Surface,
    ) {
        let guard = Guard::of(self.size);
        let Some(extent) = surface.extent(patch, &guard, screen, error) else { return };
        let last = self.size.map(|s| f64::from(s) - 1.0);
        let [mut low, mut high] = extent.own;
        if let Some(ahead) = ahead {
            for a in 0..2 {
                (low[a], high[a]) = (low[a].max(ahead.low[a]), high[a].min(ahead.high[a]));
            }
        }
        if (0..2).any(|a| high[a] < 0.0 || low[a] > last[a] + 1.0) {
            return;
        }
        let block = [WIDTH as f64, TILE as f64];
        let base = [0, 1].map(|a| (low[a].max(0.0).min(last[a]) / block[a]).floor());
        let from = [base[0] * block[0], base[1] * block[1]];
        let window = [
            low[0].floor().max(0.0) - from[0],
            low[1].floor().max(0.0) - from[1],
            high[0].floor().min(last[0]) - from[0],
            high[1].floor().min(last[1]) - from[1],
        ];
        let [low, high] = extent.all;
        let span = (0..2).map(|a| (high[a] - from[a]).max(from[a] - low[a])).fold(0.0, f64::max);
        let span = window.iter().fold(span, |s, v| s.max(*v));
        let doubt = extent.doubt;
        let frame = Frame {
            nearest: ahead.map_or(f32::INFINITY, |a| a.nearness as f32),
            ..Frame::new(doubt.pixels, doubt.nearness, span, window.map(|v| v as f32))
        };
        let orient = if screen.mirrored { 1.0 } else { -1.0 };

        let rows = self.rows.map(|r| r as i32);
        let Self { size: [width, height], columns, tiles, far, live, pen, .. } = self;
        let mut canvas = Canvas {
            size: [*width, *height - (rows[0] * TILE as i32) as u32],
            columns: *columns,
            rows: rows[1] - rows[0],
            tiles,
            far,
            live,
            fringes: &mut pen.fringes,
            base: [base[0] as i32, base[1] as i32 - rows[0]],
            nearest: 0.0,
        };
        dispatch!(level, simd => {
            canvas.nearest = surface.round(from);
            surface.faces(simd, &frame, patch, orient, &mut canvas);
            surface.end(&frame, patch, orient);
            for (side, ends) in surface.ends.iter().enumerate() {
                let sign = if side == 0 { orient } else { -orient };
                ends.draw(simd, &frame, &surface.spots, sign, &mut canvas, side);
            }
        });
    }
}

/// The box around a patch, where it lies in front of the near plane. Nothing of a patch is drawn beside its box
/// or nearer, though the triangles around it may be there: so where its box is hidden, drawing it changes no
/// bit, in any band.
struct Ahead {
    low: [f64; 2],
    high: [f64; 2],
    nearness: f64,
    doubt: Doubt,
}

impl Ahead {
    fn of(screen: &ObjectScreen, patch: &Patch, error: &Clip) -> Option<Self> {
        let corners = patch.bounds().corners().map(|p| screen.clip(p));
        if !corners.iter().all(|c| c.is_in_front() && c.is_finite()) {
            return None;
        }
        let doubt = Doubt::of(error, corners.iter());
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let mut nearness = 0.0_f64;
        for s in corners.iter().map(Clip::spot) {
            low = [low[0].min(s.x), low[1].min(s.y)];
            high = [high[0].max(s.x), high[1].max(s.y)];
            nearness = nearness.max(s.nearness);
        }
        Some(Self { low, high, nearness, doubt })
    }
}

/// Where vertices are on the screen, all of which are in front of the near plane.
#[derive(Clone, Copy, Debug, Default)]
struct Placed {
    /// The least height over the near plane; below zero where a number is not finite.
    near: f64,
    /// The least w.
    w: f64,
    nearest: f64,
    /// The least and the most of the places of those of its own triangles, and a few more, and of all.
    own: [[f64; 2]; 2],
    all: [[f64; 2]; 2],
}

/// How far a patch reaches on the screen.
struct Extent {
    /// The least and the most of the places of its own triangles, and of all.
    own: [[f64; 2]; 2],
    all: [[f64; 2]; 2],
    doubt: Doubt,
}

impl Surface {
    /// Takes all vertices to the screen; of those that are not in front of the near plane come numbers without
    /// meaning.
    fn place(&mut self, level: Level, patch: &Patch, screen: &ObjectScreen) {
        let count = patch.places[0].len();
        for out in [&mut self.x, &mut self.y, &mut self.nearness] {
            out.clear();
            out.resize(count, 0.0);
        }
        self.cuts.clear();
        let Self { x, y, nearness, .. } = self;
        self.placed = dispatch!(level, simd => place(simd, screen, patch, [x, y, nearness]));
    }

    /// Measures what was placed, after cutting what reaches beyond the near plane or far beyond the
    /// screen. `None` where a number is not finite.
    fn extent(
        &mut self,
        patch: &Patch,
        guard: &Guard,
        screen: &ObjectScreen,
        error: &Clip,
    ) -> Option<Extent> {
        let Placed { near, w, nearest, own, all: [low, high] } = self.placed;
        // Not true either where a number is none.
        let is_whole = near >= 0.0
            && w >= f64::MIN_POSITIVE
            && nearest.is_finite()
            && (0..2).all(|k| guard.holds([low[k], high[k]]));
        if is_whole {
            let far = low.into_iter().chain(high).fold(0.0_f64, |m, v| m.max(v.abs()));
            let doubt = Doubt::within(error, w, far, nearest);
            return Some(Extent { own, all: [low, high], doubt });
        }
        let Self { x, y, nearness, cuts, .. } = self;
        cuts.make(patch, screen, guard)?;
        for out in [&mut *x, &mut *y, &mut *nearness] {
            out.clear();
        }
        let mut all = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        for clip in &cuts.clips {
            // What is cut off has no place; a comparison with it is never true.
            let Spot { x: px, y: py, nearness: pn } = clip.map_or(Spot::NONE, |c| c.spot());
            x.push(px);
            y.push(py);
            nearness.push(pn);
            if clip.is_some() {
                all = [
                    [all[0][0].min(px), all[0][1].min(py)],
                    [all[1][0].max(px), all[1][1].max(py)],
                ];
            }
        }
        // What is cut is off by a little more than its ends.
        let doubt = Doubt::of(error, cuts.clips.iter().flatten());
        let doubt = Doubt { pixels: doubt.pixels * 4.0, nearness: doubt.nearness * 4.0 };
        Some(Extent { own: all, all, doubt })
    }

    /// Rounds places, relative to a pixel; gives the nearest.
    #[inline(always)]
    fn round(&mut self, from: [f64; 2]) -> f32 {
        let Self { x, y, nearness, spots, .. } = self;
        spots.clear();
        spots.x.extend(x.iter().map(|v| (v - from[0]) as f32));
        spots.y.extend(y.iter().map(|v| (v - from[1]) as f32));
        spots.nearness.extend(nearness.iter().map(|v| *v as f32));
        spots.nearness.iter().fold(0.0, |most, &n| if n > most { n } else { most })
    }

    /// Draws the faces that were not cut, each to the sheet of the side that it shows.
    #[inline(always)]
    fn faces<S: Simd>(
        &mut self,
        simd: S,
        frame: &Frame,
        patch: &Patch,
        orient: f32,
        canvas: &mut Canvas<'_>,
    ) {
        let Self { spots, shown, .. } = self;
        shown.clear();
        let zero = f32x8::splat(simd, 0.0);
        let orient = f32x8::splat(simd, orient);
        for (group, [a, b, c]) in patch.faces.iter().enumerate() {
            let corners = [spots.gather(simd, a), spots.gather(simd, b), spots.gather(simd, c)];
            let (area, slack) = piece::areas(frame, &corners);
            let area = area * orient;
            let is_front = area.simd_gt(slack);
            let front = is_front.to_bitmask() as u32;
            let back = (area + slack).simd_lt(zero).to_bitmask() as u32;
            shown.push([front, back]);
            let back = if patch.two_sided { back } else { 0 };
            if front | back == 0 {
                continue;
            }
            let pieces = Pieces::triangles(simd, frame, &corners, is_front.select(orient, -orient));
            let kind = if group < patch.own_faces { Kind::Own } else { Kind::Around };
            canvas.draw(simd, &pieces, front, 0, kind);
            canvas.draw(simd, &pieces, back, 1, kind);
        }
    }

    /// Finds what is left of the faces that were cut, and where each side ends.
    fn end(&mut self, frame: &Frame, patch: &Patch, orient: f32) {
        let Self { spots, cuts, shown, sides, ends: all, .. } = self;
        sides.clone_from(shown);
        for ends in all.iter_mut() {
            ends.own.clear();
            ends.around.clear();
            ends.borders.clear();
        }
        cuts.sort(frame, spots, orient, |face, side, pieces, near| {
            let [front, back] = &mut sides[face / LANES];
            match side {
                Side::Front => *front |= 1 << (face % LANES),
                Side::Back => *back |= 1 << (face % LANES),
                Side::Neither => {}
            }
            if let Some(ends) = side.of(all, patch.two_sided) {
                let is_own = face < patch.own_faces * LANES;
                if is_own { &mut ends.own } else { &mut ends.around }.extend(pieces);
                ends.borders.extend(near);
            }
        });
        let side_of = |t: u32| match sides.get(t as usize / LANES) {
            Some([front, back]) => {
                let lane = t as usize % LANES;
                Side::of_bits(front >> lane & 1, back >> lane & 1)
            }
            None => Side::Neither,
        };
        for (number, &[a, b, one, other]) in patch.edges.iter().enumerate() {
            let (one, other) = (side_of(one), side_of(other));
            if one == other {
                continue;
            }
            let Some(edge) = cuts.edge(number, [a, b]) else { continue };
            for side in [one, other] {
                if let Some(ends) = side.of(all, patch.two_sided) {
                    ends.borders.push(edge);
                }
            }
        }
    }
}

impl Side {
    fn of_bits(front: u32, back: u32) -> Self {
        match (front, back) {
            (1, _) => Self::Front,
            (_, 1) => Self::Back,
            _ => Self::Neither,
        }
    }

    /// Where this side ends, if it is drawn at all.
    fn of(self, [front, back]: &mut [Ends; 2], two_sided: bool) -> Option<&mut Ends> {
        match self {
            Self::Front => Some(front),
            Self::Back => two_sided.then_some(back),
            Self::Neither => None,
        }
    }
}

impl Ends {
    /// Draws what is left of faces that were cut and where the side ends, and takes what its sheet proves.
    #[inline(always)]
    fn draw<S: Simd>(
        &self,
        simd: S,
        frame: &Frame,
        spots: &Spots,
        sign: f32,
        canvas: &mut Canvas<'_>,
        side: usize,
    ) {
        let sign = f32x8::splat(simd, sign);
        for (faces, kind) in [(&self.own, Kind::Own), (&self.around, Kind::Around)] {
            for some in faces.chunks(LANES) {
                let pieces = Pieces::triangles(simd, frame, &corners(simd, spots, some), sign);
                canvas.draw(simd, &pieces, first(some.len()), side, kind);
            }
        }
        if canvas.is_blank(side) {
            return;
        }
        for some in self.borders.chunks(LANES) {
            let pieces = Pieces::borders(simd, frame, spots, lanes(some));
            canvas.draw(simd, &pieces, first(some.len()), side, Kind::Border);
        }
        simd.vectorize(
            #[inline(always)]
            || canvas.take_fringe(simd, side),
        );
    }
}

#[inline(always)]
fn corners<S: Simd>(simd: S, spots: &Spots, triangles: &[[u32; 3]]) -> Corners<S> {
    let [a, b, c] = lanes(triangles);
    [spots.gather(simd, &a), spots.gather(simd, &b), spots.gather(simd, &c)]
}

/// A bit for each of the first few.
fn first(count: usize) -> u32 {
    (1 << count) - 1
}

/// The first corners of some things, the second, and so on; the last fills what is left.
#[inline(always)]
fn lanes<const N: usize>(of: &[[u32; N]]) -> [[u32; LANES]; N] {
    let mut lanes = [[0; LANES]; N];
    for lane in 0..LANES {
        let one = of[lane.min(of.len() - 1)];
        for (lanes, v) in lanes.iter_mut().zip(one) {
            lanes[lane] = v;
        }
    }
    lanes
}

/// Takes vertices to the screen.
#[inline(always)]
fn place<S: Simd>(
    simd: S,
    screen: &ObjectScreen,
    patch: &Patch,
    [out_x, out_y, out_n]: [&mut [f64]; 3],
) -> Placed {
    let rows = screen.rows();
    let splat = |v: f64| f64x4::splat(simd, v);
    let (mut least_near, mut least_w) = (splat(f64::INFINITY), splat(f64::INFINITY));
    let mut nothing = splat(0.0);
    let (mut low, mut high) = ([least_w; 2], [-least_w; 2]);
    let (mut nearest, mut own) = (high[0], [[0.0; 2]; 2]);
    let [xs, ys, zs] = &patch.places;
    for at in (0..xs.len()).step_by(LANES) {
        let axis = |from: &[f32]| f32x8::from_slice(simd, &from[at..at + LANES]).widen();
        let (x, y, z) = (axis(xs), axis(ys), axis(zs));
        for (half, (x, y, z)) in [(x.0, y.0, z.0), (x.1, y.1, z.1)].into_iter().enumerate() {
            let row = |r: &DVec4| x * r.x + y * r.y + z * r.z + splat(r.w);
            let (cx, cy, cn) = (row(&rows[0]), row(&rows[1]), row(&rows[2]));
            let (near, w) = (row(&rows[3]), row(&rows[4]));
            let inverse = splat(1.0) / w;
            let (px, py, pn) = (cx * inverse, cy * inverse, cn * inverse);
            let at = at + half * 4..at + half * 4 + 4;
            px.store_slice(&mut out_x[at.clone()]);
            py.store_slice(&mut out_y[at.clone()]);
            pn.store_slice(&mut out_n[at]);
            low = [low[0].min(px), low[1].min(py)];
            high = [high[0].max(px), high[1].max(py)];
            nearest = nearest.max(pn);
            least_near = least_near.min(near);
            least_w = least_w.min(w);
            // 0 · v is 0 for numbers alone.
            nothing += (cx + cy) * splat(0.0) + (cn + near + w) * splat(0.0);
        }
        if at < patch.own_vertices {
            own = [low.map(f64x4::reduce_min), high.map(f64x4::reduce_max)];
        }
    }
    let is_finite = nothing.simd_eq(splat(0.0)).all_true();
    Placed {
        near: if is_finite { least_near.reduce_min() } else { f64::NEG_INFINITY },
        w: least_w.reduce_min(),
        nearest: nearest.reduce_max(),
        own,
        all: [low.map(f64x4::reduce_min), high.map(f64x4::reduce_max)],
    }
}
