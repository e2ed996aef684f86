//! The program `cullet`: reports what a scene draws for nothing.
#![forbid(unsafe_code)]

mod args;
mod backfaces;
mod baked;
mod bounds;
mod cells;
mod check_occlusion;
mod cut;
mod cutting;
mod explain;
mod fetch;
mod film;
mod fly;
mod info;
mod lecture;
mod levels;
mod meshes;
mod names;
mod occluders;
mod occscn;
mod opening;
mod peer;
mod picture;
mod pvs;
mod pvs_scene;
mod quiz;
mod record;
mod recording;
mod replay;
mod report;
mod scenes;
mod serve;
mod shape;
mod standpoint;
mod survey;
mod tiles;
mod verify;
mod view;

use std::path::Path;
use std::process::ExitCode;

use clap::Parser;
use cullet_command::console::Console;
use cullet_command::exit::Outcome;
use cullet_command::program;
use cullet_measure::{bench, calibrate, reproduce};

use args::{Cli, Command};

fn main() -> ExitCode {
    // Wrong command lines end here with code 2, --help and --version with 0.
    let mut cli = Cli::parse();
    cli.settle();
    program::run("cullet", || run(&cli))
}

fn run(cli: &Cli) -> Outcome {
    let console = |json: Option<&Path>| Console::new(cli.quiet, json);
    match &cli.command {
        Command::Report(args) => report::run(args, &console(args.json.as_deref())),
        Command::Verify(args) => verify::run(args, &console(args.json.as_deref())),
        Command::CheckOcclusion(args) => check_occlusion::run(args, &console(args.json.as_deref())),
        Command::Replay(args) => replay::run(args, &console(args.json.as_deref())),
        Command::Info(args) => info::run(args, &console(args.json.as_deref())),
        Command::Scenes(args) => scenes::run(args, &console(args.json.as_deref())),
        Command::Bench(args) if args.is_of_levels() => peer::BAKER.hand_on("bench", cli.quiet),
        Command::Bench(args) => bench::run(args, &levels::load_with, &console(args.json())),
        Command::Reproduce(args) => reproduce::run(args, &levels::load_with, &console(args.json())),
        Command::Calibrate(args) => calibrate::run(args, &console(args.json())),
        Command::Cut(args) => cut::run(args, &console(args.json.as_deref())),
        Command::Bake(_) => peer::BAKER.hand_on("bake", cli.quiet),
        Command::Simplify(_) => peer::BAKER.hand_on("simplify", cli.quiet),
        Command::Occluders(args) => occluders::run(args, &console(args.json.as_deref())),
        Command::Occscn(args) => occscn::run(args, &console(None)),
        Command::View(args) => view::run(args),
        Command::Serve(args) => serve::run(args),
        Command::Cells(args) => cells::run(args, &console(args.json.as_deref())),
        Command::Pvs(args) => pvs::run(args, &console(args.json.as_deref())),
        Command::Explain(args) => explain::run(args, &console(args.json.as_deref())),
        Command::Fetch(args) => fetch::run(args, &console(None)),
        Command::Film(args) => film::run(args, &console(None)),
        Command::Fly(args) => fly::run(args, &console(args.json.as_deref())),
        Command::Tiles(args) => tiles::run(args, &console(args.json.as_deref())),
        Command::Lecture(args) => lecture::run(args, &console(args.json.as_deref())),
        Command::Quiz(args) => quiz::run(args, &console(None)),
        Command::Profile(_) => peer::PROFILER.hand_on("profile", cli.quiet),
        Command::Picture(args) => picture::run(args, &console(None)),
    }
}
