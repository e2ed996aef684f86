//! The README's second command, `cargo test --release`, and what is run of the build that it makes:
//! the tests that lacked data, the examples, and programs that other steps need.

use std::collections::BTreeSet;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::runner::{End, Ended, SkippedTest, skipped_tests};
use crate::tools::{
    Done, cargo_program, command, cpp_compiler, data as data_folder, has_program, is_set, output,
    root, run, target,
};

/// Arguments of cargo in the README.
pub(crate) const TEST: [&str; 2] = ["test", "--release"];

/// Where tests say that they were skipped: `cullet_testkit::skip` knows it.
fn list() -> PathBuf {
    root().join("target/skipped-tests.txt")
}

/// The step: all tests of the libraries and programs that need Rust, C and C++ alone.
pub(crate) fn test() -> Ended {
    cpp_compiler()?;
    // Where nothing is skipped, nobody writes it.
    let _ = fs::remove_file(list());
    let mut test = command(&cargo_program(), &TEST);
    test.arg("--no-fail-fast").env_remove("CULLET_SKIPPED").envs(all_cases());
    run(test).map(|()| End::Passed)
}

/// The step: of those tests the ones that were skipped for want of data, where it is. What was
/// skipped for other reasons is told.
pub(crate) fn data() -> Ended {
    let skipped = skipped_tests(&fs::read_to_string(list()).unwrap_or_default());
    let (lack, other): (Vec<_>, Vec<_>) = skipped.into_iter().partition(SkippedTest::lacks_data);
    if lack.is_empty() {
        return Ok(End::of(other));
    }
    let Some(data) = data_folder() else {
        if is_set("CULLET_REQUIRE_DATA", "1") {
            return Err("there is no test data, and CULLET_REQUIRE_DATA=1".to_owned());
        }
        return Ok(End::of(lack.into_iter().chain(other)));
    };
    let mut again = tester("--cargo-profile", "release")?;
    again.args(["--bins", "--tests", "--no-fail-fast", "--", "--exact"]);
    again.args(lack.iter().map(SkippedTest::path)).env("CULLET_DATA", data);
    tested(vec![again]).map(|(ended, skips)| End::from(ended, other.into_iter().chain(skips)))
}

/// All cases of properties, which are tried a quarter as often where nothing is said.
fn all_cases() -> Option<(&'static str, &'static str)> {
    std::env::var_os("CULLET_CASES").is_none().then_some(("CULLET_CASES", "100"))
}

/// A command that runs tests: cargo-nextest's where it is there, for that says which are slow, else
/// cargo's. In a profile of cargo's.
pub(crate) fn tester(profile: &str, name: &str) -> Result<Command, String> {
    let nextest = has_nextest()?;
    let words: &[&str] = if nextest { &["nextest", "run"] } else { &["test"] };
    let profile = if nextest { profile } else { "--profile" };
    Ok(command(&cargo_program(), &[words, &[profile, name]].concat()))
}

/// Whether cargo-nextest is there; CI installs it.
pub(crate) fn has_nextest() -> Result<bool, String> {
    has_program("cargo-nextest", &[])
}

/// Runs all of some commands, whichever fail, and returns which tests were skipped.
pub(crate) fn tested(commands: Vec<Command>) -> Result<(Done, Vec<SkippedTest>), String> {
    let list = target().join("skipped-tests-again.txt");
    let fail = |e: std::io::Error| format!("{}: {e}", list.display());
    fs::create_dir_all(target()).map_err(fail)?;
    let (mut all, mut skips) = (Ok(()), Vec::new());
    for mut test in commands {
        fs::write(&list, "").map_err(fail)?;
        test.env("CULLET_SKIPPED", &list).envs(all_cases());
        all = all.and(run(test));
        skips.extend(skipped_tests(&fs::read_to_string(&list).map_err(fail)?));
    }
    Ok((all, skips))
}

/// A program, or `examples`, of that build, made where it is not there yet.
pub(crate) fn program(name: &str) -> Result<PathBuf, String> {
    let mut build = command(&cargo_program(), &TEST);
    build.args(["--no-run", "--quiet"]);
    run(build)?;
    Ok(target().join("release").join(name))
}

/// Examples that are not run alone: some measure what they are given (the first is run by the step
/// `host-c`, the second beside `bench/border.py`), and some are run as each machine.
const NOT_ALONE: &[&str] = &["border", "python_border", "own_program", "lists"];

/// Runs the examples of packages that `is_chosen` to their end, from a folder.
pub(crate) fn run_examples(folder: &Path, is_chosen: impl Fn(&str) -> bool) -> Done {
    let words = ["metadata", "--no-deps", "--format-version", "1"];
    let metadata = output(&cargo_program(), &words).ok_or("cargo metadata cannot be run")?;
    let metadata: serde_json::Value =
        serde_json::from_str(&metadata).map_err(|e| format!("cargo metadata: {e}"))?;
    for package in metadata["packages"].as_array().into_iter().flatten() {
        let targets = package["targets"].as_array().into_iter().flatten();
        for target in targets.filter(|_| package["name"].as_str().is_some_and(&is_chosen)) {
            let is_example = target["kind"][0] == "example" && target["crate_types"][0] == "bin";
            match target["name"].as_str() {
                Some(name) if is_example && !NOT_ALONE.contains(&name) => {
                    run(command(&folder.join(name).to_string_lossy(), &[]))?;
                }
                _ => {}
            }
        }
    }
    Ok(())
}

/// `cargo xtask slow`: which tests take longer than `.config/nextest.toml` lets them, without a
/// reason there.
pub(crate) fn slow() -> Done {
    if !has_program("cargo-nextest", &[])? {
        return Err("needed: cargo install --locked cargo-nextest".to_owned());
    }
    let words = ["nextest", "run", "--release", "--no-fail-fast", "--color", "never"];
    let mut nextest = command(&cargo_program(), &words);
    nextest.args(["--status-level", "slow", "--final-status-level", "none"]);
    println!("$ cargo {}", words.join(" "));
    let fail = |e: std::io::Error| format!("cargo nextest: {e}");
    let mut running = nextest.stderr(Stdio::piped()).spawn().map_err(fail)?;
    let mut said = String::new();
    for line in running.stderr.take().into_iter().flat_map(|err| BufReader::new(err).lines()) {
        let line = line.map_err(fail)?;
        println!("{line}");
        said += &(line + "\n");
    }
    let status = running.wait().map_err(fail)?;
    let slow = slow_tests(&said);
    match (slow.is_empty(), status.success()) {
        (true, true) => Ok(()),
        (true, false) => Err("some tests failed".to_owned()),
        (false, _) => {
            let slow: Vec<&str> = slow.into_iter().collect();
            Err(format!(
                "slow without a reason in .config/nextest.toml: make them quicker, or say there why not\n  {}",
                slow.join("\n  ")
            ))
        }
    }
}

/// The tests that nextest calls slow, each once: behind a time in `[]` and, in newer ones, a number
/// in `()`.
fn slow_tests(said: &str) -> BTreeSet<&str> {
    let slow = said.lines().filter_map(|line| line.trim_start().strip_prefix("SLOW ["));
    slow.filter_map(|line| Some(line.rsplit_once([']', ')'])?.1.trim())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_test_is_named_once() {
        let said = "        SLOW [> 10.000s] (───) cullet-io::all a::b\n        PASS [  0.1s] (2/3) c d\n        \
                    SLOW [> 20.000s] cullet-io::all a::b\n   SLOW [> 10.000s] x y::z\n";
        let found: Vec<&str> = slow_tests(said).into_iter().collect();
        assert_eq!(found, ["cullet-io::all a::b", "x y::z"]);
    }
}
