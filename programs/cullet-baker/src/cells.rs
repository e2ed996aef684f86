//! `cullet cells`: the cells of a scene, and the scene written with them.

use std::path::PathBuf;

use crate::auto_cells::AUTO;
use clap::Args;
use cullet_command::args::SceneArgs;
use cullet_command::console::{Console, count, grouped};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::files::write_results;
use cullet_command::inputs;
use cullet_io::{Model, SaveFormat};
use serde::Serialize;

use cullet_cli::SCHEMA;

/// End of `cullet cells --help`.
pub(crate) const HELP: &str = "\
Cells are those of the scene itself (a map, office, a glTF with CULLET_cells_portals), or with --cells
those made of the volumes of its rooms, or with --auto those found in its triangles. -o writes the scene with them as a GLB, so that they are found
only once; every command that culls uses them.

Examples
  cullet cells lqdm1.bsp                                      how many cells and portals a map has
  cullet cells house.glb --cells rooms.glb -o house-cells.glb
  cullet cells house.glb --auto --voxel 0.06                  the rooms that its walls enclose
  cullet verify house-cells.glb --only portal                 nothing may be lost by them";

/// `cullet cells`
#[derive(Debug, Args)]
pub struct CellsArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    /// Find the rooms of a closed interior: the same as --cells auto
    #[arg(long, conflicts_with = "cells")]
    pub(crate) auto: bool,
    /// Write the scene with its cells: a .glb
    #[arg(long, short, value_name = "PATH", value_parser = cullet_command::parse::output)]
    pub(crate) out: Option<PathBuf>,
    /// Write the result as JSON; - is the standard output
    #[arg(long, value_name = "PATH", value_parser = cullet_command::parse::output)]
    pub(crate) json: Option<PathBuf>,
}

#[derive(Serialize)]
struct CellsRecord {
    schema: u32,
    scene: String,
    cells: usize,
    pieces: usize,
    portals: usize,
    doors: usize,
    one_way: usize,
    closed: usize,
    mirrors: usize,
    /// Volume of all pieces, in cubic units.
    volume: f64,
    /// Cells that no portal leads to.
    without_portals: usize,
    instances: u32,
    /// Instances that touch no cell: they are seen from everywhere.
    in_no_cell: u32,
    triangles: u64,
    triangles_in_no_cell: u64,
}

/// Runs the command.
pub(crate) fn run(args: &CellsArgs, console: &Console) -> Outcome {
    // Known before the work is done.
    if let Some(out) = args.out.as_deref().filter(|p| SaveFormat::of(p) != Some(SaveFormat::Glb)) {
        let message = format!("{}: cells are kept by .glb files alone", out.display());
        return Err(Failure::usage(message));
    }
    let mut scene = args.scene.clone();
    if args.auto {
        scene.cells = Some(AUTO.into());
    }
    let model = inputs::load_to_save(&scene, console)?;
    if model.cells.cells.is_empty() {
        return Err(Failure::input(format!(
            "{}: it has no cells; --auto finds them, --cells FILE makes them of the \
             volumes of its rooms",
            model.name
        )));
    }
    let record = measure(&model);
    print(&record, console);
    write_results(&model, args.out.as_deref(), &record, args.json.as_deref(), console)?;
    Ok(Exit::Fine)
}

fn measure(model: &Model) -> CellsRecord {
    let (cells, scene) = (&model.cells, &model.scene);
    let mut led = vec![false; cells.cells.len()];
    let ends = cells.portals.iter().flat_map(|portal| portal.cells);
    ends.for_each(|cell| led[cell as usize] = true);
    let is_nowhere =
        |slot: &u32| model.placed.as_ref().is_none_or(|cells| cells.cells_of(*slot).is_empty());
    let nowhere: Vec<u32> = scene.slots().filter(is_nowhere).collect();
    let triangles = |slot: &u32| u64::from(scene.mesh(*slot).triangle_count());
    CellsRecord {
        schema: SCHEMA,
        scene: model.name.clone(),
        cells: cells.cells.len(),
        pieces: cells.cells.iter().map(|cell| cell.pieces.len()).sum(),
        portals: cells.portals.len(),
        doors: cells.portals.iter().filter(|portal| portal.door.is_some()).count(),
        one_way: cells.portals.iter().filter(|portal| portal.one_way).count(),
        closed: cells.portals.iter().filter(|portal| portal.closed).count(),
        mirrors: cells.mirrors.len(),
        volume: cells.cells.iter().map(cullet_io::Cell::volume).sum(),
        without_portals: led.iter().filter(|led| !**led).count(),
        instances: scene.instance_count(),
        in_no_cell: nowhere.len() as u32,
        triangles: scene.triangle_count(),
        triangles_in_no_cell: nowhere.iter().map(triangles).sum(),
    }
}

fn print(r: &CellsRecord, console: &Console) {
    let of = |n: usize, one: &str, many: &str| count(n as u64, one, many);
    console.line(format!(
        "{}: {} of {}, {:.1} cubic units; {} ({} with a door, {} shut, {} one-way), {}",
        r.scene,
        of(r.cells, "cell", "cells"),
        of(r.pieces, "convex piece", "convex pieces"),
        r.volume,
        of(r.portals, "portal", "portals"),
        r.doors,
        r.closed,
        r.one_way,
        of(r.mirrors, "mirror", "mirrors"),
    ));
    if r.without_portals > 0 {
        let cells = of(r.without_portals, "cell has", "cells have");
        console.line(format!("{cells} no portal: what is in them is seen from within alone"));
    }
    console.line(format!(
        "{} of {} ({} of {} triangles) touch no cell, and are seen from everywhere",
        grouped(r.in_no_cell.into()),
        of(r.instances as usize, "instance", "instances"),
        grouped(r.triangles_in_no_cell),
        grouped(r.triangles),
    ));
}
