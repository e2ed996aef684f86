//! The program `cullet-baker`; `cullet bake` and `cullet simplify` start it.
#![forbid(unsafe_code)]

mod bake;
mod simplify;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use cullet_command::args::{BAKE_HELP, BakeArgs, SIMPLIFY_HELP, SimplifyArgs};
use cullet_command::console::Console;
use cullet_command::program;

/// Makes of scenes what is drawn faster
#[derive(Debug, Parser)]
#[command(name = "cullet-baker", version, arg_required_else_help = true)]
struct Cli {
    /// Print nothing but results and errors
    #[arg(long, short, global = true)]
    quiet: bool,
    /// The command to run.
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Write a GLB with levels of detail of every mesh, made and measured beforehand
    #[command(after_help = BAKE_HELP)]
    Bake(Box<BakeArgs>),
    /// Write a scene of few triangles that deviates by no more than is said, as measured
    #[command(after_help = SIMPLIFY_HELP)]
    Simplify(Box<SimplifyArgs>),
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    program::run("cullet-baker", || match &cli.command {
        Command::Bake(args) => bake::run(args, &Console::new(cli.quiet, args.json.as_deref())),
        Command::Simplify(args) => {
            simplify::run(args, &Console::new(cli.quiet, args.json.as_deref()))
        }
    })
}
