//! Cells that are found in triangles alone: lines of sight against portals, rooms against a plan, bytes against threads.

use cullet::mesh::Mesh;
use cullet::{Instance, InstanceFlags, Scene, Transform};
use cullet_bake::rooms::{FindOptions, FoundCells, RoomsError, find_cells};
use cullet_bake::sampled::{RayTree, RayTreeOptions};
use cullet_cells::Cells;
use cullet_cells::cell::{CellGraph, CellLocator, CellShapes};
use cullet_testkit::{Rng, cases, meshes};

/// A building of one storey, turned about its height and moved.
struct Plan {
    scene: Scene,
    /// The middle of each room.
    rooms: Vec<[f64; 3]>,
    doors: usize,
}

const HEIGHT: f64 = 2.6;

/// Adds boxes in the axes of a plan.
struct Builder {
    scene: Scene,
    cube: u32,
    turn: f64,
    offset: [f64; 3],
}

impl Builder {
    fn new(turn: f64, offset: [f64; 3]) -> Self {
        let mut scene = Scene::new();
        let cube = scene.add_mesh(meshes::block([0.0; 3], [1.0; 3]));
        Self { scene, cube, turn, offset }
    }

    fn place(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let (sin, cos) = self.turn.sin_cos();
        let [ox, oy, oz] = self.offset;
        [ox + cos * x + sin * z, oy + y, oz - sin * x + cos * z]
    }

    fn block(&mut self, low: [f64; 3], high: [f64; 3]) {
        let (sin, cos) = self.turn.sin_cos();
        let [x, y, z]: [f64; 3] = std::array::from_fn(|a| high[a] - low[a]);
        let linear = [[cos * x, 0.0, -sin * x], [0.0, y, 0.0], [sin * z, 0.0, cos * z]];
        let transform = Transform {
            linear: linear.map(|column| column.map(|v| v as f32)),
            translation: self.place(low),
        };
        self.scene.add(Instance::new(self.cube, transform)).expect("a mesh");
    }

    /// A wall of a plan, with a door: the thickness is about a line `at` along `axis` 0 or 2.
    fn wall(&mut self, axis: usize, at: f64, span: [f64; 2], thick: f64, door: Option<[f64; 2]>) {
        let other = 2 - axis;
        let mut part = |from: f64, to: f64, bottom: f64, top: f64| {
            let (mut low, mut high) = ([0.0, bottom, 0.0], [0.0, top, 0.0]);
            (low[axis], high[axis]) = (at - thick * 0.5, at + thick * 0.5);
            (low[other], high[other]) = (from, to);
            self.block(low, high);
        };
        let Some([from, to]) = door else {
            part(span[0], span[1], 0.0, HEIGHT);
            return;
        };
        part(span[0], from, 0.0, HEIGHT);
        part(to, span[1], 0.0, HEIGHT);
        part(from, to, 2.05, HEIGHT);
    }
}

/// Rooms in rows, walls as thick as between the two, doors in most of them, things in the rooms, and a roof.
fn plan(rng: &mut Rng, thick: [f64; 2], turn: f64) -> Plan {
    let offset = [rng.signed() * 30.0, rng.signed() * 3.0, rng.signed() * 30.0];
    let mut b = Builder::new(turn, offset);
    let lines = |rng: &mut Rng, count: usize| {
        let mut lines = vec![0.0];
        (0..count).for_each(|i| lines.push(lines[i] + rng.range(2.4, 4.2)));
        lines
    };
    let (xs, zs) = (lines(rng, 3), lines(rng, 2));
    let (width, depth) = (xs[xs.len() - 1], zs[zs.len() - 1]);
    let reach = 0.4;
    b.block([-reach, -0.3, -reach], [width + reach, 0.0, depth + reach]);
    b.block([-reach, HEIGHT, -reach], [width + reach, HEIGHT + 0.25, depth + reach]);
    let mut doors = 0;
    let mut walls = |rng: &mut Rng, b: &mut Builder, axis: usize, own: &[f64], others: &[f64]| {
        for (i, &at) in own.iter().enumerate() {
            let outer = i == 0 || i + 1 == own.len();
            for span in others.windows(2) {
                let t = rng.range(thick[0], thick[1]);
                let door = (!outer && rng.chance(0.8)).then(|| {
                    let from = rng.range(span[0] + 0.5, span[1] - 1.4);
                    [from, from + rng.range(0.7, 0.9)]
                });
                doors += usize::from(door.is_some());
                // Some reach into what they meet, some only touch it.
                let lap = if rng.chance(0.5) { t * 0.4 } else { 0.0 };
                b.wall(axis, at, [span[0] - lap, span[1] + lap], t, door);
            }
        }
        // Posts where walls meet, so that no corner is open.
        for &at in own {
            for &across in others {
                let (mut low, mut high) = ([0.0; 3], [0.0, HEIGHT, 0.0]);
                let half = thick[1] * 0.5;
                (low[axis], high[axis]) = (at - half, at + half);
                (low[2 - axis], high[2 - axis]) = (across - half, across + half);
                b.block(low, high);
            }
        }
    };
    walls(rng, &mut b, 0, &xs, &zs);
    walls(rng, &mut b, 2, &zs, &xs);
    let mut rooms = Vec::new();
    for x in xs.windows(2) {
        for z in zs.windows(2) {
            rooms.push(b.place([(x[0] + x[1]) * 0.5, 1.9, (z[0] + z[1]) * 0.5]));
            // Things that stand about, some at a wall.
            for _ in 0..3 {
                let size = [rng.range(0.1, 0.6), rng.range(0.1, 1.0), rng.range(0.1, 0.6)];
                let low = [
                    rng.range(x[0], x[1] - size[0]),
                    rng.range(0.0, 0.5),
                    rng.range(z[0], z[1] - size[2]),
                ];
                b.block(low, std::array::from_fn(|a| low[a] + size[a]));
            }
        }
    }
    let mut scene = b.scene;
    scene.commit(&cullet::Culler::default());
    Plan { scene, rooms, doors }
}

fn found(scene: &Scene, options: &FindOptions, threads: usize) -> Result<FoundCells, RoomsError> {
    find_cells(scene, options, threads, |_| true, || true)
}

/// The cell at the end of a segment that begins in a cell: through portals in the order in which it meets them.
fn walked(graph: &CellGraph, from: [f64; 3], to: [f64; 3], mut cell: u32) -> u32 {
    let mut crossings: Vec<(f64, u32)> = Vec::new();
    for (number, portal) in (0..).zip(graph.portals()) {
        let axis = (0..3).find(|&a| portal.polygon.iter().all(|p| p[a] == portal.polygon[0][a]));
        let axis = axis.expect("a rectangle along the axes");
        let at = (portal.polygon[0][axis] - from[axis]) / (to[axis] - from[axis]);
        if !(0.0..=1.0).contains(&at) {
            continue;
        }
        let is_in = (0..3).filter(|&a| a != axis).all(|a| {
            let v = from[a] + (to[a] - from[a]) * at;
            let ends = portal.polygon.iter().map(|p| p[a]);
            let low = ends.clone().fold(f64::INFINITY, f64::min);
            low <= v && v <= ends.fold(f64::NEG_INFINITY, f64::max)
        });
        if is_in {
            crossings.push((at, number));
        }
    }
    crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (_, portal) in crossings {
        cell = graph.beyond(portal, cell).unwrap_or(cell);
    }
    cell
}

/// Looks from random places in cells in random directions, and follows each look through portals: to the cell of a place on
/// the way, and to those of what ends it. How many looks there were, and how many were lost.
fn looks(
    rng: &mut Rng,
    scene: &mut Scene,
    cells: &FoundCells,
    bounds: [[f64; 3]; 2],
    count: usize,
) -> [usize; 2] {
    let (graph, shapes) = cells.build().expect("cells that can be placed");
    let (again, places): (CellGraph, CellShapes) = cells.build().expect("cells");
    let placed = Cells::new(scene, again, places);
    let tree = RayTree::new(scene, &RayTreeOptions::default()).expect("a scene");
    let (mut done, mut lost) = (0, 0);
    for _ in 0..count * 20 {
        if done >= count {
            break;
        }
        let from: [f64; 3] =
            std::array::from_fn(|a| rng.range(bounds[0][a] - 0.5, bounds[1][a] + 0.5));
        let Some(cell) = shapes.cell_of(from) else { continue };
        let direction = rng.direction();
        let hit = tree.first_hit_ref(from, direction);
        let end = hit.as_ref().map_or(40.0, |hit| hit.distance);
        let at = |t: f64| std::array::from_fn(|a| from[a] + direction[a] * t);
        let middle: [f64; 3] = at(end * rng.unit());
        if let Some(there) = shapes.cell_of(middle) {
            done += 1;
            lost += usize::from(walked(&graph, from, middle, cell) != there);
        }
        if let Some(hit) = hit {
            done += 1;
            let last = walked(&graph, from, at(end), cell);
            let slot = scene
                .slots()
                .find(|&slot| scene.handle(slot).is_some_and(|h| h.index == hit.target));
            let slot = slot.expect("what is hit is there");
            lost += usize::from(!placed.cells_of(slot).contains(&last));
        }
    }
    [done, lost]
}

fn bounds(scene: &Scene) -> [[f64; 3]; 2] {
    RayTree::new(scene, &RayTreeOptions::default()).expect("a scene").bounds()
}

#[test]
fn no_line_of_sight_is_lost() {
    let mut rng = Rng(71);
    let [mut all, mut lost] = [0; 2];
    for case in 0..cases(24) {
        // Thick and thin, straight and slanted; walls thinner than a voxel too.
        let thick = [[0.16, 0.3], [0.05, 0.3], [0.02, 0.08]][case as usize % 3];
        let turn = if case % 2 == 0 { 0.0 } else { rng.signed() };
        let mut plan = plan(&mut rng, thick, turn);
        let voxel = rng.range(0.07, 0.13);
        let options = FindOptions::default().with_voxel(voxel);
        let cells = match found(&plan.scene, &options, 2) {
            Ok(cells) => cells,
            // Walls are all thinner than a voxel then.
            Err(RoomsError::OneCell { .. }) if thick[0] < 0.1 => continue,
            Err(e) => panic!("case {case}: {e}"),
        };
        let bounds = bounds(&plan.scene);
        let looked = looks(&mut rng, &mut plan.scene, &cells, bounds, 1000);
        assert_eq!(looked[1], 0, "case {case}: {} of {} looks are lost", looked[1], looked[0]);
        all += looked[0];
        lost += looked[1];
    }
    eprintln!("{all} looks, {lost} lost");
    assert!(all >= 1000);
}

#[test]
fn cells_are_the_rooms_of_a_plan() {
    let mut rng = Rng(5);
    let (mut rooms, mut cells, mut doors, mut portals) = (0, 0, 0, 0);
    for case in 0..cases(8) {
        let turn = if case % 2 == 0 { 0.0 } else { rng.range(-0.4, 0.4) };
        let plan = plan(&mut rng, [0.2, 0.3], turn);
        let options = FindOptions::default().with_voxel(0.08);
        let found = found(&plan.scene, &options, 2).expect("rooms");
        let (graph, shapes) = found.build().expect("cells that can be placed");
        let mut own: Vec<u32> =
            plan.rooms.iter().map(|&p| shapes.cell_of(p).expect("a room is free")).collect();
        own.sort_unstable();
        own.dedup();
        assert_eq!(own.len(), plan.rooms.len(), "case {case}: two rooms are one cell");
        // Nothing leads outside.
        assert!(graph.portals_of(0).is_empty(), "case {case}");
        rooms += plan.rooms.len();
        doors += plan.doors;
        cells += found.cells.len() - 1;
        let mut pairs: Vec<[u32; 2]> = graph.portals().iter().map(|p| p.cells).collect();
        pairs.iter_mut().for_each(|pair| pair.sort_unstable());
        pairs.sort_unstable();
        pairs.dedup();
        // Two rooms that no door joins may be joined by none.
        assert!(
            pairs.len() <= plan.doors + found.cells.len() - 1 - plan.rooms.len(),
            "case {case}"
        );
        portals += found.portals.len();
    }
    eprintln!("{cells} cells of {rooms} rooms, {portals} portals of {doors} doors");
    assert!(cells <= rooms + rooms / 8, "{cells} cells of {rooms} rooms");
    assert!(portals <= doors * 3, "{portals} portals of {doors} doors");
}

#[test]
fn an_eye_at_a_surface_is_in_no_cell() {
    let mut rng = Rng(9);
    for case in 0..cases(4) {
        let plan = plan(&mut rng, [0.15, 0.3], f64::from(case) * 0.2);
        let voxel = 0.1;
        let cells =
            found(&plan.scene, &FindOptions::default().with_voxel(voxel), 2).expect("rooms");
        let (_, shapes) = cells.build().expect("cells that can be placed");
        let tree = RayTree::new(&plan.scene, &RayTreeOptions::default()).expect("a scene");
        let mut tried = 0;
        for slot in plan.scene.slots() {
            let mesh = plan.scene.mesh(slot);
            let transform = plan.scene.transform(slot);
            let bounds = plan.scene.bounds(slot);
            let mut sizes: [f32; 3] = std::array::from_fn(|a| bounds.max[a] - bounds.min[a]);
            sizes.sort_by(f32::total_cmp);
            // What is small is no wall: one may stand in it.
            if sizes[1] < 4.5 * voxel as f32 {
                continue;
            }
            for t in 0..mesh.triangle_count() {
                let corners = mesh.corners(t);
                let share = [rng.unit(), rng.unit()];
                let middle: [f64; 3] = std::array::from_fn(|a| {
                    let [p, q, r] = corners.map(|p| f64::from(p[a]));
                    p + (q - p) * share[0] + (r - q) * share[0] * share[1]
                });
                let at: [f64; 3] = std::array::from_fn(|a| {
                    let row = (0..3).map(|b| f64::from(transform.linear[b][a]) * middle[b]);
                    transform.translation[a] + row.sum::<f64>()
                });
                assert_eq!(shapes.cell_of(at), None, "case {case}: at {at:?}");
                tried += 1;
            }
        }
        assert!(tried > 50 && tree.triangle_count() > 0);
    }
}

#[test]
fn threads_change_nothing() {
    let mut rng = Rng(3);
    let plan = plan(&mut rng, [0.1, 0.3], 0.2);
    let options = FindOptions::default().with_voxel(0.12);
    let one = found(&plan.scene, &options, 1).expect("rooms");
    assert!(found(&plan.scene, &options, 5).expect("rooms") == one);
}

#[test]
fn what_is_ignored_or_transparent_hides_nothing() {
    let mut b = Builder::new(0.0, [0.0; 3]);
    b.block([-0.3, -0.3, -0.3], [8.3, 0.0, 4.3]);
    b.block([-0.3, HEIGHT, -0.3], [8.3, HEIGHT + 0.3, 4.3]);
    for (axis, at, span) in
        [(0, 0.0, [-0.1, 4.1]), (0, 8.0, [-0.1, 4.1]), (2, 0.0, [0.0, 8.0]), (2, 4.0, [0.0, 8.0])]
    {
        b.wall(axis, at, span, 0.25, None);
    }
    b.wall(0, 4.0, [0.0, 4.0], 0.25, Some([1.5, 2.4]));
    // The leaf of the door, and a little more.
    let leaf = b.scene.add(Instance::new(
        b.cube,
        Transform {
            linear: [[0.25, 0.0, 0.0], [0.0, 2.06, 0.0], [0.0, 0.0, 0.92]],
            translation: [3.875, 0.0, 1.49],
        },
    ));
    let leaf = leaf.expect("a mesh");
    b.scene.commit(&cullet::Culler::default());
    let options = FindOptions::default().with_voxel(0.1);
    let shut = found(&b.scene, &options, 1).expect("rooms");
    assert_eq!((shut.cells.len(), shut.portals.len()), (3, 0));
    let open = found(&b.scene, &options.clone().with_ignored(vec![leaf]), 1).expect("rooms");
    assert_eq!(open.cells.len(), 3);
    assert!(!open.portals.is_empty() && open.portals.len() <= 4, "{}", open.portals.len());
    let flags = InstanceFlags { transparent: true, ..InstanceFlags::default() };
    b.scene.set_flags(leaf, flags).expect("it is there");
    b.scene.commit(&cullet::Culler::default());
    assert_eq!(found(&b.scene, &options, 1).expect("rooms"), open);
}

#[test]
fn what_cannot_be_cells_is_a_named_error() {
    let none = Scene::new();
    let options = FindOptions::default();
    assert!(matches!(found(&none, &options, 1), Err(RoomsError::NoWalls { instances: 0 })));
    let mut open = Builder::new(0.0, [0.0; 3]);
    open.block([0.0; 3], [10.0, 0.3, 10.0]);
    open.scene.commit(&cullet::Culler::default());
    let result = found(&open.scene, &options.clone().with_voxel(0.1), 1);
    assert!(matches!(result, Err(RoomsError::OneCell { .. })), "{result:?}");
    let result = found(&open.scene, &options.clone().with_voxel(1e-4), 1);
    let Err(RoomsError::TooMany { fits, .. }) = result else { panic!("{result:?}") };
    // 10 x 0.3 x 10, and what is around it.
    let voxels = (10.0 / fits + 2.0).powi(2) * (0.3 / fits + 2.0);
    assert!((0.9..1.0).contains(&(voxels / FindOptions::MOST_VOXELS as f64)), "{fits}");
    for voxel in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let result = found(&open.scene, &options.clone().with_voxel(voxel), 1);
        assert!(matches!(result, Err(RoomsError::Setting { name: "voxel", .. })), "{voxel}");
    }
    let stopped = find_cells(&open.scene, &options, 1, |_| true, || false);
    assert_eq!(stopped, Err(RoomsError::Stopped));
    // A triangle is no wall.
    let mut flat = Scene::new();
    let mesh = Mesh::new(cullet::MeshData {
        positions: vec![[0.0; 3], [9.0, 0.0, 0.0], [0.0, 0.0, 9.0]],
        indices: vec![0, 1, 2],
        ..cullet::MeshData::default()
    });
    let mesh = flat.add_mesh(mesh.expect("a triangle"));
    flat.add(Instance::new(mesh, Transform::from_translation([0.0; 3]))).expect("a mesh");
    flat.commit(&cullet::Culler::default());
    assert!(matches!(found(&flat, &options, 1), Err(RoomsError::NoWalls { instances: 1 })));
}
