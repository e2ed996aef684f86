//! Steps of CI: the README's two commands as a stranger meets them, in a fresh checkout with a
//! fresh target folder, no data beside it, nothing installed but Rust and compilers of C and C++;
//! then in the same checkout everything else.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use crate::ahead;
use crate::changed;
use crate::plain;
use crate::runner;
use crate::steps;
use crate::tools::{Done, cache, cargo_program, command, data, output, root, run};

/// Seconds in which the page should be there, on two cores that do nothing else.
const REPORT_GOAL: f64 = 90.0;
/// Seconds in which the second command should end there.
const TEST_GOAL: f64 = 360.0;
/// How the cache is laid out: one of another layout is emptied.
const LAYOUT: &str = "2";

/// Both commands in a clone of what is committed, which then goes.
pub(crate) fn bare() -> Done {
    let folder = std::env::temp_dir().join(format!("cullet-bare-{}", std::process::id()));
    let clone = folder.join("cullet");
    let done = check_out(&clone).and_then(|()| first(&clone)).and_then(|()| second(&clone));
    let _ = fs::remove_dir_all(&folder);
    done
}

/// All of it. The clone is kept for the next run, so that what has not changed keeps its time and
/// is not built again; only what the README's commands build is built each time.
pub(crate) fn all() -> Done {
    let cache = cache();
    lay_out(&cache)?;
    let clone = cache.join("clone/cullet");
    check_out(&clone)?;
    let bare = first(&clone).and_then(|()| second(&clone));
    println!("\n════ the rest ════");
    let own = std::env::current_exe().map_err(|e| format!("this program: {e}"))?;
    let mut rest = Command::new(own);
    // It takes the folder of its checkout from there.
    rest.arg("rest").current_dir(&clone).env("CARGO_MANIFEST_DIR", clone.join("xtask"));
    rest.env_remove("CARGO_TARGET_DIR").env("CI", "true");
    // The test data lies beside this checkout, not beside the clone; without it tests would be
    // skipped, and here they must not.
    rest.envs(data().map(|folder| ("CULLET_DATA", folder)));
    if std::env::var_os("CULLET_REQUIRE_DATA").is_none() {
        rest.env("CULLET_REQUIRE_DATA", "1");
    }
    let rest = run(rest);
    let bare = bare.map_err(|why| format!("the README's commands: {why}"));
    match (bare, rest) {
        (Err(why), Err(also)) => Err(format!("{why}\n{also}")),
        (bare, rest) => bare.and(rest),
    }
}

/// Runs what `test` has beyond the README's second command, which ran just now.
pub(crate) fn rest() -> Done {
    let but_plain: Vec<_> = steps::all().into_iter().filter(|step| step.name != "plain").collect();
    let ahead = ahead::begin();
    let done = runner::run_by(&but_plain, "", changed::run);
    // It has nothing left to do, for the steps waited for it.
    if let Some(mut ahead) = ahead {
        let _ = ahead.wait();
    }
    done
}

/// Empties a cache of another layout, but for tools and the folder that this program runs from, and
/// says so.
fn lay_out(cache: &Path) -> Done {
    let fail = |e: std::io::Error| {
        format!("{}: {e}; CULLET_CACHE names a folder that can be written", cache.display())
    };
    fs::create_dir_all(cache.join("target")).map_err(fail)?;
    let stamp = cache.join("layout");
    if fs::read_to_string(&stamp).is_ok_and(|layout| layout == LAYOUT) {
        return Ok(());
    }
    let kept = fs::read_dir(cache.join("target")).map_err(fail)?.flatten().map(|e| e.path());
    let mut old: Vec<PathBuf> =
        kept.filter(|path| path.is_dir() && !path.ends_with("xtask")).collect();
    old.extend(["clone", "passed"].map(|name| cache.join(name)).into_iter().filter(|p| p.exists()));
    if !old.is_empty() {
        println!(
            "{}: a cache of another layout; what was built there is thrown away",
            cache.display()
        );
    }
    old.iter().try_for_each(fs::remove_dir_all).map_err(fail)?;
    fs::write(stamp, LAYOUT).map_err(fail)
}

/// Puts what is committed into a folder, and nothing else. What is there already is brought up to
/// date, so that files that are the same keep their time; where that fails it is made anew.
fn check_out(clone: &Path) -> Done {
    let at = clone.to_string_lossy().into_owned();
    let from = root().to_string_lossy().into_owned();
    let git = |words: &[&str]| output("git", &[&["-C", &at], words].concat()).is_some();
    if clone.exists() {
        let is_new = git(&["fetch", "--quiet", &from, "HEAD"])
            && git(&["reset", "--quiet", "--hard", "FETCH_HEAD"])
            && git(&["clean", "-ffdxq"]);
        if is_new {
            return Ok(());
        }
        println!("{at}: this clone cannot be brought up to date; it is made anew");
        fs::remove_dir_all(clone).map_err(|e| format!("{at}: {e}; remove it"))?;
    }
    run(command("git", &["clone", "--quiet", "--no-hardlinks", &from, &at]))
}

/// The first command: the page is there.
fn first(clone: &Path) -> Done {
    let start = Instant::now();
    run(there(clone, &["run", "--release", "--", "report"]))?;
    let reported = start.elapsed().as_secs_f64();
    for file in ["index.html", "report.json", "views.csv"] {
        let path = clone.join("report").join(file);
        let size = fs::metadata(&path).map_err(|e| format!("{}: {e}", path.display()))?.len();
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
fn second(clone: &Path) -> Done {
    let start = Instant::now();
    let tested = run(there(clone, &plain::TEST));
    let took = start.elapsed().as_secs_f64();
    let end = if tested.is_ok() { "passed" } else { "failed" };
    println!("\nsecond command: {end} after {took:.0} s (goal {TEST_GOAL} s on two idle cores)");
    tested
}

/// A command of cargo in the clone, with nothing of what this run was told or is kept for it.
fn there(clone: &Path, args: &[&str]) -> Command {
    let mut cargo = Command::new(cargo_program());
    cargo.args(args).current_dir(clone);
    let told = std::env::vars_os().map(|(name, _)| name);
    let ours =
        |name: &str| name.starts_with("CULLET_") || ["CARGO_TARGET_DIR", "CI"].contains(&name);
    for name in told.filter(|name| name.to_str().is_some_and(ours)) {
        cargo.env_remove(name);
    }
    cargo
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("cullet-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        folder
    }

    #[test]
    fn a_cache_of_another_layout_is_emptied_but_for_tools_and_this_program() {
        let cache = folder("cache");
        let parts = ["clone/cullet", "target/xtask", "target/checked", "passed", "tools/bin"];
        for (layout, kept) in [(LAYOUT, [true; 5]), ("1", [false, true, false, false, true])] {
            parts.iter().for_each(|part| fs::create_dir_all(cache.join(part)).unwrap());
            fs::write(cache.join("layout"), layout).unwrap();
            lay_out(&cache).unwrap();
            assert_eq!(parts.map(|part| cache.join(part).exists()), kept, "layout {layout}");
        }
        assert_eq!(fs::read_to_string(cache.join("layout")).unwrap(), LAYOUT);
        fs::write(cache.join("file"), "").unwrap();
        let why = lay_out(&cache.join("file")).unwrap_err();
        assert!(why.contains("CULLET_CACHE"), "{why}");
        fs::remove_dir_all(&cache).unwrap();
    }

    #[test]
    fn a_clone_is_what_is_committed_whatever_was_there() {
        let clone = folder("clone");
        check_out(&clone).unwrap();
        let file = clone.join("README.md");
        let time = || fs::metadata(&file).unwrap().modified().unwrap();
        let (before, text) = (time(), fs::read_to_string(&file).unwrap());
        fs::write(clone.join("target"), "").unwrap();
        fs::remove_file(clone.join("Cargo.toml")).unwrap();
        check_out(&clone).unwrap();
        assert!(!clone.join("target").exists() && clone.join("Cargo.toml").exists());
        assert_eq!(time(), before, "what is the same is not written");
        // A broken one.
        fs::remove_dir_all(clone.join(".git")).unwrap();
        fs::write(&file, "other").unwrap();
        check_out(&clone).unwrap();
        assert_eq!(fs::read_to_string(&file).unwrap(), text);
        fs::remove_dir_all(&clone).unwrap();
    }
}
