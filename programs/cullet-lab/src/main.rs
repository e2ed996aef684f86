//! The program `cullet-lab`: measures and teaches. `cullet` starts it.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use clap::Parser;
use cullet_command::{bakery, program};
use cullet_lab::Command;

/// Measures and teaches cullet
#[derive(Debug, Parser)]
#[command(name = "cullet-lab", version, arg_required_else_help = true)]
struct Cli {
    /// Print nothing but results and errors
    #[arg(long, short, global = true)]
    quiet: bool,
    /// The command to run.
    #[command(subcommand)]
    command: Command,
}

fn main() -> ExitCode {
    let mut cli = Cli::parse();
    bakery::provide(cullet_baker::bakery());
    cli.command.settle();
    program::run("cullet-lab", || cli.command.run(cli.quiet)).into()
}
