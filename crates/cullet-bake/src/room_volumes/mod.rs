//! Cells of a building from the volumes of its rooms, as BIM models have them (`IfcSpace`).
//!
//! A volume says where a room is, not where one sees out of it. That is looked for along the border
//! of each: rays straight outward tell where the border is closed within a few centimetres, where
//! another room begins behind, and where neither is so. Whatever is not proven closed is a portal:
//! to the room behind, or to the *outside*, a cell that is wherever no room is.

mod borders;
mod solids;

use cullet::{Instance, Scene};
use glam::{DMat3, DVec3};

use borders::Borders;
use cullet_io::reader::Convex;
use cullet_io::reader::numbers;
use cullet_io::{Cell, CellGraph};
use cullet_io::{Model, Warning};

/// Settings of [`cells_of_rooms`], in world units; the defaults are for metres.
#[derive(Clone, Debug, PartialEq)]
pub struct RoomOptions {
    /// Distance of the rays along a border: an opening that is narrower may be missed, and what is
    /// seen through it alone is lost. Costs its inverse square. Default 0.05, at least 0.001.
    pub step: f64,
    /// How thick walls between rooms are, at the most: how far rays look for the room behind.
    /// Default 0.75.
    pub reach: f64,
    /// How far off the border of a volume its wall may stand and count as closing it; also
    /// [`CellGraph::walls`]. Default 0.05.
    pub walls: f64,
    /// Instances whose names begin so are doors and windows: rays go through them, shut as they may
    /// be. Default `IfcDoor`, `IfcWindow`.
    pub openings: Vec<String>,
}

impl Default for RoomOptions {
    fn default() -> Self {
        let openings = vec!["IfcDoor".into(), "IfcWindow".into()];
        Self { step: 0.05, reach: 0.75, walls: 0.05, openings }
    }
}

/// Cells that were made of rooms.
#[derive(Debug, Default)]
pub struct RoomCells {
    /// A cell for each volume, in order, with its name; the last is the outside, where any portal
    /// leads there.
    pub cells: CellGraph,
    /// Volumes that are none, and rooms that overlap.
    pub warnings: Vec<Warning>,
}

/// Cells of a model from the volumes of its rooms, which are the instances of another model in the
/// same world space: each a closed mesh, however it is wound. What two of them share belongs to the
/// first.
///
/// Portals are where a ray of a grid, from within a room straight through its border, meets nothing
/// within [`RoomOptions::walls`] / 2; all are open. They lead to the room that begins behind within
/// [`RoomOptions::reach`], if the ray meets nothing before, or to the outside. So what a model does
/// not close is no loss, but makes for more that is seen.
///
/// Cost: a ray for each square of [`RoomOptions::step`] of all borders.
#[must_use]
pub fn cells_of_rooms(model: &Model, rooms: &Model, options: &RoomOptions) -> RoomCells {
    let mut out = RoomCells::default();
    let mut names = Vec::new();
    let mut pieces: Vec<(u32, Convex)> = Vec::new();
    let mut slots: Vec<u32> = rooms.scene.slots().collect();
    slots.sort_by_key(|&slot| rooms.scene.handle(slot));
    for slot in slots {
        let Some(handle) = rooms.scene.handle(slot) else { continue };
        let name = rooms.instance_name(handle).into_owned();
        let own = match solids::pieces(&triangles(&rooms.scene, slot)) {
            Ok(own) => own,
            Err(why) => {
                let message = format!("{why}, and is no cell");
                out.warnings.push(Warning { item: format!("room “{name}”"), message });
                continue;
            }
        };
        let number = names.len() as u32;
        let whole: f64 = own.iter().map(Convex::volume).sum();
        let mut left = own;
        for (_, other) in &pieces {
            if left.iter().any(|piece| meet(piece, other)) {
                let rest = left.iter().flat_map(|piece| {
                    if meet(piece, other) { piece.without(other) } else { vec![piece.clone()] }
                });
                left = rest.collect();
            }
        }
        let rest: f64 = left.iter().map(Convex::volume).sum();
        if rest < whole * 0.99 {
            let share = 100.0 * (1.0 - rest / whole);
            let message = format!("shares {share:.0} % of its volume with rooms before it");
            out.warnings.push(Warning { item: format!("room “{name}”"), message });
        }
        names.push(name);
        pieces.extend(left.into_iter().map(|piece| (number, piece)));
    }
    let outside = names.len() as u32;
    out.cells.walls = options.walls.max(0.0);
    out.cells.cells = names.into_iter().map(|name| Cell { name, ..Cell::default() }).collect();
    out.cells.cells.push(Cell { name: "outside".into(), ..Cell::default() });
    for (room, piece) in &pieces {
        let planes = piece.faces().map(|(plane, _)| numbers(plane)).collect();
        out.cells.cells[*room as usize].pieces.push(planes);
    }
    let scene = without_openings(model, &options.openings);
    let borders = Borders { scene: &scene, pieces: &pieces, outside, options };
    borders.find(&mut out.cells);
    if !out.cells.portals.iter().any(|portal| portal.cells.contains(&outside)) {
        out.cells.cells.pop();
    }
    out
}

/// Whether the boxes of two pieces share more than a border.
fn meet(a: &Convex, b: &Convex) -> bool {
    let (Some([a_low, a_high]), Some([b_low, b_high])) = (a.bounds(), b.bounds()) else {
        return false;
    };
    (0..3).all(|k| a_low[k] + solids::ON < b_high[k] && b_low[k] + solids::ON < a_high[k])
}

/// The triangles of an instance in world space.
fn triangles(scene: &Scene, slot: u32) -> Vec<[DVec3; 3]> {
    let (mesh, transform) = (scene.mesh(slot), scene.transform(slot));
    let linear = DMat3::from_cols_array_2d(&transform.linear.map(|c| c.map(f64::from)));
    let place = DVec3::from(transform.translation);
    let world = |p: [f32; 3]| linear * DVec3::from(p.map(f64::from)) + place;
    let all = (0..mesh.triangle_count()).map(|t| mesh.corners(t).map(world));
    all.filter(|corners| corners.iter().all(|p| p.is_finite())).collect()
}

/// The scene of a model without its doors and windows, for rays.
fn without_openings(model: &Model, openings: &[String]) -> Scene {
    let mut scene = Scene::new();
    for mesh in model.scene.meshes() {
        scene.add_mesh(mesh.clone());
    }
    for slot in model.scene.slots() {
        let Some(handle) = model.scene.handle(slot) else { continue };
        let name = model.instance_name(handle);
        if openings.iter().any(|opening| name.starts_with(opening.as_str())) {
            continue;
        }
        let instance = Instance::new(model.scene.mesh_id(slot), *model.scene.transform(slot));
        // One that the model has can be had here.
        let _ = scene.add(instance);
    }
    scene.commit(&cullet::Culler::default());
    scene
}
