//! Where to stand before a model that was cut open, to look into it.

use cullet::View;
use cullet::bounds::Aabb;
use cullet_command::exit::Failure;
use cullet_cut::{Keep, ModelOptions};
use cullet_draw::clip::{HalfSpace, Region};
use cullet_io::Model;
use cullet_scenes::paths;
use glam::{DMat3, DVec3};

/// The vertical field of view: narrow, so that the cut keeps its shape.
const FOV_DEGREES: f64 = 35.0;

/// The view from a point to another; without, from where the model was opened.
pub(super) fn stand(
    model: &Model,
    whole: &Aabb,
    options: &ModelOptions<'_>,
    line: Option<([f64; 3], [f64; 3])>,
    size: [u32; 2],
) -> Result<View, Failure> {
    if let Some((eye, target)) = line {
        let overrides =
            paths::Overrides { fov_degrees: Some(FOV_DEGREES), ..paths::Overrides::default() };
        let camera =
            paths::look_at(model, eye, target, size, &overrides).map_err(Failure::usage)?;
        return View::new(&camera, overrides.depth, size).map_err(Failure::usage);
    }
    let sides = options.planes.iter().map(|&plane| HalfSpace::try_from(plane));
    let region = sides.collect::<Result<Vec<_>, _>>().and_then(Region::new);
    let region = region.map_err(Failure::usage)?;
    let outside = options.keep == Keep::Outside;
    let mut points = vertices(model);
    if points.is_empty() {
        points.extend(whole.corners().map(|p| DVec3::from(p.map(f64::from))));
    }
    cullet_draw::before_cut(&points, &region, outside, size)
        .ok_or_else(|| Failure::usage("there is nothing to look at; give --eye and --target"))
}

/// Every vertex of every instance in the world.
fn vertices(model: &Model) -> Vec<DVec3> {
    let mut vertices = Vec::new();
    for slot in model.scene.slots() {
        let t = model.scene.transform(slot);
        let linear = DMat3::from_cols_array_2d(&t.linear.map(|c| c.map(f64::from)));
        let place =
            |p: &[f32; 3]| linear * DVec3::from(p.map(f64::from)) + DVec3::from(t.translation);
        vertices.extend(model.scene.mesh(slot).positions().iter().map(place));
    }
    vertices
}
