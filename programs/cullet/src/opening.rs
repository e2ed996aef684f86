//! A view and its culling from outside, cut open where something covers what the view sees.

use cullet::bounds::Plane;
use cullet::{Scene, View, Visible};
use cullet_draw::clip::{HalfSpace, Region};
use cullet_draw::{Opening, Outlook, Picture};

/// Draws the scene as it is, or cut open above the eye; then with the height of the cut. `result`
/// has reasons and triangles.
pub(crate) fn kinds(
    scene: &Scene,
    view: &View,
    result: &Visible,
    size: [u32; 2],
) -> (Picture, Option<f64>) {
    let Outlook { from, cut_at } = Outlook::new(scene, view, size);
    let opened = cut_at.and_then(|height| {
        let plane = HalfSpace::try_from(Plane::new([0.0, 1.0, 0.0], height)).ok()?;
        let [x, y, z, w] = view.eye();
        let eye = (w != 0.0).then_some([x, y, z]);
        Opening::new(scene, Region::new([plane]).ok()?, false, eye, size)
    });
    match opened {
        Some(opening) => (opening.draw(scene, view, result), cut_at),
        None => (cullet_draw::kinds_of(scene, view, result, &from), None),
    }
}
