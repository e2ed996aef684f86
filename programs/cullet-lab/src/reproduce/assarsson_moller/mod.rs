//! Assarsson & Möller, *Optimized View Frustum Culling Algorithms for Bounding Boxes* (2000): the
//! gain of each of its tricks, alone and together, on a path of small steps; and what is left of it
//! beside a tree that tests sixteen boxes at once.

mod graph;
mod measure;
mod print;
mod record;
mod scalar;

use std::path::PathBuf;

use clap::Args;
use cullet_command::args::SceneArgs;
use cullet_command::console::{Console, interrupted};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::inputs;

use super::output;
use measure::Walk;

pub(super) const HELP: &str = "\
A view walks in a circle through the middle of the scene and looks ahead. A binary tree over the boxes of
all instances is culled for every frame: plainly, with each trick of the paper alone, and with all of them;
then the engine's own sixteen-fold tree. All answers are compared in every frame.

Writes assarsson-moller.json and a chart (assarsson-moller.svg, assarsson-moller.png) into --out.

Examples
  cullet reproduce assarsson-moller                             a forest of 100,000, turning by 1.2 degrees
  cullet reproduce assarsson-moller --model city --degrees 0.1
  cullet reproduce assarsson-moller --degrees 0 --stride 0.05   creeping straight on
  cullet reproduce assarsson-moller --json - | jq .rows";

/// `cullet reproduce assarsson-moller`
#[derive(Debug, Args)]
pub(crate) struct AssarssonMollerArgs {
    /// A file, or a built-in scene
    #[arg(long, value_name = "PATH", default_value = "forest:n=100000")]
    model: String,
    /// Folder to write into
    #[arg(long, value_name = "DIR", default_value = "reproduce")]
    out: PathBuf,
    /// Also write the results here; - is the standard output
    #[arg(long, value_name = "PATH")]
    pub(super) json: Option<PathBuf>,
    /// How many frames the path has
    #[arg(long, value_name = "N", default_value_t = 300, value_parser = clap::value_parser!(u32).range(2..=100_000))]
    frames: u32,
    /// Angle by which the view turns from frame to frame, in degrees
    #[arg(long, value_name = "ANGLE", default_value_t = 1.2, value_parser = degrees)]
    degrees: f64,
    /// How far it goes from frame to frame, in the scene's units [default: a ten-thousandth of the
    /// scene]
    #[arg(long, value_name = "LENGTH", value_parser = stride)]
    stride: Option<f64>,
}

fn degrees(text: &str) -> Result<f64, String> {
    let wrong = || format!("'{text}' is not an angle of 0 to 180 degrees");
    text.parse().ok().filter(|v| (0.0..=180.0).contains(v)).ok_or_else(wrong)
}

fn stride(text: &str) -> Result<f64, String> {
    let wrong = || format!("'{text}' is not a length of 0 to 1e9");
    text.parse().ok().filter(|v| (0.0..=1e9).contains(v)).ok_or_else(wrong)
}

/// Runs the command.
pub(super) fn run(args: &AssarssonMollerArgs, console: &Console) -> Outcome {
    let scene = SceneArgs::of(&args.model);
    let model = inputs::load(&scene, console)?;
    std::fs::create_dir_all(&args.out).map_err(|e| Failure::write(&args.out, &e))?;
    let walk = Walk { frames: args.frames, degrees: args.degrees, stride: args.stride };
    let record = measure::all(&walk, &model, console)?;
    print::all(console, &record);
    let places = output::Places { out: &args.out, json: args.json.as_deref() };
    places.write("assarsson-moller", "The chart", &graph::chart(&record), &record, console)?;
    let wrong = record.frames_differing + record.lost > 0;
    Ok(match interrupted() {
        _ if wrong => Exit::FalseCull,
        true => Exit::Interrupted,
        false => Exit::Fine,
    })
}
