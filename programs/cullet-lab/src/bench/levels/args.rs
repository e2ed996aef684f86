//! The command line of `cullet bench lod`.

use std::path::PathBuf;

use clap::Args;

/// End of `cullet bench lod --help`.
pub(crate) const LOD_BENCH_HELP: &str = "\
Makes levels of each model, taken as one mesh, and looks at them from eight sides at six distances: how many triangles
are drawn where nothing may be off by more than one pixel of 1080 lines over 60 degrees, and how far off they are
found to be, from points that took no part in making them. Beside them levels by the errors that the simplifier
returns, and those of its own library, with its errors as they are and times the least factor at which a pixel is one.
Then triangles within three bounds beside a plain chain, and what flips while the eye trembles by 2 % of its distance.

--scenes measures what they leave of scenes instead, beside what is to be reached: of the castle in CULLET_DATA, of the
built-in city and plant over what is visible; and the times of small-object culling and of choosing.

The work is done by cullet-baker, as that of 'cullet simplify' is. Ends with exit code 1 where a bound is not kept.

Examples
  cullet bench lod                              of CULLET_DATA armadillo, buddha, castle and fandisk
  cullet bench lod --scene model.glb --points 10000000
  cullet bench lod --scenes                     the castle, the city, a plant and a forest
  cullet bench lod --json lod.json";

/// Arguments of `cullet bench lod`.
#[derive(Clone, Debug, Args)]
pub(crate) struct LodBenchArgs {
    /// A model, a file or a built-in scene; may be given many times [default: four of
    /// `CULLET_DATA`]
    #[arg(long, value_name = "SCENE")]
    pub scene: Vec<String>,
    /// Rows for scenes, with what levels and small-object culling leave of them, in place of those
    /// for models
    #[arg(long, conflicts_with_all = ["scene", "points"])]
    pub scenes: bool,
    /// Points from which levels are measured, at each distance
    #[arg(long, value_name = "N", default_value_t = 1_000_000, value_parser = clap::value_parser!(u32).range(1000..=100_000_000))]
    pub points: u32,
    /// Write the results as JSON; - is the standard output
    #[arg(long, value_name = "PATH", value_parser = cullet_command::parse::output)]
    pub json: Option<PathBuf>,
}
