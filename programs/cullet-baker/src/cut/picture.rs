//! A picture of what is left, seen from where it was opened.

use cullet::bounds::Aabb;
use cullet_command::exit::Failure;
use cullet_command::inputs;
use cullet_cut::ModelOptions;
use cullet_draw::{Picture, RenderOptions, Selection};
use cullet_io::Model;

use super::standpoint;

/// Draws. All surfaces become two-sided: an open cut shows insides.
pub(super) fn draw(
    model: &mut Model,
    whole: &Aabb,
    options: &ModelOptions<'_>,
    cap_material: u32,
    eye: Option<([f64; 3], [f64; 3])>,
    size: [u32; 2],
) -> Result<Picture, Failure> {
    model.scene.edit_meshes(|_, m| m.set_two_sided(true));
    let view = standpoint::stand(model, whole, options, eye, size)?;
    let scene = &model.scene;
    let options = RenderOptions { scale: 2, ..RenderOptions::default() };
    let frame = cullet_draw::render(scene, &view, Selection::All, &options);
    let colors = inputs::colors(model);
    Ok(cullet_draw::cut_away(scene, &frame, &view, &colors, cap_material))
}
