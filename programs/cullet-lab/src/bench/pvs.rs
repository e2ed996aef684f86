//! `cullet bench pvs`: bakes of portal graphs beside the tool that level builders use.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use cullet_bake::pvs::{Bake, BitRows, Pvs, PvsSettings, check_sight_ref};
use cullet_bake::work::RunOptions;
use cullet_command::console::{Console, digits, grouped, interrupted};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::files::write_json;
use cullet_maps::load_prt;
use serde::Serialize;

use super::pvs_scene::{self, PvsSceneBenchArgs};
use cullet_command::machine::Machine;
use cullet_command::process;

pub(crate) const HELP: &str = "\
Bakes each portal graph of a folder. Where NAME.pvs lies beside NAME.prt, the rows that the tool vis made, pairs are compared
with those that it has in both directions; where NAME.vis.txt does, the time of the processors with its \"full\" run on one
thread. These are times of another machine: run vis beside for a claim. The answer is held against sampled lines of sight, and
the bytes against a run on another number of threads.

Examples
  cullet bench pvs                                      the folder portals of CULLET_DATA
  cullet bench pvs maps/*.prt --check 10000000          ten million lines for each
  cullet bench pvs lqdm13.prt --threads 2 --json -
  cullet bench pvs --scene city --scene hall.glb --threads 2 --heights 1..2.5

With --scene, scenes without cells are baked by sampled lines, and held against pictures from random places.";

/// `cullet bench pvs`
#[derive(Debug, Args)]
pub(super) struct PvsArgs {
    /// Portal graphs [default: every .prt in the folder portals of `CULLET_DATA`, else of
    /// ../shared/data]
    #[arg(value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Threads of the run that is timed
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=256))]
    threads: u32,
    /// Threads of a second run, whose bytes must be the same; 0 leaves it out
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(0..=256))]
    again: u32,
    /// Sampled lines of sight for each graph
    #[arg(long, value_name = "N", default_value_t = 1_000_000)]
    check: u64,
    /// Write the results as JSON; - is the standard output
    #[arg(long, value_name = "PATH")]
    json: Option<PathBuf>,
    #[command(flatten)]
    of_scenes: PvsSceneBenchArgs,
}

impl PvsArgs {
    pub(crate) fn json(&self) -> Option<&Path> {
        self.json.as_deref()
    }
}

#[derive(Debug, Serialize)]
struct Record {
    schema: u32,
    machine: Machine,
    threads: u32,
    graphs: Vec<Graph>,
    /// Geometric mean of vis's time over this one's, where vis took 0.05 s or more.
    speed: Option<f64>,
    /// Geometric mean of these pairs over vis's in both directions.
    pairs: Option<f64>,
    /// Geometric mean of these pairs over all of vis's.
    pairs_one_way: Option<f64>,
    complete: bool,
}

#[derive(Debug, Serialize)]
struct Graph {
    name: String,
    cells: u32,
    portals: usize,
    candidates: u64,
    visible_pairs: u64,
    proven_visible: u64,
    undecided: u64,
    cpu_seconds: f64,
    wall_seconds: f64,
    /// Bytes that the engine holds; the process has more.
    bytes: u64,
    peak_bytes: Option<u64>,
    /// Whether another number of threads gave the same bytes.
    same_bytes: Option<bool>,
    lines: u64,
    missed: u64,
    vis: Option<Vis>,
}

/// Results and time of the tool.
#[derive(Debug, Serialize)]
struct Vis {
    /// Ordered pairs that it has in both directions, and in either.
    pairs: u64,
    pairs_one_way: u64,
    cpu_seconds: Option<f64>,
}

/// The shortest time of vis that is worth a ratio: it is stated in hundredths of a second.
const SHORTEST: f64 = 0.05;

impl Graph {
    fn speed(&self) -> Option<f64> {
        let theirs = self.vis.as_ref()?.cpu_seconds.filter(|&s| s >= SHORTEST)?;
        Some(theirs / self.cpu_seconds.max(1e-6))
    }

    fn ratio(&self, of: fn(&Vis) -> u64) -> Option<f64> {
        let theirs = of(self.vis.as_ref()?);
        (theirs > 0).then(|| self.visible_pairs as f64 / theirs as f64)
    }
}

/// Runs the command.
pub(crate) fn run(args: &PvsArgs, console: &Console) -> Outcome {
    if !args.of_scenes.scene.is_empty() {
        return pvs_scene::run(&args.of_scenes, args.threads, args.json.as_deref(), console);
    }
    let files = if args.files.is_empty() { all()? } else { args.files.clone() };
    let mut graphs = Vec::new();
    console.line(HEADING);
    for file in &files {
        let graph = measure(file, args)?;
        console.line(row(&graph));
        graphs.push(graph);
        if interrupted() {
            break;
        }
    }
    let mean = |of: &dyn Fn(&Graph) -> Option<f64>| {
        let logs: Vec<f64> = graphs.iter().filter_map(of).map(f64::ln).collect();
        (!logs.is_empty()).then(|| (logs.iter().sum::<f64>() / logs.len() as f64).exp())
    };
    let record = Record {
        schema: 1,
        machine: Machine::here(),
        threads: args.threads,
        speed: mean(&Graph::speed),
        pairs: mean(&|g| g.ratio(|v| v.pairs)),
        pairs_one_way: mean(&|g| g.ratio(|v| v.pairs_one_way)),
        complete: graphs.len() == files.len(),
        graphs,
    };
    let text = |mean: Option<f64>, places: usize| {
        mean.map_or_else(|| "-".to_owned(), |mean| format!("{mean:.places$}"))
    };
    console.line(format!(
        "geometric means: {} times as fast as vis; pairs {} of its own in both directions, {} of all of its own",
        text(record.speed, 2),
        text(record.pairs, 4),
        text(record.pairs_one_way, 4),
    ));
    if let Some(path) = &args.json {
        write_json(path, &record)?;
    }
    let wrong = record.graphs.iter().any(|g| g.missed > 0 || g.same_bytes == Some(false));
    Ok(match (wrong, record.complete) {
        (true, _) => Exit::FalseCull,
        (false, true) => Exit::Fine,
        (false, false) => Exit::Interrupted,
    })
}

const HEADING: &str = "graph              cells portals  CPU s  wall s   vis s  times    pairs  of vis  undecided   MiB  missed  bytes";

fn row(g: &Graph) -> String {
    let or = |text: Option<String>| text.unwrap_or_else(|| "-".to_owned());
    format!(
        "{:<18} {:>5} {:>7} {:>6} {:>7} {:>7} {:>6} {:>8} {:>7} {:>8.2} % {:>5} {:>7}  {}",
        g.name,
        g.cells,
        g.portals,
        digits(g.cpu_seconds),
        digits(g.wall_seconds),
        or(g.vis.as_ref().and_then(|v| v.cpu_seconds).map(|s| format!("{s:.2}"))),
        or(g.speed().map(|s| format!("{s:.2}"))),
        g.visible_pairs,
        or(g.ratio(|v| v.pairs).map(|r| format!("{r:.4}"))),
        g.undecided as f64 / g.visible_pairs.max(1) as f64 * 100.0,
        digits(g.bytes as f64 / f64::from(1 << 20)),
        grouped(g.missed),
        match g.same_bytes {
            Some(true) => "same",
            Some(false) => "DIFFER",
            None => "-",
        }
    )
}

/// Every portal graph of the test data, smallest first.
fn all() -> Result<Vec<PathBuf>, Failure> {
    let set = std::env::var_os("CULLET_DATA").filter(|v| !v.is_empty()).map(PathBuf::from);
    let folder = set.unwrap_or_else(|| "../shared/data".into()).join("portals");
    let entries = std::fs::read_dir(&folder).map_err(|e| {
        Failure::input(format!("{}: {e}; name portal graphs, or set CULLET_DATA", folder.display()))
    })?;
    let mut files: Vec<(u64, PathBuf)> = entries
        .flatten()
        .map(|entry| (entry.metadata().map_or(0, |m| m.len()), entry.path()))
        .filter(|(_, path)| path.extension().is_some_and(|e| e == "prt"))
        .collect();
    files.sort();
    Ok(files.into_iter().map(|(_, path)| path).collect())
}

fn measure(file: &Path, args: &PvsArgs) -> Result<Graph, Failure> {
    let prt = load_prt(file).map_err(Failure::input)?;
    let graph = &prt.graph;
    let bake = |threads: u32| {
        let mut bake = Bake::new(graph, &PvsSettings::default(), threads as usize);
        let options = RunOptions { threads: threads as usize, ..RunOptions::default() };
        // Without a folder nothing can fail.
        let _ = bake.run(&options, &|_| true);
        (bake.bytes(), bake.finish())
    };
    let begin = (Instant::now(), process::cpu_time());
    let (bytes, pvs) = bake(args.threads);
    let cpu_seconds = (process::cpu_time() - begin.1).as_secs_f64();
    let wall_seconds = begin.0.elapsed().as_secs_f64();
    let same_bytes = (args.again > 0).then(|| bake(args.again).1.to_bytes() == pvs.to_bytes());
    let corners = || graph.portals().iter().flat_map(|p| &p.polygon).map(|&v| glam::DVec3::from(v));
    let low = corners().reduce(glam::DVec3::min).unwrap_or_default();
    let high = corners().reduce(glam::DVec3::max).unwrap_or_default();
    let margin = (high - low).length() * 5e-6;
    let threads = args.threads.max(args.again).max(1) as usize;
    let check = check_sight_ref(graph, pvs.visible(), args.check, 7, margin, threads);
    Ok(Graph {
        name: file.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        cells: graph.cell_count(),
        portals: graph.portals().len(),
        candidates: pvs.candidates(),
        visible_pairs: pvs.visible_pairs(),
        proven_visible: pvs.proven_pairs(),
        undecided: pvs.undecided(),
        cpu_seconds,
        wall_seconds,
        bytes,
        peak_bytes: process::peak_bytes(),
        same_bytes,
        lines: check.lines,
        missed: check.missed,
        vis: vis(file, &pvs),
    })
}

/// Reads the results of vis from the files beside a graph.
fn vis(file: &Path, pvs: &Pvs) -> Option<Vis> {
    let rows = BitRows::from_exchange(&std::fs::read(file.with_extension("pvs")).ok()?)?;
    let cells = pvs.cell_count();
    if rows.columns() != cells {
        return None;
    }
    let text = std::fs::read_to_string(file.with_extension("vis.txt")).unwrap_or_default();
    // One thread where there was such a run, and of several the one on a quieter machine, which is
    // the last.
    let of =
        |kind: &str| text.lines().rfind(|line| line.contains(kind) && line.contains("user_cpu_s="));
    let line = of(" full t1 ").or_else(|| of(" full t2 "));
    let seconds =
        line.and_then(|line| line.split("user_cpu_s=").nth(1)?.split(' ').next()?.parse().ok());
    let both = |a: u32| (0..cells).filter(|&b| a != b && rows.has(a, b) && rows.has(b, a)).count();
    let one = |a: u32| (0..cells).filter(|&b| a != b && rows.has(a, b)).count();
    Some(Vis {
        pairs: (0..cells).map(|a| both(a) as u64).sum(),
        pairs_one_way: (0..cells).map(|a| one(a) as u64).sum(),
        cpu_seconds: seconds,
    })
}
