//! The commands of `cullet`, and how each is run.

use std::path::Path;

use clap::Subcommand;
use cullet_command::args::{CullArgs, OccluderKind, SceneArgs};
use cullet_command::console::Console;
use cullet_command::exit::Outcome;

use crate::explain::{self, ExplainArgs};
use crate::info::{self, InfoArgs};
use crate::picture::{self, PictureArgs};
use crate::report::{self, ReportArgs};
use crate::scenes::{self, ScenesArgs};
use crate::verify::{self, VerifyArgs};

/// A command of `cullet`.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Write a page that says what is drawn for nothing, and why
    #[command(after_help = report::HELP)]
    Report(Box<ReportArgs>),
    /// Draw every view with and without culling and compare the images
    #[command(after_help = verify::HELP)]
    Verify(Box<VerifyArgs>),
    /// Say what is in a scene, and what is wrong with it
    Info(InfoArgs),
    /// List the built-in scenes and their settings
    Scenes(ScenesArgs),
    /// Draw one picture of one view
    #[command(after_help = picture::HELP)]
    Picture(Box<PictureArgs>),
    /// Say why one instance is drawn or not: each test, with its numbers
    #[command(after_help = explain::HELP)]
    Explain(Box<ExplainArgs>),
}

impl Command {
    /// Puts what depends on the scene where nothing was given.
    pub fn settle(&mut self) {
        match self {
            Self::Report(args) => args.input.settle(),
            Self::Verify(args) => args.input.settle(),
            Self::Picture(args) => args.input.settle(),
            Self::Explain(args) => args.input.settle(),
            Self::Info(_) | Self::Scenes(_) => {}
        }
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Report(_) => "report",
            Self::Verify(_) => "verify",
            Self::Info(_) => "info",
            Self::Scenes(_) => "scenes",
            Self::Picture(_) => "picture",
            Self::Explain(_) => "explain",
        }
    }

    /// Whether it asks for what only a program with the [baker](cullet_command::bakery) does.
    #[must_use]
    pub fn needs_baker(&self) -> bool {
        let scene = |args: &SceneArgs| args.cells.is_some();
        let cull = |args: &CullArgs| !args.no_occlusion && args.occluders != OccluderKind::Mesh;
        match self {
            Self::Report(args) => {
                scene(&args.input.scene) || cull(&args.input.cull) || args.units.are_kept()
            }
            Self::Verify(args) => {
                scene(&args.input.scene) || cull(&args.input.cull) || args.units.are_kept()
            }
            Self::Picture(args) => scene(&args.input.scene) || cull(&args.input.cull),
            Self::Explain(args) => scene(&args.input.scene) || cull(&args.input.cull),
            Self::Info(args) => scene(&args.scene),
            Self::Scenes(_) => false,
        }
    }

    /// Runs it.
    ///
    /// # Errors
    /// What the user is to be told, with the exit code.
    pub fn run(&self, quiet: bool) -> Outcome {
        let console = |json: Option<&Path>| Console::new(quiet, json);
        match self {
            Self::Report(args) => report::run(args, &console(args.json.as_deref())),
            Self::Verify(args) => verify::run(args, &console(args.json.as_deref())),
            Self::Info(args) => info::run(args, &console(args.json.as_deref())),
            Self::Scenes(args) => scenes::run(args, &console(args.json.as_deref())),
            Self::Picture(args) => picture::run(args, &console(None)),
            Self::Explain(args) => explain::run(args, &console(args.json.as_deref())),
        }
    }
}
