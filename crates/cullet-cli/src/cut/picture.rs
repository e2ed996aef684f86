//! A picture of what is left, seen from where it was opened.

use cullet::View;
use cullet::bounds::Aabb;
use cullet::clip::cut::Keep;
use cullet_draw::{Picture, RenderOptions, Selection};
use cullet_io::{Model, paths};
use glam::DVec3;

use super::apply::Settings;
use crate::drawing;
use crate::exit::Failure;

/// Draws. All surfaces become two-sided: an open cut shows insides.
pub(super) fn draw(
    model: &mut Model,
    whole: &Aabb,
    settings: &Settings<'_>,
    eye: Option<([f64; 3], [f64; 3])>,
    size: [u32; 2],
) -> Result<Picture, Failure> {
    model.scene.meshes_mut().for_each(|m| m.set_two_sided(true));
    let ([eye, target], overrides) = (
        eye.map_or_else(|| stand(model, whole, settings), |(eye, target)| [eye, target]),
        paths::Overrides { fov_degrees: Some(35.0), ..paths::Overrides::default() },
    );
    let camera = paths::look_at(model, eye, target, size, &overrides).map_err(Failure::usage)?;
    let view = View::new(&camera, overrides.depth, size).map_err(Failure::usage)?;
    let scene = &model.scene;
    let options = RenderOptions { scale: 2, ..RenderOptions::default() };
    let frame = cullet_draw::render(scene, &view, Selection::All, &options);
    Ok(cullet_draw::shaded(scene, &frame, &view, &drawing::colors(model)).halved())
}

/// Above and to the side of the cut, far enough for all that is left.
fn stand(model: &Model, whole: &Aabb, settings: &Settings<'_>) -> [[f64; 3]; 2] {
    let left = model.scene.extent();
    let shown = if left.is_empty() { whole } else { &left };
    let centre = DVec3::from(shown.center());
    let reach = DVec3::from(shown.half_extent()).length().max(1e-6);
    // A region's faces point all ways; of a box the corner towards +X, +Y and +Z is opened.
    let mut open = DVec3::ZERO;
    if let [plane] = settings.planes {
        open = DVec3::from(plane.normal).normalize_or_zero();
        if settings.keep == Keep::Outside {
            open = -open;
        }
    }
    let towards = if open.y.abs() > 0.8 {
        open * 0.9 + DVec3::new(0.35, 0.0, 0.75)
    } else {
        let side = open.cross(DVec3::Y).normalize_or(DVec3::X);
        open.try_normalize().unwrap_or(DVec3::Z) + DVec3::Y * 0.5 - side * 0.45
    };
    // Half of 35 degrees, with a little air around the sphere of the box.
    let distance = reach * 0.92 / (17.5f64.to_radians()).sin();
    let origin = DVec3::from(model.scene.origin());
    let target = centre + origin;
    [(target + towards.normalize() * distance).into(), target.into()]
}
