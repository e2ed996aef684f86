//! The command line of `cullet explain`.

use std::path::PathBuf;

use clap::{ArgGroup, Args};
use cullet_command::args::InputArgs;
use cullet_command::parse;

/// End of `cullet explain --help`.
pub(crate) const HELP: &str = "\
Says of one instance of one view what each stage of culling tested, with the numbers of the test, what came of it,
and why the instance is drawn or not. The reason is the one that a cull of the whole view writes.

--pixel tells who owns a pixel in the image that is drawn with no culling at all, why it is kept, and which culled
instances lie behind it, the nearest first. --instance takes a name as cullet verify and report write it, or
#N for slot N. --triangle tells of one triangle of it too, by its number in the file.

Signed distances to planes are above 0 outside. Sizes are in pixels of the view.

Examples
  cullet explain city --view 2 --views 8 --pixel 640,360
  cullet explain city --view 2 --views 8 --instance 'house 12'
  cullet explain office --path walk --views 8 --view 3 --instance 'desk 40' --json -
  cullet explain model.glb --eye 0,2,9 --target 0,1,0 --pixel 10,20 --out why.png
  cullet explain city --view 2 --views 8 --pixel 640,360 --out chain.svg
  cullet explain knobs --views 8 --view 1 --instance 'knobs 0' --triangle 17";

/// `cullet explain`
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("what").required(true).args(["pixel", "instance"])))]
pub struct ExplainArgs {
    #[command(flatten)]
    pub(crate) input: InputArgs,
    /// View of the path, from 0
    #[arg(long = "view", value_name = "INDEX", default_value_t = 0)]
    pub(crate) index: u32,
    /// Explain what owns this pixel, counted from the top left corner, and what lies behind it
    #[arg(long, value_name = "X,Y", value_parser = parse::pixel)]
    pub(crate) pixel: Option<[u32; 2]>,
    /// Explain the instance of this name, or of slot N by #N
    #[arg(long, value_name = "NAME")]
    pub(crate) instance: Option<String>,
    /// Explain this triangle of it, too, by its number in the file, from 0
    #[arg(long, value_name = "ID", requires = "instance")]
    pub(crate) triangle: Option<u32>,
    /// Draw a .png: the instance, what hides it, and the numbers; or an .svg: the chain of tests,
    /// each value beside its limit
    #[arg(long, value_name = "PATH", value_parser = parse::output)]
    pub(crate) out: Option<PathBuf>,
    /// Write the explanation as JSON; - is the standard output
    #[arg(long, value_name = "PATH", value_parser = parse::output)]
    pub(crate) json: Option<PathBuf>,
}
