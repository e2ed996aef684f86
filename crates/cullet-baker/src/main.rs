//! The program `cullet-baker`; `cullet bake`, `cullet simplify` and `cullet bench lod` start it.
#![forbid(unsafe_code)]

mod bake;
mod bench;
mod simplify;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use cullet_command::args::{
    BAKE_HELP, BakeArgs, LOD_BENCH_HELP, LodBenchArgs, SIMPLIFY_HELP, SimplifyArgs,
};
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
    /// Measure what is made
    #[command(subcommand)]
    Bench(BenchOf),
}

#[derive(Debug, Subcommand)]
enum BenchOf {
    /// Levels of detail beside those of errors that are believed
    #[command(after_help = LOD_BENCH_HELP)]
    Lod(LodBenchArgs),
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    program::run("cullet-baker", || match &cli.command {
        Command::Bake(args) => bake::run(args, &Console::new(cli.quiet, args.json.as_deref())),
        Command::Simplify(args) => {
            simplify::run(args, &Console::new(cli.quiet, args.json.as_deref()))
        }
        Command::Bench(BenchOf::Lod(args)) => {
            bench::run(args, &Console::new(cli.quiet, args.json.as_deref()))
        }
    })
}
