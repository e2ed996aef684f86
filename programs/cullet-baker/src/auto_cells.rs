//! Cells of a model that brings none: found in its triangles.

use std::path::Path;
use std::time::Instant;

use cullet::{Handle, prepared::Preparation};
use cullet_bake::room_volumes::{RoomCells, RoomOptions, cells_of_rooms};
use cullet_bake::rooms::{FindOptions, FoundCells, FoundFigures, RoomsError, find_cells};
use cullet_command::args::SceneArgs;
use cullet_io::{LoadOptions, Model};

use cullet_command::console::{Console, count, digits, grouped, interrupted, percent};
use cullet_command::exit::{Exit, Failure};

/// Value of `--cells` for cells that are found.
pub(crate) const AUTO: &str = "auto";

/// Gives a model the cells of `--cells`: those found in it, or those that volumes of rooms make.
///
/// # Errors
/// If none can be made.
pub(crate) fn give(model: &mut Model, args: &SceneArgs, console: &Console) -> Result<(), Failure> {
    match &args.cells {
        Some(word) if word.as_os_str() == AUTO => find(model, args.voxel, console),
        _ if args.voxel.is_some() => {
            Err(Failure::usage("--voxel is of use with --cells auto alone"))
        }
        Some(rooms) => take_rooms(model, rooms, args),
        None => Ok(()),
    }
}

/// Gives a model the cells that volumes of rooms make of it, in place of its own.
fn take_rooms(model: &mut Model, path: &Path, args: &SceneArgs) -> Result<(), Failure> {
    let options = LoadOptions {
        up: args.up,
        levels: false,
        prepare: Preparation::NONE,
        ..LoadOptions::default()
    };
    let volumes = cullet_maps::load(path, &options).map_err(Failure::input)?;
    let RoomCells { cells, warnings } = cells_of_rooms(model, &volumes, &RoomOptions::default());
    if cells.cells.is_empty() {
        let message =
            format!("{}: none of its meshes encloses the volume of a room", path.display());
        return Err(Failure::input(message));
    }
    (model.cells, model.cell_sets) = (cells, None);
    model.place_cells().map_err(|e| Failure::input(format!("{}: {e}", path.display())))?;
    model.warnings.extend(warnings);
    Ok(())
}

/// Gives a model the cells that are found in its triangles, in place of its own. Doors and windows
/// hide nothing: leafs of the doors of its own portals, and instances whose names begin as those of
/// a BIM model do.
///
/// # Errors
/// If it moves, for then what hides would not stay where it is; if nothing in it is closed; if
/// there are too many voxels.
pub(crate) fn find(
    model: &mut Model,
    voxel: Option<f64>,
    console: &Console,
) -> Result<(), Failure> {
    let failure = |e: &dyn std::fmt::Display| format!("{}: no cells found: {e}", model.name);
    if model.motion.as_ref().is_some_and(cullet_io::Motion::moves) {
        return Err(Failure::input(failure(&"what moves in it would hide as if it stood still")));
    }
    let begin = Instant::now();
    let mut options = FindOptions::default().with_ignored(openings(model));
    options.voxel = voxel;
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let mut bar = None;
    let step = |step: cullet_bake::rooms::FindStep| {
        bar.get_or_insert_with(|| console.progress("finding cells", step.of.into())).step();
        !interrupted()
    };
    let found = find_cells(&model.scene, &options, threads, step, || !interrupted());
    drop(bar);
    let found = found.map_err(|e| {
        let exit = match e {
            RoomsError::Setting { .. } => Exit::Usage,
            RoomsError::TooMany { .. } | RoomsError::TooDense { .. } => Exit::Limit,
            RoomsError::Stopped => Exit::Interrupted,
            _ => Exit::Input,
        };
        let hint = match e {
            RoomsError::TooMany { .. }
            | RoomsError::TooDense { .. }
            | RoomsError::OneCell { .. } => "; --voxel sets their size",
            _ => "",
        };
        Failure { exit, message: failure(&format!("{e}{hint}")) }
    })?;
    note(&found, begin.elapsed().as_secs_f64(), &model.name, console);
    (model.cells, model.cell_sets) = (found.into_graph(), None);
    model.place_cells().map_err(|e| Failure::input(format!("{}: {e}", model.name)))
}

/// Instances that may open.
fn openings(model: &Model) -> Vec<Handle> {
    let names = RoomOptions::default().openings;
    let opens = |handle: &Handle| {
        let name = model.instance_name(*handle);
        names.iter().any(|opening| name.starts_with(opening.as_str()))
    };
    let handles = model.scene.slots().filter_map(|slot| model.scene.handle(slot));
    let mut all: Vec<Handle> = handles.filter(opens).collect();
    all.extend(model.cells.portals.iter().filter_map(|portal| portal.door));
    all.sort_unstable();
    all.dedup();
    all
}

fn note(found: &FoundCells, seconds: f64, name: &str, console: &Console) {
    let FoundFigures { voxel, free, touched, solid, walls, instances, .. } = found.figures;
    console.note(format!(
        "{name}: {} and {} found in {} s: {} voxels of {}, {} free; {} hide, of {}",
        count(found.cells.len() as u64, "cell", "cells"),
        count(found.portals.len() as u64, "portal", "portals"),
        digits(seconds),
        grouped(free + touched + solid),
        digits(voxel),
        percent(free, free + touched + solid),
        grouped(walls.into()),
        count(instances.into(), "instance", "instances"),
    ));
    // A door has one to four rectangles where its wall stands askew.
    if found.portals.len() > 12 * found.cells.len() {
        console.note(format!(
            "{name}: walls may be thinner than a voxel, so that portals go through them; try --voxel {}",
            digits(voxel * 0.5)
        ));
    }
}
