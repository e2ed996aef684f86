//! The command line of `cullet profile`.

use std::path::PathBuf;

use clap::Args;

use cullet_command::args::InputArgs;
use cullet_command::parse;

/// End of `cullet profile --help`.
pub(crate) const PROFILE_HELP: &str = "\
A frame goes from the program over the bus through the transform of its triangles to the filling of its pixels.
These links work side by side, so that making one faster helps only if the others wait for it. The work of one is
doubled at a time: by how much frames take longer says how much they wait for it. A link is named where that is at
least 40 percent, and more than that of all others beyond doubt; else the frame is mixed.

Then each kind of culling is tried. What it should give is predicted from the links and from what it takes of
covered samples, triangles, bytes and the program's time; what it gives is measured beside frames without it.
Frames are drawn off screen: as the engine lists them, instances of a mesh in one draw, each lit by one lamp. A
program with costlier pixels waits more for fill than is found here.

The scenes fill, transform, bus and cpu are frames with hardly any work but that of one link, to see whether it is
found on this device.

The work is done by a program of its own, cullet-profile, which is looked for beside this program, then in PATH; a
'cullet' that cargo built in the folder of its source builds it at the first call. It needs a graphics device, or a
program in its place. Ctrl-C keeps the rounds that were done.

Examples
  cullet profile model.glb                     which link its frames wait for, and which culling helps
  cullet profile city --path walk --views 8    a walk of eight views
  cullet profile city --already frustum        what more would help a program that culls by the frustum
  cullet profile model.glb --lod 1             levels of detail too
  cullet profile model.glb -o profile.svg      the chain as a picture
  cullet profile model.glb --json -            the figures as JSON
  cullet profile fill                          is fill found here?";

/// Arguments of `cullet profile`.
#[derive(Clone, Debug, Args)]
#[command(mut_arg("views", |arg| arg.default_value("4")))]
pub(crate) struct ProfileArgs {
    /// The scene, views and culling.
    #[command(flatten)]
    pub input: InputArgs,
    /// Stages that cull the frames of the baseline already
    #[arg(long, value_parser = parse::choice(ALREADY), default_value = "none", value_name = "STAGE")]
    pub already: Already,
    /// How often each way is timed; fewer than 30 name a link less often
    #[arg(long, value_name = "N", default_value_t = 30, value_parser = clap::value_parser!(u32).range(3..=10_000))]
    pub rounds: u32,
    /// Draw the chain as a picture, an SVG
    #[arg(long, short, value_name = "PATH", value_parser = cullet_command::parse::output)]
    pub out: Option<PathBuf>,
    /// Write the figures as JSON; - is the standard output
    #[arg(long, value_name = "PATH", value_parser = cullet_command::parse::output)]
    pub json: Option<PathBuf>,
}

/// Culling that a program does already.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Already {
    /// Nothing.
    Nothing,
    /// The frustum.
    Frustum,
}

const ALREADY: &[(&str, Already, &str)] = &[
    ("none", Already::Nothing, "Everything is drawn"),
    ("frustum", Already::Frustum, "What is outside the view is not"),
];
