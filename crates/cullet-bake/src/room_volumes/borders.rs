//! Where one sees out of rooms: rays along their borders, and portals around those that nothing
//! stops.

use std::collections::BTreeMap;

use cullet::Scene;
use cullet::bounds::Plane;
use cullet_cells::query::{Sight, SightOptions, line_of_sight};
use glam::DVec3;

use super::RoomOptions;
use super::solids::ON;
use cullet_io::reader::Convex;
use cullet_io::reader::Winding;
use cullet_io::reader::numbers;
use cullet_io::{CellGraph, Portal};

/// How far within the border rays begin, and how far within the next room they end, so that a
/// surface on a border is met.
const WITHIN: f64 = 0.005;
/// How far a cell reaches out through its portals at least: there the portal is on its border.
const WAFER: f64 = 1e-3;
/// Most rays across a face, each way.
const MOST_RAYS: f64 = 4096.0;

/// Pieces of rooms, and what stands between them.
pub(super) struct Borders<'a> {
    pub(super) scene: &'a Scene,
    pub(super) pieces: &'a [(u32, Convex)],
    pub(super) outside: u32,
    pub(super) options: &'a RoomOptions,
}

/// A face of a piece, and a grid over it.
struct Face<'a> {
    room: u32,
    plane: &'a Plane,
    outline: &'a [DVec3],
    /// Directions of the grid, of unit length, so that u × v is the normal.
    axes: [DVec3; 2],
    /// Lowest corner of the grid along both, its squares, and how many there are.
    low: [f64; 2],
    size: [f64; 2],
    count: [usize; 2],
}

impl Borders<'_> {
    /// Adds the portals to the cells, and to the cells that they lead to where these are beyond.
    pub(super) fn find(&self, cells: &mut CellGraph) {
        for (number, (room, piece)) in self.pieces.iter().enumerate() {
            for (plane, outline) in piece.faces() {
                let face = self.face(*room, plane, outline);
                self.openings(number, &face, cells);
            }
        }
    }

    fn face<'f>(&self, room: u32, plane: &'f Plane, outline: &'f [DVec3]) -> Face<'f> {
        let normal = DVec3::from(plane.normal);
        // Along the longest edge.
        let edges = outline.iter().zip(outline.iter().cycle().skip(1)).map(|(a, b)| *b - *a);
        let longest = edges.max_by(|a, b| a.length().total_cmp(&b.length())).unwrap_or(DVec3::X);
        let u =
            (longest - normal * longest.dot(normal)).normalize_or(normal.any_orthonormal_vector());
        let axes = [u, normal.cross(u)];
        let (mut low, mut size, mut count) = ([0.0; 2], [0.0; 2], [0; 2]);
        let step = self.options.step.max(1e-3);
        for (k, axis) in axes.into_iter().enumerate() {
            let along = outline.iter().map(|p| p.dot(axis));
            let (min, max) =
                along.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
            let squares = ((max - min) / step).ceil().clamp(1.0, MOST_RAYS);
            (low[k], size[k], count[k]) = (min, (max - min) / squares, squares as usize);
        }
        Face { room, plane, outline, axes, low, size, count }
    }

    /// Portals of a face.
    fn openings(&self, piece: usize, face: &Face<'_>, cells: &mut CellGraph) {
        let near = self.near(face);
        let mut led: BTreeMap<u32, Vec<[usize; 2]>> = BTreeMap::new();
        for j in 0..face.count[1] {
            for i in 0..face.count[0] {
                let point = face.point([i as f64 + 0.5, j as f64 + 0.5]);
                if let Some(to) = face.has(point).then(|| self.leads(piece, face, point, &near)) {
                    to.into_iter().for_each(|to| led.entry(to).or_default().push([i, j]));
                }
            }
        }
        for (to, squares) in led {
            for [low, high] in together(&squares) {
                self.portal(face, to, low, high, cells);
            }
        }
    }

    /// Pieces that rays of a face may come to.
    fn near(&self, face: &Face<'_>) -> Vec<usize> {
        let grown = |p: DVec3, by: f64| {
            let end = p + DVec3::from(face.plane.normal) * by;
            [p.min(end), p.max(end)]
        };
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for p in face.outline {
            let [l, h] = grown(*p, self.options.reach);
            (low, high) = (low.min(l - WITHIN), high.max(h + WITHIN));
        }
        let is_near = |(_, piece): &(u32, Convex)| {
            piece.bounds().is_some_and(|[l, h]| (0..3).all(|k| l[k] <= high[k] && low[k] <= h[k]))
        };
        (0..self.pieces.len()).filter(|&n| is_near(&self.pieces[n])).collect()
    }

    /// Where one sees to straight out of a point of a face; `None` if a wall is there, or more of
    /// the room.
    fn leads(&self, own: usize, face: &Face<'_>, point: DVec3, near: &[usize]) -> Option<u32> {
        let normal = DVec3::from(face.plane.normal);
        let entries = near.iter().filter(|&&n| n != own).filter_map(|&n| {
            let (room, piece) = &self.pieces[n];
            Some((entry(piece, point, normal)?, *room))
        });
        // Of pieces at one distance the own room's first: there is no border.
        let key = |(at, room): &(f64, u32)| (if *at < ON { 0.0 } else { *at }, *room != face.room);
        let next = entries
            .filter(|(at, _)| *at <= self.options.reach)
            .min_by(|a, b| key(a).partial_cmp(&key(b)).unwrap_or(std::cmp::Ordering::Equal));
        let end = next.map_or(self.options.reach, |(at, _)| at);
        let from = point - normal * WITHIN;
        let length = WITHIN + end + if next.is_some() { WITHIN } else { 0.0 };
        let to = from + normal * length;
        match line_of_sight(self.scene, from.into(), to.into(), &SightOptions::default()) {
            // What is farther off than walls are may leave a way along it.
            Sight::Blocked(by) => {
                let at = by.share * length - WITHIN;
                (at > (self.options.walls * 0.5).max(ON) && at < end).then_some(self.outside)
            }
            _ => match next {
                Some((_, room)) => (room != face.room).then_some(room),
                None => Some(self.outside),
            },
        }
    }

    /// The portal around squares of a face.
    fn portal(
        &self,
        face: &Face<'_>,
        to: u32,
        low: [usize; 2],
        high: [usize; 2],
        cells: &mut CellGraph,
    ) {
        // An edge is somewhere between a ray that was stopped and one that was not.
        let [a, b] = [0, 1].map(|k| low[k] as f64 - 1.0);
        let [c, d] = [0, 1].map(|k| high[k] as f64 + 2.0);
        let corners = [[a, b], [c, b], [c, d], [a, d]].map(|at| face.point(at));
        let mut polygon = Some(Winding(corners.to_vec()));
        let normal = DVec3::from(face.plane.normal);
        for (p, q) in face.outline.iter().zip(face.outline.iter().cycle().skip(1)) {
            let Some(side) = Plane::from_point_normal(*p, (*q - *p).cross(normal)) else {
                continue;
            };
            polygon = polygon.and_then(|w| w.behind_within(&side, ON * 0.1));
        }
        let Some(polygon) = polygon.filter(|w| w.0.len() >= 3 && w.width() > ON) else { return };
        cells.cells[to as usize].pieces.push(wafer(&polygon.0, normal));
        // Counter-clockwise from outside, and so clockwise from the room.
        let polygon = polygon.reversed().0.iter().map(DVec3::to_array).collect();
        cells.portals.push(Portal { cells: [face.room, to], polygon, ..Portal::default() });
    }
}

impl Face<'_> {
    /// A point of the grid, in squares from its lowest corner.
    fn point(&self, at: [f64; 2]) -> DVec3 {
        let [u, v] = [0, 1].map(|k| self.axes[k] * (self.low[k] + self.size[k] * at[k]));
        u + v + DVec3::from(self.plane.normal) * self.plane.d
    }

    /// Whether a point of its plane is within its outline.
    fn has(&self, point: DVec3) -> bool {
        let normal = DVec3::from(self.plane.normal);
        let edges = self.outline.iter().zip(self.outline.iter().cycle().skip(1));
        edges.into_iter().all(|(a, b)| normal.cross(*b - *a).dot(point - *a) >= 0.0)
    }
}

/// How far from a point along a direction a piece begins; `None` if the ray does not come to it, or
/// leaves it there.
fn entry(piece: &Convex, point: DVec3, along: DVec3) -> Option<f64> {
    let (mut first, mut last) = (0.0_f64, f64::INFINITY);
    for (plane, _) in piece.faces() {
        let (height, speed) = (plane.distance(point), DVec3::from(plane.normal).dot(along));
        if speed.abs() < 1e-9 {
            if height > 0.0 {
                return None;
            }
        } else if speed > 0.0 {
            last = last.min(-height / speed);
        } else {
            first = first.max(-height / speed);
        }
    }
    (last - first > ON).then_some(first)
}

/// Squares that hang together, by sides or corners: the lowest and highest of each group.
fn together(squares: &[[usize; 2]]) -> Vec<[[usize; 2]; 2]> {
    let mut left: std::collections::BTreeSet<[usize; 2]> = squares.iter().copied().collect();
    let mut groups = Vec::new();
    while let Some(first) = left.pop_first() {
        let (mut low, mut high) = (first, first);
        let mut open = vec![first];
        while let Some([i, j]) = open.pop() {
            for k in 0..2 {
                (low[k], high[k]) = (low[k].min([i, j][k]), high[k].max([i, j][k]));
            }
            for a in i.saturating_sub(1)..=i + 1 {
                for b in j.saturating_sub(1)..=j + 1 {
                    if left.remove(&[a, b]) {
                        open.push([a, b]);
                    }
                }
            }
        }
        groups.push([low, high]);
    }
    groups
}

/// A thin piece over a polygon that is counter-clockwise about `normal`, to the side where that
/// points.
fn wafer(polygon: &[DVec3], normal: DVec3) -> Vec<[f64; 4]> {
    let edges = polygon.iter().zip(polygon.iter().cycle().skip(1));
    let sides = edges.filter_map(|(a, b)| Plane::from_point_normal(*a, (*b - *a).cross(normal)));
    let d = normal.dot(polygon[0]);
    let ends = [Plane::new((-normal).into(), -d), Plane::new(normal.into(), d + WAFER)];
    sides.chain(ends).map(|plane| numbers(&plane)).collect()
}
