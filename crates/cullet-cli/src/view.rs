//! `cullet view`: starts the viewer in a window.

use std::ffi::OsString;

use clap::Args;
use cullet_command::exit::Outcome;

use crate::peer::Peer;

const VIEWER: Peer =
    Peer { name: "cullet-viewer", what: "the viewer", example: "city", needs: "some minutes" };

pub(crate) const HELP: &str = "\
The viewer is a program of its own, so that building this one stays quick. It is looked for beside this
program, then in PATH. What follows the scene is handed on: cullet view city --help lists it.

Examples
  cullet view                            the built-in city
  cullet view model.glb
  cullet view scan.ply --one-sided       cull the back faces of a scan with small holes too
  cullet view city:n=1e8                 a world larger than memory, tile by tile
  cullet view city --state 'layout=split&ghosts.form=solid'
  cullet view office --size 960x600 --screenshot office.png";

/// Arguments of `cullet view`.
#[derive(Clone, Debug, Args)]
pub(crate) struct WindowArgs {
    /// A file or a built-in scene, then options of the viewer
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, value_name = "SCENE|FILE")]
    rest: Vec<OsString>,
}

/// Runs the command: ends when the viewer does.
pub(crate) fn run(args: &WindowArgs) -> Outcome {
    VIEWER.run(&args.rest)
}
