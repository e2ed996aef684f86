//! `cullet bench pvs --scene`: sets of scenes without cells, and how wrong they are.

use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use clap::Args;
use cullet::{Scene, View};
use cullet_bake::sampled::{
    RayTree, RayTreeOptions, SampledBake, SampledError, SampledSettings, ScenePvs, SceneSets,
    ViewCells, check_pictures,
};
use cullet_bake::work::RunOptions;
use cullet_command::args::SceneArgs;
use cullet_command::console::{Console, digits, grouped, interrupted};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::files::write_json;
use cullet_command::inputs;
use cullet_draw::{RenderOptions, Selection, render};
use serde::Serialize;

use super::pvs_edit::{self, Edited, Setting};
use super::world::Random;
use crate::stopwatch::of_thread;
use cullet_command::machine::Machine;
use cullet_command::process;

/// Scenes to bake.
#[derive(Debug, Args)]
pub(crate) struct PvsSceneBenchArgs {
    /// Bake this scene, a file or a built-in one, in place of portal graphs; may be given many
    /// times
    #[arg(long, value_name = "SCENE", conflicts_with_all = ["files", "again"])]
    pub(crate) scene: Vec<String>,
    /// View cells of each scene
    #[arg(long, value_name = "N", default_value_t = 1000, requires = "scene")]
    cells: u32,
    /// Cells only so far above the scene's lowest point
    #[arg(long, value_name = "LOW..HIGH", value_parser = cullet_command::parse::span, requires = "scene")]
    heights: Option<[f64; 2]>,
    /// Rays of each scene
    #[arg(long, value_name = "N", default_value_t = 100_000_000, requires = "scene")]
    rays: u64,
    /// Share of looks that may be estimated to go to what is missing
    #[arg(long, value_name = "SHARE", default_value_t = 2e-5, requires = "scene")]
    missing: f64,
    /// Random places from where pictures check the sets
    #[arg(long, value_name = "N", default_value_t = 1000, requires = "scene")]
    poses: u32,
    /// Rays of a bake on one thread and on two; 0 leaves it out
    #[arg(long, value_name = "N", default_value_t = 5_000_000, requires = "scene")]
    again_rays: u64,
    /// Places of which the reference renderer draws pictures besides
    #[arg(long, value_name = "N", default_value_t = 4, requires = "scene")]
    drawn: u32,
    /// Also change this share of the instances, and go on from the sets: once of some that stand
    /// together, once of any
    #[arg(long, value_name = "SHARE", requires = "scene")]
    edit: Option<f64>,
}

/// Pixels along each side of the six pictures from a place.
const SIDE: u32 = 64;

#[derive(Debug, Serialize)]
struct Record {
    schema: u32,
    machine: Machine,
    threads: u32,
    scenes: Vec<Baked>,
    complete: bool,
}

/// A scene, what its bake took, and how wrong the sets are.
#[derive(Debug, Serialize)]
struct Baked {
    name: String,
    cells: u32,
    instances: u32,
    triangles: u64,
    visible_pairs: u64,
    found_pairs: u64,
    missing_estimate: f64,
    rays: u64,
    cpu_seconds: f64,
    wall_seconds: f64,
    /// Seconds of these spent on the trees of rays and the cells.
    tree_seconds: f64,
    poses: u32,
    pixel_error: f64,
    missing_share: f64,
    /// The same by the reference renderer, from a few places.
    drawn_poses: u32,
    drawn_pixel_error: f64,
    drawn_missing_share: f64,
    threads: Option<Threads>,
    run_time: RunTime,
    edits: Vec<Edited>,
}

/// A shorter bake on one thread and on two.
#[derive(Debug, Serialize)]
struct Threads {
    rays: u64,
    one_wall_seconds: f64,
    two_wall_seconds: f64,
    one_cpu_seconds: f64,
    two_cpu_seconds: f64,
    same_bytes: bool,
}

/// The sets where they are used.
#[derive(Debug, Serialize)]
struct RunTime {
    /// Whether a cell sees an instance, for random ones.
    lookup_ns: f64,
    /// A whole row, as bits.
    row_ns: f64,
    bytes_per_row: f64,
    file_bytes: usize,
    load_ms: f64,
    /// Lookups and rows that differ from the bake, and whether the file is another after it was
    /// read.
    wrong: u64,
}

const HEADING: &str = "scene                    cells instances triangles  Mrays  CPU s  wall s   of all  estimate  pixels wrong  missing  drawn: pixels  missing";

/// Runs the command.
pub(super) fn run(
    args: &PvsSceneBenchArgs,
    threads: u32,
    json: Option<&Path>,
    console: &Console,
) -> Outcome {
    let mut scenes = Vec::new();
    console.line(HEADING);
    for name in &args.scene {
        let baked = measure(name, args, threads as usize, console)?;
        console.line(row(&baked));
        more(&baked, console);
        scenes.push(baked);
        if interrupted() {
            break;
        }
    }
    let complete = scenes.len() == args.scene.len();
    let record = Record { schema: 1, machine: Machine::here(), threads, scenes, complete };
    if let Some(path) = json {
        write_json(path, &record)?;
    }
    let wrong =
        |b: &Baked| b.run_time.wrong > 0 || b.threads.as_ref().is_some_and(|t| !t.same_bytes);
    Ok(match (record.scenes.iter().any(wrong), complete) {
        (true, _) => Exit::FalseCull,
        (false, true) => Exit::Fine,
        (false, false) => Exit::Interrupted,
    })
}

/// Prints what does not fit in a row.
fn more(b: &Baked, console: &Console) {
    if let Some(t) = &b.threads {
        console.line(format!(
            "  {} rays: two threads {:.2} times as fast as one ({:.1} s and {:.1} s; of processors {:.1} s and {:.1} s), bytes {}",
            grouped(t.rays),
            t.one_wall_seconds / t.two_wall_seconds.max(1e-9),
            t.one_wall_seconds,
            t.two_wall_seconds,
            t.one_cpu_seconds,
            t.two_cpu_seconds,
            if t.same_bytes { "same" } else { "DIFFER" },
        ));
    }
    b.edits.iter().for_each(|edit| pvs_edit::tell(edit, console));
    let r = &b.run_time;
    console.line(format!(
        "  a lookup {:.0} ns, a row {:.0} ns; {:.0} bytes a row, a file of {} bytes read in {:.1} ms; {} wrong",
        r.lookup_ns,
        r.row_ns,
        r.bytes_per_row,
        grouped(r.file_bytes as u64),
        r.load_ms,
        grouped(r.wrong),
    ));
}

/// A bake of so many rays, on one thread and on two.
fn threads_of(
    tree: &RayTree<'_>,
    cells: &ViewCells,
    rays: u64,
) -> Result<Option<Threads>, SampledError> {
    if rays == 0 {
        return Ok(None);
    }
    let settings = SampledSettings::default().with_rays(rays).with_missing(0.0);
    let bake = |threads: usize| {
        // What one thread does before it begins is no part of it.
        let mut bake = SampledBake::new(tree, cells, &settings)?;
        let begin = (Instant::now(), process::cpu_time());
        let options = RunOptions { threads, ..RunOptions::default() };
        let _ = bake.run(&options, &|_| !interrupted());
        let took = [begin.0.elapsed(), process::cpu_time() - begin.1].map(|t| t.as_secs_f64());
        Ok((took, bake.rays(), bake.finish().rows_hash()))
    };
    let ([one_wall_seconds, one_cpu_seconds], rays, one) = bake(1)?;
    let ([two_wall_seconds, two_cpu_seconds], _, two) = bake(2)?;
    let same_bytes = one == two;
    Ok(Some(Threads {
        rays,
        one_wall_seconds,
        two_wall_seconds,
        one_cpu_seconds,
        two_cpu_seconds,
        same_bytes,
    }))
}

/// Looks things up in the sets, and reads their file.
fn use_of(pvs: &ScenePvs) -> RunTime {
    const LOOKUPS: usize = 200_000;
    const ROWS: usize = 2_000;
    const ROUNDS: usize = 9;
    let bytes = pvs.to_bytes();
    let mut load_ms = f64::INFINITY;
    for _ in 0..ROUNDS {
        let took = of_thread(|| drop(black_box(SceneSets::from_bytes(black_box(&bytes)))));
        load_ms = load_ms.min(took.as_secs_f64() * 1e3);
    }
    let made = pvs.to_sets();
    let mut wrong = u64::from(SceneSets::from_bytes(&bytes).as_ref() != Ok(&made));
    let (cells, targets) = (made.sets.cell_count(), made.sets.target_count());
    let mut random = Random::new();
    let mut some = |count: u32| (random.next() * count as f32) as u32 % count.max(1);
    let pairs: Vec<[u32; 2]> = (0..LOOKUPS).map(|_| [some(cells), some(targets)]).collect();
    wrong += pairs.iter().filter(|&&[c, t]| made.sets.sees(c, t) != pvs.visible.has(c, t)).count()
        as u64;
    let (mut lookup_ns, mut row_ns) = (f64::INFINITY, f64::INFINITY);
    let mut row = Vec::new();
    for cell in 0..cells {
        row.clear();
        made.sets.add_row_to(cell, &mut row);
        let bits = pvs.visible.row(cell).iter();
        wrong += u64::from(bits.zip(row.iter().chain(std::iter::repeat(&0))).any(|(a, b)| a != b));
    }
    for _ in 0..ROUNDS {
        let took = of_thread(|| {
            let seen = pairs.iter().filter(|&&[c, t]| made.sets.sees(black_box(c), t));
            black_box(seen.count());
        });
        lookup_ns = lookup_ns.min(took.as_secs_f64() * 1e9 / LOOKUPS as f64);
        let took = of_thread(|| {
            for &[cell, _] in &pairs[..ROWS] {
                row.clear();
                made.sets.add_row_to(black_box(cell), &mut row);
                black_box(&row);
            }
        });
        row_ns = row_ns.min(took.as_secs_f64() * 1e9 / ROWS as f64);
    }
    RunTime {
        lookup_ns,
        row_ns,
        bytes_per_row: made.sets.size() as f64 / f64::from(cells.max(1)),
        file_bytes: bytes.len(),
        load_ms,
        wrong,
    }
}

fn row(b: &Baked) -> String {
    let percent = |share: f64| format!("{:.4} %", share * 100.0);
    format!(
        "{:<24} {:>5} {:>9} {:>9} {:>6} {:>6} {:>7} {:>8} {:>9} {:>13} {:>8} {:>14} {:>8}",
        b.name,
        b.cells,
        b.instances,
        b.triangles,
        digits(b.rays as f64 / 1e6),
        digits(b.cpu_seconds),
        digits(b.wall_seconds),
        format!(
            "{:.1} %",
            b.visible_pairs as f64 / (f64::from(b.cells) * f64::from(b.instances)) * 100.0
        ),
        percent(b.missing_estimate),
        percent(b.pixel_error),
        percent(b.missing_share),
        percent(b.drawn_pixel_error),
        percent(b.drawn_missing_share),
    )
}

fn measure(
    name: &str,
    args: &PvsSceneBenchArgs,
    threads: usize,
    console: &Console,
) -> Result<Baked, Failure> {
    let scene_args = SceneArgs::of(name);
    let mut model = inputs::load(&scene_args, console)?;
    let scene = &model.scene;
    let fail = |error| Failure::input(format!("{name}: {error}"));
    let begin = (Instant::now(), process::cpu_time());
    let tree = RayTree::new(scene, &RayTreeOptions::default()).map_err(fail)?;
    let mut region = tree.bounds();
    if let Some([low, high]) = args.heights {
        let floor = region[0][1];
        (region[0][1], region[1][1]) = (floor + low, floor + high);
    }
    let cells = ViewCells::adaptive(&tree, &[region], args.cells, 1).map_err(fail)?;
    let tree_seconds = begin.0.elapsed().as_secs_f64();
    let settings = SampledSettings::default().with_rays(args.rays).with_missing(args.missing);
    let mut bake = SampledBake::new(&tree, &cells, &settings).map_err(fail)?;
    let options = RunOptions { threads, ..RunOptions::default() };
    // Without a folder nothing can fail.
    let _ = bake.run(&options, &|_| !interrupted());
    let missing_estimate = bake.missing();
    let pvs = bake.finish();
    let cpu_seconds = (process::cpu_time() - begin.1).as_secs_f64();
    let wall_seconds = begin.0.elapsed().as_secs_f64();
    let check = check_pictures(&tree, &cells, &pvs.visible, args.poses, SIDE, 1, threads);
    let drawn = draw(scene, &cells, &pvs, args.drawn);
    let triangles = tree.triangle_count();
    let instances = scene.instance_count();
    let threads_of = threads_of(&tree, &cells, args.again_rays).map_err(fail)?;
    let with = Setting { settings, threads, poses: args.poses, side: SIDE };
    let mut edits = Vec::new();
    for together in [true, false] {
        let Some(share) = args.edit.filter(|_| !interrupted()) else { break };
        // Each edit is one of the scene as it was.
        model = inputs::load(&scene_args, console)?;
        let how = (share, together);
        edits.push(pvs_edit::measure(&mut model.scene, &pvs, how, &with).map_err(fail)?);
    }
    Ok(Baked {
        name: name.rsplit(['/', '\\']).next().unwrap_or(name).to_owned(),
        cells: cells.len(),
        instances,
        triangles,
        visible_pairs: pvs.visible_pairs(),
        found_pairs: pvs.found.count(),
        missing_estimate,
        rays: pvs.rays,
        cpu_seconds,
        wall_seconds,
        tree_seconds,
        poses: check.poses,
        pixel_error: check.pixel_error(),
        missing_share: check.missing_share(),
        drawn_poses: args.drawn,
        drawn_pixel_error: drawn[0],
        drawn_missing_share: drawn[1],
        threads: threads_of,
        edits,
        run_time: use_of(&pvs),
    })
}

/// Pictures by the reference renderer, which knows neither the rays nor their tree: the shares of
/// wrong pixels and of what is seen and missing.
fn draw(scene: &Scene, cells: &ViewCells, pvs: &ScenePvs, poses: u32) -> [f64; 2] {
    let extent = scene.extent();
    let size = extent.half_extent().iter().map(|h| h * h).sum::<f64>().sqrt() * 2.0;
    let (mut wrong, mut pixels, mut seen, mut missing) = (0_u64, 0_u64, 0_usize, 0_usize);
    for pose in 0..poses {
        // Cells spread over all of them, and the middle of each.
        let cell = (u64::from(pose) * 2 + 1) * u64::from(cells.len()) / (2 * u64::from(poses));
        let [low, high] = cells.bounds(cell as u32);
        let eye: [f64; 3] = std::array::from_fn(|a| (low[a] + high[a]) * 0.5);
        let mut in_pictures = std::collections::BTreeSet::new();
        for face in 0..6 {
            let mut target = eye;
            target[face / 2] += if face % 2 == 0 { 1.0 } else { -1.0 };
            let (near, far) = (size * 1e-6, size * 2.0);
            let quarter = std::f64::consts::FRAC_PI_2;
            let Ok(view) = View::perspective(eye, target, quarter, near, far, [SIDE * 2; 2]) else {
                continue;
            };
            let frame = render(scene, &view, Selection::All, &RenderOptions::default());
            let index = |slot: u32| scene.handle(slot).map(|h| h.index);
            pixels += frame.ids.len() as u64;
            for id in &frame.ids {
                let Some(index) = index(id.slot) else { continue };
                in_pictures.insert(index);
                wrong += u64::from(!pvs.visible.has(cell as u32, index));
            }
            in_pictures.extend(frame.blended.iter().filter_map(|id| index(id.slot)));
        }
        seen += in_pictures.len();
        missing += in_pictures.iter().filter(|&&i| !pvs.visible.has(cell as u32, i)).count();
    }
    [wrong as f64 / pixels.max(1) as f64, missing as f64 / seen.max(1) as f64]
}
