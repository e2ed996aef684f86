//! The command line of `cullet simplify`.

use std::path::PathBuf;

use clap::Args;

use cullet_command::args::SceneArgs;
use cullet_command::parse;

/// End of `cullet simplify --help`.
pub(crate) const SIMPLIFY_HELP: &str = "\
--error is a share of the bounding radius of the whole scene, as it stands. No point of the result is farther
than that from the original, nor of the original from the result, but for less than one in a thousand, which
are hardly farther. That is measured while it is made, and then from a million other points each way, which
the figures are of.

Each mesh is simplified once, for its largest instance. Vertices keep their places; normals, texture
coordinates and colours go along. Where several of them meet at one position, the seam is kept, which costs
triangles, in models of flat shading nearly all; --weld joins them.

--pixels is for one eye, D radii in front of the middle of the scene, on the side of +Z: what is far from it may
be farther off. A pixel is one of 1080 lines over 60 degrees. Meshes of more than 5,000 triangles are cut from a
hierarchy of clusters, which meet without cracks; smaller ones are simplified for the nearest of them.

The work is done by a program of its own, cullet-baker. It is looked for beside this program, then in PATH; a
'cullet' that cargo built in the folder of its source builds it at the first call.

Examples
  cullet simplify model.glb --error 0.001 -o small.glb
  cullet simplify scan.ply --error 0.01 -o coarse.obj
  cullet simplify part.stl --error 0.0005 --json -          only the figures
  cullet simplify flat.glb --error 0.003 --weld -o small.ply
  cullet simplify castle.glb --pixels 1 --distance 5 -o from-afar.glb";

/// Arguments of `cullet simplify`.
#[derive(Clone, Debug, Args)]
pub struct SimplifyArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// How far the result may deviate, as a share of the bounding radius
    #[arg(long, value_name = "E", value_parser = parse::radii, allow_hyphen_values = true, required_unless_present = "pixels", conflicts_with = "pixels")]
    pub error: Option<f64>,
    /// How far the result may deviate for one eye, in pixels
    #[arg(long, value_name = "E", value_parser = parse::pixels, allow_hyphen_values = true, requires = "distance")]
    pub pixels: Option<f64>,
    /// How far the eye is from the middle of the scene, in bounding radii
    #[arg(long, value_name = "D", value_parser = parse::distance, allow_hyphen_values = true, requires = "pixels")]
    pub distance: Option<f64>,
    /// Join vertices at one position even where normals, texture coordinates or colours differ: of
    /// these, the first stay, but for normals, which are left out
    #[arg(long)]
    pub weld: bool,
    /// Points from which the result is measured, each way
    #[arg(long, value_name = "N", default_value_t = 1_000_000, value_parser = clap::value_parser!(u32).range(1000..=100_000_000))]
    pub samples: u32,
    /// The file to write: .glb, .ply, .obj or .stl
    #[arg(long, short, value_name = "PATH", value_parser = cullet_command::parse::output)]
    pub out: Option<PathBuf>,
    /// Write the figures as JSON; - is the standard output
    #[arg(long, value_name = "PATH", value_parser = cullet_command::parse::output)]
    pub json: Option<PathBuf>,
}
