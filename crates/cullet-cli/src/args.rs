//! The command line.

use clap::{Parser, Subcommand};
use cullet_command::args::{
    BAKE_HELP, BakeArgs, PROFILE_HELP, ProfileArgs, SIMPLIFY_HELP, SimplifyArgs,
};
use cullet_measure::bench::BenchArgs;
use cullet_measure::calibrate::{self, CalibrateArgs};
use cullet_measure::reproduce::ReproduceArgs;

use crate::cells::{self, CellsArgs};
use crate::check_occlusion::{self, CheckArgs};
use crate::cut::{self, CutArgs};
use crate::explain::{self, ExplainArgs};
use crate::fetch::{self, FetchArgs};
use crate::film::{self, FilmArgs};
use crate::fly::{self, FlyArgs};
use crate::info::InfoArgs;
use crate::lecture::{self, LectureArgs};
use crate::occluders::{self, OccludersArgs};
use crate::occscn::{self, OccscnArgs};
use crate::picture::{self, PictureArgs};
use crate::pvs::{self, PvsArgs};
use crate::quiz::{self, QuizArgs};
use crate::replay::{self, ReplayArgs};
use crate::report::{self, ReportArgs};
use crate::scenes::ScenesArgs;
use crate::serve::{self, ServeArgs};
use crate::tiles::{self, TilesArgs};
use crate::verify::{self, VerifyArgs};
use crate::view::{self, WindowArgs};

const ABOUT: &str =
    "Finds what a 3D scene draws for nothing, and proves that nothing visible was lost";

const EXAMPLES: &str = "\
Examples
  cullet report                              the built-in city: a page with pictures, figures, advice
  cullet report model.glb --out page/        the same for your own model
  cullet report models/                      every file in a folder, and a page over all of them
  cullet report model.glb --path walk --views 32 --size 1920x1080
  cullet report model.glb --eye 0,2,9 --target 0,1,0 --fov 60
                                             one view of your choice
  cullet report house.glb --cut 0,1,0,2.4    also shows it cut open, with what was culled inside
  cullet report model.glb --detail 2         also drop what stays under 2 pixels (lossy)
  cullet report model.glb --lod 1            levels of detail, off by a pixel at most (lossy)
  cullet report model.glb --baseline old/report.json --fail-if 'tightness>3'
                                             for CI: what changed, and exit code 5 if too loose
  cullet verify model.glb                    only the proof: culled and unculled images must agree
  cullet check-occlusion model.glb           each pixel of the occlusion buffer against samples
  cullet replay frame.occ                    a recorded frame of occlusion culling, played again
  cullet info model.glb                      what is in a file, and what is wrong with it
  cullet scenes                              the built-in scenes and their settings
  cullet fetch bunny --accept                bunny, teapot and armadillo, on their makers' terms
  cullet picture kinds --out kinds.png       each triangle in the colour of what dropped it
  cullet explain city --pixel 640,360        why that is drawn, and what was culled behind it
  cullet film city --of freeze               a short clip: culling freezes, and the eye flies out
  cullet cut model.glb --plane 0,0,1,0 --cap -o half.glb
                                             cut it open; the caps leave no gap
  cullet simplify model.glb --error 0.001 -o small.glb
                                             few triangles, none off by more than a 1,000th of its radius
  cullet bake model.glb -o baked.glb         levels of detail beside every mesh, with measured errors
  cullet occluders model.glb --picture o.png boxes inside of it, and polygons in its surface
  cullet cells house.glb --cells rooms.glb -o out.glb
                                             cells and portals from the volumes of its rooms
  cullet pvs map.prt -o map.cpvs             which cells of a map see each other, and what proves it
  cullet tiles city.glb -o city              3D Tiles, for worlds that are loaded piece by piece
  cullet fly city:n=1e8                      a hundred million instances, loaded on the way
  cullet profile model.glb                   which link of a frame is the slowest, and which culling helps
  cullet view model.glb                      a window: turn it, freeze it, click what is missing
  cullet serve model.glb                     the same as a page, on localhost
  cullet bench                               the batch tests against this machine's streaming rate
  cullet bench hierarchy                     walks of a million boxes against flat sweeps of them
  cullet occscn city:ground=0 -o city.bin    triangles, boxes and views, for comparing occlusion cullers
  cullet bench occlusion --scene city.bin    what hiding boxes takes on such a file
  cullet bench culler forest --path walk     what each stage of culling takes on a scene
  cullet bench pays                          whether occlusion gives back what it takes, scene by scene
  cullet lecture                             three lectures and a paper, each claim measured here
  cullet quiz frustum-1 2.5                  the exercises of the book: is that the answer?
  cullet reproduce assarsson-moller          what each trick of the paper on frustum culling gains
  cullet reproduce zhang-hoff                Table 1 and Graph 1 of the paper on normal masks
  cullet reproduce mesh-reduction --model armadillo.obj
                                             smaller and smaller, of fewer and fewer triangles
  cullet calibrate                           what a triangle costs here, for reports in milliseconds
  cullet reproduce johannsen-carter          clusters and their bounds, beside the ideal

Exit codes
  0 fine        1 something visible was culled, or a wrong claim      2 wrong command line
  3 input unreadable or invalid     4 over a limit      5 a --fail-if holds
  70 internal error                 130 interrupted, with a valid report of what was done";

/// The whole command line.
#[derive(Debug, Parser)]
#[command(name = "cullet", version, about = ABOUT, after_help = EXAMPLES, arg_required_else_help = true)]
pub(crate) struct Cli {
    /// Print nothing but results and errors
    #[arg(long, short, global = true)]
    pub(crate) quiet: bool,
    /// The command to run.
    #[command(subcommand)]
    pub(crate) command: Command,
}

impl Cli {
    /// Puts what depends on the scene where nothing was given.
    pub(crate) fn settle(&mut self) {
        match &mut self.command {
            Command::Report(args) => args.input.settle(),
            Command::Verify(args) => args.input.settle(),
            Command::CheckOcclusion(args) => args.settle(),
            Command::Picture(args) => args.input.settle(),
            Command::Explain(args) => args.input.settle(),
            Command::Bench(args) => args.settle(),
            _ => {}
        }
    }
}

/// The command to run.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Write a page that says what is drawn for nothing, and why
    #[command(after_help = report::HELP)]
    Report(Box<ReportArgs>),
    /// Draw every view with and without culling and compare the images
    #[command(after_help = verify::HELP)]
    Verify(Box<VerifyArgs>),
    /// Hold every pixel that the occlusion buffer claims against samples
    #[command(after_help = check_occlusion::HELP)]
    CheckOcclusion(Box<CheckArgs>),
    /// Play a recording of occlusion culling again: are its answers the same?
    #[command(after_help = replay::HELP)]
    Replay(ReplayArgs),
    /// Say what is in a scene, and what is wrong with it
    Info(InfoArgs),
    /// List the built-in scenes and their settings
    Scenes(ScenesArgs),
    /// Fetch a model that everybody knows: bunny, armadillo, teapot, on its maker's terms
    #[command(after_help = fetch::HELP)]
    Fetch(FetchArgs),
    /// Measure the tests and the hierarchy against this machine's streaming rate and each other
    Bench(BenchArgs),
    /// Measure the figures of a published work again, beside the published ones
    Reproduce(Box<ReproduceArgs>),
    /// Three lectures and a paper, item by item: each claim, measured here
    #[command(after_help = lecture::HELP)]
    Lecture(LectureArgs),
    /// The exercises of the book: is an answer right?
    #[command(after_help = quiz::HELP)]
    Quiz(QuizArgs),
    /// Measure what tests and triangles cost here, so that reports speak of milliseconds
    #[command(after_help = calibrate::HELP)]
    Calibrate(CalibrateArgs),
    /// Draw one picture of one view
    #[command(after_help = picture::HELP)]
    Picture(Box<PictureArgs>),
    /// Say why one instance is drawn or not: each test, with its numbers
    #[command(after_help = explain::HELP)]
    Explain(Box<ExplainArgs>),
    /// Write a short clip of culling at work: frozen, through portals, around a model, moving away
    #[command(after_help = film::HELP)]
    Film(Box<FilmArgs>),
    /// Cut a scene open at planes or a box, with caps
    #[command(after_help = cut::HELP)]
    Cut(Box<CutArgs>),
    /// Write a GLB with levels of detail of every mesh, made and measured beforehand
    #[command(after_help = BAKE_HELP)]
    Bake(Box<BakeArgs>),
    /// Write a scene of few triangles that deviates by no more than is said, as measured
    #[command(after_help = SIMPLIFY_HELP)]
    Simplify(Box<SimplifyArgs>),
    /// Bake occluders for each mesh: boxes inside of it and polygons in its surface
    #[command(after_help = occluders::HELP)]
    Occluders(Box<OccludersArgs>),
    /// Count the cells and portals of a scene, and write it with them
    #[command(after_help = cells::HELP)]
    Cells(Box<CellsArgs>),
    /// Bake which cells of a map's portal graph see each other
    #[command(after_help = pvs::HELP)]
    Pvs(Box<PvsArgs>),
    /// Write a scene as 3D Tiles, for worlds that are loaded piece by piece
    #[command(after_help = tiles::HELP)]
    Tiles(Box<TilesArgs>),
    /// Fly through a world larger than memory: what that takes
    #[command(after_help = fly::HELP)]
    Fly(Box<FlyArgs>),
    /// Write a scene as triangles, boxes and views for comparing occlusion cullers
    #[command(after_help = occscn::HELP)]
    Occscn(Box<OccscnArgs>),
    /// Name the slowest link of a frame, and the culling that relieves it
    #[command(after_help = PROFILE_HELP)]
    Profile(Box<ProfileArgs>),
    /// Show a scene in a window: what is culled, and why
    #[command(after_help = view::HELP)]
    View(WindowArgs),
    /// Serve the viewer's page, and a scene for it, on this machine
    #[command(after_help = serve::HELP)]
    Serve(ServeArgs),
}
