//! Surfaces: connected triangles on the screen, which of them show which side, and where those end.

use fearless_simd::prelude::*;
use fearless_simd::{dispatch, f32x8, f64x4};
use glam::DVec4;

use super::bounds::ScreenBounds;
use super::clip::{Clipped, Guard};
use super::connected::{Connected, Side};
use super::primitives::{self, Corners, LANES, Primitives, Setup, Spots};
use super::screen::{Clip, Doubt, ObjectScreen, Spot};
use super::shared_edges::{Canvas, Kind, SharedCoverage, WIDTH};
use super::tile::TILE;
use super::tiles::TilesMut;

/// A surface on the screen; kept for its memory.
#[derive(Clone, Debug, Default)]
pub(super) struct Surface {
    x: Vec<f64>,
    y: Vec<f64>,
    nearness: Vec<f64>,
    spots: Spots,
    placed: Placed,
    clipped: Clipped,
    /// Of each group of triangles those that show their front, a bit each, and those that show their back: of what was
    /// not clipped, and of all.
    shown: Vec<[u32; 2]>,
    sides: Vec<[u32; 2]>,
    /// Where what shows its front ends, and what shows its back.
    ends: [Ends; 2],
}

/// Ends of the triangles that show one side.
#[derive(Clone, Debug, Default)]
struct Ends {
    /// Remains of triangles that were clipped: of the surface's own, and of those around.
    own: Vec<[u32; 3]>,
    around: Vec<[u32; 3]>,
    /// Silhouette edges.
    edges: Vec<[u32; 2]>,
}

impl Surface {
    /// Draws connected triangles.
    pub(super) fn draw(
        &mut self,
        level: crate::Simd,
        mesh: &Connected,
        screen: &ObjectScreen,
        target: TilesMut<'_>,
        coverage: &mut [SharedCoverage; 2],
    ) {
        let error = screen.error(mesh.reach);
        let front = FrontBox::of(screen, mesh, &error);
        if front.as_ref().is_some_and(|b| b.is_covered(level, &target)) {
            return;
        }
        self.place(level, mesh, screen);
        let guard = Guard::of(target.size);
        let Some(extent) = self.extent(mesh, &guard, screen, &error) else { return };
        let last = target.size.map(|s| f64::from(s) - 1.0);
        let [mut low, mut high] = extent.own;
        if let Some(front) = &front {
            for a in 0..2 {
                (low[a], high[a]) = (low[a].max(front.low[a]), high[a].min(front.high[a]));
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
        let setup = Setup {
            nearest: front.as_ref().map_or(f32::INFINITY, |b| b.nearness as f32),
            ..Setup::new(doubt.pixels, doubt.nearness, span, window.map(|v| v as f32))
        };
        let orient = if screen.mirrored { 1.0 } else { -1.0 };

        let first = target.rows[0] as i32;
        let base = [base[0] as i32, base[1] as i32 - first];
        let mut canvas = Canvas { target, coverage, base, nearest: 0.0 };
        dispatch!(level.0, simd => {
            canvas.nearest = self.round(from);
            self.draw_whole(simd, &setup, mesh, orient, &mut canvas);
            self.end(&setup, mesh, orient);
            for (side, ends) in self.ends.iter().enumerate() {
                let sign = if side == 0 { orient } else { -orient };
                ends.draw(simd, &setup, &self.spots, sign, &mut canvas, side);
            }
        });
    }
}

/// The box around a surface's own triangles on the screen, where it lies in front of the near plane. Nothing of the surface
/// is drawn beside it or nearer, though the triangles around may be there: so where the box is hidden, drawing changes no
/// bit, in any band.
struct FrontBox {
    low: [f64; 2],
    high: [f64; 2],
    nearness: f64,
    doubt: Doubt,
}

impl FrontBox {
    fn of(screen: &ObjectScreen, mesh: &Connected, error: &Clip) -> Option<Self> {
        let corners = mesh.bounds.corners().map(|p| screen.clip(p));
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

    /// Whether nothing within the box can add to what is there.
    fn is_covered(&self, level: crate::Simd, target: &TilesMut<'_>) -> bool {
        let Self { low, high, nearness, doubt } = *self;
        let near = (nearness + doubt.nearness) * (1.0 + 2.0_f64.powi(-20));
        let out = |v: f64, by: f64| (v + by * (doubt.pixels + 1.0 / 64.0)).floor() as i32;
        let [min, max] = [low.map(|v| out(v, -1.0)), high.map(|v| out(v, 1.0))];
        if !near.is_finite() {
            return false;
        }
        let last = target.size.map(|s| s as i32 - 1);
        if (0..2).any(|a| max[a] < 0 || min[a] > last[a]) {
            return true;
        }
        let pixel = |v: i32, a: usize| v.clamp(0, last[a]) as u32;
        let bounds = ScreenBounds {
            min: [pixel(min[0], 0), pixel(min[1], 1)],
            max: [pixel(max[0], 0), pixel(max[1], 1)],
            nearness: near as f32,
        };
        dispatch!(level.0, simd => target.read().covers(simd, &bounds))
    }
}

/// Extent of vertices on the screen, all of which are in front of the near plane.
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

/// Extent of a surface on the screen.
struct Extent {
    /// The least and the most of the places of its own triangles, and of all.
    own: [[f64; 2]; 2],
    all: [[f64; 2]; 2],
    doubt: Doubt,
}

impl Surface {
    /// Takes all vertices to the screen; of those that are not in front of the near plane come numbers without
    /// meaning.
    fn place(&mut self, level: crate::Simd, mesh: &Connected, screen: &ObjectScreen) {
        let count = mesh.places[0].len();
        for out in [&mut self.x, &mut self.y, &mut self.nearness] {
            out.clear();
            out.resize(count, 0.0);
        }
        self.clipped.clear();
        let Self { x, y, nearness, .. } = self;
        self.placed = dispatch!(level.0, simd => place(simd, screen, mesh, [x, y, nearness]));
    }

    /// Measures what was placed, after clipping what reaches beyond the near plane or far beyond the
    /// screen. `None` where a number is not finite.
    fn extent(
        &mut self,
        mesh: &Connected,
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
        let Self { x, y, nearness, clipped, .. } = self;
        clipped.make(mesh, screen, guard)?;
        for out in [&mut *x, &mut *y, &mut *nearness] {
            out.clear();
        }
        let mut all = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        for clip in &clipped.clips {
            // A vertex that is clipped off has no place; a comparison with it is never true.
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
        // Points on a clipped edge are off by a little more than its ends.
        let doubt = Doubt::of(error, clipped.clips.iter().flatten());
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

    /// Draws the triangles that were not clipped, each to the side that it shows.
    #[inline(always)]
    fn draw_whole<S: Simd>(
        &mut self,
        simd: S,
        setup: &Setup,
        mesh: &Connected,
        orient: f32,
        canvas: &mut Canvas<'_>,
    ) {
        let Self { spots, shown, .. } = self;
        shown.clear();
        let zero = f32x8::splat(simd, 0.0);
        let orient = f32x8::splat(simd, orient);
        for (group, [a, b, c]) in mesh.groups.iter().enumerate() {
            let corners = [spots.gather(simd, a), spots.gather(simd, b), spots.gather(simd, c)];
            let (area, slack) = primitives::areas(setup, &corners);
            let area = area * orient;
            let is_front = area.simd_gt(slack);
            let front = is_front.to_bitmask() as u32;
            let back = (area + slack).simd_lt(zero).to_bitmask() as u32;
            shown.push([front, back]);
            let back = if mesh.two_sided { back } else { 0 };
            if front | back == 0 {
                continue;
            }
            let all =
                Primitives::triangles(simd, setup, &corners, is_front.select(orient, -orient));
            let kind = if group < mesh.own_groups { Kind::Own } else { Kind::Around };
            canvas.draw(simd, &all, front, 0, kind);
            canvas.draw(simd, &all, back, 1, kind);
        }
    }

    /// Finds what is left of the triangles that were clipped, and where each side ends.
    fn end(&mut self, setup: &Setup, mesh: &Connected, orient: f32) {
        let Self { spots, clipped, shown, sides, ends: all, .. } = self;
        sides.clone_from(shown);
        for ends in all.iter_mut() {
            ends.own.clear();
            ends.around.clear();
            ends.edges.clear();
        }
        clipped.sort(setup, spots, orient, |triangle, side, remains, near| {
            let [front, back] = &mut sides[triangle / LANES];
            match side {
                Side::Front => *front |= 1 << (triangle % LANES),
                Side::Back => *back |= 1 << (triangle % LANES),
                Side::Neither => {}
            }
            if let Some(ends) = side.of(all, mesh.two_sided) {
                let is_own = triangle < mesh.own_groups * LANES;
                if is_own { &mut ends.own } else { &mut ends.around }.extend(remains);
                ends.edges.extend(near);
            }
        });
        let side_of = |t: u32| match sides.get(t as usize / LANES) {
            Some([front, back]) => {
                let lane = t as usize % LANES;
                Side::of_bits(front >> lane & 1, back >> lane & 1)
            }
            None => Side::Neither,
        };
        for (number, &[a, b, one, other]) in mesh.edges.iter().enumerate() {
            let (one, other) = (side_of(one), side_of(other));
            if one == other {
                continue;
            }
            let Some(edge) = clipped.edge(number, [a, b]) else { continue };
            for side in [one, other] {
                if let Some(ends) = side.of(all, mesh.two_sided) {
                    ends.edges.push(edge);
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
    /// Draws what is left of triangles that were clipped and the silhouette edges, and takes what is proved of the side.
    #[inline(always)]
    fn draw<S: Simd>(
        &self,
        simd: S,
        setup: &Setup,
        spots: &Spots,
        sign: f32,
        canvas: &mut Canvas<'_>,
        side: usize,
    ) {
        let sign = f32x8::splat(simd, sign);
        for (triangles, kind) in [(&self.own, Kind::Own), (&self.around, Kind::Around)] {
            for some in triangles.chunks(LANES) {
                let all = Primitives::triangles(simd, setup, &corners(simd, spots, some), sign);
                canvas.draw(simd, &all, first(some.len()), side, kind);
            }
        }
        if canvas.is_blank(side) {
            return;
        }
        for some in self.edges.chunks(LANES) {
            let all = Primitives::silhouettes(simd, setup, spots, lanes(some));
            canvas.draw(simd, &all, first(some.len()), side, Kind::Silhouette);
        }
        simd.vectorize(
            #[inline(always)]
            || canvas.take(simd, side),
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

/// The first corners of some triangles or edges, the second, and so on; the last fills what is left.
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
    mesh: &Connected,
    [out_x, out_y, out_n]: [&mut [f64]; 3],
) -> Placed {
    let rows = screen.rows();
    let splat = |v: f64| f64x4::splat(simd, v);
    let (mut least_near, mut least_w) = (splat(f64::INFINITY), splat(f64::INFINITY));
    let mut nothing = splat(0.0);
    let (mut low, mut high) = ([least_w; 2], [-least_w; 2]);
    let (mut nearest, mut own) = (high[0], [[0.0; 2]; 2]);
    let [xs, ys, zs] = &mesh.places;
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
        if at < mesh.own_vertices {
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
