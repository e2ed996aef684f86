//! The steps of `test`, in order: what fails fastest comes first.

use crate::bindings;
use crate::book;
use crate::checked::{self, MACHINES};
use crate::graphics::{self, Machine};
use crate::plain;
use crate::platforms;
use crate::readers;
use crate::release;
use crate::rooms;
use crate::runner::{self, End, Ended, Skip, Step, all as all_of};
use crate::tools::{Done, cargo_install_words, cargo_program, command, has_program, run};
use crate::web;

const STEPS: &[Step] = &[
    Step { name: "format", run: || all_of(cargo("fmt", &["--all", "--check"])) },
    Step { name: "rooms", run: rooms::check },
    Step { name: "book", run: book::test },
    Step { name: "licences", run: licences },
    Step { name: "packages", run: release::packages },
    Step { name: "oldest", run: release::oldest_compiler },
    Step { name: "features", run: features },
    Step { name: "graphics", run: graphics::prepare },
    Step { name: "lints", run: lints },
    Step { name: "docs", run: docs },
    Step { name: "plain", run: plain::test },
    Step { name: "data", run: plain::data },
    Step { name: "build", run: checked::build },
    Step { name: "tests", run: checked::tests },
    Step { name: "nothing", run: || checked::tests_on(Machine::Nothing) },
    Step { name: "opengl", run: || checked::beside(Machine::OpenGl) },
    Step { name: "both", run: || checked::beside(Machine::Both) },
    Step { name: "examples", run: checked::examples },
    Step { name: "readers", run: readers::test },
    Step { name: "web", run: web::test },
    Step { name: "published", run: book::published },
    Step { name: "lists", run: web::lists },
];

/// All of them.
pub(crate) fn all() -> Vec<Step> {
    [STEPS, bindings::STEPS, &[Step { name: "platforms", run: platforms::test }]].concat()
}

/// Runs the steps whose name contains `filter`.
pub(crate) fn test(filter: &str) -> Done {
    runner::run(&all(), filter)
}

/// Runs the tests that use a graphics device as machines whose name contains `filter`.
pub(crate) fn machines(filter: &str) -> Done {
    runner::run(MACHINES, filter)
}

/// A command of cargo, with the second build beside it: checking is cheap, and its dependencies are
/// shared.
fn cargo(word: &str, args: &[&str]) -> Done {
    let mut cargo = command(&cargo_program(), &[&[word], args].concat());
    cargo.env("CARGO_TARGET_DIR", checked::folder()).env("RUSTDOCFLAGS", "-Dwarnings");
    run(cargo)
}

/// All of the workspace, what cannot be run here too.
fn lints() -> Ended {
    let words = ["--workspace", "--all-targets", "--profile", checked::PROFILE, "--", "-Dwarnings"];
    all_of(cargo("clippy", &words))
}

fn docs() -> Ended {
    all_of(cargo("doc", &["--workspace", "--no-deps", "--profile", checked::PROFILE]))
}

/// The engine, cells, the cuts and maps with no feature, then all libraries with each: the workspace may lend a
/// crate what it does not ask for.
fn features() -> Ended {
    let check =
        |words: &[&str]| cargo("check", &[&["--profile", checked::PROFILE], words].concat());
    // Apart, for the cuts need the standard library and would lend it to the cells.
    check(&["--package", "cullet-cells", "--no-default-features"])?;
    check(&["--package", "cullet", "--package", "cullet-cut", "--no-default-features"])?;
    check(&["--package", "cullet-maps", "--no-default-features"])?;
    check(&["--package", "cullet-c", "--lib", "--no-default-features"])?;
    check(&["--package", "cullet-c", "--lib", "--no-default-features", "--features", "scenes"])?;
    let published = release::published()?;
    let mut words = vec!["--lib", "--all-features"];
    words.extend(published.iter().map(String::as_str));
    all_of(check(&words))
}

fn licences() -> Ended {
    const PACKAGE: &str = "cargo-deny";
    if !has_program(PACKAGE, &[])? {
        let skip = Skip::new("licences and sources of dependencies", cargo_install_words(PACKAGE));
        return Ok(End::Skipped(skip));
    }
    // It looks at what is built on any system, more than a build here has fetched.
    cargo("fetch", &["--locked"])?;
    all_of(run(command(PACKAGE, &["--offline", "check", "licenses", "bans", "sources"])))
}
