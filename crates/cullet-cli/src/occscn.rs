//! `cullet occscn`: benchmark scenes for occlusion culling, as files that other programs read too.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use cullet::{Depth, View};
use cullet_io::occscn::{MakeOptions, Objects, Occscn};
use cullet_io::paths::{self, Overrides, PathSpec};
use cullet_io::{MatrixView, Model};

use crate::args::SceneArgs;
use crate::console::{Console, count};
use crate::exit::{Exit, Failure, Outcome};
use crate::{inputs, parse};

/// What `cullet occscn --help` ends with.
pub(crate) const HELP: &str = "\
Writes an OCCSCN01 file: triangles that occlude, in world space and in meshes; boxes that are asked for;
views as matrices. cullet bench occlusion --scene FILE measures it.

Of a city, the buildings and the ground occlude, each a mesh of its own; all else is boxes, seen from the
city's own cameras. Of any other model all that is opaque occludes, cut into meshes of at most 128
triangles at medians; the boxes are 20000 random ones, and the views walk through it. A scene that says
what occludes (an OCCSCN01 file) is taken at its word.

Examples
  cullet occscn city:ground=0 -o city.bin            120000 triangles, 100000 boxes, 32 views
  cullet occscn city:ground=0,sub=3 -o dense.bin     1080000 triangles
  cullet occscn city -o ground.bin                   with the ground
  cullet occscn castle.glb --occluders castleLargeOccluders --occluders ground -o castle.bin
  cullet occscn sponza.ply --up z -o sponza.bin";

/// `cullet occscn`
#[derive(Debug, Args)]
pub(crate) struct OccscnArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// The file to write
    #[arg(long, short, value_name = "PATH")]
    out: PathBuf,
    /// What occludes: instances with this in their name, their mesh's, or that of a node above them; may
    /// be given several times
    #[arg(long, value_name = "NAME")]
    occluders: Vec<String>,
    /// Most triangles of a mesh, or 'none' for one mesh an instance
    #[arg(long, value_name = "N|none", value_parser = cluster)]
    cluster: Option<Cluster>,
    /// What is asked for: so many random boxes, or 'rest', the bounds of all that does not occlude
    #[arg(long, value_name = "N|rest", value_parser = objects)]
    objects: Option<Objects>,
    /// Where from: as of cullet report [default: the scene's own views or cameras, else walk]
    #[arg(long, value_name = "PATH")]
    path: Option<String>,
    /// Distance of the near plane [default: the camera's own, else a thousandth of the scene's diagonal]
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

/// Triangles of a mesh and boxes asked for where nobody says another number: those of published figures.
const CLUSTER: u32 = 128;
const BOXES: u32 = 20_000;
/// Distance of the near plane, by the scene's diagonal.
const NEAR: f64 = 1e-3;
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
    let scene = make(&model, &views, &options)?;
    write(&scene, &args.out)?;
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

/// The benchmark scene of a built-in scene or a file, as `cullet occscn` makes it where nothing is said.
pub(crate) fn of_model(model: &Model) -> Result<Occscn, Failure> {
    with_occluders(model, &[])
}

/// The same with only what has one of these names for occluders, if there are names.
pub(crate) fn with_occluders(model: &Model, names: &[String]) -> Result<Occscn, Failure> {
    let views = views(model, None, 32, [1280, 720], &Overrides::default())?;
    let mut options = default_options(model);
    if !names.is_empty() {
        options.occluders = names.to_vec();
    }
    make(model, &views, &options)
}

fn make(model: &Model, views: &[MatrixView], options: &MakeOptions) -> Result<Occscn, Failure> {
    Occscn::make(model, views, options).map_err(|e| Failure::input(format!("{}: {e}", model.name)))
}

fn default_options(model: &Model) -> MakeOptions {
    let scene = &model.scene;
    let city = model.name == "city" || model.name.starts_with("city:");
    let says = scene.slots().any(|slot| scene.flags(slot).no_occlusion);
    match (city, says) {
        (true, _) => MakeOptions { occluders: city_occluders(model), ..MakeOptions::default() },
        (_, true) => MakeOptions::default(),
        _ => MakeOptions {
            cluster: Some(CLUSTER),
            objects: Objects::Random(BOXES),
            ..MakeOptions::default()
        },
    }
}

/// Names of what occludes in a city. One without ground has no such name to be found.
fn city_occluders(model: &Model) -> Vec<String> {
    let has = |name: &&str| model.mesh_names.iter().any(|m| m.contains(name));
    ["building", "ground"].iter().filter(|n| has(n)).map(ToString::to_string).collect()
}

/// The views asked for; else the scene's own, else its cameras, else a walk.
fn views(
    model: &Model,
    path: Option<PathSpec>,
    count: usize,
    size: [u32; 2],
    overrides: &Overrides,
) -> Result<Vec<MatrixView>, Failure> {
    let path = match path {
        Some(path) => path,
        None if !model.views.is_empty() => {
            return Ok(model.views.iter().take(count).cloned().collect());
        }
        None if !model.cameras.is_empty() => PathSpec::Camera("*".to_owned()),
        None => PathSpec::Walk,
    };
    let mut overrides = *overrides;
    let own = matches!(path, PathSpec::Camera(_) | PathSpec::File(_));
    if overrides.near.is_none() && !own {
        // Nearer planes fit too, but would leave 32-bit depths of far things nothing to differ by.
        let extent = model.scene.extent();
        let square = |k: usize| (f64::from(extent.max[k]) - f64::from(extent.min[k])).powi(2);
        let near = (0..3).map(square).sum::<f64>().sqrt() * NEAR;
        overrides.near = Some(near).filter(|n| n.is_finite() && *n > 0.0);
    }
    let cameras =
        paths::cameras(model, &path, count, size, &overrides).map_err(|e| match path {
            PathSpec::File(_) => Failure::input(e),
            _ => Failure::usage(e),
        })?;
    let view = |(i, c): (usize, &cullet::Camera)| {
        let view = View::new(c, Depth::Standard, size).map_err(Failure::usage)?;
        let [x, y, z, w] = view.eye();
        if w == 0.0 {
            return Err(Failure::usage(format!(
                "view {i} is orthographic, and a file of this format gives each eye a place; try \
                 --path walk"
            )));
        }
        Ok(MatrixView {
            name: format!("camera {i}"),
            clip_from_world: view.clip_from_world(),
            eye: [x, y, z],
            near: paths::range(&c.projection)[0],
        })
    };
    cameras.iter().enumerate().map(view).collect()
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

    #[test]
    fn a_city_is_buildings_that_hide_things() {
        for (text, meshes, triangles) in [
            ("city:cells=4,objects=50,ground=0", 16, 192),
            ("city:cells=4,objects=50,sub=3", 17, 1730),
        ] {
            let model = cullet_io::scenes::build(text).unwrap();
            let scene = of_model(&model).unwrap();
            assert_eq!(scene.meshes.len(), meshes, "{text}");
            assert_eq!(scene.triangles.len(), triangles, "{text}");
            assert_eq!((scene.objects.len(), scene.cameras.len()), (50, 32), "{text}");
            assert!(scene.cameras.iter().all(|c| c.near == 0.5), "{text}");
        }
    }
}
