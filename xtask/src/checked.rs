//! The one build that all tests, examples and scripts run from: one profile, one choice of packages, one set of
//! features. Any other choice would have cargo build the engine once more.

use std::path::PathBuf;
use std::process::Command;

use crate::graphics::{self, Machine};
use crate::runner::{End, Ended, Skip, Step, all, skipped_tests};
use crate::tools::{
    Done, cargo_program, command, cpp_compiler, install_words, is_ci, output, run, target,
};

/// Optimised, with the assertions on.
pub(crate) const PROFILE: &str = "checked";
/// The scalar SIMD level beside those of the machine, whose answers must not differ: tests go through all that there
/// are, so that one build serves them all.
const FEATURES: &str = "cullet/force_support_fallback";
/// Where tests that were skipped say so.
const SKIPPED: &str = "skipped-tests.txt";

/// The viewer takes long to build, so it is built only where it can be run.
const VIEWER: &str = "cullet-viewer";
/// It has no tests, and what it is made of is for the page alone.
const BINDGEN: &str = "cullet-bindgen";

/// It has meshoptimizer compiled, which needs a C++ compiler.
const BAKER: &str = "cullet-baker";

fn excluded() -> Vec<&'static str> {
    let viewer = (!graphics::is_there()).then_some(VIEWER);
    [BINDGEN].into_iter().chain(viewer).chain(without_cpp()).collect()
}

/// The packages that cannot be built without a C++ compiler, where there is none.
pub(crate) fn without_cpp() -> Option<&'static str> {
    cpp_compiler().is_err().then_some(BAKER)
}

/// A command of cargo on that build.
fn cargo(args: &[&str]) -> Command {
    let mut cargo = command(&cargo_program(), &args[..1]);
    cargo.args(["--workspace", "--profile", PROFILE, "--features", FEATURES]);
    for package in excluded() {
        cargo.args(["--exclude", package]);
    }
    cargo.args(&args[1..]);
    cargo
}

/// The step that builds it all, apart from running it, so that its time is seen.
pub(crate) fn build() -> Ended {
    run(cargo(&["test", "--no-run"]))?;
    let mut skips = Vec::new();
    if !graphics::is_there() {
        skips.push(Skip::new("the viewer and its tests", install_words(graphics::DEBIAN)));
    }
    if without_cpp().is_some() {
        let what = "levels of detail, `cullet simplify` and their tests";
        skips.push(Skip::new(what, install_words(&["g++"])));
    }
    Ok(if skips.is_empty() { End::Passed } else { End::Partly(skips) })
}

/// The step that runs all tests, whichever fail. Where there is a graphics device, in software or not, and CI runs
/// this, those that need it must find it.
pub(crate) fn tests() -> Ended {
    let must = graphics::is_there() && is_ci();
    tested(vec![cargo(&["test", "--no-fail-fast"])], must.then_some(Machine::Vulkan))
}

/// The tests that draw or compute on a device, as each machine runs them.
pub(crate) const MACHINES: &[Step] = &[
    Step { name: "nothing", run: || tests_on(Machine::Nothing) },
    Step { name: "opengl", run: || tests_on(Machine::OpenGl) },
    Step { name: "vulkan", run: || tests_on(Machine::Vulkan) },
    Step { name: "both", run: || tests_on(Machine::Both) },
];

/// Runs the tests and examples that use a graphics device as a machine would that has less than this one.
pub(crate) fn tests_on(machine: Machine) -> Ended {
    let of_passes = ["--lib", "--test", "all", "--", "gpu_", "checked::tests"];
    let mut programs = vec!["--test", "profile"];
    if !excluded().contains(&VIEWER) {
        programs.extend(["--test", "draw", "--test", "fading", "--test", "window"]);
    }
    let test = |more: &[&str]| cargo(&[&["test", "--no-fail-fast"], more].concat());
    let mut commands = vec![test(&of_passes), test(&programs)];
    let folder = program("examples")?;
    let example = |name| command(&folder.join(name).to_string_lossy(), &[]);
    commands.extend(["own_program", "lists"].map(example));
    tested(commands, Some(machine))
}

/// Runs all of some commands, whichever fail, and tells what their tests skipped.
fn tested(commands: Vec<Command>, machine: Option<Machine>) -> Ended {
    let skipped = target().join(SKIPPED);
    let fail = |e: std::io::Error| format!("{}: {e}", skipped.display());
    std::fs::create_dir_all(target()).map_err(fail)?;
    // There already, so that none is no error; empty, so that the last run's are not told again.
    std::fs::write(&skipped, "").map_err(fail)?;
    let mut all = Ok(());
    for mut test in commands {
        test.env("CULLET_SKIPPED", &skipped);
        test.envs(machine.into_iter().flat_map(Machine::environment));
        all = all.and(run(test));
    }
    let skips = skipped_tests(&std::fs::read_to_string(&skipped).map_err(fail)?);
    Ok(match all {
        Err(why) => End::Failed(why, skips),
        Ok(()) if skips.is_empty() => End::Passed,
        Ok(()) => End::Partly(skips),
    })
}

/// A program of that build, made where it is not there yet. Examples are built along, for what their dependencies
/// ask for is part of the set of features.
pub(crate) fn program(name: &str) -> Result<PathBuf, String> {
    run(cargo(&["build", "--quiet", "--bins", "--examples"]))?;
    Ok(target().join(PROFILE).join(name))
}

/// Examples that measure what they are given: the first is run by the step `host-c`, the second beside `bench/border.py`.
const WITH_ARGUMENTS: &[&str] = &["border", "python_border"];

/// The step that runs every example, of every package, to its end.
pub(crate) fn examples() -> Ended {
    all(run_examples())
}

fn run_examples() -> Done {
    let metadata = output(&cargo_program(), &["metadata", "--no-deps", "--format-version", "1"])
        .ok_or("cargo metadata cannot be run")?;
    let metadata: serde_json::Value =
        serde_json::from_str(&metadata).map_err(|e| format!("cargo metadata: {e}"))?;
    let folder = program("examples")?;
    for package in metadata["packages"].as_array().into_iter().flatten() {
        if excluded().iter().any(|e| package["name"] == *e) {
            continue;
        }
        for target in package["targets"].as_array().into_iter().flatten() {
            let is_example =
                target["kind"].as_array().is_some_and(|k| k.iter().any(|k| k == "example"));
            if let (Some(name), true) = (target["name"].as_str(), is_example)
                && !WITH_ARGUMENTS.contains(&name)
            {
                run(command(&folder.join(name).to_string_lossy(), &[]))?;
            }
        }
    }
    Ok(())
}
