//! Zhang & Hoff, *Fast Backface Culling Using Normal Masks* (1997): Table 1 and Graph 1.
//!
//! The paper draws two Stanford bunnies and prints, for nine sizes of the grid of normals, how many
//! triangles its masks cull and how long a frame takes. It prints neither where its viewer stood nor how
//! long a frame takes without masks. A mask culls the more the farther the viewer is, on all models
//! nearly alike, so the distance can be read off the shares: this command finds it, and measures there.

mod culling;
mod drawing;
mod graph;
mod print;
mod refined;

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;

use self::culling::{Grids, Pair};
use super::model::Subject;
use crate::bench::Machine;
use crate::console::{Console, interrupted, write_json};
use crate::exit::{Exit, Failure, Outcome};
use crate::parse;

pub(super) const HELP: &str = "\
Two copies of the model side by side, every triangle one-sided; each copy has a viewing cone from its
bounding sphere, and a mask of 256 bytes for each grid of N x N cells on a face of the cube of normals.
The distance is fitted so that the shares culled come out as the paper's; --directions views from there,
spread over a sphere, give the means. A few of them are drawn with and without masks by the reference
renderer, on one thread, and must come out the same, pixel for pixel.

Writes zhang-hoff.json and Graph 1 (zhang-hoff.svg, zhang-hoff.png) into --out.

Examples
  cullet reproduce zhang-hoff                           the built-in solid of 69,312 triangles
  cullet reproduce zhang-hoff --model bun_zipper.ply    the paper's own model
  cullet reproduce zhang-hoff --json - | jq .rows";

/// Cells along an edge of the cube, and what the paper prints for them: per cent culled, milliseconds a
/// frame.
pub(super) const PAPER: [(u32, f64, f64); 9] = [
    (2, 27.5, 469.5),
    (4, 35.1, 425.1),
    (6, 38.2, 396.3),
    (8, 39.9, 388.3),
    (10, 40.9, 391.3),
    (12, 41.6, 393.8),
    (14, 42.2, 386.2),
    (16, 42.6, 378.6),
    (18, 43.0, 371.9),
];

/// Triangles in the paper's frames.
const PAPER_TRIANGLES: f64 = 138_901.0;

/// Distances beside the fitted one, in radii of the sphere around both copies: near, middling, far.
const OTHER_DISTANCES: [f64; 3] = [1.5, 3.0, 20.0];

/// `cullet reproduce zhang-hoff`
#[derive(Debug, Args)]
pub(crate) struct ZhangHoffArgs {
    /// A file, or a built-in scene, in place of the built-in solid
    #[arg(long, value_name = "PATH")]
    model: Option<String>,
    /// Folder to write into
    #[arg(long, value_name = "DIR", default_value = "reproduce")]
    out: PathBuf,
    /// Also write the results here; - is the standard output
    #[arg(long, value_name = "PATH")]
    pub(super) json: Option<PathBuf>,
    /// How many views the shares are means over
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    directions: u32,
    /// How many of the views are drawn for the times
    #[arg(long, value_name = "N", default_value_t = 6, value_parser = clap::value_parser!(u32).range(1..=1000))]
    frames: u32,
    /// Pixels of a drawn view
    #[arg(long, value_name = "WxH", default_value = "640x480", value_parser = parse::size)]
    size: [u32; 2],
}

/// All that the command finds.
#[derive(Debug, Serialize)]
struct Record {
    schema: u32,
    model: ModelRecord,
    /// Views that the shares are means over.
    directions: u32,
    /// The fitted distance, in radii of the sphere around all copies.
    distance_radii: f64,
    /// Ours less the paper's at that distance, over N ≥ 6, where it is largest.
    worst_difference_points: f64,
    /// Triangles that a mask culled and the exact test does not; 0, or something is very wrong.
    front_faces_lost: u64,
    renderer: String,
    machine: Machine,
    /// Views drawn.
    frames: u32,
    /// Whether each was drawn the same with masks as without, pixel for pixel.
    images_agree: bool,
    /// A frame without masks: the renderer finds the back faces itself.
    baseline_ms: Option<f64>,
    /// Of it, what a frame of no triangle takes: no culling saves that.
    empty_ms: Option<f64>,
    rows: Vec<Row>,
    /// The engine's own test of triangles at the same views, for comparison.
    planes8: Option<Drawn>,
    other_distances: Vec<Distance>,
    groups: Vec<refined::GroupRow>,
    sectors: Vec<refined::SectorRow>,
    /// False where Ctrl-C stopped the command early.
    complete: bool,
}

#[derive(Debug, Serialize)]
struct ModelRecord {
    name: String,
    copies: u32,
    /// Triangles of all copies.
    triangles: u64,
    /// Why it is no solid, where it is taken for one all the same.
    defect: Option<String>,
}

/// A row of Table 1. Counts are of all copies, means over the directions.
#[derive(Clone, Debug, Serialize)]
struct Row {
    n: u32,
    classes: u32,
    /// What the masks keep; the paper's word for it is front-facing.
    front: u64,
    back: u64,
    culled_percent: f64,
    paper_percent: f64,
    exact_percent: f64,
    ms_per_frame: Option<f64>,
    speedup: Option<f64>,
    /// What the speed-up were if a frame's time went by its triangles alone, each costing the same.
    even_speedup: f64,
    paper_ms: f64,
}

/// Frames drawn from a list.
#[derive(Clone, Copy, Debug, Serialize)]
struct Drawn {
    culled_percent: f64,
    ms_per_frame: f64,
    speedup: f64,
}

/// The shares at another distance.
#[derive(Debug, Serialize)]
struct Distance {
    distance_radii: f64,
    rows: Vec<ShareRow>,
}

#[derive(Debug, Serialize)]
struct ShareRow {
    n: u32,
    classes: u32,
    front: u64,
    back: u64,
    culled_percent: f64,
    exact_percent: f64,
}

/// Runs the command.
pub(super) fn run(args: &ZhangHoffArgs, console: &Console) -> Outcome {
    let subject = Subject::load(args.model.as_deref(), console)?;
    if let Some(defect) = &subject.defect {
        let name = &subject.name;
        console
            .note(format!("{name} is no solid ({defect}); its triangles are taken as one-sided"));
    }
    std::fs::create_dir_all(&args.out).map_err(|e| Failure::write(&args.out, &e))?;
    let record = measure(args, &subject, console)?;
    print::all(console, &record);
    write(args, console, &record)?;
    Ok(match (&record, interrupted()) {
        (r, _) if !r.images_agree || r.front_faces_lost > 0 => Exit::FalseCull,
        (_, true) => Exit::Interrupted,
        _ => Exit::Fine,
    })
}

fn measure(args: &ZhangHoffArgs, subject: &Subject, console: &Console) -> Result<Record, Failure> {
    let pair = Pair::new(subject);
    let grids = Grids::new(subject);
    let directions = args.directions;
    let distance_radii = pair.fit(&grids, directions);
    let distances = 1 + OTHER_DISTANCES.len() as u64;
    let mut progress = console.progress("culling", distances * u64::from(directions));
    let found = pair.shares(&grids, distance_radii, directions, &mut progress);
    let mut rows: Vec<Row> = found.rows.iter().zip(PAPER).map(|(s, paper)| s.row(paper)).collect();
    let differences = rows.iter().filter(|r| r.n >= 6).map(|r| r.culled_percent - r.paper_percent);
    let worst = differences.fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
    let mut lost = found.lost;
    let mut other_distances = Vec::new();
    for distance_radii in OTHER_DISTANCES {
        let found = pair.shares(&grids, distance_radii, directions, &mut progress);
        lost += found.lost;
        other_distances.push(Distance { distance_radii, rows: found.rows });
    }
    progress.finish();
    let times = drawing::draw(&pair, &grids, distance_radii, (args.frames, args.size), console)?;
    if let Some(ms) = &times.ms {
        for (row, &ms_per_frame) in rows.iter_mut().zip(&ms.masks) {
            row.ms_per_frame = Some(ms_per_frame);
            row.speedup = Some(ms.baseline / ms_per_frame);
        }
    }
    let (groups, sectors) = if interrupted() {
        (Vec::new(), Vec::new())
    } else {
        let mut progress = console.progress("culling by groups and sectors", refined::STEPS);
        let groups = refined::groups(subject, directions, &mut progress)?;
        (groups, refined::sectors(subject, directions, &mut progress)?)
    };
    let [w, h] = args.size;
    Ok(Record {
        schema: 1,
        model: ModelRecord {
            name: subject.name.clone(),
            copies: 2,
            triangles: pair.triangles(),
            defect: subject.defect.clone(),
        },
        directions,
        distance_radii,
        worst_difference_points: worst,
        front_faces_lost: lost,
        renderer: format!("cullet-draw, the reference renderer (CPU, f64, one thread), {w}x{h}"),
        machine: Machine::here(),
        frames: times.frames,
        images_agree: times.images_agree,
        baseline_ms: times.ms.as_ref().map(|t| t.baseline),
        empty_ms: times.ms.as_ref().map(|t| t.empty),
        rows,
        planes8: times.ms.as_ref().map(|t| Drawn {
            culled_percent: times.planes8_percent,
            ms_per_frame: t.planes8,
            speedup: t.baseline / t.planes8,
        }),
        other_distances,
        groups,
        sectors,
        complete: !interrupted(),
    })
}

fn write(args: &ZhangHoffArgs, console: &Console, record: &Record) -> Result<(), Failure> {
    let file = |name: &str| args.out.join(name);
    let save = |path: &Path, bytes: &[u8]| {
        std::fs::write(path, bytes).map_err(|e| Failure::write(path, &e))
    };
    let chart = graph::chart(record);
    save(&file("zhang-hoff.svg"), chart.to_svg().as_bytes())?;
    save(&file("zhang-hoff.png"), &chart.to_picture().to_png())?;
    write_json(&file("zhang-hoff.json"), record)?;
    if let Some(path) = &args.json {
        write_json(path, record)?;
    }
    console.line(format!(
        "\nGraph 1 is in {} and .png, all figures are in zhang-hoff.json beside them.",
        file("zhang-hoff.svg").display()
    ));
    Ok(())
}
