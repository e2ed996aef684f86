//! The second build: with assertions and checks of overflow on. The engine is tested in it once
//! more, and what the README's second command leaves out.
//!
//! With `CULLET_ALL=1` the scalar SIMD level stands beside those of the machine, whose answers must
//! not differ. It is left out otherwise, for it makes the engine ten times as long to compile:
//! kernels of 16 lanes are unrolled into thousands of numbers each, `BatchSizes::decide` among
//! them, and the compiler spends minutes in the largest.

use std::path::PathBuf;
use std::process::Command;

use crate::graphics::{self, Machine};
use crate::plain::{self, run_examples, tested, tester};
use crate::runner::{End, Ended, Skip, Step, all};
use crate::tools::{apart, cargo_program, command, install_words, is_ci, is_set, run, target};

pub(crate) const PROFILE: &str = "checked";
const SCALAR: [&str; 2] =
    ["--features", "cullet/force_support_fallback,cullet-testkit/force_support_fallback"];
/// The viewer takes long to build, so it is built only where it can be run.
const VIEWER: &str = "cullet-viewer";
const PACKAGES: &[&str] = &[
    "cullet",
    "cullet-bake",
    "cullet-cells",
    "cullet-cut",
    "cullet-draw",
    "cullet-io",
    "cullet-lab",
    "cullet-maps",
    "cullet-mesh",
    "cullet-scenes",
    "cullet-testkit",
    "cullet-gpu",
    "cullet-profile",
    "cullet-c",
    "cullet-web",
    "xtask",
    VIEWER,
];

/// The libraries, whose units `cargo test` leaves out so that it need not compile them twice; the
/// engine's tests once more; and what the README's second command does not run. Examples are built
/// apart: named here they would be built as tests, and not as programs.
const TARGETS: [&str; 2] = ["--lib", "--bins"];
const TESTS: &[&str] = &["cells", "cullet*", "gpu", "header", "profile", "queries"];
const VIEWER_TESTS: &[&str] = &[
    "book",
    "camera",
    "controls",
    "drawn",
    "fading",
    "panels",
    "report",
    "serve_load",
    "session",
    "sides",
    "state",
    "tour",
    "window",
];

/// Words that name it all.
fn targets() -> Vec<&'static str> {
    let viewer: &[&str] = if graphics::is_there() { VIEWER_TESTS } else { &[] };
    let tests = TESTS.iter().chain(viewer).flat_map(|&name| ["--test", name]);
    TARGETS.into_iter().chain(tests).collect()
}

fn packages() -> impl Iterator<Item = &'static str> {
    let is_there = graphics::is_there();
    PACKAGES.iter().copied().filter(move |&package| package != VIEWER || is_there)
}

/// Where it is built; CI keeps it, while that of the README's commands is made anew.
pub(crate) fn folder() -> PathBuf {
    if is_ci() { apart(PROFILE) } else { target() }
}

/// A command on that build, of a beginning.
fn of_build(mut command: Command, args: &[&str]) -> Command {
    command.env("CARGO_TARGET_DIR", folder());
    if is_set("CULLET_ALL", "1") {
        command.args(SCALAR);
    }
    for package in packages() {
        command.args(["--package", package]);
    }
    command.args(args);
    command
}

fn cargo(word: &str, args: &[&str]) -> Command {
    of_build(command(&cargo_program(), &[word, "--profile", PROFILE]), args)
}

fn test(args: &[&str]) -> Result<Command, String> {
    let begun = tester("--cargo-profile", PROFILE)?;
    Ok(of_build(begun, &[&["--no-fail-fast"], args].concat()))
}

/// The step that builds it all, apart from running it, so that its time is seen.
pub(crate) fn build() -> Ended {
    run(cargo("test", &[&targets()[..], &["--no-run"]].concat()))?;
    run(cargo("build", &["--examples"]))?;
    if graphics::is_there() {
        return Ok(End::Passed);
    }
    let cure = install_words(graphics::DEBIAN);
    Ok(End::Partly(vec![Skip::new("the viewer and its tests", cure)]))
}

/// The step that runs all its tests, whichever fail. Where there is Vulkan, and CI runs this, those
/// that need a device must find it.
pub(crate) fn tests() -> Ended {
    let mut all = test(&targets())?;
    if graphics::is_there() && is_ci() {
        all.envs(Machine::Vulkan.environment());
    }
    // nextest has no doc tests; those of the engine are run in release.
    let docs = cargo("test", &["--doc", "--", "gpu", "profile", "viewer"]);
    tested(vec![all, docs]).map(|(ended, skips)| End::from(ended, skips))
}

/// The tests that draw or compute on a device, as each machine runs them.
pub(crate) const MACHINES: &[Step] = &[
    Step { name: "nothing", run: || tests_on(Machine::Nothing) },
    Step { name: "opengl", run: || tests_on(Machine::OpenGl) },
    Step { name: "vulkan", run: || tests_on(Machine::Vulkan) },
    Step { name: "both", run: || tests_on(Machine::Both) },
];

/// The step of a machine that has less than this one, or more backends at once, than the step
/// `tests` takes.
pub(crate) fn beside(machine: Machine) -> Ended {
    if graphics::is_there() && graphics::has_opengl() {
        return tests_on(machine);
    }
    let what = format!("tests of the graphics device as on a machine with {}", machine.words());
    Ok(End::Skipped(Skip::new(what, install_words(graphics::DEBIAN))))
}

/// Runs the tests and examples that use a graphics device as a machine would that has less than
/// this one. Of two backends the better is taken, by which all tests have run: there only what
/// chooses is run again.
pub(crate) fn tests_on(machine: Machine) -> Ended {
    let chooses = machine == Machine::Both;
    let passes = if chooses { "gpu_devices" } else { "gpu_" };
    let of_passes = ["--lib", "--test", "gpu", "--", passes, "checked::tests"];
    let mut programs = vec!["--test", "profile"];
    if packages().any(|package| package == VIEWER) {
        let drawn: &[&str] = if chooses { &[] } else { &["--test", "drawn", "--test", "fading"] };
        programs.extend([&["--test", "window"], drawn].concat());
    }
    if chooses {
        programs.extend(["--", "a_screenshot_has", "what_a_program_culls"]);
    }
    let mut commands = vec![test(&of_passes)?, test(&programs)?];
    let folder = examples_folder()?;
    let example = |name| command(&folder.join(name).to_string_lossy(), &[]);
    commands.extend(["own_program", "lists"].map(example));
    for command in &mut commands {
        command.envs(machine.environment());
    }
    tested(commands).map(|(ended, skips)| End::from(ended, skips))
}

/// The folder of that build's examples, made where they are not there yet.
pub(crate) fn examples_folder() -> Result<PathBuf, String> {
    run(cargo("build", &["--examples", "--quiet"]))?;
    Ok(folder().join(PROFILE).join("examples"))
}

/// The step that runs every example, of every package, to its end.
pub(crate) fn examples() -> Ended {
    let is_plain = |name: &str| name == "cullet" || !PACKAGES.contains(&name);
    run_examples(&plain::program("examples")?, is_plain)?;
    let is_built = |name: &str| !is_plain(name) && packages().any(|package| package == name);
    all(run_examples(&examples_folder()?, is_built))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_test_of_the_viewer_is_named() {
        let folder = crate::tools::root().join("programs/cullet-viewer/tests");
        let entries = std::fs::read_dir(&folder).expect("the viewer's tests").flatten();
        let programs = entries.filter(|e| e.path().is_file() || e.path().join("main.rs").is_file());
        let mut names: Vec<String> = programs
            .map(|e| e.path().with_extension("").file_name().unwrap().to_string_lossy().into())
            .collect();
        names.sort();
        assert_eq!(names, VIEWER_TESTS);
    }
}
