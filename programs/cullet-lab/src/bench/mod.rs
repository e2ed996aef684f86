//! `cullet bench`: named workloads, their times, and how far from what the machine could do.
//!
//! A time says little on another machine; so each comes with the time that the same machine, in the
//! same run and at its best SIMD level, takes only to read the bytes that must be read, or with
//! that of another way to the same answer. Every workload checks its answer before it is timed:
//! against the scalar oracle, or, with a hierarchy, against the flat sweep that was.

mod backface;
mod clip;
mod culler;
mod cut;
mod frustum;
mod hierarchy;
mod levels;
mod lod;
mod lod_scenes;
mod measure;
mod measured;
mod moving;
pub mod occlusion;
mod options;
mod pays;
mod portal;
mod pvs;
mod pvs_edit;
mod pvs_scene;
mod results;
mod shadow;
pub(crate) mod world;

use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};

use cullet_command::console::Console;
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::files::write_json;

pub use measured::{Measured, Yardstick};
pub use occlusion::OcclusionArgs;
pub use options::BenchOptions;
pub use results::Results;

use cullet_command::machine::Machine;

/// `cullet bench`
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true)]
pub struct BenchArgs {
    /// Only workloads whose name contains this, such as frustum, backface, hierarchy, moving,
    /// occlusion, lod/
    filter: Option<String>,
    /// Also a hierarchy of 1e7 boxes, and 1,000 frames of 1e6 that move: 1 GiB, some minutes
    #[arg(long)]
    large: bool,
    /// Write the results as JSON; - is the standard output
    #[arg(long, value_name = "PATH")]
    json: Option<PathBuf>,
    #[command(flatten)]
    occlusion: OcclusionArgs,
    #[command(subcommand)]
    of: Option<BenchOf>,
}

/// Measurements of a scene by `cullet bench`.
#[derive(Debug, Subcommand)]
enum BenchOf {
    /// Time of each stage of the culler on a scene
    #[command(after_help = culler::HELP)]
    Culler(Box<culler::CullerArgs>),
    /// Whether occlusion culling gives back what it takes, on many scenes
    #[command(after_help = pays::HELP)]
    Pays(Box<pays::PaysArgs>),
    /// Levels of detail beside those of errors that are believed
    #[command(after_help = levels::args::LOD_BENCH_HELP)]
    Lod(levels::args::LodBenchArgs),
    /// Costs and savings of cells and portals
    #[command(after_help = portal::HELP)]
    Portal(portal::PortalArgs),
    /// Sets of cells of portal graphs, beside the tool that level builders use
    #[command(after_help = pvs::HELP)]
    Pvs(Box<pvs::PvsArgs>),
}

impl BenchArgs {
    /// Puts what depends on the scene where nothing was given.
    pub fn settle(&mut self) {
        if let Some(BenchOf::Culler(args)) = &mut self.of {
            args.settle();
        }
    }

    /// The path that JSON is to be written to.
    #[must_use]
    pub fn json(&self) -> Option<&Path> {
        match &self.of {
            Some(BenchOf::Culler(args)) => args.json(),
            Some(BenchOf::Lod(args)) => args.json.as_deref(),
            Some(BenchOf::Pays(args)) => args.json(),
            Some(BenchOf::Portal(args)) => args.json(),
            Some(BenchOf::Pvs(args)) => args.json(),
            None => self.json.as_deref(),
        }
    }
}

/// Runs the command.
///
/// # Errors
/// If the command line cannot be carried out, or a file cannot be read or written.
pub fn run(args: &BenchArgs, console: &Console) -> Outcome {
    match &args.of {
        Some(BenchOf::Culler(args)) => return culler::run(args, console),
        Some(BenchOf::Pays(args)) => return pays::run(args, console),
        Some(BenchOf::Portal(args)) => return portal::run(args, console),
        Some(BenchOf::Pvs(args)) => return pvs::run(args, console),
        Some(BenchOf::Lod(args)) if args.scenes => {
            return lod_scenes::run(args.json.as_deref(), console);
        }
        Some(BenchOf::Lod(args)) => return levels::run(args, console),
        None => {}
    }
    if args.occlusion.scene.is_some() {
        if args.filter.as_ref().is_some_and(|f| !"occlusion".contains(f.as_str())) {
            return Err(Failure::usage("--scene belongs to cullet bench occlusion"));
        }
        return occlusion::run_scene(&args.occlusion, args.json.as_deref(), console);
    }
    let options = BenchOptions::new(args.filter.clone(), args.large);
    let mut heading = "";
    let results = run_each(&options, &mut |measured| {
        if console.json_on_stdout {
            return;
        }
        if std::mem::replace(&mut heading, measured.heading()) != measured.heading() {
            console.line(heading);
        }
        console.line(measured.to_string());
    });
    if let Some(path) = &args.json {
        write_json(path, &results)?;
    }
    Ok(Exit::Fine)
}

/// Measures those workloads of a subject that are wanted, and hands each result on.
type Workloads = fn(&BenchOptions, &mut dyn FnMut(Measured));

/// The subjects in the order in which they run. Occlusion follows them, for it has more to tell.
const SUBJECTS: [Workloads; 8] = [
    frustum::run,
    backface::run,
    shadow::run,
    hierarchy::run,
    moving::run,
    clip::run,
    cut::run,
    lod::run,
];

/// Runs the workloads that are wanted.
#[must_use]
pub fn run_all(options: &BenchOptions) -> Results {
    run_each(options, &mut |_| {})
}

/// The same, and hands each result on as soon as it is there.
pub fn run_each(options: &BenchOptions, each: &mut dyn FnMut(&Measured)) -> Results {
    let mut results = Vec::new();
    let mut take = |measured| {
        each(&measured);
        results.push(measured);
    };
    for subject in SUBJECTS {
        subject(options, &mut take);
    }
    let occlusion = occlusion::run(options, &mut take);
    Results { schema: 1, machine: Machine::here(), results, occlusion }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn small(filter: Option<String>) -> BenchOptions {
        let (sizes, tree_sizes) = (vec![1000], vec![1000]);
        BenchOptions { filter, seconds: 0.0, sizes, tree_sizes, drift_size: 1000 }
    }

    #[test]
    fn every_workload_of_a_small_run_checks_out() {
        let results = run_all(&small(None));
        let levels = cullet_command::machine::levels().len();
        // Frustum: two kinds, three shares. Back faces: four forms of triangles and six of
        // clusters, with three answers each, and the vertices. A frame: three at each level, and
        // three that have none. Shadows: three lights.
        let flat = (2 * 3 + (4 + 6) * 3 + 3 + 3) * levels + 1 + 3;
        // Two layouts: four shares, a list at each level and sorted; six of moves.
        let trees = 2 * (4 * (levels + 1) + 6);
        // Sorting, three ways for lines, four for triangles, two places. Cuts: six.
        let clipping = 1 + 3 + 4 + 2 + 6;
        // Two eyes.
        let lod = 2 * levels;
        // Three ways to draw, and the tests.
        let occlusion = 4 * levels;
        assert_eq!(results.results.len(), flat + trees + clipping + lod + occlusion);
        for r in &results.results {
            assert!(r.checked, "{} at {}", r.name, r.level);
            assert!(r.ns_per_item > 0.0 && r.yardstick.ratio() > 0.0, "{r:?}");
        }
        let json = serde_json::to_value(&results).expect("plain data");
        assert_eq!(json["schema"], 1);
        assert_eq!(json["results"][0]["name"], "frustum/spheres/1e3/5%");
    }

    #[test]
    fn a_filter_leaves_out_the_rest() {
        let filter = Some("boxes/1e3/30%".to_owned());
        let options = small(filter);
        let mut seen = 0;
        let results = run_each(&options, &mut |_| seen += 1);
        assert!(results.results.iter().all(|r| r.name == "frustum/boxes/1e3/30%"));
        assert_eq!(seen, results.results.len());
        assert!(seen > 0);
    }
}
