//! An office building: rooms along corridors, doors, windows, furniture; its cells and portals
//! known.

mod furniture;
mod walls;

use cullet::mesh::Alpha;
use cullet::{MeshId, Transform};

use super::builder::{SceneBuilder, Sides, fill, turned};
use super::rng::Rng;
use super::shapes::{Shape, mesh_data};
use super::spec::{KeyInfo, SceneInfo, SceneSpecError, Spec};
use cullet_io::{Cell, Model, Portal};
use furniture::Furniture;

pub(super) const INFO: SceneInfo = SceneInfo {
    name: "office",
    about: "storeys of rooms on both sides of corridors, joined by doors (some shut) and a stairwell, \
            with windows and furniture; cells and portals are known",
    keys: &[
        KeyInfo { name: "seed", about: "which office", default: 1, min: 0, max: u64::MAX },
        KeyInfo {
            name: "rooms",
            about: "rooms along each side of a corridor",
            default: 8,
            min: 1,
            max: 100,
        },
        KeyInfo {
            name: "corridors",
            about: "corridors on a storey, each between two rows of rooms",
            default: 3,
            min: 1,
            max: 50,
        },
        KeyInfo { name: "floors", about: "storeys", default: 2, min: 1, max: 20 },
        KeyInfo {
            name: "furniture",
            about: "pieces of furniture in each room, as far as they fit",
            default: 6,
            min: 0,
            max: 50,
        },
        KeyInfo {
            name: "roof",
            about: "1 covers the top storey, 0 leaves it open, so that one looks in from above",
            default: 0,
            min: 0,
            max: 1,
        },
        KeyInfo {
            name: "closed",
            about: "doors that are shut, in percent",
            default: 25,
            min: 0,
            max: 100,
        },
    ],
};

/// From floor to floor.
const STOREY: f64 = 3.2;
/// Height of a room: what the slab leaves of a storey.
const ROOM: f64 = 2.9;
const SLAB: f64 = STOREY - ROOM;
/// Thickness of walls; cells meet in their middle.
const WALL: f64 = 0.2;
/// Walls reach this far into slabs and into each other, so that rounding leaves no crack.
const LAP: f64 = 0.05;
const ROOM_DEPTH: f64 = 5.0;
const CORRIDOR: f64 = 2.4;
const BLOCK: f64 = 2.0 * ROOM_DEPTH + CORRIDOR;
/// West of the rooms: a hall along the whole building, and the stairwell beside it.
const HALL: f64 = -6.0;
const STAIRWELL: f64 = -10.0;
const STAIRWELL_DEPTH: f64 = 8.0;
/// The stairwell has no floor up to here, above the lowest storey.
const STAIRS_DEPTH: f64 = 4.0;
/// Slabs reach this far beyond their lines.
const SLAB_LAP: f64 = WALL * 0.5 - 0.02;
const DOOR: [f64; 2] = [0.9, 2.1];

/// A wall stands along x or along z.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Along {
    X,
    Z,
}

impl Along {
    /// (along, height, across) as (x, y, z).
    fn point(self, along: f64, y: f64, across: f64) -> [f64; 3] {
        match self {
            Self::X => [along, y, across],
            Self::Z => [across, y, along],
        }
    }
}

/// A hole in a wall: from..to along it, and heights above the floor.
#[derive(Clone, Copy)]
struct Hole {
    from: f64,
    to: f64,
    sill: f64,
    head: f64,
}

impl Hole {
    fn door(at: f64) -> Self {
        Self { from: at - DOOR[0] * 0.5, to: at + DOOR[0] * 0.5, sill: 0.0, head: DOOR[1] }
    }

    fn arch(at: f64, width: f64) -> Self {
        Self { from: at - width * 0.5, to: at + width * 0.5, sill: 0.0, head: 2.3 }
    }

    fn window(at: f64, width: f64) -> Self {
        Self { from: at - width * 0.5, to: at + width * 0.5, sill: 0.9, head: 2.2 }
    }
}

/// A line that a wall stands on.
#[derive(Clone, Copy)]
struct Line {
    along: Along,
    across: f64,
    floor: f64,
}

struct Office {
    b: SceneBuilder,
    /// Lowest and highest corner of each cell, up to the middle of its walls and slabs.
    rooms: Vec<[[f64; 3]; 2]>,
    wall: MeshId,
    slab: MeshId,
    glass: MeshId,
    leaf: MeshId,
    furniture: Furniture,
    rng: Rng,
    pieces: usize,
    shut: f64,
}

pub(super) fn build(spec: &Spec) -> Result<Model, SceneSpecError> {
    let mut b = SceneBuilder::new(spec);
    let plaster = b.material("plaster", 0xE9E4D8);
    let concrete = b.material("concrete", 0xA7A39B);
    let lawn = b.material("lawn", 0x7E9B5B);
    let wood = b.material("door", 0x9A6B3F);
    let pane = b.material_alpha("glass", 0xA9CCD6, 0.3);
    let stone = b.material("stairs", 0x8A8F98);
    let cube = || Shape::building(1);
    let wall = b.mesh("wall", &[(cube(), plaster)], Sides::One)?;
    let slab = b.mesh("slab", &[(cube(), concrete)], Sides::One)?;
    let ground = b.mesh("lawn", &[(cube(), lawn)], Sides::One)?;
    let glass = b.mesh_from("window", mesh_data(&[(cube(), pane)], false, Alpha::Blended))?;
    // It hangs at its edge, and is wider and higher than its hole by what vanishes in the wall.
    let leaf = Shape::boxes(&[
        ([-0.02, -0.02, -0.025], [DOOR[0] + 0.02, DOOR[1] + 0.02, 0.025]),
        ([DOOR[0] - 0.12, 1.0, -0.07], [DOOR[0] - 0.08, 1.04, 0.07]),
    ]);
    let leaf = b.mesh("door", &[(leaf, wood)], Sides::One)?;
    let stairs = b.mesh("stairs", &[(stairs(), stone)], Sides::One)?;
    let furniture = Furniture::new(&mut b)?;

    let corridors = spec.get("corridors") as usize;
    let depth = corridors as f64 * BLOCK;
    let rooms = spec.get("rooms") as usize;
    let width = rooms as f64 * 4.5;
    let floors = spec.get("floors") as usize;
    b.add(ground, fill([STAIRWELL - 4.0, -0.8, -4.0], [width + 4.0, -SLAB - 0.05, depth + 4.0]))?;

    let mut office = Office {
        b,
        rooms: Vec::new(),
        wall,
        slab,
        glass,
        leaf,
        furniture,
        rng: Rng::new(spec.get("seed"), 1),
        pieces: spec.get("furniture") as usize,
        shut: spec.get("closed") as f64 / 100.0,
    };
    let mut below = None;
    for storey in 0..floors {
        let floor = storey as f64 * STOREY;
        let stairwell = office.storey(storey, floor, width, depth, rooms, corridors)?;
        if let Some(below) = below.replace(stairwell) {
            let y = floor - SLAB * 0.5;
            let (x0, x1) = (STAIRWELL + WALL * 0.5, HALL - WALL * 0.5);
            // To the edge of the slab, which reaches a little farther than its line.
            let (z0, z1) = (WALL * 0.5, STAIRS_DEPTH - SLAB_LAP);
            let polygon = vec![[x0, y, z0], [x0, y, z1], [x1, y, z1], [x1, y, z0]];
            office.portal([below, stairwell], polygon, None, false);
            let at = [STAIRWELL + WALL * 0.5 + 0.1, floor - STOREY, 1.5];
            office.b.add(stairs, Transform::from_translation(at))?;
        }
    }
    // Cells stay what they are without a roof: what is seen over a wall is above all cells.
    if spec.get("roof") == 1 {
        let roof = floors as f64 * STOREY;
        office.slab([STAIRWELL, 0.0], [HALL, STAIRWELL_DEPTH], roof)?;
        office.slab([HALL, 0.0], [width, depth], roof)?;
    }
    let mut model = office.b.finish();
    walls::take_walls(&mut model.cells, &office.rooms, [WALL * 0.5, SLAB * 0.5, WALL * 0.5]);
    model.place_cells()?;
    Ok(model)
}

/// Twelve steps up one storey.
fn stairs() -> Shape {
    let (rise, run) = (STOREY / 12.0, 0.28);
    // Steps reach a little into the floor they start on.
    let mut polygon = vec![[0.0, -LAP], [12.0 * run, -LAP]];
    for i in (0..12).rev() {
        let (x, y) = (f64::from(i) * run, f64::from(i + 1) * rise);
        polygon.extend([[x + run, y], [x, y]]);
    }
    Shape::prism(&polygon, 0.0, 1.4)
}

impl Office {
    /// One storey; gives the number of its stairwell's cell.
    fn storey(
        &mut self,
        storey: usize,
        floor: f64,
        width: f64,
        depth: f64,
        rooms: usize,
        corridors: usize,
    ) -> Result<u32, SceneSpecError> {
        let line = |along, across| Line { along, across, floor };
        let half = WALL * 0.5;
        let named = |name: &str| format!("{name} {storey}");
        let stairwell =
            self.cell(named("stairwell"), floor, [STAIRWELL, 0.0], [HALL, STAIRWELL_DEPTH]);
        let hall = self.cell(named("hall"), floor, [HALL, 0.0], [0.0, depth]);
        let opening = if storey == 0 { 0.0 } else { STAIRS_DEPTH };
        self.slab([STAIRWELL, opening], [HALL, STAIRWELL_DEPTH], floor)?;
        self.slab([HALL, 0.0], [0.0, depth], floor)?;

        // Around stairwell and hall.
        self.wall(line(Along::Z, STAIRWELL), [-half, STAIRWELL_DEPTH + half], &[])?;
        let (inner, outer) = (STAIRWELL + half - LAP, HALL - half + LAP);
        self.wall(line(Along::X, 0.0), [inner, outer], &[])?;
        self.wall(line(Along::X, STAIRWELL_DEPTH), [inner, outer], &[])?;
        let arch = Hole::arch(6.5, 1.8);
        self.wall(line(Along::Z, HALL), [-half, depth + half], &[arch])?;
        self.opening(line(Along::Z, HALL), arch, [stairwell, hall]);
        let (inner, outer) = (HALL + half - LAP, -half + LAP);
        self.wall(line(Along::X, 0.0), [inner, outer], &[])?;
        self.wall(line(Along::X, depth), [inner, outer], &[])?;
        // Clear of the arches to the corridors.
        for z in (0..corridors).flat_map(|i| [1.5, 4.0, 9.5].map(|z| i as f64 * BLOCK + z)) {
            self.furniture.stand_in_hall(&mut self.b, &mut self.rng, [-1.0, floor, z])?;
        }

        // Corridors open into the hall, one arch each; the far wall of the building has no hole.
        let middle = |i: usize| i as f64 * BLOCK + BLOCK * 0.5;
        let arches: Vec<Hole> = (0..corridors).map(|i| Hole::arch(middle(i), 1.6)).collect();
        self.wall(line(Along::Z, 0.0), [-half, depth + half], &arches)?;
        self.wall(line(Along::Z, width), [-half, depth + half], &[])?;

        // Back to back with the row before: its partitions and cells.
        let mut behind: Option<(Vec<f64>, u32)> = None;
        for (i, arch) in arches.iter().enumerate() {
            let z = i as f64 * BLOCK;
            let (near, far) = (z + ROOM_DEPTH, z + ROOM_DEPTH + CORRIDOR);
            let corridor =
                self.cell(format!("corridor {storey}.{i}"), floor, [0.0, near], [width, far]);
            self.slab([0.0, near], [width, far], floor)?;
            self.opening(line(Along::Z, 0.0), *arch, [hall, corridor]);

            let name = |side: &str| format!("room {storey}.{i}{side}");
            let south = self.row(&name("s"), floor, rooms, width, [z, near])?;
            let north = self.row(&name("n"), floor, rooms, width, [far, z + BLOCK])?;
            self.doors(line(Along::X, near), &south, corridor, true)?;
            self.doors(line(Along::X, far), &north, corridor, false)?;
            match behind.take() {
                None => self.windows(line(Along::X, z), &south.0)?,
                Some(behind) => self.back_to_back(line(Along::X, z), &behind, &south)?,
            }
            behind = Some(north);
        }
        if let Some(last) = behind {
            self.windows(line(Along::X, depth), &last.0)?;
        }
        Ok(stairwell)
    }

    /// A row of rooms with its partitions: gives where they stand (both ends included), and the
    /// number of the first room's cell.
    fn row(
        &mut self,
        name: &str,
        floor: f64,
        rooms: usize,
        width: f64,
        [z0, z1]: [f64; 2],
    ) -> Result<(Vec<f64>, u32), SceneSpecError> {
        let mut at = 0.0;
        let mut lines = vec![0.0];
        for _ in 0..rooms {
            at += self.rng.range(3.5, 5.5);
            lines.push(at);
        }
        lines.iter_mut().for_each(|x| *x *= width / at);
        let first = self.b.model.cells.cells.len() as u32;
        for (i, pair) in lines.windows(2).enumerate() {
            self.cell(format!("{name}{i}"), floor, [pair[0], z0], [pair[1], z1]);
            self.slab([pair[0], z0], [pair[1], z1], floor)?;
            let inset = WALL * 0.5 + 0.1;
            let low = [pair[0] + inset, floor, z0 + inset];
            let high = [pair[1] - inset, floor, z1 - inset];
            self.furniture.fill_room(&mut self.b, &mut self.rng, low, high, self.pieces)?;
        }
        for (i, x) in lines.iter().enumerate().take(rooms).skip(1) {
            let line = Line { along: Along::Z, across: *x, floor };
            let span = [z0 + WALL * 0.5 - LAP, z1 - WALL * 0.5 + LAP];
            let cells = [first + i as u32 - 1, first + i as u32];
            if self.rng.chance(0.3) {
                let hole = Hole::door(self.rng.range(z0 + 1.2, z1 - 1.2));
                self.wall(line, span, &[hole])?;
                self.door(line, hole, cells)?;
            } else {
                self.wall(line, span, &[])?;
            }
        }
        Ok((lines, first))
    }

    /// The wall between a row and its corridor, with a door for each room.
    fn doors(
        &mut self,
        line: Line,
        (lines, first): &(Vec<f64>, u32),
        corridor: u32,
        room_first: bool,
    ) -> Result<(), SceneSpecError> {
        let holes: Vec<Hole> = lines
            .windows(2)
            .map(|pair| Hole::door(self.rng.range(pair[0] + 0.8, pair[1] - 0.8)))
            .collect();
        self.wall(line, span_of(lines), &holes)?;
        for (i, hole) in (*first..).zip(holes) {
            self.door(line, hole, if room_first { [i, corridor] } else { [corridor, i] })?;
        }
        Ok(())
    }

    /// The wall between two rows of rooms, with a door here and there.
    fn back_to_back(
        &mut self,
        line: Line,
        (south, south_first): &(Vec<f64>, u32),
        (north, north_first): &(Vec<f64>, u32),
    ) -> Result<(), SceneSpecError> {
        let mut holes = Vec::new();
        for (i, pair) in (*north_first..).zip(north.windows(2)) {
            let at = self.rng.range(pair[0] + 0.8, pair[1] - 0.8);
            let wanted = self.rng.chance(0.3);
            let room = south.windows(2).position(|p| p[0] + 0.8 < at && at < p[1] - 0.8);
            if let Some(room) = room.filter(|_| wanted) {
                holes.push((Hole::door(at), [south_first + room as u32, i]));
            }
        }
        let all: Vec<Hole> = holes.iter().map(|h| h.0).collect();
        self.wall(line, span_of(south), &all)?;
        for (hole, cells) in holes {
            self.door(line, hole, cells)?;
        }
        Ok(())
    }

    /// An outer wall with a window for each room.
    fn windows(&mut self, line: Line, lines: &[f64]) -> Result<(), SceneSpecError> {
        let holes: Vec<Hole> = lines
            .windows(2)
            .map(|p| Hole::window((p[0] + p[1]) * 0.5, (p[1] - p[0] - 1.0).min(2.0)))
            .collect();
        self.wall(line, span_of(lines), &holes)?;
        for h in holes {
            let (y0, y1) = (line.floor + h.sill - LAP, line.floor + h.head + LAP);
            let low = line.along.point(h.from - LAP, y0, line.across - 0.01);
            let high = line.along.point(h.to + LAP, y1, line.across + 0.01);
            self.b.add(self.glass, fill(low, high))?;
        }
        Ok(())
    }

    /// A wall with holes, which are in order: whole segments between them, and what is above and
    /// below.
    fn wall(&mut self, line: Line, span: [f64; 2], holes: &[Hole]) -> Result<(), SceneSpecError> {
        // Up through the slab to the wall above, for where the stairwell has no slab.
        let (bottom, top) = (line.floor - LAP, line.floor + STOREY - 0.5 * LAP);
        let mut segments = Vec::new();
        let mut from = span[0];
        for h in holes {
            segments.push((from, h.from, bottom, top));
            segments.push((h.from - LAP, h.to + LAP, line.floor + h.head, top));
            if h.sill > 0.0 {
                segments.push((h.from - LAP, h.to + LAP, bottom, line.floor + h.sill));
            }
            from = h.to;
        }
        segments.push((from, span[1], bottom, top));
        for (from, to, low, high) in segments {
            let low = line.along.point(from, low, line.across - WALL * 0.5);
            let high = line.along.point(to, high, line.across + WALL * 0.5);
            self.b.add(self.wall, fill(low, high))?;
        }
        Ok(())
    }

    /// A floor: its top at `floor`.
    fn slab(&mut self, low: [f64; 2], high: [f64; 2], floor: f64) -> Result<(), SceneSpecError> {
        // Into the walls, but not to their outside, where two surfaces would share a plane.
        let half = SLAB_LAP;
        let min = [low[0] - half, floor - SLAB, low[1] - half];
        self.b.add(self.slab, fill(min, [high[0] + half, floor, high[1] + half]))?;
        Ok(())
    }

    /// A cell, up to the middle of its walls and slabs.
    fn cell(&mut self, name: String, floor: f64, low: [f64; 2], high: [f64; 2]) -> u32 {
        let min = [low[0], floor - SLAB * 0.5, low[1]];
        let max = [high[0], floor + STOREY - SLAB * 0.5, high[1]];
        let cells = &mut self.b.model.cells.cells;
        cells.push(Cell { name, ..Cell::default() });
        self.rooms.push([min, max]);
        (cells.len() - 1) as u32
    }

    fn portal(
        &mut self,
        cells: [u32; 2],
        polygon: Vec<[f64; 3]>,
        door: Option<cullet::Handle>,
        closed: bool,
    ) {
        let portal = Portal { cells, polygon, door, closed, ..Portal::default() };
        self.b.model.cells.portals.push(portal);
    }

    /// The portal of a hole, in the middle of its wall.
    fn outline(line: Line, h: Hole) -> Vec<[f64; 3]> {
        let at = |along: f64, y: f64| line.along.point(along, line.floor + y, line.across);
        vec![at(h.from, h.sill), at(h.to, h.sill), at(h.to, h.head), at(h.from, h.head)]
    }

    fn opening(&mut self, line: Line, h: Hole, cells: [u32; 2]) {
        self.portal(cells, Self::outline(line, h), None, false);
    }

    /// A door in a hole: shut, or open into the second cell.
    fn door(&mut self, line: Line, h: Hole, cells: [u32; 2]) -> Result<(), SceneSpecError> {
        let shut = self.rng.chance(self.shut);
        // The leaf runs along +x from its hinge; a quarter turn takes it to −z, three to +z.
        let turns = match (line.along, shut) {
            (Along::X, true) => 0.0,
            (Along::X, false) => 0.75,
            (Along::Z, true) => 0.75,
            (Along::Z, false) => 0.0,
        };
        let across = if shut { 0.0 } else { WALL * 0.5 + 0.03 };
        let hinge = if shut { h.from } else { h.from - 0.04 };
        let at = line.along.point(hinge, line.floor, line.across + across);
        let leaf = self.b.add(self.leaf, turned(turns, [1.0; 3], at))?;
        self.portal(cells, Self::outline(line, h), Some(leaf), shut);
        Ok(())
    }
}

/// Where a wall across the building stands: between the walls of its ends.
fn span_of(lines: &[f64]) -> [f64; 2] {
    let end = |x: Option<&f64>| x.copied().unwrap_or_default();
    [end(lines.first()) + WALL * 0.5 - LAP, end(lines.last()) - WALL * 0.5 + LAP]
}
