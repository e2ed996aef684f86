//! The steps of `test`, in order: what fails fastest comes first.

use std::process::Command;

use crate::bindings;
use crate::book;
use crate::checked;
use crate::compiler::{Compiler, words};
use crate::graphics;
use crate::readers;
use crate::release;
use crate::rooms;
use crate::runner::{self, End, Ended, Skip, Step, all};
use crate::tools::{
    Done, apart, cargo, cargo_install, cargo_install_words, cargo_program, command, is_ci,
    optional, root, run, target,
};
use crate::web;

const STEPS: &[Step] = &[
    Step { name: "format", run: || all(cargo(&["fmt", "--all", "--check"])) },
    Step { name: "rooms", run: rooms::check },
    Step { name: "book", run: book::test },
    Step { name: "licences", run: licences },
    Step { name: "neon", run: neon },
    Step { name: "packages", run: release::packages },
    Step { name: "oldest", run: release::oldest_compiler },
    Step { name: "features", run: features },
    Step { name: "graphics", run: graphics::prepare },
    Step { name: "lints", run: lints },
    Step { name: "docs", run: docs },
    Step { name: "build", run: checked::build },
    Step { name: "tests", run: checked::tests },
    Step { name: "examples", run: checked::examples },
    Step { name: "readers", run: readers::test },
    Step { name: "web", run: web::test },
    Step { name: "published", run: book::published },
    Step { name: "lists", run: web::lists },
];

/// Runs the steps whose name contains `filter`.
pub(crate) fn test(filter: &str) -> Done {
    runner::run(&[STEPS, bindings::STEPS].concat(), filter)
}

/// All of the workspace, what cannot be run here too: checking is cheap, and shares its dependencies with `docs` and
/// `features`, since all three are of one profile.
fn lints() -> Ended {
    let mut clippy = command(&cargo_program(), &["clippy", "--workspace", "--all-targets"]);
    clippy.args(["--profile", checked::PROFILE]);
    exclude(&mut clippy);
    clippy.args(["--", "-Dwarnings"]);
    all(run(clippy))
}

fn docs() -> Ended {
    let words = ["doc", "--workspace", "--no-deps", "--profile", checked::PROFILE];
    let mut doc = command(&cargo_program(), &words);
    exclude(&mut doc);
    doc.env("RUSTDOCFLAGS", "-Dwarnings");
    all(run(doc))
}

/// Leaves out what would have to be compiled by what is not there.
fn exclude(command: &mut Command) {
    if let Some(package) = checked::without_cpp() {
        command.args(["--exclude", package]);
    }
}

/// Each library alone, with no more features than it declares, and each of its features: the workspace may lend it some.
fn features() -> Ended {
    let check = |more: &[&str]| {
        cargo(&[&["check", "--profile", checked::PROFILE, "--package"], more].concat())
    };
    for package in ["cullet", "cullet-methods", "cullet-io", "cullet-draw", "cullet-cut"] {
        check(&[package])?;
    }
    check(&["cullet-cut", "--no-default-features"])?;
    for feature in ["serde", "mint", "rayon"] {
        check(&["cullet", "--features", feature])?;
    }
    Ok(End::Passed)
}

/// The NEON code is compiled, never run: no machine of ours has it.
fn neon() -> Ended {
    const TARGET: &str = "aarch64-unknown-linux-gnu";
    let Some(compiler) = Compiler::find(TARGET)? else {
        return Ok(End::Skipped(Skip::new("the NEON code, compiled", words(TARGET))));
    };
    let check = ["check", "--package", "cullet"];
    all(run(compiler.cargo(&check, TARGET, &apart("neon"))))
}

/// Whether a program is there, once CI has installed it where it was not: an error where that fails.
pub(crate) fn has_program(program: &str, options: &[&str]) -> Result<bool, String> {
    let is_there = || optional(program, &["--version"]).is_some();
    if !is_there() && is_ci() {
        cargo_install(program, options)?;
        if !is_there() {
            return Err(format!("{program} was installed, but cannot be run"));
        }
    }
    Ok(is_there())
}

fn licences() -> Ended {
    const PACKAGE: &str = "cargo-deny";
    if !has_program(PACKAGE, &[])? {
        let skip = Skip::new("licences and sources of dependencies", cargo_install_words(PACKAGE));
        return Ok(End::Skipped(skip));
    }
    // It looks at what is built on any system, more than a build here has fetched.
    cargo(&["fetch", "--locked"])?;
    all(run(command(PACKAGE, &["--offline", "check", "licenses", "bans", "sources"])))
}

/// `cullet bench`, and the benches for developers.
pub(crate) fn bench() -> Done {
    cargo(&["run", "--release", "--", "bench"])?;
    cargo(&["bench", "--workspace", "--benches"])
}

/// Culling on the graphics device.
pub(crate) fn bench_gpu() -> Done {
    cargo(&["bench", "-p", "cullet-gpu", "--bench", "device"])
}

/// The normal masks' table and graph on the graphics device, into a folder.
pub(crate) fn bench_gpu_masks(folder: Option<&str>) -> Done {
    // The bench runs in the folder of its crate.
    let out = match folder {
        Some(folder) => std::env::current_dir().map_err(|e| e.to_string())?.join(folder),
        None => target().join("bench-gpu"),
    };
    let out = out.to_string_lossy().into_owned();
    cargo(&["bench", "-p", "cullet-gpu", "--bench", "masks", "--", "--out", &out])?;
    println!("written to {out}");
    Ok(())
}

/// The cuts of `cullet bench`, and of trimesh and VTK beside them.
pub(crate) fn peers_cut() -> Done {
    cargo(&["build", "--release"])?;
    let script = root().join("benches/peers/cut_python.py");
    let program = target().join("release/cullet");
    run(command("python3", &[&script.to_string_lossy(), &program.to_string_lossy()]))
}
