//! The command line of `cullet report`.

use std::path::PathBuf;

use clap::Args;
use cullet_command::args::{InputArgs, UnitArgs};
use cullet_command::parse;

use super::drawing::Show;
use super::opened::OpenedArgs;
use super::saved::CostArgs;

/// End of `cullet report --help`.
pub(crate) const HELP: &str = "\
Writes into --out: index.html (one file, opens offline), report.json, views.csv and pictures.
Each view's part is written as it is finished; Ctrl-C finishes the current view and leaves a valid
report.

Of a folder every scene in it and below gets a report of its own in --out, with a page over all of them. --unit I/N does one
of N shares of the files; --resume takes what is finished in --units, does the rest, and writes the page.

--fail-if EXPR is KEY OP VALUE: KEY is tightness, false_culls, all, potentially_visible, visible or
culled_percent; OP is one of > >= < <= == !=; VALUE a number, or, with --baseline, 'baseline',
'baseline+5%' or 'baseline-5%'. Examples: 'tightness>3', 'potentially_visible>baseline+2%'.

A city larger than memory (city:n=1e8) is flown through while its tiles come and go: the page is that of cullet fly.

--time 1.5 poses what moves (the animations, skins and morph targets of a glTF, or the built-in scene
moving) at 1.5 s; --time 0..4 lets four seconds pass along the views. Animations start again at their end.

--lod 1 draws levels of detail that are off by up to a pixel. The page then goes from all triangles to those that are
seen, with a table by level, pictures before and after, and how far off what is drawn was found to be. A scene without
levels gets some from the baker, once.

A --path is orbit (around the scene), walk (through it at eye height), fly (over and through it),
file:PATH (a JSON list of cameras) or camera:NAME (a camera of the file, over its animation). Without
one, the built-in city, office, plant, forest and moving are walked through, so that frustum, occlusion and
back faces all have something to cull; anything else is looked at from all around.";

/// `cullet report`
#[derive(Clone, Debug, Args)]
pub struct ReportArgs {
    #[command(flatten)]
    pub(crate) input: InputArgs,
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
    pub(crate) units: UnitArgs,
    #[command(flatten)]
    pub(crate) opened: OpenedArgs,
    /// Also draw this of each view that has pictures
    #[arg(long, value_enum)]
    pub(crate) show: Vec<Show>,
    /// Size below which a mesh is tiny in the advice, in pixels
    #[arg(long, value_name = "PX", default_value_t = 4.0, value_parser = parse::pixels)]
    pub(crate) tiny: f64,
}
