//! `cullet pvs`: which cells of a map see each other.

use std::path::PathBuf;
use std::time::Instant;

use crate::units::Units;
use clap::Args;
use cullet_bake::job::CellSource;
use cullet_bake::job::Settings;
use cullet_bake::job::is_named_map;
use cullet_bake::job::is_named_scene;
use cullet_bake::pvs::{Bake, Pvs, PvsPreset, SightCheck, check_sight_ref};
use cullet_bake::work::{Rounds, RunEnd, RunOptions};
use cullet_cells::cell::CellGraph;
use cullet_command::args::{SceneArgs, UnitArgs};
use cullet_command::console::{Console, agree, count, digits, grouped, percent};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::files::{replace, write_json};
use cullet_command::process;
use cullet_command::{inputs, parse};
use cullet_io::{ErrorKind, LoadError, Model};
use serde::Serialize;

use crate::pvs_scene::{self, PvsSceneArgs};

/// End of `cullet pvs --help`.
pub(crate) const HELP: &str = "\
Bakes which cells of a portal graph (.prt: PRT1, PRT2, PRT1-AM) or of a map (.bsp of Quake, Half-Life, Quake 2 and 3) see each other. With
-o MAP.bsp the sets are written into a copy of the map, in the place of what its compiler's vis would write. Each pair of cells is proven visible by a
line of sight, proven hidden by planes, or undecided and kept; the share of the last says how much the sets may be too
large by. The bytes are the same for any number of threads and any split into units.

A scene without cells (glb, gltf, obj, ply, stl, off, occscn, or a built-in one) gets view cells, and lines sampled from
them find what each sees. Such sets may lack something: it is estimated how much, and --check N measures it by pictures from N
random places. Ctrl-C ends with what was found, and with --resume keeps it to go on; --resume with more --rays goes on too.

--unit I/N does one of N shares of the work and leaves it as files in --units; any number of processes may share a
folder, on one machine or many. Once all have ended, --resume joins them. --resume alone does all the work and keeps
what it finished there, so that it can go on after Ctrl-C.

Examples
  cullet pvs lqdm1.prt                              how much is seen, in what time
  cullet pvs lqdm1.bsp -o baked.bsp                 the map with its visibility baked, for the game
  cullet pvs lqdm1.prt -o lqdm1.cpvs --rows lqdm1.pvs
  cullet pvs lqdm1.prt --preset fast                only a first bound, at once
  cullet pvs lqdm1.prt --check 10000000             holds the result against ten million sampled lines
  cullet pvs big.prt --resume -o big.cpvs           goes on where Ctrl-C stopped it
  cullet pvs big.prt --unit 3/8 --units /shared/big the third of eight machines
  cullet pvs lqdm1.prt --json - | jq .undecided
  cullet pvs city --view-cells 1000 --heights 1..2.5     what is seen from 1,000 places of a scene, at the height of eyes
  cullet pvs hall.glb --rays 50000000 --check 1000  and how wrong that is
  cullet pvs hall.glb --after hall.cpvs -o new.cpvs goes on from the sets of before an edit

Exit codes
  0 fine        1 --check found a line of sight between cells that the result calls hidden
  3 no portal file or map, or invalid      130 interrupted; with --resume or --unit finished units are kept";

/// `cullet pvs`
#[derive(Debug, Args)]
pub struct PvsArgs {
    /// The portal graph, a .prt; or a map, a .bsp; or a scene
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Write the sets, with the lines that prove them; with the ending .bsp, the map with the sets
    /// in it
    #[arg(long, short, value_name = "PATH", value_parser = parse::output, conflicts_with = "unit")]
    out: Option<PathBuf>,
    /// Write the sets as plain bit rows, PVSROWS1; of a scene PVSROWS2
    #[arg(long, value_name = "PATH", conflicts_with = "unit")]
    rows: Option<PathBuf>,
    /// Write what was found as JSON; - is the standard output
    #[arg(long, value_name = "PATH", value_parser = parse::output, conflicts_with = "unit")]
    pub(crate) json: Option<PathBuf>,
    /// Threads [default: as many as there are processors]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=256))]
    threads: Option<u32>,
    /// Seed of the sampled lines
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// How far to go
    #[arg(long, value_name = "NAME", default_value = "full", value_parser = parse::choice(&PRESETS))]
    preset: PvsPreset,
    /// Width of a slit that counts as closed, as a share of the map's diagonal, 1e-7 to 1e-3
    #[arg(long, value_name = "SHARE", default_value_t = 1e-6, value_parser = tolerance)]
    tolerance: f64,
    /// Hold the result against N lines of sight, sampled by code of their own; of a scene, N
    /// pictures all around
    #[arg(long, value_name = "N", conflicts_with = "unit")]
    check: Option<u64>,
    /// How far inside of each portal the lines of --check pass [default: five times the tolerance]
    #[arg(long, value_name = "DISTANCE", value_parser = parse::distance, requires = "check")]
    margin: Option<f64>,
    #[command(flatten)]
    units: UnitArgs,
    #[command(flatten)]
    scene: PvsSceneArgs,
}

const PRESETS: [(&str, PvsPreset, &str); 2] = [
    ("full", PvsPreset::Full, "Decide every pair"),
    ("fast", PvsPreset::Fast, "Only floods through whole portals: several times too much"),
];

fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(v) if (1e-7..=1e-3).contains(&v) => Ok(v),
        _ => Err(format!("'{text}' is not a share of 1e-7 to 1e-3; try 1e-6")),
    }
}

/// Contents of the JSON. Pairs are ordered; a cell with itself is not counted.
#[derive(Debug, Serialize)]
struct Record {
    schema: u32,
    cells: u32,
    portals: u64,
    visible_pairs: u64,
    proven_visible: u64,
    undecided: u64,
    candidates: u64,
    cpu_seconds: f64,
    wall_seconds: f64,
    peak_bytes: u64,
    bytes_hash: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    check: Option<CheckRecord>,
}

/// Findings of the sampled lines.
#[derive(Debug, Serialize)]
struct CheckRecord {
    lines: u64,
    margin: f64,
    pairs: u64,
    missed: u64,
}

/// Runs the command.
pub(crate) fn run(args: &PvsArgs, console: &Console) -> Outcome {
    let threads = args.threads.map_or_else(
        || std::thread::available_parallelism().map_or(1, usize::from),
        |threads| threads as usize,
    );
    let settings = settings(args);
    let wants_view_cells = settings.scene.wants_view_cells() || args.scene.after.is_some();
    let source = if wants_view_cells || is_named_scene(&args.file) {
        let model = inputs::load(&SceneArgs::of(args.file.display().to_string()), console)?;
        match model.in_cells().graph().filter(|_| !wants_view_cells) {
            Some(graph) => CellSource::of_cells(graph.clone()),
            None => return run_scene(args, &settings, &model, threads, console),
        }
    } else {
        CellSource::open(&args.file).map_err(failure)?
    };
    if !source.has_map() && args.out.as_deref().is_some_and(is_named_map) {
        return Err(Failure::usage(
            "a portal graph has no map to write the sets into; give the .bsp itself, or another ending to --out",
        ));
    }
    let begin = (Instant::now(), process::cpu_time());
    let mut bake = Bake::new(&source.graph, &settings.of_cells(), threads);
    let units = Units::open(&args.units, &args.file)?;
    let options = RunOptions { threads, ..RunOptions::default() };
    match units.run(&mut bake, &options, console)? {
        RunEnd::Whole => {}
        RunEnd::Stopped => {
            let (round, rounds) = (bake.round() + 1, bake.rounds());
            console.note(match units.folder() {
                Some(at) => format!(
                    "interrupted in round {round} of {rounds}; the same command goes on from {}",
                    at.display()
                ),
                None => "interrupted, and nothing is kept; --resume would keep it".to_owned(),
            });
            return Ok(Exit::Interrupted);
        }
        RunEnd::Share => {
            units.tell_done(console);
            return Ok(Exit::Fine);
        }
    }
    let own_bytes = bake.bytes();
    let pvs = bake.finish();
    let mut record = Record {
        schema: 1,
        cells: pvs.cell_count(),
        portals: source.graph.portals().len() as u64,
        visible_pairs: pvs.visible_pairs(),
        proven_visible: pvs.proven_pairs(),
        undecided: pvs.undecided(),
        candidates: pvs.candidates(),
        cpu_seconds: (process::cpu_time() - begin.1).as_secs_f64(),
        wall_seconds: begin.0.elapsed().as_secs_f64(),
        peak_bytes: process::peak_bytes().unwrap_or(own_bytes),
        bytes_hash: format!("{:016x}", pvs.rows_hash()),
        check: None,
    };
    print(console, args, source.turned, &record);
    if let Some(path) = &args.rows {
        replace(path, &pvs.rows_bytes())?;
    }
    if let Some(path) = &args.out {
        let bytes = match is_named_map(path) {
            true => source.map_with(&args.file, &pvs).map_err(failure)?,
            false => pvs.to_bytes(),
        };
        replace(path, &bytes)?;
        console.line(format!("{}, {} bytes", path.display(), grouped(bytes.len() as u64)));
    }
    if let Some(lines) = args.check {
        record.check = Some(check(args, &source.graph, &pvs, lines, threads, console));
    }
    if let Some(path) = &args.json {
        write_json(path, &record)?;
    }
    let missed = record.check.is_some_and(|check| check.missed > 0);
    Ok(if missed { Exit::FalseCull } else { Exit::Fine })
}

/// Returns the settings of the bake.
fn settings(args: &PvsArgs) -> Settings {
    let fast = args.preset == PvsPreset::Fast;
    Settings { seed: args.seed, fast, tolerance: args.tolerance, scene: args.scene.settings() }
}

/// Returns the failure that ends the command where a file cannot be loaded.
pub fn failure(error: LoadError) -> Failure {
    let over = matches!(error.kind, ErrorKind::OverLimit { .. });
    Failure { exit: if over { Exit::Limit } else { Exit::Input }, message: error.to_string() }
}

/// Bakes a scene without cells.
fn run_scene(
    args: &PvsArgs,
    settings: &Settings,
    model: &Model,
    threads: usize,
    console: &Console,
) -> Outcome {
    let units = Units::open(&args.units, &args.file)?;
    let common = pvs_scene::Common {
        file: &args.file,
        out: args.out.as_deref(),
        rows: args.rows.as_deref(),
        json: args.json.as_deref(),
        threads,
        settings,
        check: args.check,
        units: &units,
    };
    pvs_scene::run(&args.scene, model, &common, console)
}

fn print(console: &Console, args: &PvsArgs, turned: u32, record: &Record) {
    let Record { cells, portals, visible_pairs, .. } = *record;
    let all = u64::from(cells) * u64::from(cells.saturating_sub(1));
    console.line(format!(
        "{}: {}, {}",
        args.file.display(),
        count(u64::from(cells), "cell", "cells"),
        count(portals, "portal", "portals"),
    ));
    if turned > 0 {
        let odd = count(u64::from(turned), "portal is", "portals are");
        console.note(format!("{odd} wound the other way around than the rest; turned"));
    }
    console.line(format!(
        "{} of cells see each other, {} of all; {} a cell in the mean",
        count(visible_pairs, "pair", "pairs"),
        percent(visible_pairs, all),
        digits(visible_pairs as f64 / f64::from(cells.max(1))),
    ));
    console.line(format!(
        "  {} proven visible by a line of sight, {} undecided and kept: {}",
        grouped(record.proven_visible),
        grouped(record.undecided),
        percent(record.undecided, visible_pairs),
    ));
    let hidden = all - visible_pairs;
    console.line(format!(
        "  {} hidden, {} of them by floods through whole portals alone",
        grouped(hidden),
        grouped(all - record.candidates),
    ));
    console.line(format!(
        "{} s of processors, {} s, {} MiB at the most",
        digits(record.cpu_seconds),
        digits(record.wall_seconds),
        digits(record.peak_bytes as f64 / f64::from(1 << 20)),
    ));
}

/// Holds the sets against sampled lines.
fn check(
    args: &PvsArgs,
    graph: &CellGraph,
    pvs: &Pvs,
    lines: u64,
    threads: usize,
    console: &Console,
) -> CheckRecord {
    let margin = args.margin.unwrap_or(args.tolerance * 5.0 * diagonal(graph));
    let found = check_sight_ref(graph, pvs.visible(), lines, args.seed, margin, threads);
    let SightCheck { lines, missed, ref first, .. } = found;
    let pairs = found.found.count();
    console.line(format!(
        "{} through random portals, {} inside of each that they pass: {} seen, {missed} missed",
        count(lines, "line", "lines"),
        digits(margin),
        count(pairs, "pair", "pairs"),
    ));
    for m in first {
        let ([px, py, pz], [dx, dy, dz]) = (m.point, m.direction);
        console.line(format!(
            "  MISSED cell {} sees cell {}, by the line through {px},{py},{pz} along {dx},{dy},{dz}",
            m.from, m.to
        ));
    }
    if missed > 0 {
        let are = agree(missed, "pair is", "pairs are");
        console.line(format!("{missed} {are} missed: a fault of cullet, please report it"));
    }
    CheckRecord { lines, margin, pairs, missed }
}

/// Length of the diagonal of the box around all portals.
fn diagonal(graph: &CellGraph) -> f64 {
    let corners = || graph.portals().iter().flat_map(|p| &p.polygon).map(|&v| glam::DVec3::from(v));
    let low = corners().reduce(glam::DVec3::min).unwrap_or_default();
    let high = corners().reduce(glam::DVec3::max).unwrap_or_default();
    (high - low).length()
}
