//! The README's two commands as a stranger meets them: a fresh clone in an empty folder, no data beside it, nothing
//! installed but Rust and a C compiler.

use std::path::Path;
use std::process::Command;
use std::time::Instant;

use crate::tools::{Done, cargo_program, command, root, run};

/// Seconds in which the page should be there, on two cores that do nothing else.
const REPORT_GOAL: f64 = 90.0;
/// Seconds in which the second command should end there.
const TEST_GOAL: f64 = 900.0;

/// Clones what is committed, and runs both commands in the clone.
pub(crate) fn try_out() -> Done {
    let folder = std::env::temp_dir().join(format!("cullet-bare-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let result = in_clone(&folder.join("cullet"));
    let _ = std::fs::remove_dir_all(&folder);
    result
}

fn in_clone(clone: &Path) -> Done {
    let (from, to) = (root(), clone.to_string_lossy().into_owned());
    run(command("git", &["clone", "--quiet", "--no-hardlinks", &from.to_string_lossy(), &to]))?;
    let start = Instant::now();
    run(there(clone, &["run", "--release", "--", "report"]))?;
    let reported = start.elapsed().as_secs_f64();
    for file in ["index.html", "report.json", "views.csv"] {
        let path = clone.join("report").join(file);
        let size = std::fs::metadata(&path).map_err(|e| format!("{}: {e}", path.display()))?.len();
        if size == 0 {
            return Err(format!("{} is empty", path.display()));
        }
    }
    println!(
        "\nfirst command: the page was there after {reported:.0} s (goal {REPORT_GOAL} s on two idle cores)"
    );
    let start = Instant::now();
    let tested = run(there(clone, &["xtask", "test"]));
    let took = start.elapsed().as_secs_f64();
    let end = if tested.is_ok() { "passed" } else { "failed" };
    println!("\nfirst command: {reported:.0} s (goal {REPORT_GOAL} s on two idle cores)");
    println!("second command: {end} after {took:.0} s (goal {TEST_GOAL} s)");
    tested
}

/// A command of cargo in the clone, with nothing of what this run was told or is kept for it.
fn there(clone: &Path, args: &[&str]) -> Command {
    let mut cargo = Command::new(cargo_program());
    cargo.args(args).current_dir(clone).env("CULLET_BARE", "1");
    for name in ["CARGO_TARGET_DIR", "CULLET_DATA", "CULLET_REQUIRE_DATA", "CULLET_REQUIRE_GPU"] {
        cargo.env_remove(name);
    }
    for name in ["CULLET_REQUIRE_WEB", "CULLET_SKIPPED", "CI"] {
        cargo.env_remove(name);
    }
    cargo
}
