//! The program `cullet-baker`: the commands that write files. `cullet` starts it.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use cullet_command::{bakery, program};

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

/// The commands of this program, and those of `cullet` for what they need of it.
#[derive(Debug, Subcommand)]
enum Command {
    #[command(flatten)]
    Own(cullet_baker::Command),
    #[command(flatten)]
    Shared(cullet_cli::Command),
}

fn main() -> ExitCode {
    let mut cli = Cli::parse();
    bakery::provide(cullet_baker::bakery());
    if let Command::Shared(command) = &mut cli.command {
        command.settle();
    }
    program::run("cullet-baker", || match &cli.command {
        Command::Own(command) => command.run(cli.quiet),
        Command::Shared(command) => command.run(cli.quiet),
    })
    .into()
}
