//! `cullet reproduce`: the figures of published work, measured again and put beside the published ones.

mod assarsson_moller;
mod chart;
mod johannsen_carter;
mod model;
mod zhang_hoff;

use std::path::PathBuf;

use clap::{Args, Subcommand};

use crate::console::Console;
use crate::exit::Outcome;

/// `cullet reproduce`
#[derive(Debug, Args)]
pub(crate) struct ReproduceArgs {
    /// Which work.
    #[command(subcommand)]
    which: Which,
}

/// What can be reproduced.
#[derive(Debug, Subcommand)]
enum Which {
    /// Optimized View Frustum Culling Algorithms for Bounding Boxes (2000): the gain of each trick
    #[command(after_help = assarsson_moller::HELP)]
    AssarssonMoller(assarsson_moller::AssarssonMollerArgs),
    /// Fast Backface Culling Using Normal Masks (1997): Table 1 and Graph 1
    #[command(after_help = zhang_hoff::HELP)]
    ZhangHoff(zhang_hoff::ZhangHoffArgs),
    /// Clustered Backface Culling (1998): the bounds of clusters beside the ideal, and hierarchies
    #[command(after_help = johannsen_carter::HELP)]
    JohannsenCarter(johannsen_carter::JohannsenCarterArgs),
}

impl ReproduceArgs {
    /// Where JSON is asked for.
    pub(crate) fn json(&self) -> &Option<PathBuf> {
        match &self.which {
            Which::AssarssonMoller(args) => &args.json,
            Which::ZhangHoff(args) => &args.json,
            Which::JohannsenCarter(args) => &args.json,
        }
    }
}

/// Runs the command.
pub(crate) fn run(args: &ReproduceArgs, console: &Console) -> Outcome {
    match &args.which {
        Which::AssarssonMoller(args) => assarsson_moller::run(args, console),
        Which::ZhangHoff(args) => zhang_hoff::run(args, console),
        Which::JohannsenCarter(args) => johannsen_carter::run(args, console),
    }
}
