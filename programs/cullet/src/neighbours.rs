//! Programs beside `cullet`, and the commands that each has: `cullet X` starts the one that has X.

use std::ffi::{OsStr, OsString};

use cullet_command::exit::Outcome;
use cullet_command::peer::Peer;

/// A command of another program.
#[derive(Debug)]
pub struct Elsewhere {
    /// Its name.
    pub name: &'static str,
    /// Sentence that says what it does.
    pub about: &'static str,
    /// The program that has it.
    pub program: &'static Peer,
}

/// The program that writes files: levels of detail, occluders, cells, visible sets, tiles, cuts.
pub const BAKER: Peer = Peer {
    name: "cullet-baker",
    what: "the baker",
    example: "simplify city --error 0.001",
    needs: "some minutes",
    has_commands: true,
    build: &["--package", "cullet-baker"],
};

/// The program that measures and teaches.
pub const LAB: Peer = Peer {
    name: "cullet-lab",
    what: "the lab",
    example: "bench",
    needs: "a C++ compiler and some minutes",
    has_commands: true,
    build: &["--package", "cullet-lab"],
};

/// The program that draws on a graphics device and times that.
pub const PROFILER: Peer = Peer {
    name: "cullet-profile",
    what: "the profiler",
    example: "profile city",
    needs: "some minutes",
    has_commands: true,
    build: &["--package", "cullet-profile"],
};

/// The viewer in a window.
pub const VIEWER: Peer = Peer {
    name: "cullet-viewer",
    what: "the viewer",
    example: "city",
    needs: "some minutes",
    has_commands: false,
    build: &["--package", "cullet-viewer", "--bin", "cullet-viewer"],
};

/// The server of the viewer's page.
pub const SERVER: Peer = Peer {
    name: "cullet-serve",
    what: "the server",
    example: "city",
    needs: "some minutes",
    has_commands: false,
    build: &[
        "--package",
        "cullet-viewer",
        "--bin",
        "cullet-serve",
        "--no-default-features",
        "--features",
        "serve",
    ],
};

macro_rules! commands {
    ($($program:ident: $($name:literal $about:literal),+;)+) => {
        &[$($(Elsewhere { name: $name, about: $about, program: &$program }),+),+]
    };
}

/// The commands of other programs, in the order of the help.
pub const ELSEWHERE: &[Elsewhere] = commands! {
    VIEWER:
        "view" "Show a scene in a window: what is culled, and why";
    SERVER:
        "serve" "Serve the viewer's page, and a scene for it, on this machine";
    PROFILER:
        "profile" "Name the slowest link of a frame, and the culling that relieves it";
    BAKER:
        "bake" "Write a GLB with levels of detail of every mesh, made and measured beforehand",
        "simplify" "Write a scene of few triangles that deviates by no more than is said, as measured",
        "occluders" "Bake occluders for each mesh: boxes inside of it and polygons in its surface",
        "cells" "Count the cells and portals of a scene, and write it with them",
        "pvs" "Bake which cells of a map or view cells of a scene see what",
        "tiles" "Write a scene as 3D Tiles, for worlds that are loaded piece by piece",
        "cut" "Cut a scene open at planes or a box, with caps";
    LAB:
        "bench" "Measure the tests and the hierarchy against this machine's streaming rate and each other",
        "calibrate" "Measure what tests and triangles cost here, so that reports speak of milliseconds",
        "reproduce" "Measure the figures of a published work again, beside the published ones",
        "check-occlusion" "Hold every pixel that the occlusion buffer claims against samples",
        "replay" "Play a recording of occlusion culling again: are its answers the same?",
        "occscn" "Write a scene as triangles, boxes and views for comparing occlusion cullers",
        "lecture" "Three lectures and a paper, item by item: each claim, measured here",
        "quiz" "The exercises of the book: is an answer right?",
        "film" "Write a short clip of culling at work: frozen, through portals, around a model, moving away",
        "fly" "Fly through a world larger than memory: what that takes",
        "fetch" "Fetch a model that everybody knows: bunny, armadillo, teapot, on its maker's terms";
};

/// The kinds of `cullet picture` that the lab draws: diagrams that teach, and what is made for
/// them.
pub const LAB_PICTURES: &[&str] = &[
    "impostor",
    "coverage",
    "pvs-matrix",
    "normal-mask",
    "normal-partition",
    "conservative-set",
    "culling-volume",
    "clusters",
    "cones",
    "back-regions",
    "outcodes",
    "clip-polygon",
    "clip-w",
    "pipeline",
];

/// The command of another program, by its name.
#[must_use]
pub fn elsewhere(name: &str) -> Option<&'static Elsewhere> {
    ELSEWHERE.iter().find(|command| command.name == name)
}

/// Hands the command line of a command of another program on to that; `rest` follows its name.
///
/// # Errors
/// If the program can be neither found nor built.
pub fn hand_on(command: &Elsewhere, rest: &[OsString], quiet: bool) -> Outcome {
    let is = |word: &str| rest.iter().any(|arg| arg == OsStr::new(word));
    let program = match command.name {
        "occluders" if is("--compare") => &LAB,
        _ => command.program,
    };
    program.run_command(command.name, rest, quiet)
}
