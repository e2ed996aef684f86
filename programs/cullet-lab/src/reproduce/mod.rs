//! `cullet reproduce`: the figures of published work, measured again and put beside the published
//! ones.

mod assarsson_moller;
mod chart;
mod johannsen_carter;
mod mesh_reduction;
pub mod model;
mod output;
pub mod zhang_hoff;

use std::path::Path;

use clap::{Args, Subcommand};
use cullet_command::console::Console;
use cullet_command::exit::Outcome;

/// `cullet reproduce`
#[derive(Debug, Args)]
pub struct ReproduceArgs {
    /// Work to reproduce.
    #[command(subcommand)]
    which: Which,
}

/// Papers that can be reproduced.
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
    /// The lecture's row of smaller and smaller models of fewer and fewer triangles, with how far
    /// each is off
    #[command(after_help = mesh_reduction::HELP)]
    MeshReduction(mesh_reduction::MeshReductionArgs),
}

impl ReproduceArgs {
    /// The path that JSON is to be written to.
    #[must_use]
    pub fn json(&self) -> Option<&Path> {
        match &self.which {
            Which::AssarssonMoller(args) => args.json.as_deref(),
            Which::ZhangHoff(args) => args.json.as_deref(),
            Which::JohannsenCarter(args) => args.json.as_deref(),
            Which::MeshReduction(args) => args.json.as_deref(),
        }
    }
}

/// Runs the command.
///
/// # Errors
/// If a model cannot be read or measured, or a file not be written.
pub fn run(args: &ReproduceArgs, console: &Console) -> Outcome {
    match &args.which {
        Which::AssarssonMoller(args) => assarsson_moller::run(args, console),
        Which::ZhangHoff(args) => zhang_hoff::run(args, console),
        Which::JohannsenCarter(args) => johannsen_carter::run(args, console),
        Which::MeshReduction(args) => mesh_reduction::run(args, console),
    }
}
