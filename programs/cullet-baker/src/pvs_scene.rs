//! `cullet pvs` of a scene without cells: sets of boxes that an eye may be in, by sampled lines.

use std::path::{Path, PathBuf};
use std::time::Instant;

use crate::units::Units;
use clap::Args;
use cullet_bake::job::SceneSettings;
use cullet_bake::job::Settings;
use cullet_bake::sampled::{
    EditCounts, RayTree, RayTreeOptions, Region, SampledBake, SampledError, ScenePvs, SolidVoxels,
    ViewCells, check_pictures,
};
use cullet_bake::work::{RunEnd, RunOptions};
use cullet_command::console::{Console, count, digits, grouped, percent};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::files::{replace, write_json};
use cullet_command::{process, sets};
use cullet_io::Model;
use serde::Serialize;

/// Cells and lines of a scene.
#[derive(Debug, Args)]
#[command(next_help_heading = "For scenes, which have no cells of their own")]
pub(crate) struct PvsSceneArgs {
    /// How many view cells to make [default: 500]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1 << 24))]
    view_cells: Option<u32>,
    /// A box to make cells in, its low and its high corner; may be given many times [default: the
    /// scene's bounds]
    #[arg(long, value_name = "X,Y,Z,X,Y,Z", value_parser = region, allow_hyphen_values = true)]
    region: Vec<Region>,
    /// Cells only so far above the scene's lowest point, such as 1..2.5 for eyes
    #[arg(long, value_name = "LOW..HIGH", value_parser = heights, conflicts_with = "region")]
    heights: Option<[f64; 2]>,
    /// Cut the boxes into equal cells, so many along each axis
    #[arg(long, value_name = "X,Y,Z", value_parser = grid, conflicts_with = "view_cells")]
    grid: Option<[u32; 3]>,
    /// Sets of clusters of triangles instead of whole instances
    #[arg(long)]
    clusters: bool,
    /// End after about so many rays [default: 100000000]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    rays: Option<u64>,
    /// End where so small a share of looks is estimated to go to what is missing, 0 to 1 [default:
    /// 0.00002]
    #[arg(long, value_name = "SHARE", value_parser = share)]
    missing: Option<f64>,
    /// Keep whatever could appear wider than this, in degrees, above 0 to 180 [default: 180, what a
    /// cell touches]
    #[arg(long, value_name = "DEGREES", value_parser = degrees)]
    keep_angle: Option<f64>,
    /// Give each cell what cells within this distance see
    #[arg(long, value_name = "DISTANCE", value_parser = radius)]
    join: Option<f64>,
    /// Go on from sets that were baked before the scene was edited: only what changed is looked at,
    /// from the cells that see any of it
    #[arg(long, value_name = "PATH",
        conflicts_with_all = ["view_cells", "region", "heights", "grid", "clusters", "solid"])]
    pub(crate) after: Option<PathBuf>,
    /// Also prove what is hidden by solid voxels, so many along the longest side, and hold the
    /// lines against it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=512))]
    solid: Option<u32>,
}

/// Options and inputs that `cullet pvs` has beyond those of a scene.
#[derive(Debug)]
pub(crate) struct Common<'a> {
    pub(crate) file: &'a Path,
    pub(crate) out: Option<&'a Path>,
    pub(crate) rows: Option<&'a Path>,
    pub(crate) json: Option<&'a Path>,
    pub(crate) threads: usize,
    pub(crate) settings: &'a Settings,
    /// Pictures to check the sets with.
    pub(crate) check: Option<u64>,
    /// Where finished units are kept, and whose share is to be done.
    pub(crate) units: &'a Units<'a>,
}

/// Pixels along each side of the six pictures from a place.
const SIDE: u32 = 64;

impl PvsSceneArgs {
    /// Returns the settings as plans carry them.
    pub(crate) fn settings(&self) -> SceneSettings {
        SceneSettings {
            view_cells: self.view_cells,
            regions: self.region.clone(),
            heights: self.heights,
            grid: self.grid,
            clusters: self.clusters,
            rays: self.rays,
            missing: self.missing,
            keep_angle: self.keep_angle,
            join: self.join,
        }
    }
}

fn region(text: &str) -> Result<Region, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[a, b, c, d, e, f]) if a < d && b < e && c < f => Ok([[a, b, c], [d, e, f]]),
        _ => Err(format!(
            "'{text}' is not six numbers, each of the last three above its own of the first three"
        )),
    }
}

fn grid(text: &str) -> Result<[u32; 3], String> {
    let numbers: Option<Vec<u32>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) if x.min(y).min(z) > 0 => Ok([x, y, z]),
        _ => Err(format!("'{text}' is not three numbers from 1; try 16,1,16")),
    }
}

fn degrees(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(v) if v > 0.0 && v <= 180.0 => Ok(v),
        _ => Err(format!("'{text}' is not an angle above 0 and at most 180 degrees; try 60")),
    }
}

fn heights(text: &str) -> Result<[f64; 2], String> {
    let number = |t: &str| t.trim().parse().ok().filter(|v: &f64| v.is_finite());
    match text.split_once("..").and_then(|(low, high)| Some([number(low)?, number(high)?])) {
        Some([low, high]) if low < high => Ok([low, high]),
        _ => Err(format!("'{text}' is not LOW..HIGH with LOW below HIGH; try 1..2.5")),
    }
}

fn radius(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(v) if v >= 0.0 && f64::is_finite(v) => Ok(v),
        _ => Err(format!("'{text}' is not a distance from 0; 0 joins cells that touch")),
    }
}

fn share(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(v) if (0.0..=1.0).contains(&v) => Ok(v),
        _ => Err(format!("'{text}' is not a share of 0 to 1; try 0.00002")),
    }
}

/// Contents of the JSON.
#[derive(Debug, Serialize)]
struct Record {
    schema: u32,
    cells: u32,
    /// Kind of item that the bits of a row stand for, and how many bits a row has.
    granularity: &'static str,
    targets: u32,
    triangles: u64,
    visible_pairs: u64,
    /// Pairs among them that a line found; the rest is kept by settings.
    found_pairs: u64,
    /// Mean over the cells, and the worst.
    missing_estimate: f64,
    worst_missing_estimate: f64,
    buried_cells: usize,
    rays: u64,
    /// Rays of the sets that it went on from.
    rays_before: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    edit: Option<EditCounts>,
    cpu_seconds: f64,
    wall_seconds: f64,
    peak_bytes: Option<u64>,
    bytes_hash: String,
    scene_hash: String,
    complete: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    solid: Option<SolidRecord>,
    #[serde(skip_serializing_if = "Option::is_none")]
    check: Option<PictureRecord>,
}

/// Findings of the voxels.
#[derive(Debug, Serialize)]
struct SolidRecord {
    voxels: u64,
    solid_voxels: u64,
    proven_hidden_pairs: u64,
    /// Pairs proven hidden that a line found: a fault.
    contradicted: u64,
}

/// Findings of pictures from random places.
#[derive(Debug, Serialize)]
struct PictureRecord {
    poses: u32,
    pixels: u64,
    wrong_pixels: u64,
    pixel_error: f64,
    seen: u64,
    missing: u64,
    missing_share: f64,
}

/// Runs the command.
pub(crate) fn run(
    args: &PvsSceneArgs,
    model: &Model,
    common: &Common<'_>,
    console: &Console,
) -> Outcome {
    let begin = (Instant::now(), process::cpu_time());
    let granularity = common.settings.scene.granularity();
    let options = RayTreeOptions { granularity, ..RayTreeOptions::default() };
    let tree = RayTree::new(&model.scene, &options).map_err(|e| failure(common.file, &e))?;
    let before = match &args.after {
        Some(path) => Some(sets::of_scene(path)?.ok_or_else(|| {
            Failure::input(format!("{}: it has no sets of a scene's view cells", path.display()))
        })?),
        None => None,
    };
    let sampled = common.settings.sampled();
    let cells = match &before {
        Some(before) => ViewCells::of_boxes(&before.cells),
        None => common.settings.view_cells(&tree),
    };
    let cells = cells.map_err(|e| failure(common.file, &e))?;
    let mut bake = match &before {
        Some(before) => SampledBake::after(&tree, &cells, &sampled, before),
        None => SampledBake::new(&tree, &cells, &sampled),
    }
    .map_err(|e| failure(common.file, &e))?;
    // Ctrl-C ends it with what was found until then.
    let options = RunOptions { threads: common.threads, ..RunOptions::default() };
    let end = common.units.run(&mut bake, &options, console)?;
    if let Some(exit) = told_of_units(end, common, console) {
        return Ok(exit);
    }
    let (edit, spent) = (bake.edited(), bake.rays());
    let (pvs, complete) = (bake.finish(), end == RunEnd::Whole);
    let mut record = Record {
        schema: 1,
        cells: cells.len(),
        granularity: granularity.name(),
        targets: tree.targets().count(),
        triangles: tree.triangle_count(),
        visible_pairs: pvs.visible_pairs(),
        found_pairs: pvs.found.count(),
        missing_estimate: mean(&pvs.missing),
        worst_missing_estimate: pvs.missing.iter().fold(0.0, |a, &b| f64::max(a, b.into())),
        buried_cells: pvs.buried.len(),
        rays: spent,
        rays_before: pvs.rays - spent,
        edit,
        cpu_seconds: (process::cpu_time() - begin.1).as_secs_f64(),
        wall_seconds: begin.0.elapsed().as_secs_f64(),
        peak_bytes: process::peak_bytes(),
        bytes_hash: format!("{:016x}", pvs.rows_hash()),
        scene_hash: format!("{:016x}", pvs.scene_hash),
        complete,
        solid: None,
        check: None,
    };
    print(console, common.file, &record);
    if let Some(path) = common.rows {
        replace(path, &pvs.rows_bytes())?;
    }
    if let Some(path) = common.out {
        let bytes = pvs.to_bytes();
        replace(path, &bytes)?;
        console.line(format!("{}, {} bytes", path.display(), grouped(bytes.len() as u64)));
    }
    if let Some(resolution) = args.solid {
        let solid = prove(&tree, &cells, &pvs, resolution).map_err(|e| failure(common.file, &e))?;
        print_solid(console, &solid);
        record.solid = Some(solid);
    }
    if let Some(poses) = common.check {
        record.check = Some(check(&tree, &cells, &pvs, poses, common, console));
    }
    if let Some(path) = common.json {
        write_json(path, &record)?;
    }
    let is_wrong = record.solid.is_some_and(|solid| solid.contradicted > 0);
    Ok(match (is_wrong, complete) {
        (true, _) => Exit::FalseCull,
        (false, true) => Exit::Fine,
        (false, false) => Exit::Interrupted,
    })
}

fn failure(file: &Path, error: &SampledError) -> Failure {
    let exit = match error {
        SampledError::Rows { .. } | SampledError::Targets { .. } => Exit::Limit,
        SampledError::Empty { .. } => Exit::Input,
        _ => Exit::Usage,
    };
    Failure { exit, message: format!("{}: {error}", file.display()) }
}

/// Says how a bake ended that leaves units; the exit code where nothing but those is wanted of it.
fn told_of_units(end: RunEnd, common: &Common<'_>, console: &Console) -> Option<Exit> {
    match end {
        RunEnd::Share => {
            common.units.tell_done(console);
            Some(Exit::Fine)
        }
        RunEnd::Stopped if common.units.tell_stopped(console) => Some(Exit::Interrupted),
        RunEnd::Stopped => {
            console.note(
                "interrupted: the sets hold what was found until then; --resume would keep it to go on",
            );
            None
        }
        RunEnd::Whole => None,
    }
}

fn mean(values: &[f32]) -> f64 {
    values.iter().map(|&v| f64::from(v)).sum::<f64>() / values.len().max(1) as f64
}

fn print(console: &Console, file: &Path, record: &Record) {
    let all = u64::from(record.cells) * u64::from(record.targets);
    console.line(format!(
        "{}: {}, {}, {}",
        file.display(),
        count(record.cells.into(), "view cell", "view cells"),
        count(record.targets.into(), record.granularity, &format!("{}s", record.granularity)),
        count(record.triangles, "triangle", "triangles"),
    ));
    console.line(format!(
        "{} of a cell and what it sees, {} of all; {} a cell in the mean",
        count(record.visible_pairs, "pair", "pairs"),
        percent(record.visible_pairs, all),
        digits(record.visible_pairs as f64 / f64::from(record.cells.max(1))),
    ));
    console.line(format!(
        "  {} found by a line, {} kept by settings besides",
        grouped(record.found_pairs),
        grouped(record.visible_pairs - record.found_pairs),
    ));
    console.line(format!(
        "  {} % of looks are estimated to go to what is missing, {} % in the worst cell",
        digits(record.missing_estimate * 100.0),
        digits(record.worst_missing_estimate * 100.0),
    ));
    if record.buried_cells > 0 {
        console.line(format!(
            "  {} within something solid",
            count(record.buried_cells as u64, "cell is", "cells are")
        ));
    }
    if let Some(edit) = &record.edit {
        console.line(format!(
            "  since {}: {} came or moved, {} went or moved; {} of {} see any of it, the others keep their sets",
            count(record.rays_before, "ray", "rays"),
            grouped(edit.came.into()),
            grouped(edit.went.into()),
            grouped(edit.cells.into()),
            count(record.cells.into(), "cell", "cells"),
        ));
    }
    console.line(format!(
        "{}: {} s of processors, {} s",
        count(record.rays, "ray", "rays"),
        digits(record.cpu_seconds),
        digits(record.wall_seconds),
    ));
}

fn prove(
    tree: &RayTree<'_>,
    cells: &ViewCells,
    pvs: &ScenePvs,
    resolution: u32,
) -> Result<SolidRecord, SampledError> {
    let solid = SolidVoxels::new(tree, resolution)?;
    let [solid_voxels, voxels] = solid.counts();
    let hidden = solid.hidden(tree, cells);
    let both = |cell: u32| {
        let pairs = hidden.row(cell).iter().zip(pvs.found.row(cell));
        pairs.map(|(h, f)| u64::from((h & f).count_ones())).sum::<u64>()
    };
    let contradicted = (0..cells.len()).map(both).sum();
    Ok(SolidRecord { voxels, solid_voxels, proven_hidden_pairs: hidden.count(), contradicted })
}

fn print_solid(console: &Console, solid: &SolidRecord) {
    console.line(format!(
        "{} of {} are solid; they prove {} hidden, of which lines found {}",
        grouped(solid.solid_voxels),
        count(solid.voxels, "voxel", "voxels"),
        count(solid.proven_hidden_pairs, "pair", "pairs"),
        grouped(solid.contradicted),
    ));
    if solid.contradicted > 0 {
        console.line("what is proven hidden was seen: a fault of cullet, please report it");
    }
}

fn check(
    tree: &RayTree<'_>,
    cells: &ViewCells,
    pvs: &ScenePvs,
    poses: u64,
    common: &Common<'_>,
    console: &Console,
) -> PictureRecord {
    let poses = u32::try_from(poses).unwrap_or(u32::MAX);
    let found = check_pictures(
        tree,
        cells,
        &pvs.visible,
        poses,
        SIDE,
        common.settings.seed,
        common.threads,
    );
    console.line(format!(
        "{} of {} pixels: {} % of the pixels wrong, {} of {} missing: {} %",
        count(poses.into(), "place", "places"),
        grouped(6 * u64::from(SIDE) * u64::from(SIDE)),
        digits(found.pixel_error() * 100.0),
        grouped(found.missing),
        count(found.seen, "visible target", "visible targets"),
        digits(found.missing_share() * 100.0),
    ));
    if let Some(worst) = found.worst {
        let [x, y, z] = worst.eye;
        console.line(format!(
            "  worst: {} wrong from {x:.3},{y:.3},{z:.3} in cell {}",
            count(worst.wrong_pixels, "pixel", "pixels"),
            worst.cell
        ));
    }
    PictureRecord {
        poses,
        pixels: found.pixels,
        wrong_pixels: found.wrong_pixels,
        pixel_error: found.pixel_error(),
        seen: found.seen,
        missing: found.missing,
        missing_share: found.missing_share(),
    }
}
