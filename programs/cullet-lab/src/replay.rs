//! `cullet replay`: plays a recording of an occlusion buffer again.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use cullet::Simd;
use cullet::bounds::Aabb;
use cullet::cull::occlusion::Visibility;
use cullet_command::console::{Console, count, grouped};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::files::write_json;
use cullet_maps::recording::{Difference, Differences, Recording};
use serde_json::json;

/// End of `cullet replay --help`.
pub(crate) const HELP: &str = "\
A recording holds views, the occluders drawn into the occlusion buffer and the boxes tested, with the
results then. Played again, each result must be the same; one that is not is printed, and
the exit code is 1. The time is that of drawing and testing together, the best of --times.

Examples
  cullet verify city --path walk --views 2 --record city.occ
  cullet replay city.occ
  cullet replay city.occ --times 20 --json -";

/// Differences printed; all of them are in the JSON.
const SHOWN: usize = 20;

/// `cullet replay`
#[derive(Debug, Args)]
pub struct ReplayArgs {
    /// A recording, made by cullet verify --record
    file: PathBuf,
    /// Play it so often, and tell the best time
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    times: u32,
    /// Write the result as JSON; - is the standard output
    #[arg(long, value_name = "PATH", value_parser = cullet_command::parse::output)]
    pub(crate) json: Option<PathBuf>,
}

/// Runs the command.
pub(crate) fn run(args: &ReplayArgs, console: &Console) -> Outcome {
    let name = args.file.display();
    let wrong = |e: &dyn std::fmt::Display| Failure::input(format!("{name}: {e}"));
    let bytes = std::fs::read(&args.file).map_err(|e| wrong(&format!("cannot be read: {e}")))?;
    let recording = Recording::decode(&bytes).map_err(|e| wrong(&e))?;
    let mut best = f64::INFINITY;
    let mut found = Differences::default();
    for _ in 0..args.times {
        let start = Instant::now();
        found = recording.replay(Simd::best()).map_err(|e| wrong(&e))?;
        best = best.min(start.elapsed().as_secs_f64());
    }
    console.line(format!(
        "{name}: {}, {} drawn, {} tested, {} of them hidden; {:.3} ms",
        count(found.views, "view", "views"),
        count(found.drawn, "occluder", "occluders"),
        count(found.tested, "box", "boxes"),
        grouped(found.hidden),
        best * 1e3
    ));
    found.changed.iter().take(SHOWN).for_each(|d| console.line(text(d)));
    if found.changed.len() > SHOWN {
        let more = found.changed.len() - SHOWN;
        console.line(format!("  and {more} more, all of them in the JSON of --json"));
    }
    console.line(match found.changed.len() {
        0 => "all results are as they were".to_owned(),
        n => count(n as u64, "RESULT DIFFERS", "RESULTS DIFFER"),
    });
    if let Some(path) = &args.json {
        let changed: Vec<_> = found
            .changed
            .iter()
            .map(|d| json!({"call": d.call, "min": d.bounds.min, "max": d.bounds.max, "was": word(d.was), "is": word(d.is)}))
            .collect();
        let record = json!({
            "schema": 2, "file": name.to_string(), "views": found.views, "drawn": found.drawn,
            "tested": found.tested, "hidden": found.hidden, "changed": changed, "ms": best * 1e3,
        });
        write_json(path, &record)?;
    }
    Ok(if found.changed.is_empty() { Exit::Fine } else { Exit::FalseCull })
}

fn word(visibility: Visibility) -> &'static str {
    match visibility {
        Visibility::Outside => "outside",
        Visibility::Visible => "visible",
        Visibility::Hidden => "hidden",
    }
}

fn text(d: &Difference) -> String {
    let Difference { call, bounds, was, is } = d;
    let Aabb { min, max } = bounds;
    format!("  call {call}: the box {min:?} to {max:?} was {}, is {}", word(*was), word(*is))
}
