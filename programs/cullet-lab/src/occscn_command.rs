//! `cullet occscn`: benchmark scenes for occlusion culling, as files that other programs read too.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::occscn::{default_options, make, views};
use clap::Args;
use cullet_command::args::SceneArgs;
use cullet_command::console::{Console, count, grouped};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::{inputs, parse};
use cullet_maps::occscn::{Objects, Occscn};
use cullet_scenes::paths::Overrides;

/// End of `cullet occscn --help`.
pub(crate) const HELP: &str = "\
Writes an OCCSCN01 file: triangles that occlude, in world space and in meshes; boxes to test;
views as matrices. cullet bench occlusion --scene FILE measures it.

Of a city, the buildings and the ground occlude, each a mesh of its own; all else is boxes, seen from the
city's own cameras. Of any other model all that is opaque occludes, cut into meshes of at most 128
triangles at medians; the boxes are 20000 random ones, and the views walk through it. A scene that says
what occludes (an OCCSCN01 file) is used as it says.

The file has 32-bit numbers: of a scene far from zero all is counted from a place nearby, which a note says.

Examples
  cullet occscn city:ground=0 -o city.bin            120000 triangles, 100000 boxes, 32 views
  cullet occscn city:ground=0,sub=3 -o dense.bin     1080000 triangles
  cullet occscn city -o ground.bin                   with the ground
  cullet occscn castle.glb --occluders castleLargeOccluders --occluders ground -o castle.bin
  cullet occscn sponza.ply --up z -o sponza.bin";

/// `cullet occscn`
#[derive(Debug, Args)]
pub struct OccscnArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// The file to write
    #[arg(long, short, value_name = "PATH", value_parser = cullet_command::parse::output)]
    out: PathBuf,
    /// Instances that occlude: those with this in their name, their mesh's, or that of a node above
    /// them; may be given several times
    #[arg(long, value_name = "NAME")]
    occluders: Vec<String>,
    /// Most triangles of a mesh, or 'none' for one mesh an instance
    #[arg(long, value_name = "N|none", value_parser = cluster)]
    cluster: Option<Cluster>,
    /// Boxes to test: so many random ones, or 'rest', the bounds of all that does not occlude
    #[arg(long, value_name = "N|rest", value_parser = objects)]
    objects: Option<Objects>,
    /// Where from: as of cullet report [default: the scene's own views or cameras, else walk]
    #[arg(long, value_name = "PATH")]
    path: Option<String>,
    /// Distance of the near plane [default: the camera's own, else a thousandth of the scene's
    /// diagonal]
    #[arg(long, value_name = "DISTANCE", value_parser = parse::distance)]
    near: Option<f64>,
    /// How many views along the path
    #[arg(long, value_name = "N", default_value_t = 32, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    views: u32,
    /// Pixels of a view, of which only the ratio is kept
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = parse::size)]
    size: [u32; 2],
    /// Seed of the random boxes and of the path
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// Meshes of at most so many triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Cluster(Option<u32>);

/// More would take more memory than the format's 32 bits are meant for.
const MOST_BOXES: u32 = 100_000_000;

fn cluster(text: &str) -> Result<Cluster, String> {
    match text.parse() {
        _ if text == "none" => Ok(Cluster(None)),
        Ok(n) if n > 0 => Ok(Cluster(Some(n))),
        _ => {
            Err(format!("'{text}' is neither a number of triangles, 1 or more, nor none; try 128"))
        }
    }
}

fn objects(text: &str) -> Result<Objects, String> {
    match text.parse() {
        _ if text == "rest" => Ok(Objects::Rest),
        Ok(n) if n <= MOST_BOXES => Ok(Objects::Random(n)),
        _ => Err(format!(
            "'{text}' is neither a number of boxes, up to {MOST_BOXES}, nor rest; try 20000"
        )),
    }
}

/// Runs the command.
pub(crate) fn run(args: &OccscnArgs, console: &Console) -> Outcome {
    let model = inputs::load(&args.scene, console)?;
    let path = args.path.as_deref().map(str::parse).transpose().map_err(Failure::usage)?;
    let overrides = Overrides { seed: args.seed, near: args.near, ..Overrides::default() };
    let views = views(&model, path, args.views as usize, args.size, &overrides)?;
    let mut options = default_options(&model);
    options.seed = args.seed;
    if !args.occluders.is_empty() {
        options.occluders.clone_from(&args.occluders);
    }
    options.objects = args.objects.unwrap_or(options.objects);
    if let Some(Cluster(most)) = args.cluster {
        options.cluster = most;
    }
    options.origin = Occscn::local_origin(&model);
    let scene = make(&model, &views, &options)?;
    write(&scene, &args.out)?;
    let out = args.out.display();
    if options.origin != [0.0; 3] {
        let [x, y, z] = options.origin;
        console.note(format!(
            "note: {out}: 32-bit numbers are too coarse so far from zero: positions, boxes and views are counted from ({x}, {y}, {z})"
        ));
    }
    let (all, written) = (model.scene.triangle_count(), scene.triangles.len() as u64);
    if written < all {
        console.note(format!(
            "note: {out}: {} of {} no triangle that occludes: see-through, or not of the occluders{}",
            grouped(all - written),
            count(all, "triangle is", "triangles are"),
            match options.objects {
                Objects::Rest => "; its bounds are a box",
                Objects::Random(_) => "; left out",
            }
        ));
    }
    console.line(format!(
        "{}: {} in {}, {}, {}",
        args.out.display(),
        count(scene.triangles.len() as u64, "triangle", "triangles"),
        count(scene.meshes.len() as u64, "mesh", "meshes"),
        count(scene.objects.len() as u64, "box", "boxes"),
        count(scene.cameras.len() as u64, "view", "views")
    ));
    Ok(Exit::Fine)
}

fn write(scene: &Occscn, path: &Path) -> Result<(), Failure> {
    let fail = |e: std::io::Error| Failure::write(path, &e);
    let mut out = BufWriter::with_capacity(1 << 16, File::create(path).map_err(fail)?);
    scene.write(&mut out).and_then(|()| out.flush()).map_err(fail)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_words_are_taken() {
        assert_eq!(cluster("none"), Ok(Cluster(None)));
        assert_eq!(cluster("128"), Ok(Cluster(Some(128))));
        assert_eq!(objects("rest"), Ok(Objects::Rest));
        assert_eq!(objects("20000"), Ok(Objects::Random(20_000)));
        assert!(cluster("0").is_err() && cluster("-1").is_err() && cluster("all").is_err());
        assert!(objects("4000000000").is_err() && objects("all").is_err());
    }
}
