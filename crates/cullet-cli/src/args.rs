//! The command line.

use std::path::{Path, PathBuf};

use clap::{Args, Parser, Subcommand, ValueEnum};
use cullet_io::paths::{self, PathSpec};
use cullet_io::scenes;

use crate::bench::OcclusionArgs;
use crate::bench::culler::{self, CullerArgs};
use crate::calibrate::{self, CalibrateArgs, ClusterArgs};
use crate::cut::{self, CutArgs};
use crate::occluders::{self, OccludersArgs};
use crate::occscn::{self, OccscnArgs};
use crate::parse;
use crate::replay::{self, ReplayArgs};
use crate::report::{CostArgs, OpenedArgs};
use crate::reproduce::ReproduceArgs;
use crate::serve::{self, ServeArgs};
use crate::view::{self, WindowArgs};

const ABOUT: &str =
    "Finds what a 3D scene draws for nothing, and proves that nothing visible was lost";

const EXAMPLES: &str = "\
Examples
  cullet report                              the built-in city: a page with pictures, figures, advice
  cullet report model.glb --out page/        the same for your own model
  cullet report model.glb --path walk --views 32 --size 1920x1080
  cullet report model.glb --eye 0,2,9 --target 0,1,0 --fov 60
                                             one view of your choice
  cullet report house.glb --cut 0,1,0,2.4    also shows it cut open, with what was culled inside
  cullet report model.glb --detail 2         also drop what stays under 2 pixels (lossy)
  cullet report model.glb --baseline old/report.json --fail-if 'tightness>3'
                                             for CI: what changed, and exit code 5 if too loose
  cullet verify model.glb                    only the proof: culled and unculled images must agree
  cullet replay frame.occ                    a recorded frame of occlusion culling, played again
  cullet info model.glb                      what is in a file, and what is wrong with it
  cullet scenes                              the built-in scenes and their settings
  cullet picture kinds --out kinds.png       each triangle in the colour of what dropped it
  cullet cut model.glb --plane 0,0,1,0 --cap -o half.glb
                                             cut it open; the caps leave no gap
  cullet occluders model.glb --picture o.png boxes inside of it, and polygons in its surface
  cullet view model.glb                      a window: turn it, freeze it, click what is missing
  cullet serve model.glb                     the same as a page, on localhost
  cullet bench                               the batch tests against this machine's streaming rate
  cullet bench hierarchy                     walks of a million boxes against flat sweeps of them
  cullet occscn city:ground=0 -o city.bin    triangles, boxes and views, for comparing occlusion cullers
  cullet bench occlusion --scene city.bin    what hiding boxes takes on such a file
  cullet bench culler forest --path walk     what each stage of culling takes on a scene
  cullet reproduce assarsson-moller          what each trick of the paper on frustum culling gains
  cullet reproduce zhang-hoff                Table 1 and Graph 1 of the paper on normal masks
  cullet calibrate                           what a triangle costs here, for reports in milliseconds
  cullet reproduce johannsen-carter          clusters and their bounds, beside the ideal

Exit codes
  0 fine        1 something visible was culled      2 wrong command line
  3 input unreadable or invalid     4 over a limit      5 a --fail-if holds
  70 internal error                 130 interrupted, with a valid report of what was done";

/// The whole command line.
#[derive(Debug, Parser)]
#[command(name = "cullet", version, about = ABOUT, after_help = EXAMPLES, arg_required_else_help = true)]
pub(crate) struct Cli {
    /// Print nothing but results and errors
    #[arg(long, short, global = true)]
    pub(crate) quiet: bool,
    /// What to do.
    #[command(subcommand)]
    pub(crate) command: Command,
}

impl Cli {
    /// Puts what depends on the scene where nothing was given.
    pub(crate) fn settle(&mut self) {
        match &mut self.command {
            Command::Report(a) => a.view.settle(&a.scene),
            Command::Verify(a) => a.view.settle(&a.scene),
            Command::Picture(a) => a.view.settle(&a.scene),
            Command::Bench(BenchArgs { of: Some(BenchOf::Culler(a)), .. }) => a.settle(),
            _ => {}
        }
    }
}

/// What to do.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Write a page that says what is drawn for nothing, and why
    #[command(after_help = REPORT_HELP)]
    Report(Box<ReportArgs>),
    /// Draw every view with and without culling and compare the images
    #[command(after_help = VERIFY_HELP)]
    Verify(Box<VerifyArgs>),
    /// Play a recording of occlusion culling again: are its answers the same?
    #[command(after_help = replay::HELP)]
    Replay(ReplayArgs),
    /// Say what is in a scene, and what is wrong with it
    Info(InfoArgs),
    /// List the built-in scenes and their settings
    Scenes(ScenesArgs),
    /// Measure the tests and the hierarchy against this machine's streaming rate and each other
    Bench(BenchArgs),
    /// Measure the figures of a published work again, beside the published ones
    Reproduce(Box<ReproduceArgs>),
    /// Measure what tests and triangles cost here, so that reports speak of milliseconds
    #[command(after_help = calibrate::HELP)]
    Calibrate(CalibrateArgs),
    /// Draw one picture of one view
    #[command(after_help = PICTURE_HELP)]
    Picture(Box<PictureArgs>),
    /// Cut a scene open at planes or a box, with caps
    #[command(after_help = cut::HELP)]
    Cut(Box<CutArgs>),
    /// Make what can stand for each mesh when things behind it are looked for
    #[command(after_help = occluders::HELP)]
    Occluders(Box<OccludersArgs>),
    /// Write a scene as triangles, boxes and views for comparing occlusion cullers
    #[command(after_help = occscn::HELP)]
    Occscn(Box<OccscnArgs>),
    /// Show a scene in a window: what is culled, and why
    #[command(after_help = view::HELP)]
    View(WindowArgs),
    /// Serve the viewer's page, and a scene for it, on this machine
    #[command(after_help = serve::HELP)]
    Serve(ServeArgs),
}

const REPORT_HELP: &str = "\
Writes into --out: index.html (one file, opens offline), report.json, views.csv and pictures.
Each view's part is written as it is finished; Ctrl-C finishes the current view and leaves a valid
report.

--fail-if EXPR is KEY OP VALUE: KEY is tightness, false_culls, all, potentially_visible, visible or
culled_percent; OP is one of > >= < <= == !=; VALUE a number, or, with --baseline, 'baseline',
'baseline+5%' or 'baseline-5%'. Examples: 'tightness>3', 'potentially_visible>baseline+2%'.

--time 1.5 poses what moves (the animations, skins and morph targets of a glTF, or the built-in scene
moving) at 1.5 s; --time 0..4 lets four seconds pass along the views. Animations start again at their end.

A --path is orbit (around the scene), walk (through it at eye height), fly (over and through it),
file:PATH (a JSON list of cameras) or camera:NAME (a camera of the file, over its animation). Without
one, the built-in city, office, plant, forest and moving are walked through, so that frustum, occlusion and
back faces all have something to cull; anything else is looked at from all around.";

const VERIFY_HELP: &str = "\
Draws every view with and without culling, and demands that each pixel be owned by the same triangle
of the same instance. With --samples 4 it also looks for instances that own one of 4x4 jittered
samples a pixel and were dropped. Every loss is printed with its view, instance, stage and reason,
and the exit code is 1.

--time 0..4 lets what moves do so along the views, under bounds from its joints and morph targets.

Examples
  cullet verify city --path walk
  cullet verify figure.glb --time 0..4 --views 32
  cullet verify moving --time 1.5 --path walk
  cullet verify city --views 1 --record city.occ     for cullet replay";

const PICTURE_HELP: &str = "\
kinds   the scene from outside, cut open above the eye where something covers what that sees: each
        triangle in the colour of the kind of culling that took it
shaded  the view itself
depth   how often each pixel is covered
map     from above: the frustum, and every instance coloured by what became of it
hierarchy
        from above, level by level: what the walk of the hierarchy dropped, kept whole, tested further

Of occlusion culling:
occlusion-buffer  the true depth, what is proved pixel by pixel and tile by tile, and the difference
occluders         what each occluder that was drawn covers
hidden            what is hidden, as ghosts behind what hides it
coverage          when a pixel counts as covered, and what a buffer of samples does not see; no scene

To teach back-face culling:
normal-mask       the cube of directions in 216 and 1536 classes, those that face away in pink
normal-partition  the same in the plane: the circle of normals
conservative-set  how the set of back-facing normals grows as the view is cut into sectors
culling-volume    a cluster, and the eyes from which all of it faces away (--cluster N)
clusters          the model in the colours of its clusters
cones             the clusters with their cones of normals
back-regions      the connected regions that face away from the view's eye, counted
The first three read no scene: --eye and --target give the direction of sight, --fov the angle.
Clusters of two-sided meshes are never culled, and made otherwise: give --one-sided for scans with
holes.

To teach clipping; these draw no scene:
outcodes          the nine regions around a window; lines and triangles by their codes
clip-polygon      Sutherland & Hodgman, one side after another
clip-w            a segment behind the eye, divided before it is clipped, and after
pipeline          the spaces of the pipeline, the tests in each, and their cost on this machine

Examples
  cullet picture kinds --out kinds.png
  cullet picture occlusion-buffer plant --path walk --views 8 --view 2
  cullet picture normal-mask --eye 3,2,5 --target 0,0,0 --fov 20
  cullet picture back-regions knobs --views 8 --view 1
  cullet picture culling-volume bunny.ply --one-sided --cluster 17
  cullet picture map city:seed=3 --path walk --view 2 --views 4";

/// Which scene, and how to read it.
#[derive(Clone, Debug, Args)]
pub(crate) struct SceneArgs {
    /// A file (glb, gltf, obj, ply, stl, off, occscn), or a built-in scene: NAME or NAME:key=value,...
    #[arg(default_value = "city")]
    pub(crate) scene: String,
    /// Which axis of the file points up [default: what the format says, else y]
    #[arg(long, value_enum)]
    pub(crate) up: Option<UpAxis>,
    /// Take every triangle for one-sided, whatever the file says
    #[arg(long, conflicts_with = "two_sided")]
    pub(crate) one_sided: bool,
    /// Take every triangle for two-sided: nothing is back-face culled
    #[arg(long)]
    pub(crate) two_sided: bool,
    /// Refuse files with more triangles than this (exit code 4)
    #[arg(long, value_name = "N")]
    pub(crate) max_triangles: Option<u64>,
}

impl SceneArgs {
    /// Whether this is a built-in scene. A file of that name wins, for a name can be changed with a `./`.
    pub(crate) fn builtin(&self) -> bool {
        !Path::new(&self.scene).exists() && scenes::is_builtin(&self.scene)
    }
}

/// The axis that points up.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum UpAxis {
    /// +Y
    Y,
    /// +Z
    Z,
}

/// Which views.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Views")]
pub(crate) struct ViewArgs {
    /// Pixels of a view
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = parse::size)]
    pub(crate) size: [u32; 2],
    /// How many views along the path
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub(crate) views: u32,
    /// One of orbit, walk, fly, `file:PATH`, `camera:NAME`; auto is walk for the built-in scenes that one walks
    /// in (city, office, plant, forest, moving), else orbit
    #[arg(long, default_value = AUTO)]
    pub(crate) path: String,
    /// One view, from this point
    #[arg(long, value_name = "X,Y,Z", value_parser = parse::point, allow_hyphen_values = true, requires = "target")]
    pub(crate) eye: Option<[f64; 3]>,
    /// One view, looking at this point
    #[arg(long, value_name = "X,Y,Z", value_parser = parse::point, allow_hyphen_values = true, requires = "eye")]
    pub(crate) target: Option<[f64; 3]>,
    /// Vertical field of view, in degrees [default: the path's own, else 60]
    #[arg(long, value_name = "DEGREES", value_parser = parse::angle)]
    pub(crate) fov: Option<f64>,
    /// Distance of the near plane [default: fits the scene]
    #[arg(long, value_name = "DISTANCE", value_parser = parse::distance)]
    pub(crate) near: Option<f64>,
    /// Distance of the far plane, or inf [default: fits the scene]
    #[arg(long, value_name = "DISTANCE", value_parser = parse::distance)]
    pub(crate) far: Option<f64>,
    /// Pose what moves at T seconds; A..B lets the time pass evenly over the views
    #[arg(long, value_name = "T|A..B", value_parser = parse::span, allow_hyphen_values = true)]
    pub(crate) time: Option<[f64; 2]>,
    /// Seed of the jittered samples
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Threads that draw; 0 is one for each core
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) threads: usize,
}

/// The path that depends on the scene.
const AUTO: &str = "auto";

impl ViewArgs {
    /// Puts the path that suits the scene where none was given.
    pub(crate) fn settle(&mut self, scene: &SceneArgs) {
        if self.path == AUTO {
            let path =
                if scene.builtin() { paths::of_builtin(&scene.scene) } else { PathSpec::Orbit };
            self.path = path.to_string();
        }
    }
}

/// Which kinds of culling.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Culling")]
pub(crate) struct CullArgs {
    /// Also drop what stays under PX pixels on the screen (lossy: may cost visible pixels)
    #[arg(long, value_name = "PX", value_parser = parse::pixels)]
    pub(crate) detail: Option<f64>,
    /// How --detail measures: both sides of the screen box, its area in square pixels, or its diagonal
    #[arg(long, value_enum, default_value_t = DetailMeasure::Sides)]
    pub(crate) detail_by: DetailMeasure,
    /// Run one stage alone
    #[arg(long, value_enum, value_name = "STAGE", conflicts_with_all = ["no_frustum", "no_backface", "no_degenerate", "no_occlusion"])]
    pub(crate) only: Option<OnlyStage>,
    /// Keep what is outside the frustum
    #[arg(long)]
    pub(crate) no_frustum: bool,
    /// Keep back faces
    #[arg(long)]
    pub(crate) no_backface: bool,
    /// Keep triangles without area
    #[arg(long)]
    pub(crate) no_degenerate: bool,
    /// Keep what is hidden behind something
    #[arg(long)]
    pub(crate) no_occlusion: bool,
    /// Pixels across the occlusion buffer; never more than the view has
    #[arg(long, value_name = "PX", default_value_t = 640, value_parser = clap::value_parser!(u32).range(1..=16384))]
    pub(crate) occlusion_width: u32,
    /// What drawing occluders may cost a view, in modelled microseconds
    #[arg(long, value_name = "US", default_value_t = 100_000.0, value_parser = parse::microseconds)]
    pub(crate) occlusion_budget: f32,
    /// What hides: each mesh itself, boxes and polygons baked from it first, or the cheaper of the two
    #[arg(long, value_enum, default_value_t = OccluderKind::Mesh)]
    pub(crate) occluders: OccluderKind,
    /// Test big boxes at the frustum's corners exactly
    #[arg(long)]
    pub(crate) exact_frustum: bool,
}

/// A stage that can be run alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum OnlyStage {
    /// What is outside the frustum
    Frustum,
    /// What is small on the screen (lossy; --detail sets the threshold, else a pixel)
    Detail,
    /// What is hidden behind something
    Occlusion,
    /// What faces away
    Backface,
    /// What has no area
    Degenerate,
}

/// What stands for a mesh in the occlusion buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum OccluderKind {
    /// Proxies where they cover nearly as much at half the modelled cost, else the mesh
    Auto,
    /// The mesh itself
    Mesh,
    /// Boxes and polygons made from it, and some of its triangles where those leave much; nothing where none do
    Baked,
}

/// How detail culling measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum DetailMeasure {
    /// Width and height both under the threshold
    Sides,
    /// Area under the threshold
    Area,
    /// Diagonal under the threshold
    Diameter,
}

/// `cullet report`
#[derive(Debug, Args)]
pub(crate) struct ReportArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    #[command(flatten)]
    pub(crate) view: ViewArgs,
    #[command(flatten)]
    pub(crate) cull: CullArgs,
    #[command(flatten)]
    pub(crate) costs: CostArgs,
    /// Verify with N x N jittered samples a pixel; 1 is off
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=64))]
    pub(crate) samples: u32,
    /// Folder to write into
    #[arg(long, value_name = "DIR", default_value = "report")]
    pub(crate) out: PathBuf,
    /// Also write report.json here; - is the standard output
    #[arg(long, value_name = "PATH")]
    pub(crate) json: Option<PathBuf>,
    /// An older report.json: print what changed
    #[arg(long, value_name = "PATH")]
    pub(crate) baseline: Option<PathBuf>,
    /// End with exit code 5 if this holds; may be given several times
    #[arg(long, value_name = "EXPR")]
    pub(crate) fail_if: Vec<String>,
    /// Write what each view keeps and drops, with names, handles and reasons
    #[arg(long, value_name = "PATH")]
    pub(crate) export: Option<PathBuf>,
    /// Seconds for verification where a view has over 5e7 triangles
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = parse::seconds)]
    pub(crate) verify_seconds: f64,
    #[command(flatten)]
    pub(crate) opened: OpenedArgs,
    /// Also draw this of each view that has pictures
    #[arg(long, value_enum)]
    pub(crate) show: Vec<Show>,
    /// What counts as tiny in the advice, in pixels
    #[arg(long, value_name = "PX", default_value_t = 4.0, value_parser = parse::pixels)]
    pub(crate) tiny: f64,
}

/// What a report can draw besides.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Show {
    /// The walk of the scene's hierarchy, level by level
    Hierarchy,
}

/// `cullet verify`
#[derive(Debug, Args)]
pub(crate) struct VerifyArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    #[command(flatten)]
    pub(crate) view: ViewArgs,
    #[command(flatten)]
    pub(crate) cull: CullArgs,
    /// N x N jittered samples a pixel; 1 is off
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=64))]
    pub(crate) samples: u32,
    /// Record the occluders and boxes of every view, and what is hidden, for cullet replay
    #[arg(long, value_name = "PATH", conflicts_with = "no_occlusion")]
    pub(crate) record: Option<PathBuf>,
    /// Write the result as JSON; - is the standard output
    #[arg(long, value_name = "PATH")]
    pub(crate) json: Option<PathBuf>,
}

/// `cullet info`
#[derive(Debug, Args)]
pub(crate) struct InfoArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    /// List every mesh and warning, not only the first ones
    #[arg(long)]
    pub(crate) all: bool,
    /// Write the result as JSON; - is the standard output
    #[arg(long, value_name = "PATH")]
    pub(crate) json: Option<PathBuf>,
}

/// `cullet scenes`
#[derive(Debug, Args)]
pub(crate) struct ScenesArgs {
    /// Write the list as JSON; - is the standard output
    #[arg(long, value_name = "PATH")]
    pub(crate) json: Option<PathBuf>,
}

/// `cullet bench`
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true)]
pub(crate) struct BenchArgs {
    /// Only workloads whose name contains this, such as frustum, backface, hierarchy, views, moving, occlusion
    pub(crate) filter: Option<String>,
    /// Also a hierarchy of 1e7 boxes, and 1,000 frames of 1e6 that move: 1 GiB, some minutes
    #[arg(long)]
    pub(crate) large: bool,
    /// Write the results as JSON; - is the standard output
    #[arg(long, value_name = "PATH")]
    pub(crate) json: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) occlusion: OcclusionArgs,
    #[command(subcommand)]
    pub(crate) of: Option<BenchOf>,
}

/// What `cullet bench` measures of a scene.
#[derive(Debug, Subcommand)]
pub(crate) enum BenchOf {
    /// What each stage of the culler takes on a scene
    #[command(after_help = culler::HELP)]
    Culler(Box<CullerArgs>),
}

/// `cullet picture`
#[derive(Debug, Args)]
pub(crate) struct PictureArgs {
    /// What to draw
    #[arg(value_enum)]
    pub(crate) kind: PictureKind,
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    #[command(flatten)]
    pub(crate) view: ViewArgs,
    #[command(flatten)]
    pub(crate) cull: CullArgs,
    /// culling-volume: which cluster of the first instance, from 0 [default: the widest with a volume, of the
    /// first instance that has one]
    #[arg(long, value_name = "N")]
    pub(crate) cluster: Option<u32>,
    #[command(flatten)]
    pub(crate) clusters: ClusterArgs,
    /// Which view of the path, from 0
    #[arg(long = "view", value_name = "INDEX", default_value_t = 0)]
    pub(crate) index: u32,
    /// The PNG to write [default: KIND.png]
    #[arg(long, value_name = "PATH")]
    pub(crate) out: Option<PathBuf>,
}

/// What a picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum PictureKind {
    /// Each triangle in the colour of the kind of culling that took it
    Kinds,
    /// The view itself
    Shaded,
    /// How often each pixel is covered
    Depth,
    /// From above, with the frustum
    Map,
    /// The walk of the scene's hierarchy, level by level, from above
    Hierarchy,
    /// The true depth, the occlusion buffer by pixels and by tiles, and what they differ by
    OcclusionBuffer,
    /// What each occluder that was drawn covers
    Occluders,
    /// What is hidden, as ghosts
    Hidden,
    /// When a pixel counts as covered
    Coverage,
    /// The cube of directions and its classes that face away
    NormalMask,
    /// The circle of normals and its classes that face away
    NormalPartition,
    /// The conservative set of normals against the number of sectors
    ConservativeSet,
    /// A cluster and the eyes from which all of it faces away
    CullingVolume,
    /// The model in the colours of its clusters
    Clusters,
    /// The clusters with their cones of normals
    Cones,
    /// The connected regions that face away
    BackRegions,
    /// The nine regions of outcodes, with lines and triangles
    Outcodes,
    /// A polygon clipped side by side
    ClipPolygon,
    /// A segment behind the eye, divided and then clipped, and the other way round
    ClipW,
    /// The spaces of the pipeline and the tests in each
    Pipeline,
}

impl PictureKind {
    /// Its name on the command line.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Kinds => "kinds",
            Self::Shaded => "shaded",
            Self::Depth => "depth",
            Self::Map => "map",
            Self::Hierarchy => "hierarchy",
            Self::OcclusionBuffer => "occlusion-buffer",
            Self::Occluders => "occluders",
            Self::Hidden => "hidden",
            Self::Coverage => "coverage",
            Self::NormalMask => "normal-mask",
            Self::NormalPartition => "normal-partition",
            Self::ConservativeSet => "conservative-set",
            Self::CullingVolume => "culling-volume",
            Self::Clusters => "clusters",
            Self::Cones => "cones",
            Self::BackRegions => "back-regions",
            Self::Outcodes => "outcodes",
            Self::ClipPolygon => "clip-polygon",
            Self::ClipW => "clip-w",
            Self::Pipeline => "pipeline",
        }
    }
}
