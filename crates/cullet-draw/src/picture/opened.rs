//! A scene cut open, and in it what became of everything in a view.

use cullet::{CullFace, Handle, Scene, View, Visible};
use glam::DVec3;

use super::Picture;
use super::kinds::{draw_frustum, explain};
use super::map::{Fate, counts, fates};
use super::shaded::{light_through, linear};
use super::space::Surfaces;
use crate::frame::{PixelId, RenderOptions, Selection};
use crate::render::render;

/// How much of its light a cut face keeps: less, so that a section reads as one.
const CUT_LIGHT: f64 = 0.42;

/// What is left of a scene that was cut open.
#[derive(Clone, Copy, Debug)]
pub struct OpenedScene<'a> {
    /// What is left.
    pub scene: &'a Scene,
    /// For each instance of it, by the index of its handle, which instance of the whole scene it is of.
    pub origin: &'a [Handle],
    /// The material of cut faces.
    pub cut_material: u32,
}

/// Draws a scene cut open, seen from `from`: each instance in the colour of what became of it in `view`, cut
/// faces darker, with the frustum, and a legend where it would cover less than a quarter. The counts of the
/// legend are those of the whole scene.
///
/// `visible` must be of the whole `scene` and have reasons. What is left of an instance that is no more in
/// the whole scene is drawn as dropped. Cost: two frames, of the whole and of what is left, and some 0.3 µs a
/// pixel.
#[must_use]
pub fn opened(
    scene: &Scene,
    view: &View,
    visible: &Visible,
    left: &OpenedScene<'_>,
    from: &View,
) -> Picture {
    let seen = render(scene, view, Selection::All, &RenderOptions::default()).visible();
    let fates = fates(scene, visible, &seen);
    // Everything is shown, insides too: both sides, all layers.
    let mut from = from.clone();
    from.cull_face = CullFace::None;
    from.layers = u32::MAX;
    let options = RenderOptions { scale: 2, ..RenderOptions::default() };
    let frame = render(left.scene, &from, Selection::All, &options);
    let surfaces = Surfaces::new(left.scene, &frame.ids);
    let fate = |slot: u32| {
        let handle = left.scene.handle(slot)?;
        let whole = left.origin.get(handle.index as usize)?;
        fates.get(scene.slot(*whole).ok()? as usize).copied().flatten()
    };
    let color = |id: PixelId| {
        let [r, g, b] = fate(id.slot).unwrap_or(Fate::Dropped(None)).color().map(linear);
        let cut = surfaces.part(id).material == left.cut_material;
        DVec3::new(r, g, b) * if cut { CUT_LIGHT } else { 1.0 }
    };
    // Colours carry the meaning: no haze.
    let mut picture = light_through(0.0, left.scene, &frame, &from, &surfaces, color).halved();
    draw_frustum(&mut picture, scene, view, &from, &frame);
    explain(&mut picture, &counts(&fates));
    picture
}
