//! Cutting facets that reach before the near plane, or so far off the screen that f32 has no digits
//! for them.
//!
//! In f64, and always from the end that is inside, so that neighbours cut an edge that they share
//! alike. Only along the near plane does that make new silhouette edges: the guard band is beyond
//! the screen.

use alloc::vec::Vec;

use super::super::connected::{Connected, MOST_VERTICES, NUMBERS};
use super::super::screen::{Clip, ObjectScreen};
use super::Surface;
use super::projection::{GUARD, PLANES, Projection, UNUSABLE};
use crate::array::Each;
use crate::bits;

/// The most corners of what is left of a triangle.
const CORNERS: usize = 3 + PLANES;

/// Remains of facets that were cut; kept for its memory.
#[derive(Clone, Debug, Default)]
pub(super) struct Cut {
    /// How many vertices there are, those that were added included.
    vertices: usize,
    /// Whether a vertex could not be added, so that a facet or an edge is missing.
    is_full: bool,
    /// Remains of the facets that show their fronts, and of those that show their backs.
    sides: [CutSide; 2],
}

#[derive(Clone, Debug, Default)]
struct CutSide {
    /// Numbers of the facets that are drawn.
    facets: Vec<u16>,
    /// Triangles of what is left.
    triangles: Vec<[u16; 3]>,
    /// Edges along the near plane.
    near_edges: Vec<[u16; 2]>,
}

impl Cut {
    /// Forgets all, of a patch of so many vertices.
    pub(super) fn begin(&mut self, vertices: usize) {
        debug_assert!(vertices <= MOST_VERTICES);
        (self.vertices, self.is_full) = (vertices, false);
        for side in &mut self.sides {
            side.facets.clear();
            side.triangles.clear();
            side.near_edges.clear();
        }
    }
}

/// A polygon, and of each corner whether the edge to the next runs along the near plane.
#[derive(Clone, Copy)]
struct Polygon {
    corners: [(Clip, bool); CORNERS],
    count: usize,
}

impl Polygon {
    const NONE: Self = Self { corners: [(Clip::NONE, false); CORNERS], count: 0 };

    fn push(&mut self, corner: Clip, is_along: bool) {
        // One more for each plane is all that there can be.
        if let Some(next) = self.corners.get_mut(self.count) {
            *next = (corner, is_along);
            self.count += 1;
        }
    }

    fn corners(&self) -> &[(Clip, bool)] {
        &self.corners[..self.count]
    }
}

impl Projection {
    /// How far a point is within a plane, times something above 0.
    fn height(&self, c: &Clip, plane: usize) -> f64 {
        let [width, height] = self.size();
        match plane {
            0 => c.near,
            1 => c.x + GUARD * c.w,
            2 => (width + GUARD) * c.w - c.x,
            3 => c.y + GUARD * c.w,
            _ => (height + GUARD) * c.w - c.y,
        }
    }

    /// Where the edge between a point within a plane and one beyond meets it.
    fn meet(&self, inside: &Clip, outside: &Clip, plane: usize) -> Clip {
        let (p, q) = (self.height(inside, plane), self.height(outside, plane));
        let at = inside.mix(outside, p / (p - q));
        if plane == 0 { Clip { near: 0.0, ..at } } else { at }
    }

    /// Planes beyond which some points lie, a bit each, and those beyond which all do.
    fn beyond<'a>(&self, points: impl Iterator<Item = &'a Clip>) -> [u32; 2] {
        points.fold([0, u32::MAX], |[some, all], c| {
            let bit = |plane: usize| u32::from(self.height(c, plane) < 0.0) << plane;
            let code = (0..PLANES).fold(0, |code, plane| code | bit(plane));
            [some | code, all & code]
        })
    }

    /// Remains of a polygon, in place of what `left` was.
    fn cut(&self, polygon: &Polygon, plane: usize, left: &mut Polygon) {
        left.count = 0;
        let corners = polygon.corners();
        for (i, (a, is_along)) in corners.iter().enumerate() {
            let b = &corners[(i + 1) % corners.len()].0;
            let [a_in, b_in] = [a, b].each(|c| self.height(c, plane) >= 0.0);
            match (a_in, b_in) {
                (true, true) => left.push(*a, *is_along),
                (true, false) => {
                    left.push(*a, *is_along);
                    left.push(self.meet(a, b, plane), plane == 0);
                }
                (false, true) => left.push(self.meet(b, a, plane), *is_along),
                (false, false) => {}
            }
        }
    }

    /// Remains of an edge.
    fn cut_edge(&self, [mut a, mut b]: [Clip; 2]) -> Option<[Clip; 2]> {
        if self.beyond([a, b].iter())[1] != 0 {
            return None;
        }
        for plane in 0..PLANES {
            match [a, b].each(|c| self.height(&c, plane) >= 0.0) {
                [true, true] => {}
                [true, false] => b = self.meet(&a, &b, plane),
                [false, true] => a = self.meet(&b, &a, plane),
                [false, false] => return None,
            }
        }
        Some([a, b])
    }
}

/// A vertex of a patch before the divide.
fn clip(screen: &ObjectScreen, patch: &Connected, vertex: u16) -> Clip {
    let v = usize::from(vertex);
    screen.clip([patch.places[0][v], patch.places[1][v], patch.places[2][v]])
}

impl Surface {
    /// Cuts the facets that have a vertex which is NaN; `own` grows by where those of its own are.
    #[inline(never)]
    pub(super) fn cut_facets(
        &mut self,
        screen: &ObjectScreen,
        projection: &Projection,
        patch: &Connected,
        own: &mut [[f32; 2]; 2],
    ) {
        patch.for_groups(|kind, number, rows| {
            for lane in 0..rows[0].len() {
                let mut corners = [0; 4];
                for (corner, row) in corners.iter_mut().zip(rows) {
                    *corner = row[lane];
                }
                let corners = &corners[..rows.len()];
                let [mut some, mut all] = [0, !0];
                for &v in corners {
                    let code = self.codes[usize::from(v) % NUMBERS];
                    (some, all) = (some | code, all & code);
                }
                // What fills up a group has one corner throughout.
                if some & UNUSABLE != 0 && all & !UNUSABLE == 0 && corners[0] != corners[1] {
                    let own = if kind < 2 { Some(&mut *own) } else { None };
                    let all = corners.iter().map(|&v| clip(screen, patch, v));
                    let mut clips = [Clip::default(); 4];
                    clips.iter_mut().zip(all).for_each(|(to, c)| *to = c);
                    self.cut_facet(projection, &clips[..corners.len()], number + lane, own);
                }
            }
        });
    }

    /// A quad need not be flat: each of its triangles is cut by itself, and both must show one
    /// side.
    fn cut_facet(
        &mut self,
        projection: &Projection,
        corners: &[Clip],
        number: usize,
        own: Option<&mut [[f32; 2]; 2]>,
    ) {
        if !corners.iter().all(Clip::is_finite) {
            return;
        }
        let before = self.cut.vertices;
        let mut polygons = [[0_u16; CORNERS]; 2];
        let mut along = [0_u64; 2];
        let mut counts = [0; 2];
        let mut shown = None;
        for half in 0..corners.len() - 2 {
            let triangle = [0, 1 + half, 2 + half].each(|k| corners[k]);
            let [some, all] = projection.beyond(triangle.iter());
            if all != 0 {
                continue;
            }
            let (mut polygon, mut other) = (Polygon::NONE, Polygon::NONE);
            triangle.into_iter().for_each(|corner| polygon.push(corner, false));
            for plane in bits::ones(u64::from(some)) {
                projection.cut(&polygon, plane, &mut other);
                core::mem::swap(&mut polygon, &mut other);
            }
            if polygon.count < 3 {
                continue;
            }
            let vertices = &mut polygons[half][..polygon.count];
            for (i, (vertex, (corner, is_along))) in
                vertices.iter_mut().zip(polygon.corners()).enumerate()
            {
                along[half] |= u64::from(*is_along) << i;
                match self.put(corner) {
                    Some(number) => *vertex = number,
                    None => return,
                }
            }
            counts[half] = polygon.count;
            let side = self.side_of(&polygons[half][..polygon.count]);
            if side.is_none() || (shown.is_some() && shown != side) {
                self.cut.vertices = before;
                return;
            }
            shown = side;
        }
        let Some(is_clockwise) = shown else { return };
        let is_back = is_clockwise != projection.is_mirrored();
        let side = &mut self.cut.sides[usize::from(is_back)];
        side.facets.push(number as u16);
        let mut bounds = own;
        for half in 0..2 {
            let vertices = &polygons[half][..counts[half]];
            for i in 2..vertices.len() {
                let [a, b, c] = [vertices[0], vertices[i - 1], vertices[i]];
                side.triangles.push(if is_clockwise { [a, c, b] } else { [a, b, c] });
            }
            for i in bits::ones(along[half]) {
                side.near_edges.push([vertices[i], vertices[(i + 1) % vertices.len()]]);
            }
            if let Some([low, high]) = &mut bounds {
                for &v in vertices {
                    for (a, at) in self.spots.place(v).into_iter().enumerate() {
                        (low[a], high[a]) = (low[a].min(at), high[a].max(at));
                    }
                }
            }
        }
    }

    /// Whether a polygon runs clockwise on the screen, y upward; `None` where that is not certain.
    /// Corners are off by less than a twentieth of a pixel.
    fn side_of(&self, vertices: &[u16]) -> Option<bool> {
        let place = |i: usize| self.spots.place(vertices[i % vertices.len()]).each(f64::from);
        let (mut area, mut around) = (0.0, 0.0);
        let [ox, oy] = place(0);
        for i in 0..vertices.len() {
            let ([ux, uy], [vx, vy]) = (place(i), place(i + 1));
            area += (ux - ox) * (vy - oy) - (vx - ox) * (uy - oy);
            around += (ux - vx).abs() + (uy - vy).abs();
        }
        let is_certain = area.abs() > around * (around * 1e-12 + 0.2) + 0.1;
        // y grows downward: what runs counter-clockwise, y upward, has an area below 0.
        is_certain.then_some(area > 0.0)
    }

    /// Adds a projected vertex.
    fn put(&mut self, corner: &Clip) -> Option<u16> {
        let spot = corner.spot();
        let v = self.cut.vertices;
        if v >= NUMBERS || !(corner.w > 0.0 && spot.is_finite()) {
            self.cut.is_full = true;
            return None;
        }
        self.spots.put(v, spot.x as f32, spot.y as f32, spot.nearness as f32);
        self.cut.vertices += 1;
        Some(v as u16)
    }

    /// Draws what is left of the facets that show a side.
    #[inline(always)]
    pub(super) fn draw_cut<S: fearless_simd::Simd>(
        &mut self,
        simd: S,
        window: &super::Window,
        back: bool,
        target: &mut super::BlocksMut<'_>,
    ) {
        let side = usize::from(back);
        for i in 0..self.cut.sides[side].facets.len() {
            let number = usize::from(self.cut.sides[side].facets[i]) % NUMBERS;
            self.drawn[number] = u8::MAX;
        }
        let triangles = core::mem::take(&mut self.cut.sides[side].triangles);
        self.draw_triangles(simd, window, &triangles, target);
        self.cut.sides[side].triangles = triangles;
    }

    /// Cuts silhouette edges, and adds those along the near plane; `false` where there are not
    /// numbers enough.
    pub(super) fn cut_silhouettes(
        &mut self,
        screen: &ObjectScreen,
        projection: &Projection,
        patch: &Connected,
        back: bool,
        edges: &mut Vec<[u16; 2]>,
    ) -> bool {
        edges.retain_mut(|ends| {
            if ends.iter().all(|&v| !self.spots.place(v)[0].is_nan()) {
                return true;
            }
            let clips = ends.each(|v| clip(screen, patch, v));
            let Some(clips) = projection.cut_edge(clips) else { return false };
            let [Some(a), Some(b)] = [self.put(&clips[0]), self.put(&clips[1])] else {
                return false;
            };
            *ends = [a, b];
            true
        });
        edges.extend_from_slice(&self.cut.sides[usize::from(back)].near_edges);
        !self.cut.is_full
    }
}
