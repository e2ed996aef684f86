//! `cullet tiles`: a scene as 3D Tiles, with coarse stand-ins and rows of view cells.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use cullet::Mesh;
use cullet_bake::stand_in::{MeshAttributes, StandIn, StandInOptions, StandIns};
use cullet_cli::levels::Wanted;
use cullet_command::args::SceneArgs;
use cullet_command::console::{Console, count, digits, grouped, interrupted};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::files::write_json;
use cullet_command::{inputs, sets};
use cullet_io::{Attributes, Model};
use cullet_maps::GlobePlace;
use cullet_maps::TileInput;
use cullet_maps::TileSets;
use cullet_maps::TileStandIn;
use cullet_maps::WriteTiles;
use cullet_maps::write_tiles_with;
use serde::Serialize;

use cullet_cli::levels;

/// End of `cullet tiles --help`.
pub(crate) const HELP: &str = "\
Writes 3D Tiles 1.1, which CesiumJS, Unreal, Unity and others show: tileset.json and a GLB for each tile. Each instance is in one
tile; large ones stand high up in the tree of tiles and are loaded first, small ones far down and are loaded where the eye comes near. Levels of
detail and occluders of a baked scene are written with their meshes; impostors, textures, cameras, cells and motions are not.

With --stand-ins what is far away is shown coarse instead of not at all: a tile shows one mesh in the place of all that is below it, made of the
levels of detail and merged groups that the scene was baked with, and the tiles below replace it. A scene without levels is baked first, once.

With --at the scene stands at a place on the globe (WGS 84, its units metres): +X is east, +Y up, +Z south. Each tile then has a horizon
occlusion point (extension 3DTILES_horizon_occlusion_point, a draft of 3D Tiles 2.0), by which viewers of globes drop it beyond the horizon.

With --pvs, the sets of `cullet pvs` for this scene, each view cell has a row that says which tiles can be seen from it, and those are
loaded before all others while the eye is in the cell.

The world is shown tile by tile by the crate cullet-tiles (FolderTiles) and by `cullet fly`, within a budget of memory, and as one model by every
command that takes a scene.

Examples
  cullet tiles city.glb -o city                        city/tileset.json, and city/tiles
  cullet tiles city:objects=100000 -o city             a built-in scene
  cullet tiles castle.glb --stand-ins -o castle        with coarse stand-ins
  cullet bake castle.glb -o b.glb --merge --occluders && cullet tiles b.glb --stand-ins -o castle     with all that is baked
  cullet pvs city -o city.cpvs && cullet tiles city --pvs city.cpvs -o city                  with rows for view cells
  cullet tiles plant.glb -o plant --triangles 20000    smaller tiles
  cullet tiles city.glb -o city --at 13.4,52.5,34      on the globe: degrees east and north, metres above the ellipsoid
  cullet report city/tileset.json                      what of all of it is drawn for nothing";

/// `cullet tiles`
#[derive(Debug, Args)]
pub struct TilesArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// The folder to write into; made where it is not there
    #[arg(long, short, value_name = "FOLDER")]
    out: PathBuf,
    /// Cut tiles that have more triangles, each instance counted
    #[arg(long, value_name = "N", default_value_t = WriteTiles::default().triangles, value_parser = clap::value_parser!(u64).range(1..))]
    triangles: u64,
    /// Cut tiles that have more instances
    #[arg(long, value_name = "N", default_value_t = WriteTiles::default().instances, value_parser = clap::value_parser!(u32).range(1..))]
    instances: u32,
    /// Show coarse stand-ins in tiles that others are below, which those replace
    #[arg(long)]
    stand_ins: bool,
    /// The most triangles of a stand-in
    #[arg(long, value_name = "N", requires = "stand_ins", default_value_t = StandInOptions::default().triangles, value_parser = clap::value_parser!(u64).range(1..))]
    stand_in_triangles: u64,
    /// Place of the scene's origin on the globe: longitude and latitude in degrees, and metres above the ellipsoid
    #[arg(long, value_name = "LON,LAT[,HEIGHT]", allow_hyphen_values = true)]
    at: Option<GlobePlace>,
    /// Write the figures as JSON; - is the standard output
    #[arg(long, value_name = "PATH", value_parser = cullet_command::parse::output)]
    pub(crate) json: Option<PathBuf>,
}

/// The figures.
#[derive(Debug, Serialize)]
struct Record {
    schema: u32,
    /// Instances and triangles in the files, without stand-ins.
    instances: u64,
    triangles: u64,
    /// Tiles, and those of them that show something.
    tiles: u32,
    tiles_with_content: u32,
    /// Tiles that show a stand-in, with the triangles of all of these and the largest error of one,
    /// in units of the scene.
    stand_ins: u32,
    stand_in_triangles: u64,
    stand_in_error: f64,
    /// View cells with a row of tiles.
    cells: u32,
    /// Tiles with a horizon occlusion point.
    horizon_points: u32,
    /// How often a tile is cut at the most.
    depth: u32,
    bytes: u64,
    seconds: f64,
}

/// Runs the command.
pub(crate) fn run(args: &TilesArgs, console: &Console) -> Outcome {
    let tileset = args.out.join("tileset.json");
    if std::path::Path::new(&args.scene.scene) == tileset {
        return Err(Failure::usage(
            "a tileset cannot be written over itself; give another folder to --out",
        ));
    }
    let model = load(args, console)?;
    let sets = match &args.scene.pvs {
        Some(path) => Some(sets::of_scene(path)?.ok_or_else(|| {
            let message = "sets of cells of a map or model; tiles take those of view cells, which `cullet pvs` makes of scenes without cells";
            Failure::usage(format!("{}: {message}", path.display()))
        })?),
        None => None,
    };
    let start = Instant::now();
    let mut options = WriteTiles::default();
    (options.triangles, options.instances) = (args.triangles, args.instances);
    options.place = args.at;
    let attributes: Vec<MeshAttributes<'_>> = model
        .attributes
        .iter()
        .map(|a| MeshAttributes { uvs: &a.uvs, colors: &a.colors })
        .collect();
    let of_triangles = StandInOptions::default().with_triangles(args.stand_in_triangles);
    let stand_ins = StandIns::new(&model.scene, &attributes, of_triangles);
    let stand_in = |slots: &[u32], least: f64| stand_ins.of(slots, least).and_then(as_tile);
    let mut input = TileInput::default();
    if args.stand_ins {
        input = input.with_stand_ins(&stand_in);
    }
    if let Some(sets) = &sets {
        input = input.with_sets(TileSets { cells: &sets.cells, sets: &sets.sets });
    }
    let bar = console.share_bar();
    let written = write_tiles_with(&model, &args.out, &options, &input, |share| {
        bar.to(share);
        !interrupted()
    });
    bar.finish();
    let Some(written) = written.map_err(Failure::input)? else {
        let message = format!("interrupted; {} was not written", tileset.display());
        return Err(Failure { exit: Exit::Interrupted, message });
    };
    for note in &written.notes {
        console.note(format!("note: {note}"));
    }
    let record = Record {
        schema: 1,
        instances: written.instances,
        triangles: written.triangles,
        tiles: written.tiles[0],
        tiles_with_content: written.tiles[1],
        stand_ins: written.stand_ins,
        stand_in_triangles: written.stand_in_triangles,
        stand_in_error: written.stand_in_error,
        cells: written.cells,
        horizon_points: written.horizon_points,
        depth: written.depth,
        bytes: written.bytes,
        seconds: start.elapsed().as_secs_f64(),
    };
    console.line(format!(
        "{}: {} of {} in {}, {} bytes in {:.1} s",
        tileset.display(),
        count(record.instances, "instance", "instances"),
        count(record.triangles, "triangle", "triangles"),
        count(record.tiles.into(), "tile", "tiles"),
        grouped(record.bytes),
        record.seconds,
    ));
    if args.stand_ins {
        console.line(format!(
            "  {} of {}, off by {} at the most",
            count(record.stand_ins.into(), "stand-in", "stand-ins"),
            count(record.stand_in_triangles, "triangle", "triangles"),
            digits(record.stand_in_error),
        ));
    }
    if args.at.is_some() {
        let points = count(record.horizon_points.into(), "tile", "tiles");
        console.line(format!("  {points} with a horizon occlusion point"));
    }
    if sets.is_some() {
        let cells = count(record.cells.into(), "view cell", "view cells");
        console.line(format!("  {cells} with a row of tiles that can be seen"));
    }
    if let Some(path) = &args.json {
        write_json(path, &record)?;
    }
    Ok(Exit::Fine)
}

/// Loads the scene; for stand-ins, what the baker makes of it where it has no levels of detail.
fn load(args: &TilesArgs, console: &Console) -> Result<Model, Failure> {
    let model = inputs::load_to_save(&args.scene, console)?;
    if !args.stand_ins || inputs::has_levels(&model.scene) {
        return Ok(model);
    }
    let (path, _) = levels::file(&args.scene, Wanted::Groups, &model.name, console)?;
    let baked = SceneArgs { pvs: args.scene.pvs.clone(), ..SceneArgs::of(path.to_string_lossy()) };
    let baked = inputs::load_to_save(&baked, &Console::new(true, None))?;
    Ok(Model { name: model.name, ..baked })
}

/// A stand-in as tiles have it; `None` where it has no mesh, as that of nothing but what is too
/// small for numbers.
fn as_tile(made: StandIn) -> Option<TileStandIn> {
    let mesh = Mesh::new(made.mesh).ok()?;
    let attributes = Attributes { uvs: made.uvs, colors: made.colors, ..Attributes::default() };
    Some(TileStandIn { mesh, attributes, origin: made.origin, error: made.error })
}
