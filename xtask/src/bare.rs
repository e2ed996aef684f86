//! The README's two commands as a stranger meets them: a fresh clone in an empty folder, no data beside it, nothing
//! installed but Rust and compilers of C and C++. What CI runs begins with them, and goes on in that clone.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use crate::tools::{Done, cargo_program, command, root, run};

/// Seconds in which the page should be there, on two cores that do nothing else.
const REPORT_GOAL: f64 = 90.0;
/// Seconds in which the second command should end there.
const TEST_GOAL: f64 = 900.0;
/// How often random cases are tried by CI in the part that has them tried in full as well, in percent.
const FEWER_CASES: &str = "20";

/// Clones what is committed, and runs both commands in the clone.
pub(crate) fn try_out() -> Done {
    let clone = Clone::make()?;
    first(&clone.0)?;
    second(&clone.0, &[])
}

/// All that CI runs. Both commands in a clone, then there everything with nothing left out: what a stranger has to build is
/// built once, from nothing, and the rest beside it.
pub(crate) fn then_all() -> Done {
    let clone = Clone::make()?;
    let bare = first(&clone.0).and_then(|()| second(&clone.0, &[("CULLET_CASES", FEWER_CASES)]));
    println!("\n════ everything, with nothing left out ════");
    let mut all = Command::new(cargo_program());
    all.args(["xtask", "test"]).current_dir(&clone.0).env_remove("CARGO_TARGET_DIR");
    // The test data lies beside the checkout; without it tests would be skipped, and here they must not.
    let set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    if !set("CULLET_DATA") {
        all.env("CULLET_DATA", root().join("../shared/data"));
    }
    if !set("CULLET_REQUIRE_DATA") {
        all.env("CULLET_REQUIRE_DATA", "1");
    }
    all.env("CI", "true");
    let all = run(all);
    match (bare, all) {
        (Ok(()), Ok(())) => Ok(()),
        (Err(why), Ok(())) => Err(format!("the README's commands: {why}")),
        (Ok(()), Err(why)) => Err(why),
        (Err(why), Err(also)) => Err(format!("the README's commands: {why}\n{also}")),
    }
}

/// A folder with what is committed, gone once it is dropped.
struct Clone(PathBuf);

impl Clone {
    fn make() -> Result<Self, String> {
        let folder = std::env::temp_dir().join(format!("cullet-bare-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        let clone = Self(folder.join("cullet"));
        let (from, to) = (root(), clone.0.to_string_lossy().into_owned());
        let words = ["clone", "--quiet", "--no-hardlinks", &from.to_string_lossy(), &to];
        run(command("git", &words))?;
        Ok(clone)
    }
}

impl Drop for Clone {
    fn drop(&mut self) {
        if let Some(folder) = self.0.parent() {
            let _ = std::fs::remove_dir_all(folder);
        }
    }
}

/// The first command: the page is there.
fn first(clone: &Path) -> Done {
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
    Ok(())
}

/// The second: the tests pass.
fn second(clone: &Path, variables: &[(&str, &str)]) -> Done {
    let start = Instant::now();
    let mut test = there(clone, &["xtask", "test"]);
    test.envs(variables.iter().copied());
    let tested = run(test);
    let took = start.elapsed().as_secs_f64();
    let end = if tested.is_ok() { "passed" } else { "failed" };
    println!("\nsecond command: {end} after {took:.0} s (goal {TEST_GOAL} s)");
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
