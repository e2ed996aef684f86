//! Buildings: rooms on floors, doors and hatches between them, as cells and portals.

use cullet::bounds::Plane;
use cullet_cells::cell::{CellGraph, CellPiece, CellShapes, Mirror, Portal};

use crate::Rng;

/// A building, turned and moved as a whole.
#[derive(Debug)]
pub struct Building {
    /// Cells, and the portals that join them; some portals are shut, some one-way, and there are
    /// mirrors.
    pub graph: CellGraph,
    /// Where they are.
    pub shapes: CellShapes,
    /// The rooms that cells are made of: the cell of each, and its corners.
    rooms: Vec<(u32, [[f64; 3]; 2])>,
    turned: [[f64; 3]; 3],
    moved: [f64; 3],
}

/// Sides of a room.
const ROOM: [f64; 3] = [5.0, 3.0, 4.0];

impl Building {
    /// `size` rooms along each axis. Neighbours are joined by a door or a hatch more often than not; some are one room of two
    /// or three pieces, so that there are L-shaped ones.
    ///
    /// # Panics
    ///
    /// If the engine refuses what is a good building.
    pub fn new(rng: &mut Rng, size: [usize; 3]) -> Self {
        let number = |[x, y, z]: [usize; 3]| (y * size[2] + z) * size[0] + x;
        let count = size.iter().product();
        let mut joined: Vec<usize> = (0..count).collect();
        let mut pairs = Vec::new();
        for y in 0..size[1] {
            for z in 0..size[2] {
                for x in 0..size[0] {
                    for axis in 0..3 {
                        let here = [x, y, z];
                        let mut next = here;
                        next[axis] += 1;
                        if next[axis] == size[axis] {
                            continue;
                        }
                        pairs.push((here, number(here), number(next), axis));
                        if axis != 1 && rng.chance(0.15) {
                            let (a, b) = (joined[number(here)], joined[number(next)]);
                            joined.iter_mut().filter(|j| **j == b).for_each(|j| *j = a);
                        }
                    }
                }
            }
        }
        let mut names = joined.clone();
        names.sort_unstable();
        names.dedup();
        let cell = |room: usize| names.binary_search(&joined[room]).expect("listed") as u32;
        let angle = if rng.chance(0.5) { 0.0 } else { rng.range(-3.0, 3.0) };
        let (s, c) = (angle.sin(), angle.cos());
        let tilt = if rng.chance(0.5) { 0.0 } else { rng.range(-0.5, 0.5) };
        let (ts, tc) = (tilt.sin(), tilt.cos());
        let mut building = Self {
            graph: CellGraph::default(),
            shapes: CellShapes::default(),
            rooms: Vec::new(),
            turned: [[c, 0.0, -s], [s * ts, tc, c * ts], [s * tc, -ts, c * tc]],
            moved: rng.vector(40.0),
        };
        let mut pieces = Vec::new();
        for y in 0..size[1] {
            for z in 0..size[2] {
                for x in 0..size[0] {
                    let at = [x, y, z];
                    let min: [f64; 3] = std::array::from_fn(|a| at[a] as f64 * ROOM[a]);
                    let max = std::array::from_fn(|a| min[a] + ROOM[a]);
                    let own = cell(number(at));
                    let mut piece = CellPiece::from_box(own, min, max);
                    for plane in &mut piece.planes {
                        *plane = building.turn(plane);
                    }
                    building.rooms.push((own, [min, max]));
                    pieces.push(piece);
                }
            }
        }
        let mut portals = Vec::new();
        for (at, a, b, axis) in pairs {
            let chance = if axis == 1 { 0.4 } else { 0.75 };
            if cell(a) != cell(b) && rng.chance(chance) {
                let side = (at[axis] + 1) as f64 * ROOM[axis];
                let polygon = building.opening(rng, at, axis, side);
                portals.push(Portal { cells: [cell(a), cell(b)], polygon });
            }
        }
        // On the low side along x, seen from within: the other way round.
        let mut mirrors = Vec::new();
        let lowest = (0..size[1] * size[2]).map(|i| [0, i / size[2], i % size[2]]);
        for (at, room) in lowest.map(|at| (at, number(at))) {
            if rng.chance(0.7) {
                let mut polygon = building.opening(rng, at, 0, 0.0);
                polygon.reverse();
                mirrors.push(Mirror { cell: cell(room), polygon });
            }
        }
        let graph =
            CellGraph::new(names.len() as u32, portals).and_then(|g| g.with_mirrors(mirrors));
        building.graph = graph.expect("good portals");
        for portal in 0..building.graph.portals().len() as u32 {
            building.graph.set_open(portal, !rng.chance(0.15));
            building.graph.set_one_way(portal, rng.chance(0.15));
        }
        building.shapes = CellShapes::new(&building.graph, pieces).expect("good pieces");
        building
    }

    /// A door or hatch in the wall of a room across an axis, counter-clockwise as seen from the low side.
    fn opening(&self, rng: &mut Rng, at: [usize; 3], axis: usize, side: f64) -> Vec<[f64; 3]> {
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        let span = |rng: &mut Rng, a: usize| {
            let half = rng.range(0.2, 0.49) * ROOM[a];
            let middle = rng.range(half, ROOM[a] - half) + at[a] as f64 * ROOM[a];
            [middle - half, middle + half]
        };
        let ([u0, u1], [v0, v1]) = (span(rng, u), span(rng, v));
        let mut corners = vec![[u0, v0], [u0, v1], [u1, v1], [u1, v0]];
        if rng.chance(0.4) {
            // One corner cut off.
            corners[3] = [u1, v0 + (v1 - v0) * 0.5];
            corners.push([u0 + (u1 - u0) * 0.5, v0]);
        }
        let place = |[a, b]: [f64; 2]| {
            let mut p = [side; 3];
            (p[u], p[v]) = (a, b);
            self.place(p)
        };
        corners.into_iter().map(place).collect()
    }

    fn place(&self, p: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|a| {
            self.moved[a] + (0..3).map(|k| self.turned[k][a] * p[k]).sum::<f64>()
        })
    }

    fn turn(&self, plane: &Plane) -> Plane {
        let n = plane.normal;
        let normal: [f64; 3] =
            std::array::from_fn(|a| (0..3).map(|k| self.turned[k][a] * n[k]).sum());
        let moved: f64 = (0..3).map(|a| normal[a] * self.moved[a]).sum();
        Plane::new(normal, plane.d + moved)
    }

    /// A point in a room, at least `margin` from its sides, and its cell.
    pub fn point(&self, rng: &mut Rng, margin: f64) -> ([f64; 3], u32) {
        let (cell, [min, max]) = self.rooms[rng.index(self.rooms.len())];
        let p = std::array::from_fn(|a| rng.range(min[a] + margin, max[a] - margin));
        (self.place(p), cell)
    }

    /// The middle of a portal.
    pub fn middle(&self, portal: u32) -> [f64; 3] {
        let polygon = &self.graph.portals()[portal as usize].polygon;
        std::array::from_fn(|a| polygon.iter().map(|p| p[a]).sum::<f64>() / polygon.len() as f64)
    }
}
