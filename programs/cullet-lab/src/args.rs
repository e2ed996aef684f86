//! The commands that measure and teach, and how each is run.

use std::path::Path;

use clap::Subcommand;
use cullet_baker::occluders::{self, OccludersArgs};
use cullet_command::console::Console;
use cullet_command::exit::Outcome;

use crate::bench::{self, BenchArgs};
use crate::calibrate::{self, CalibrateArgs};
use crate::check_occlusion::{self, CheckArgs};
use crate::compare_occluders::compare;
use crate::fetch::{self, FetchArgs};
use crate::film::{self, FilmArgs};
use crate::fly::{self, FlyArgs};
use crate::lecture::{self, LectureArgs};
use crate::occscn_command::{self, OccscnArgs};
use crate::picture::{self, PictureArgs};
use crate::quiz::{self, QuizArgs};
use crate::replay::{self, ReplayArgs};
use crate::reproduce::{self, ReproduceArgs};

/// A command of `cullet-lab`.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Measure the tests and the hierarchy against this machine's streaming rate and each other
    Bench(BenchArgs),
    /// Measure what tests and triangles cost here, so that reports speak of milliseconds
    #[command(after_help = calibrate::HELP)]
    Calibrate(CalibrateArgs),
    /// Measure the figures of a published work again, beside the published ones
    Reproduce(Box<ReproduceArgs>),
    /// Hold every pixel that the occlusion buffer claims against samples
    #[command(after_help = check_occlusion::HELP)]
    CheckOcclusion(Box<CheckArgs>),
    /// Play a recording of occlusion culling again: are its answers the same?
    #[command(after_help = replay::HELP)]
    Replay(ReplayArgs),
    /// Write a scene as triangles, boxes and views for comparing occlusion cullers
    #[command(after_help = occscn_command::HELP)]
    Occscn(Box<OccscnArgs>),
    /// Three lectures and a paper, item by item: each claim, measured here
    #[command(after_help = lecture::HELP)]
    Lecture(LectureArgs),
    /// The exercises of the book: is an answer right?
    #[command(after_help = quiz::HELP)]
    Quiz(QuizArgs),
    /// Draw a picture that teaches
    #[command(after_help = picture::HELP)]
    Picture(Box<PictureArgs>),
    /// Write a short clip of culling at work: frozen, through portals, around a model, moving away
    #[command(after_help = film::HELP)]
    Film(Box<FilmArgs>),
    /// Fly through a world larger than memory: what that takes
    #[command(after_help = fly::HELP)]
    Fly(Box<FlyArgs>),
    /// Fetch a model that everybody knows: bunny, armadillo, teapot, on its maker's terms
    #[command(after_help = fetch::HELP)]
    Fetch(FetchArgs),
    /// Compare baked occluders with a model's own, and with all of its triangles
    #[command(after_help = occluders::HELP)]
    Occluders(Box<OccludersArgs>),
}

impl Command {
    /// Puts what depends on the scene where nothing was given.
    pub fn settle(&mut self) {
        match self {
            Self::Bench(args) => args.settle(),
            Self::CheckOcclusion(args) => args.settle(),
            Self::Picture(args) => args.input.settle(),
            _ => {}
        }
    }

    /// Runs it.
    ///
    /// # Errors
    /// What the user is to be told, with the exit code.
    pub fn run(&self, quiet: bool) -> Outcome {
        let console = |json: Option<&Path>| Console::new(quiet, json);
        match self {
            Self::Bench(args) => bench::run(args, &console(args.json())),
            Self::Calibrate(args) => calibrate::run(args, &console(args.json())),
            Self::Reproduce(args) => reproduce::run(args, &console(args.json())),
            Self::CheckOcclusion(args) => {
                check_occlusion::run(args, &console(args.json.as_deref()))
            }
            Self::Replay(args) => replay::run(args, &console(args.json.as_deref())),
            Self::Occscn(args) => occscn_command::run(args, &console(None)),
            Self::Lecture(args) => lecture::run(args, &console(args.json.as_deref())),
            Self::Quiz(args) => quiz::run(args, &console(None)),
            Self::Picture(args) => picture::run(args, &console(None)),
            Self::Film(args) => film::run(args, &console(None)),
            Self::Fly(args) => fly::run(args, &console(args.json.as_deref())),
            Self::Fetch(args) => fetch::run(args, &console(None)),
            Self::Occluders(args) => {
                occluders::run(args, Some(compare), &console(args.json.as_deref()))
            }
        }
    }
}
