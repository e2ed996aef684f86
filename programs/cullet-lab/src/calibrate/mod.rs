//! `cullet calibrate`: what tests and triangles cost on this machine, kept for the report.

mod clusters;
mod measure;

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use cullet_command::console::{Console, count, digits};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::files::{replace, write_json};

pub use clusters::{ClusterArgs, ClusterCosts};
use cullet_command::stored_costs::{Place, Stored, VARIABLE};

/// End of the text of `cullet calibrate --help`.
pub const HELP: &str = "\
Measures t, the test of a cluster, r, a triangle of the reference renderer for each kind of material,
and what else decides whether a kind of culling pays; in nanoseconds on one thread, each from the
fastest of many rounds, with the range that thirds of the rounds give. A triangle's cost is the slope of a line through the times of one
sheet cut into 8,192 to 131,072 triangles that fill the same pixels, so that pixels do not count in it.

The costs are kept in cullet/costs.json in the user's folder of settings (XDG_CONFIG_HOME, ~/.config or
%APPDATA%), or in the file that CULLET_COSTS names. From then on `cullet report` speaks of milliseconds
too, and `cullet picture` and `cullet reproduce johannsen-carter` make clusters for them.

Examples
  cullet calibrate                      measure and keep; some ten seconds on a quiet machine
  cullet calibrate --dry-run            measure and print only
  cullet calibrate --out ci.json        keep elsewhere, for cullet report --costs ci.json
  cullet calibrate --show               what is kept
  cullet calibrate --forget             remove it";

/// `cullet calibrate`
#[derive(Debug, Args)]
pub struct CalibrateArgs {
    /// Print what is kept, and measure nothing
    #[arg(long, conflicts_with_all = ["forget", "dry_run", "out", "rounds"])]
    show: bool,
    /// Remove what is kept, and measure nothing
    #[arg(long, conflicts_with_all = ["dry_run", "out", "rounds", "json"])]
    forget: bool,
    /// Measure and print, and keep nothing
    #[arg(long, conflicts_with = "out")]
    dry_run: bool,
    /// Keep the costs in this file
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Rounds of which the fastest counts; more are steadier and take longer, and are added where a
    /// cost comes out below zero
    #[arg(long, value_name = "N", default_value_t = 24, value_parser = clap::value_parser!(u32).range(1..=1000))]
    rounds: u32,
    /// Write the costs as JSON; - is the standard output
    #[arg(long, value_name = "PATH")]
    json: Option<PathBuf>,
}

impl CalibrateArgs {
    /// The path that JSON is to be written to.
    #[must_use]
    pub fn json(&self) -> Option<&Path> {
        self.json.as_deref()
    }
}

/// Runs the command.
///
/// # Errors
/// If costs cannot be measured, read or written.
pub fn run(args: &CalibrateArgs, console: &Console) -> Outcome {
    if args.show {
        return show(args, console);
    }
    if args.forget {
        return forget(console);
    }
    // Found before anything is measured, so that no measurement is lost for want of a place to keep
    // it.
    let path = match (&args.out, args.dry_run) {
        (_, true) => None,
        (Some(path), false) => Some(path.clone()),
        (None, false) => Some(place()?.path),
    };
    if cfg!(debug_assertions) {
        console.note("warning: this build has debug assertions, which make its costs its own");
    }
    let start = Instant::now();
    let mut progress = console.progress("rounds", u64::from(args.rounds) + 1);
    let Some(stored) = measure::measure(args.rounds, || progress.step()) else {
        progress.finish();
        console.note("stopped: nothing was measured to its end, and nothing is kept");
        return Ok(Exit::Interrupted);
    };
    progress.finish();
    stored.costs().check().map_err(|e| {
        let rounds = stored.rounds.saturating_mul(2).min(1000);
        Failure::input(format!(
            "{} came out at {:.1} ns, which cannot be: the machine was too busy; try again, or --rounds {rounds}",
            e.what.replace('_', " "),
            e.value
        ))
    })?;
    print(console, &stored);
    console.line(format!("measured in {:.1} s", start.elapsed().as_secs_f64()));
    if let Some(path) = &path {
        keep(path, &stored)?;
        console.line(format!("kept in {}", path.display()));
    }
    if let Some(path) = &args.json {
        write_json(path, &stored)?;
    }
    Ok(Exit::Fine)
}

/// The file that is meant where none is named.
fn place() -> Result<Place, Failure> {
    Place::find().ok_or_else(|| {
        Failure::input(format!(
            "the system tells no folder for settings; name a file with --out or {VARIABLE}"
        ))
    })
}

fn keep(path: &Path, stored: &Stored) -> Result<(), Failure> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(|e| Failure::write(folder, &e))?;
    }
    let mut bytes = serde_json::to_vec_pretty(stored)
        .map_err(|e| Failure { exit: Exit::Internal, message: format!("JSON: {e}") })?;
    bytes.push(b'\n');
    replace(path, &bytes)
}

fn show(args: &CalibrateArgs, console: &Console) -> Outcome {
    let path = place()?.path;
    let Some(stored) = Stored::read(&path).map_err(Failure::input)? else {
        return Err(Failure::input(format!(
            "{}: there are no costs yet; `cullet calibrate` measures them",
            path.display()
        )));
    };
    print(console, &stored);
    console.line(format!("kept in {}", path.display()));
    if !stored.is_of_here() {
        console.line("measured on another machine; `cullet calibrate` measures them on this one");
    }
    if let Some(path) = &args.json {
        write_json(path, &stored)?;
    }
    Ok(Exit::Fine)
}

fn forget(console: &Console) -> Outcome {
    let path = place()?.path;
    match std::fs::remove_file(&path) {
        Ok(()) => console.line(format!("{} removed", path.display())),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => {
            console.line(format!("{}: there was nothing to forget", path.display()));
        }
        Err(e) => {
            return Err(Failure::input(format!("{}: cannot be removed: {e}", path.display())));
        }
    }
    Ok(Exit::Fine)
}

/// Symbol and words for each cost, in the order of [`MeasuredCosts::named`].
const WORDS: [(&str, &str); 8] = [
    ("", "frustum test of an instance's box"),
    ("t", "back-face test of a cluster"),
    ("", "back-face test of a triangle"),
    ("", "triangle rejected by the renderer"),
    ("r", "opaque triangle drawn"),
    ("", "alpha-masked triangle drawn"),
    ("", "blended triangle drawn"),
    ("", "one more draw"),
];

fn print(console: &Console, stored: &Stored) {
    console.line(format!("{:<38}{:>9}   range", "", "ns"));
    let costs = stored.costs();
    for ((name, _), (symbol, words)) in costs.named().into_iter().zip(WORDS) {
        let s = stored.spread(name);
        let [ns, low, high] = [s.ns, s.low, s.high].map(digits);
        console.line(format!("{symbol:<3}{words:<35}{ns:>9}   {low} to {high}"));
    }
    let ratio = costs.t_over_r();
    let words = match ratio < 1.0 {
        true => {
            let clusters = count((1.0 / ratio).round() as u64, "cluster", "clusters");
            format!("testing {clusters} costs one triangle")
        }
        false => format!("testing a cluster costs {} triangles", digits(ratio)),
    };
    console.line(format!("t/r = {}: {words}", digits(ratio)));
    console.line(format!(
        "clusters are made for t/r = {}: a test and a draw over a rejected triangle",
        digits(clusters::options_for(&costs).test_cost)
    ));
    let rounds = count(u64::from(stored.rounds), "round", "rounds");
    console.line(format!("{}; {}; {}; {rounds}", stored.machine, stored.renderer, stored.date));
}
