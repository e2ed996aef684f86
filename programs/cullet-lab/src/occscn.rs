//! Benchmark scenes for occlusion culling, made from models.

use cullet::{Depth, View};
use cullet_command::exit::Failure;
use cullet_io::{MatrixView, Model};
use cullet_maps::occscn::{MakeOptions, Objects, Occscn};
use cullet_scenes::paths::{self, Overrides, PathSpec};

/// Triangles of a mesh and boxes to be tested where nobody says another number: those of published
/// figures.
const CLUSTER: u32 = 128;
const BOXES: u32 = 20_000;
/// Distance of the near plane, by the scene's diagonal.
const NEAR: f64 = 1e-3;
/// The benchmark scene of a built-in scene or a file, as `cullet occscn` makes it where nothing is
/// said.
///
/// # Errors
/// If it cannot be made of this model.
pub fn of_model(model: &Model) -> Result<Occscn, Failure> {
    let views = views(model, None, 32, [1280, 720], &Overrides::default())?;
    let origin = Occscn::local_origin(model);
    make(model, &views, &MakeOptions { origin, ..default_options(model) })
}

/// The same with only what has one of these names for occluders, if there are names, and in the
/// space of the model's scene, however far from zero.
///
/// # Errors
/// As [`of_model`].
pub fn with_occluders(model: &Model, names: &[String]) -> Result<Occscn, Failure> {
    let views = views(model, None, 32, [1280, 720], &Overrides::default())?;
    let mut options = default_options(model);
    if !names.is_empty() {
        options.occluders = names.to_vec();
    }
    make(model, &views, &options)
}

/// Makes a scene; an error names the model.
///
/// # Errors
/// If it cannot be made of this model.
pub fn make(model: &Model, views: &[MatrixView], options: &MakeOptions) -> Result<Occscn, Failure> {
    Occscn::make(model, views, options).map_err(|e| Failure::input(format!("{}: {e}", model.name)))
}

/// How a model is taken where nothing is said.
#[must_use]
pub fn default_options(model: &Model) -> MakeOptions {
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

/// The views of the path, if one is given; else the scene's own, else its cameras, else a walk.
///
/// # Errors
/// If the path is none of this model, or a view is orthographic.
pub fn views(
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
        // Nearer planes fit too, but would leave 32-bit depths of far surfaces nothing to differ
        // by.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_city_is_buildings_that_hide_objects() {
        for (text, meshes, triangles) in [
            ("city:cells=4,objects=50,ground=0", 16, 192),
            ("city:cells=4,objects=50,sub=3", 17, 1730),
        ] {
            let model = cullet_scenes::build(text).unwrap();
            let scene = of_model(&model).unwrap();
            assert_eq!(scene.meshes.len(), meshes, "{text}");
            assert_eq!(scene.triangles.len(), triangles, "{text}");
            assert_eq!((scene.objects.len(), scene.cameras.len()), (50, 32), "{text}");
            assert!(scene.cameras.iter().all(|c| c.near == 0.5), "{text}");
        }
    }
}
