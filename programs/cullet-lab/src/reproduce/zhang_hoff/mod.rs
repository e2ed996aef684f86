//! Zhang & Hoff, *Fast Backface Culling Using Normal Masks* (1997): Table 1 and Graph 1.
//!
//! The paper draws two Stanford bunnies and prints, for nine sizes of the grid of normals, how many
//! triangles its masks cull and how long a frame takes. It prints neither where its viewer stood
//! nor how long a frame takes without masks. A mask culls the more the farther the viewer is, on
//! all models nearly alike, so the distance can be read off the shares: this command finds it, and
//! measures there.

mod culling;
mod drawing;
mod graph;
mod print;
mod record;
mod refined;

use std::path::PathBuf;

use clap::Args;
use cullet_command::console::{Console, interrupted};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::parse;

use super::model::Subject;
use super::output::Places;
use cullet_command::machine::Machine;
pub use culling::{CullingFound, Grids, Pair, keep_exactly, mask_to};
use record::{CopiesRecord, Distance, Drawn, TableRow, ZhangHoffRecord};
pub use record::{PAPER, ShareRow};

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

/// Runs the command.
pub(super) fn run(args: &ZhangHoffArgs, console: &Console) -> Outcome {
    let subject = Subject::load(args.model.as_deref(), console)?;
    if let Some(defect) = &subject.defect {
        let name = &subject.name;
        console.note(format!(
            "{name} is not a solid ({defect}); its triangles are taken as one-sided"
        ));
    }
    std::fs::create_dir_all(&args.out).map_err(|e| Failure::write(&args.out, &e))?;
    let record = measure(args, &subject, console)?;
    print::all(console, &record);
    let places = Places { out: &args.out, json: args.json.as_deref() };
    places.write("zhang-hoff", "Graph 1", &graph::chart(&record), &record, console)?;
    Ok(match (&record, interrupted()) {
        (r, _) if !r.images_agree || r.front_faces_lost > 0 => Exit::FalseCull,
        (_, true) => Exit::Interrupted,
        _ => Exit::Fine,
    })
}

fn measure(
    args: &ZhangHoffArgs,
    subject: &Subject,
    console: &Console,
) -> Result<ZhangHoffRecord, Failure> {
    let pair = Pair::new(subject);
    let grids = Grids::new(subject);
    let directions = args.directions;
    let distance_radii = pair.fit(&grids, directions);
    let distances = 1 + OTHER_DISTANCES.len() as u64;
    let mut progress = console.progress("culling", distances * u64::from(directions));
    let found = pair.shares(&grids, distance_radii, directions, || progress.step());
    let mut rows: Vec<TableRow> =
        found.rows.iter().zip(PAPER).map(|(s, paper)| s.row(paper)).collect();
    let differences = rows.iter().filter(|r| r.n >= 6).map(|r| r.culled_percent - r.paper_percent);
    let worst = differences.fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
    let mut lost = found.lost;
    let mut other_distances = Vec::new();
    for distance_radii in OTHER_DISTANCES {
        let found = pair.shares(&grids, distance_radii, directions, || progress.step());
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
    Ok(ZhangHoffRecord {
        schema: 1,
        model: CopiesRecord {
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
