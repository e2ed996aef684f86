//! `cullet bench pvs --scene`: sets of scenes without cells, and how wrong they are.

use std::path::Path;
use std::time::Instant;

use clap::Args;
use cullet::{Scene, View};
use cullet_bake::sampled::{
    RayTree, RayTreeOptions, SampledBake, SampledSettings, ScenePvs, ViewCells, check_pictures,
};
use cullet_command::args::SceneArgs;
use cullet_command::console::{Console, digits, interrupted};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::files::write_json;
use cullet_command::inputs;
use cullet_draw::{RenderOptions, Selection, render};
use serde::Serialize;

use crate::machine::Machine;
use crate::process;

/// Scenes to bake.
#[derive(Debug, Args)]
pub(crate) struct PvsSceneBenchArgs {
    /// Bake this scene, a file or a built-in one, in place of portal graphs; may be given many times
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
    #[arg(long, value_name = "SHARE", default_value_t = 5e-4, requires = "scene")]
    missing: f64,
    /// Random places from where pictures check the sets
    #[arg(long, value_name = "N", default_value_t = 1000, requires = "scene")]
    poses: u32,
    /// Places of which the reference renderer draws pictures besides
    #[arg(long, value_name = "N", default_value_t = 4, requires = "scene")]
    drawn: u32,
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
    /// Of which for the trees of rays and the cells.
    tree_seconds: f64,
    poses: u32,
    pixel_error: f64,
    missing_share: f64,
    /// The same by the reference renderer, from a few places.
    drawn_poses: u32,
    drawn_pixel_error: f64,
    drawn_missing_share: f64,
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
    Ok(if complete { Exit::Fine } else { Exit::Interrupted })
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
    let model = inputs::load(&scene_args, console)?;
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
    while !bake.is_done() && !interrupted() {
        bake.round(threads);
    }
    let missing_estimate = bake.missing();
    let pvs = bake.finish();
    let cpu_seconds = (process::cpu_time() - begin.1).as_secs_f64();
    let wall_seconds = begin.0.elapsed().as_secs_f64();
    let check = check_pictures(&tree, &cells, &pvs.visible, args.poses, SIDE, 1, threads);
    let drawn = draw(scene, &cells, &pvs, args.drawn);
    Ok(Baked {
        name: name.rsplit(['/', '\\']).next().unwrap_or(name).to_owned(),
        cells: cells.len(),
        instances: scene.instance_count(),
        triangles: tree.triangle_count(),
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
    })
}

/// Pictures by the reference renderer, which knows neither the rays nor their tree: the shares of wrong pixels and of what
/// is seen and missing.
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
