//! `cullet tiles`: a scene as 3D Tiles.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use cullet_command::args::SceneArgs;
use cullet_command::console::{Console, count, grouped, interrupted};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::files::write_json;
use cullet_command::inputs;
use cullet_io::{WriteTiles, write_tiles};
use serde::Serialize;

/// End of `cullet tiles --help`.
pub(crate) const HELP: &str = "\
Writes 3D Tiles 1.1, which CesiumJS, Unreal, Unity and others show: tileset.json and a GLB for each tile. Each instance is in one
tile; large ones stand high up in the tree of tiles and are loaded first, small ones far down and are loaded where the eye comes near. Levels of
detail and occluders of a baked scene are written with their meshes; impostors, textures, cells and motions are not.

The world is shown tile by tile by the crate cullet-tiles (FolderTiles), within a budget of memory, and as one model by every
command that takes a scene.

Examples
  cullet tiles city.glb -o city                        city/tileset.json, and city/tiles
  cullet tiles city:objects=100000 -o city             a built-in scene
  cullet bake city.glb -o b.glb && cullet tiles b.glb -o city     with levels of detail
  cullet tiles plant.glb -o plant --triangles 20000    smaller tiles
  cullet report city/tileset.json                      what of all of it is drawn for nothing";

/// `cullet tiles`
#[derive(Debug, Args)]
pub(crate) struct TilesArgs {
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
    /// Write the figures as JSON; - is the standard output
    #[arg(long, value_name = "PATH", value_parser = cullet_command::parse::output)]
    pub(crate) json: Option<PathBuf>,
}

/// The figures.
#[derive(Debug, Serialize)]
struct Record {
    schema: u32,
    instances: u64,
    triangles: u64,
    /// Tiles, and those of them that show something.
    tiles: u32,
    tiles_with_content: u32,
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
    let model = inputs::load_to_save(&args.scene, console)?;
    if model.motion.is_some() {
        console.note("note: what moves in it stands as it is stored");
    }
    let start = Instant::now();
    let mut options = WriteTiles::default();
    (options.triangles, options.instances) = (args.triangles, args.instances);
    let bar = console.share_bar();
    let written = write_tiles(&model, &args.out, &options, |share| {
        bar.to(share);
        !interrupted()
    });
    bar.finish();
    let Some(written) = written.map_err(Failure::input)? else {
        let message = format!("interrupted; {} was not written", tileset.display());
        return Err(Failure { exit: Exit::Interrupted, message });
    };
    let record = Record {
        schema: 1,
        instances: model.scene.instance_count().into(),
        triangles: model.scene.triangle_count(),
        tiles: written.tiles[0],
        tiles_with_content: written.tiles[1],
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
    if let Some(path) = &args.json {
        write_json(path, &record)?;
    }
    Ok(Exit::Fine)
}
