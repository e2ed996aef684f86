//! Assarsson & Möller, *Optimized View Frustum Culling Algorithms for Bounding Boxes* (2000): the gain of
//! each of its tricks, alone and together, on a coherent path; and what is left of it beside a tree that
//! tests sixteen boxes at once.

mod graph;
mod measure;
mod print;
mod scalar;

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;

use crate::args::SceneArgs;
use crate::bench::Machine;
use crate::console::{Console, interrupted, write_json};
use crate::exit::{Exit, Failure, Outcome};
use crate::inputs;

pub(super) const HELP: &str = "\
A view walks in a circle through the middle of the scene and looks ahead. A binary tree over the boxes of
all instances is culled for every frame: plainly, with each trick of the paper alone, and with all of them;
then the engine's own sixteen-fold tree, cold and with what it remembers. All answers are compared in every
frame.

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
    /// By how much the view turns from frame to frame, in degrees
    #[arg(long, value_name = "ANGLE", default_value_t = 1.2, value_parser = degrees)]
    degrees: f64,
    /// How far it goes from frame to frame, in the scene's units [default: a ten-thousandth of the scene]
    #[arg(long, value_name = "LENGTH", value_parser = stride)]
    stride: Option<f64>,
}

fn degrees(text: &str) -> Result<f64, String> {
    let wrong = || format!("'{text}' is no angle of 0 to 180 degrees");
    text.parse().ok().filter(|v| (0.0..=180.0).contains(v)).ok_or_else(wrong)
}

fn stride(text: &str) -> Result<f64, String> {
    let wrong = || format!("'{text}' is no length of 0 to 1e9");
    text.parse().ok().filter(|v| (0.0..=1e9).contains(v)).ok_or_else(wrong)
}

/// All that the command finds.
#[derive(Debug, Serialize)]
struct Record {
    schema: u32,
    model: String,
    boxes: u64,
    frames: u32,
    degrees: f64,
    stride: f64,
    fov_degrees: f64,
    /// Of all boxes, mean over the frames.
    visible_percent: f64,
    machine: Machine,
    /// The scalar binary tree, in f64: plain, each trick alone, all together.
    rows: Vec<Row>,
    /// The engine's own tree, in f32, sixteen boxes at once.
    wide: Vec<WideRow>,
    /// Frames in which a variant of the scalar tree found something else than the plain one; 0, or a fault.
    frames_differing: u64,
    /// Visible for the plain tree and not for the engine's; 0, or a fault.
    lost: u64,
    /// Frames in which the coherent walk of the engine's tree is not bit for bit the cold one; 0, or a fault.
    incoherent_frames: u64,
    /// Kept by the engine's tree alone, where f32 cannot tell; of so many boxes visible in all frames.
    kept_at_the_border: u64,
    visible_in_all: u64,
    /// False where Ctrl-C stopped the command early; then the figures are of the frames done.
    complete: bool,
}

/// What a way of culling costs a frame; means over the frames.
#[derive(Debug, Serialize)]
struct Row {
    variant: &'static str,
    nodes: f64,
    plane_tests: f64,
    ns: f64,
    /// Plane tests of the plain tree over its own, and the same of the times.
    fewer_tests: f64,
    speedup: f64,
}

#[derive(Debug, Serialize)]
struct WideRow {
    variant: &'static str,
    /// Sixteen things against a plane count as sixteen.
    plane_tests: f64,
    ns: f64,
    speedup: f64,
    /// Groups of 256 boxes answered from memory.
    answered_percent: f64,
}

/// Runs the command.
pub(super) fn run(args: &AssarssonMollerArgs, console: &Console) -> Outcome {
    let scene = SceneArgs {
        scene: args.model.clone(),
        up: None,
        one_sided: false,
        two_sided: false,
        max_triangles: None,
    };
    let model = inputs::load(&scene, console)?;
    std::fs::create_dir_all(&args.out).map_err(|e| Failure::write(&args.out, &e))?;
    let record = measure::all(args, &model, console)?;
    print::all(console, &record);
    write(args, console, &record)?;
    let wrong = record.frames_differing + record.lost + record.incoherent_frames > 0;
    Ok(match interrupted() {
        _ if wrong => Exit::FalseCull,
        true => Exit::Interrupted,
        false => Exit::Fine,
    })
}

fn write(args: &AssarssonMollerArgs, console: &Console, record: &Record) -> Result<(), Failure> {
    let file = |name: &str| args.out.join(name);
    let save = |path: &Path, bytes: &[u8]| {
        std::fs::write(path, bytes).map_err(|e| Failure::write(path, &e))
    };
    let chart = graph::chart(record);
    save(&file("assarsson-moller.svg"), chart.to_svg().as_bytes())?;
    save(&file("assarsson-moller.png"), &chart.to_picture().to_png())?;
    write_json(&file("assarsson-moller.json"), record)?;
    if let Some(path) = &args.json {
        write_json(path, record)?;
    }
    console.line(format!(
        "\nThe chart is in {} and .png, all figures are in assarsson-moller.json beside them.",
        file("assarsson-moller.svg").display()
    ));
    Ok(())
}
