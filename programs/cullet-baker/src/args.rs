//! The commands that write files, and how each is run.

use std::path::Path;

use clap::Subcommand;
use cullet_cli::neighbours::LAB;
use cullet_command::console::Console;
use cullet_command::exit::Outcome;

use crate::bake;
use crate::bake_args::{BAKE_HELP, BakeArgs};
use crate::cells::{self, CellsArgs};
use crate::cut::{self, CutArgs};
use crate::occluders::{self, OccludersArgs};
use crate::pvs::{self, PvsArgs};
use crate::simplify;
use crate::simplify_args::{SIMPLIFY_HELP, SimplifyArgs};
use crate::tiles::{self, TilesArgs};

/// A command of `cullet-baker`.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Write a GLB with levels of detail of every mesh, made and measured beforehand
    #[command(after_help = BAKE_HELP)]
    Bake(Box<BakeArgs>),
    /// Write a scene of few triangles that deviates by no more than is said, as measured
    #[command(after_help = SIMPLIFY_HELP)]
    Simplify(Box<SimplifyArgs>),
    /// Bake occluders for each mesh: boxes inside of it and polygons in its surface
    #[command(after_help = occluders::HELP)]
    Occluders(Box<OccludersArgs>),
    /// Count the cells and portals of a scene, and write it with them
    #[command(after_help = cells::HELP)]
    Cells(Box<CellsArgs>),
    /// Bake which cells of a map or view cells of a scene see what
    #[command(after_help = pvs::HELP)]
    Pvs(Box<PvsArgs>),
    /// Write a scene as 3D Tiles, for worlds that are loaded piece by piece
    #[command(after_help = tiles::HELP)]
    Tiles(Box<TilesArgs>),
    /// Cut a scene open at planes or a box, with caps
    #[command(after_help = cut::HELP)]
    Cut(Box<CutArgs>),
}

impl Command {
    /// Runs it.
    ///
    /// # Errors
    /// What the user is to be told, with the exit code.
    pub fn run(&self, quiet: bool) -> Outcome {
        let console = |json: Option<&Path>| Console::new(quiet, json);
        match self {
            Self::Bake(args) => bake::run(args, &console(args.json.as_deref())),
            Self::Simplify(args) => simplify::run(args, &console(args.json.as_deref())),
            Self::Occluders(args) if args.compares() => LAB.hand_on("occluders", quiet),
            Self::Occluders(args) => occluders::run(args, None, &console(args.json.as_deref())),
            Self::Cells(args) => cells::run(args, &console(args.json.as_deref())),
            Self::Pvs(args) => pvs::run(args, &console(args.json.as_deref())),
            Self::Tiles(args) => tiles::run(args, &console(args.json.as_deref())),
            Self::Cut(args) => cut::run(args, &console(args.json.as_deref())),
        }
    }
}
