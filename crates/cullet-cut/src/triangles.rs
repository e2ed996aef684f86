//! The pass over the triangles, and the planes one after another on those few that they touch.
//!
//! Triangles that the planes leave alone are copied or dropped in one pass. The others go through
//! the planes in order, each plane's cap with them: so the caps of several planes share the edges
//! where they meet like any other two triangles. A triangle is dropped at the first plane that it
//! is not inside of; one that is outside of a later plane only must stay until then, for an earlier
//! plane may cut it, and the cap of that one would have a gap.

use cullet::exact;

use crate::hash::{QuickMap, key};
use crate::options::{CutInput, CutOptions, Keep};
use crate::result::{Cap, CutMesh, NO_ORIGIN};
use crate::sides::{CutPlane, Sides, before};
use crate::{cap, section};

/// How often duplicates are looked through for those that may go.
const MOST_PASSES: usize = 64;

/// No vertex of the result.
const DROPPED: u32 = u32::MAX;

/// A triangle that planes touch. Vertices from the number of those of the input on are new.
#[derive(Clone, Copy, Debug)]
struct CutTriangle {
    corners: [u32; 3],
    origin: u32,
    /// The plane of the cap that it is of.
    cap: Option<u8>,
}

/// Polygon that a plane cut off, where that is kept: a corner where the triangle leaves the inside,
/// corners outside, and the corner where it comes back. Later planes may divide the edge from the
/// last to the first, for the other half has it too.
#[derive(Clone, Copy, Debug)]
struct Removed {
    corners: [u32; 4],
    origin: u32,
    len: u8,
    plane: u8,
    on: On,
}

/// Edges of what was cut off that lie in the plane, so that later planes may divide them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum On {
    None,
    Last,
    All,
}

/// An edge that a plane cut, known by its positions.
#[derive(Clone, Copy, Debug)]
struct CutAt {
    vertex: u32,
    plane: u8,
    /// The one before it between the same positions, in [`Work::cut_list`].
    before: u32,
}

struct Work<'a> {
    input: &'a CutInput<'a>,
    planes: &'a [CutPlane],
    sides: &'a Sides,
    options: &'a CutOptions,
    positions: Vec<[f32; 3]>,
    attributes: Vec<f32>,
    /// The new vertex of each edge that was cut, by its ends.
    cuts: QuickMap<[u32; 2], u32>,
    /// The same by the positions of its ends, where the outside of several planes is kept: the two
    /// sides of an edge in a plane may have vertices of their own. The latest in `cut_list`.
    cuts_at: QuickMap<[[u32; 3]; 2], u32>,
    cut_list: Vec<CutAt>,
    walls: Vec<CutTriangle>,
    caps: Vec<CutTriangle>,
    removed: Vec<Removed>,
    /// The edges of what was removed that lie in the plane, in its direction.
    edges: Vec<[u32; 2]>,
    result: CutMesh,
}

/// Cuts. Everything has been checked.
pub(crate) fn run(
    input: &CutInput<'_>,
    planes: &[CutPlane],
    sides: &Sides,
    options: &CutOptions,
) -> CutMesh {
    let mut work = Work {
        input,
        planes,
        sides,
        options,
        positions: Vec::new(),
        attributes: Vec::new(),
        cuts: QuickMap::default(),
        cuts_at: QuickMap::default(),
        cut_list: Vec::new(),
        walls: Vec::new(),
        caps: Vec::new(),
        removed: Vec::new(),
        edges: Vec::new(),
        result: CutMesh::default(),
    };
    let place = work.keep_vertices();
    work.sort_triangles(planes, &place);
    work.result.report.cut_triangles = work.walls.len();
    if options.caps.is_some() {
        work.drop_duplicates();
    }
    for (number, plane) in planes.iter().enumerate() {
        work.step(number, plane);
    }
    work.finish(&place);
    work.result
}

impl Work<'_> {
    /// Copies the vertices that stay, and returns where each went.
    fn keep_vertices(&mut self) -> Vec<u32> {
        let Sides { outside, on } = self.sides;
        let stays = |v: usize| match self.options.keep {
            Keep::Inside => outside[v] == 0,
            Keep::Outside => outside[v] != 0 || on.get(v).is_some_and(|&on| on != 0),
        };
        let count = outside.len();
        let mut place = vec![DROPPED; count];
        let mut v = 0;
        while v < count {
            if !stays(v) {
                v += 1;
                continue;
            }
            let (first, to) = (v, self.result.positions.len() as u32);
            while v < count && stays(v) {
                place[v] = to + (v - first) as u32;
                v += 1;
            }
            self.result.positions.extend_from_slice(&self.input.positions[first..v]);
            let stride = self.input.stride;
            let attributes = &self.input.attributes[first * stride..v * stride];
            self.result.attributes.extend_from_slice(attributes);
        }
        place
    }

    /// Copies the triangles that stay as they are, and gathers those that planes touch.
    fn sort_triangles(&mut self, planes: &[CutPlane], place: &[u32]) {
        let Sides { outside, on } = self.sides;
        let inside = self.options.keep == Keep::Inside;
        // An open cut to the inside needs nothing of a triangle that any plane rejects.
        let any_rejects = inside && self.options.caps.is_none();
        let (indices, origin) = (&mut self.result.indices, &mut self.result.origin);
        let all = self.input.indices;
        // Runs of triangles that stay are copied at once: that is most of the work.
        let mut copy = |from: usize, to: usize| {
            indices.extend(all[from * 3..to * 3].iter().map(|&v| place[v as usize]));
            origin.extend(from as u32..to as u32);
        };
        let mut run = 0;
        for (t, corners) in all.chunks_exact(3).enumerate() {
            let corners = [corners[0], corners[1], corners[2]];
            let [a, b, c] = corners.map(|v| outside[v as usize]);
            let any = a | b | c;
            let mut touched = any != 0;
            let mut keep = inside && !touched;
            if touched {
                let all = a & b & c;
                let first = any.trailing_zeros();
                if all >> first & 1 == 1 {
                    (touched, keep) = (false, !inside);
                } else if any_rejects && all != 0 {
                    touched = false;
                }
            }
            if !on.is_empty() {
                let [a, b, c] = corners.map(|v| on[v as usize]);
                if a & b & c != 0 {
                    // On a plane, perhaps on its far side.
                    let points = corners.map(|v| self.input.positions[v as usize]);
                    let faces = |(i, plane): (usize, &CutPlane)| {
                        (a & b & c) >> i & 1 == 1 && faces_into(plane, &points)
                    };
                    if planes.iter().enumerate().any(faces) {
                        (touched, keep) = (true, false);
                    }
                }
            }
            if keep {
                continue;
            }
            if run < t {
                copy(run, t);
            }
            run = t + 1;
            if touched {
                self.walls.push(CutTriangle { corners, origin: t as u32, cap: None });
            }
        }
        copy(run, all.len() / 3);
        self.result.untouched = self.result.origin.len();
    }

    /// Drops triangles that were gathered before with the same positions in the same order, if one
    /// of them is enough to close the surface: where all of it is there twice, as are the sheets of
    /// a cap around which it winds twice, both copies stay.
    fn drop_duplicates(&mut self) {
        let positions = self.input.positions;
        let at = |v: u32| key(positions[v as usize]);
        let mut seen = QuickMap::default();
        let again = |triangle: &CutTriangle| {
            let [a, b, c] = triangle.corners.map(at);
            let turned = [[a, b, c], [b, c, a], [c, a, b]].into_iter().min();
            seen.insert(turned, ()).is_some()
        };
        let again: Vec<bool> = self.walls.iter().map(again).collect();
        if !again.contains(&true) {
            return;
        }
        // How much oftener an edge is run along one way than the other; of those edges only that no
        // plane rejects as a whole, for all triangles at them have been gathered.
        let outside = &self.sides.outside;
        let edges = |triangle: &CutTriangle| {
            let [a, b, c] = triangle.corners;
            [[a, b], [b, c], [c, a]].into_iter().filter_map(|[p, q]| {
                let (own, other) = (outside[p as usize], outside[q as usize]);
                let (p, q) = (at(p), at(q));
                let cut = p != q && own | other != 0 && own & other == 0;
                cut.then(|| if p < q { ([p, q], 1) } else { ([q, p], -1) })
            })
        };
        let mut net: QuickMap<_, i32> = QuickMap::default();
        for (edge, way) in self.walls.iter().flat_map(edges) {
            *net.entry(edge).or_default() += way;
        }
        let mut spare = vec![false; again.len()];
        // From the border of what is there twice inward, to and fro.
        for pass in 0..MOST_PASSES {
            let mut more = false;
            for i in 0..again.len() {
                let i = if pass % 2 == 0 { i } else { again.len() - 1 - i };
                let triangle = &self.walls[i];
                if !again[i] || spare[i] || edges(triangle).all(|(edge, way)| net[&edge] * way <= 0)
                {
                    continue;
                }
                edges(triangle).for_each(|(edge, way)| *net.entry(edge).or_default() -= way);
                (spare[i], more) = (true, true);
            }
            if !more {
                break;
            }
        }
        let before = self.walls.len();
        let mut spare = spare.into_iter();
        self.walls.retain(|_| spare.next() != Some(true));
        self.result.report.duplicates = before - self.walls.len();
    }

    fn position(&self, v: u32) -> [f32; 3] {
        let count = self.input.positions.len();
        match (v as usize).checked_sub(count) {
            None => self.input.positions[v as usize],
            Some(new) => self.positions[new],
        }
    }

    /// Applies one plane to the triangles gathered and to the caps before it.
    fn step(&mut self, number: usize, plane: &CutPlane) {
        self.edges.clear();
        let fresh = self.positions.len();
        let new: Vec<i8> = self.positions.iter().map(|&p| plane.side(p)).collect();
        let walls = std::mem::take(&mut self.walls);
        self.walls.reserve(walls.len());
        for triangle in walls {
            self.split(triangle, number, plane, &new);
        }
        let caps = std::mem::take(&mut self.caps);
        for triangle in caps {
            self.split(triangle, number, plane, &new);
        }
        let Some(options) = &self.options.caps else { return };
        if self.edges.is_empty() {
            return;
        }
        let count = self.input.positions.len() as u32;
        let edges = std::mem::take(&mut self.edges);
        let mut places = section::Places::new(plane);
        let edges: Vec<[u32; 2]> = edges
            .into_iter()
            .map(|edge| {
                edge.map(|v| {
                    let old = (v as usize) < count as usize + fresh;
                    places.add(v, self.position(v), old)
                })
            })
            .collect();
        // Places that differ only where the plane's coordinates cannot tell them apart become one.
        for &(v, p) in places.moved() {
            self.positions[(v - count) as usize] = p;
        }
        let outlines = section::join(&edges, &mut places, options.heal, &mut self.result.report);
        let triangles = cap::fill(&outlines, &mut places, plane, &mut self.result.report);
        let mut vertex = vec![DROPPED; places.points().len()];
        for corners in triangles {
            let corners = corners.map(|p| {
                if vertex[p as usize] == DROPPED {
                    let point = places.points()[p as usize];
                    vertex[p as usize] = count + self.positions.len() as u32;
                    self.positions.push(point);
                    cap::attributes(plane, point, options, self.input.stride, &mut self.attributes);
                }
                vertex[p as usize]
            });
            self.caps.push(CutTriangle { corners, origin: NO_ORIGIN, cap: Some(number as u8) });
        }
    }

    /// Divides a triangle at a plane: what is inside stays, what is outside goes, and the edge
    /// between them is noted.
    fn split(&mut self, triangle: CutTriangle, number: usize, plane: &CutPlane, new: &[i8]) {
        let count = self.input.positions.len();
        let corners = triangle.corners;
        let side = corners.map(|v| match (v as usize).checked_sub(count) {
            None => self.sides.side(v, number),
            Some(v) => new[v],
        });
        let to = |work: &mut Self, corners| {
            let list = if triangle.cap.is_some() { &mut work.caps } else { &mut work.walls };
            list.push(CutTriangle { corners, ..triangle });
        };
        if side.iter().all(|&s| s <= 0) {
            let flat = side == [0; 3];
            if !flat || !faces_into(plane, &corners.map(|v| self.position(v))) {
                return to(self, corners);
            }
            let [a, b, c] = corners;
            self.edges.extend([[a, b], [b, c], [c, a]]);
        }
        if side.iter().all(|&s| s > 0) || side.iter().all(|&s| s == 0) {
            let on = if side == [0; 3] { On::All } else { On::None };
            return self.remove(triangle, number, corners, None, on);
        }
        let (mut kept, mut kept_len) = ([0; 4], 0);
        let [mut exit, mut entry] = [DROPPED; 2];
        let mut outer = ([0; 2], 0);
        for i in 0..3 {
            let j = (i + 1) % 3;
            let (p, q, from, to) = (corners[i], corners[j], side[i], side[j]);
            if from <= 0 {
                kept[kept_len] = p;
                kept_len += 1;
            }
            let crossing =
                if from * to < 0 { self.meet(number, p, q) } else { if from == 0 { p } else { q } };
            if from * to < 0 {
                kept[kept_len] = crossing;
                kept_len += 1;
            }
            if from <= 0 && to > 0 {
                exit = crossing;
            } else if from > 0 && to <= 0 {
                entry = crossing;
            }
        }
        // The outer corners from the exit on.
        let start = (0..3).find(|&i| side[i] <= 0 && side[(i + 1) % 3] > 0).unwrap_or(0);
        for i in (1..3).map(|i| (start + i) % 3).filter(|&i| side[i] > 0) {
            outer.0[outer.1] = corners[i];
            outer.1 += 1;
        }
        if exit != entry {
            self.edges.push([entry, exit]);
        }
        let ([o, p], len) = outer;
        let third = if len == 2 { p } else { entry };
        let on = if exit == entry { On::None } else { On::Last };
        self.remove(triangle, number, [exit, o, third], (len == 2).then_some(entry), on);
        if side.iter().all(|&s| s >= 0) {
            return;
        }
        let [a, b, c, d] = kept;
        to(self, [a, b, c]);
        if kept_len == 4 {
            to(self, [a, c, d]);
        }
    }

    /// Notes what was cut off a wall, if that is what is kept.
    fn remove(
        &mut self,
        triangle: CutTriangle,
        plane: usize,
        [a, b, c]: [u32; 3],
        d: Option<u32>,
        on: On,
    ) {
        if self.options.keep == Keep::Inside || triangle.cap.is_some() {
            return;
        }
        // A corner on the plane with both others outside: a triangle.
        let (corners, len) = match d {
            Some(d) if d == a => ([a, b, c, c], 3),
            Some(d) => ([a, b, c, d], 4),
            None => ([a, b, c, c], 3),
        };
        let (origin, plane) = (triangle.origin, plane as u8);
        self.removed.push(Removed { corners, origin, len, plane, on });
    }

    /// The vertex where the plane meets an edge: the same for all triangles at it.
    fn meet(&mut self, plane: usize, p: u32, q: u32) -> u32 {
        if let Some(&v) = self.cuts.get(&[p.min(q), p.max(q)]) {
            return v;
        }
        let (low, high) = self.ordered(p, q);
        let (share, point) = self.planes[plane].meet(self.position(low), self.position(high));
        let v = self.add_between(low, high, share, point);
        if self.options.keep == Keep::Outside && self.planes.len() > 1 {
            let ends = [key(self.position(low)), key(self.position(high))];
            let next = self.cut_list.len() as u32;
            let before = self.cuts_at.insert(ends, next).unwrap_or(DROPPED);
            self.cut_list.push(CutAt { vertex: v, plane: plane as u8, before });
        }
        v
    }

    /// The ends of an edge, the lower position first.
    fn ordered(&self, p: u32, q: u32) -> (u32, u32) {
        if before(self.position(p), self.position(q)) { (p, q) } else { (q, p) }
    }

    /// A new vertex on an edge, with its attributes.
    fn add_between(&mut self, low: u32, high: u32, share: f64, point: [f32; 3]) -> u32 {
        let count = self.input.positions.len();
        let v = (count + self.positions.len()) as u32;
        self.positions.push(point);
        let (stride, share) = (self.input.stride, share as f32);
        for i in 0..stride {
            let of = |v: u32| match (v as usize).checked_sub(count) {
                None => self.input.attributes[v as usize * stride + i],
                Some(new) => self.attributes[new * stride + i],
            };
            let (a, b) = (of(low), of(high));
            self.attributes.push(a + (b - a) * share);
        }
        self.cuts.insert([low.min(high), low.max(high)], v);
        v
    }

    /// Appends the cut triangles and the caps to the untouched ones.
    fn finish(&mut self, place: &[u32]) {
        let count = self.input.positions.len();
        let mut triangles = match self.options.keep {
            Keep::Inside => std::mem::take(&mut self.walls),
            Keep::Outside => self.outer_triangles(),
        };
        let walls = triangles.len();
        let mut caps = std::mem::take(&mut self.caps);
        caps.sort_by_key(|c| c.cap);
        if self.options.keep == Keep::Outside {
            // The same faces, from the other side.
            for triangle in &mut caps {
                triangle.corners.swap(1, 2);
            }
            if let Some(at) = self.options.caps.as_ref().and_then(|c| c.normal_at) {
                let stride = self.input.stride;
                let mut done = vec![false; self.positions.len()];
                for v in caps.iter().flat_map(|c| c.corners).map(|v| v as usize - count) {
                    if !std::mem::replace(&mut done[v], true) {
                        let normal = &mut self.attributes[v * stride + at..][..3];
                        normal.iter_mut().for_each(|n| *n = -*n);
                    }
                }
            }
        }
        for (i, cap) in caps.iter().enumerate() {
            let plane = usize::from(cap.cap.unwrap_or_default());
            let t = self.result.untouched + walls + i;
            match self.result.caps.last_mut() {
                Some(last) if last.plane == plane => last.triangles.end = t + 1,
                _ => self.result.caps.push(Cap { plane, triangles: t..t + 1 }),
            }
        }
        triangles.append(&mut caps);
        let mut new = vec![DROPPED; self.positions.len()];
        let stride = self.input.stride;
        let result = &mut self.result;
        for triangle in triangles {
            for v in triangle.corners {
                let to = match (v as usize).checked_sub(count) {
                    None => place[v as usize],
                    Some(v) => {
                        if new[v] == DROPPED {
                            new[v] = result.positions.len() as u32;
                            result.positions.push(self.positions[v]);
                            let attributes = &self.attributes[v * stride..][..stride];
                            result.attributes.extend_from_slice(attributes);
                        }
                        new[v]
                    }
                };
                debug_assert_ne!(to, DROPPED, "a triangle has a vertex that was dropped");
                result.indices.push(to);
            }
            result.origin.push(triangle.origin);
        }
    }

    /// The polygons that the planes cut off, as triangles by origin.
    fn outer_triangles(&mut self) -> Vec<CutTriangle> {
        let mut removed = std::mem::take(&mut self.removed);
        removed.sort_by_key(|r| r.origin);
        let mut triangles = Vec::with_capacity(removed.len() * 2);
        let mut rim = Vec::new();
        for r in &removed {
            let [exit, mut apex] = [r.corners[0], r.corners[1]];
            rim.clear();
            match r.on {
                On::All => {
                    apex = exit;
                    for i in 0..3 {
                        let next = r.corners[(i + 1) % 3];
                        self.divide(r.corners[i], next, r.plane, &mut rim);
                        if i < 2 {
                            rim.push(next);
                        }
                    }
                }
                on => {
                    let corners = &r.corners[..usize::from(r.len)];
                    rim.extend_from_slice(&corners[2..]);
                    if on == On::Last {
                        self.divide(corners[corners.len() - 1], exit, r.plane, &mut rim);
                    }
                    rim.push(exit);
                }
            }
            for w in rim.windows(2) {
                let corners = [apex, w[0], w[1]];
                triangles.push(CutTriangle { corners, origin: r.origin, cap: None });
            }
        }
        triangles
    }

    /// Appends the vertices at which planes after this one divided an edge of both halves, in
    /// order.
    ///
    /// The divisions of the edge are repeated: looked up by its positions alone, it might be taken
    /// for one that came to lie there later, by rounding.
    fn divide(&mut self, from: u32, to: u32, after: u8, rim: &mut Vec<u32>) {
        for number in usize::from(after) + 1..self.planes.len() {
            let plane = &self.planes[number];
            let sides = [from, to].map(|v| plane.side(self.position(v)));
            if sides[0].max(sides[1]) <= 0 {
                continue;
            }
            // Only the part inside is there for the planes that follow.
            if sides[0] * sides[1] < 0
                && let Some(v) = self.met(number, from, to)
            {
                if sides[0] < 0 {
                    self.divide(from, v, number as u8, rim);
                }
                rim.push(v);
                if sides[1] < 0 {
                    self.divide(v, to, number as u8, rim);
                }
            }
            return;
        }
    }

    /// The vertex at which a plane cut an edge, or another one between the same positions.
    fn met(&mut self, plane: usize, p: u32, q: u32) -> Option<u32> {
        if let Some(&v) = self.cuts.get(&[p.min(q), p.max(q)]) {
            return Some(v);
        }
        let (low, high) = self.ordered(p, q);
        let ends = [low, high].map(|v| key(self.position(v)));
        let mut at = self.cuts_at.get(&ends).copied()?;
        let cut = loop {
            let cut = self.cut_list.get(at as usize)?;
            if usize::from(cut.plane) == plane {
                break *cut;
            }
            at = cut.before;
        };
        // Cut on its other side alone, which may have attributes of its own.
        let (share, _) = self.planes[plane].meet(self.position(low), self.position(high));
        Some(self.add_between(low, high, share, self.position(cut.vertex)))
    }
}

/// Whether a triangle on the plane faces against its normal: it bounds what lies outside.
fn faces_into(plane: &CutPlane, points: &[[f32; 3]; 3]) -> bool {
    let sign = exact::area_sign(points, plane.axis);
    if plane.upright() { sign < 0 } else { sign > 0 }
}
