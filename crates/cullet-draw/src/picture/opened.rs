//! A scene cut open: as a section drawing, or with what became of everything in a view.

use std::borrow::Cow;

use cullet::{Handle, Scene, View, Visible};
use glam::DVec3;

use super::Picture;
use super::frozen::{FrozenView, from_far};
use super::kinds::explain;
use super::map::Fate;
use super::outside::{draw_frustum, from_outside};
use super::palette::{INK, mix};
use super::shaded::{irradiance, light_through, linear};
use super::space::Surfaces;
use crate::frame::{Frame, PixelId};

/// How much of its light a cut face keeps where its colour says what became of it: less, so that a section
/// reads as one.
const CUT_LIGHT: f64 = 0.42;
/// The brightest that a surface is drawn: white ones would lose their shading in the light.
const BRIGHTEST: f32 = 0.52;
/// From one line of the hatching to the next, and how thick a line is, in halves of a pixel.
const HATCH: [i64; 2] = [17, 4];
/// The background, from the top of the picture to its bottom.
const BACKDROP: [[u8; 3]; 2] = [[0xF1, 0xF3, 0xF5], [0xCB, 0xD1, 0xD8]];

/// Scene that was cut open, with the origin of its instances and triangles.
#[derive(Clone, Copy, Debug)]
pub struct OpenedScene<'a> {
    /// The scene after the cut.
    pub scene: &'a Scene,
    /// For each instance of it, by the index of its handle, which instance of the whole scene it is of.
    pub origin: &'a [Handle],
    /// For each mesh of it, which original triangle of the whole mesh each of its original triangles is of;
    /// none for a mesh that is whole, and a number beyond all triangles for a cut face.
    pub triangles: &'a [Vec<u32>],
    /// The material of cut faces.
    pub cut_material: u32,
}

/// Draws what is left of a scene that was cut open as a section drawing: lit, without haze, its cut faces
/// outlined and hatched, each instance's the other way than that before it.
///
/// `frame` must be of `view`, at scale 2 ([`RenderOptions::scale`](crate::RenderOptions::scale)); the picture has half its size.
/// `material_colors` are as for [`shaded`](super::shaded); ones too bright to show their shading are toned
/// down. Blended triangles are not drawn. Cost: some 0.3 µs a pixel of the frame.
#[must_use]
pub fn cut_away(
    scene: &Scene,
    frame: &Frame,
    view: &View,
    material_colors: &[[f32; 4]],
    cut_material: u32,
) -> Picture {
    let surfaces = Surfaces::new(scene, &frame.ids);
    let color = |id: PixelId| {
        let given = material_colors.get(surfaces.part(id).material as usize);
        let [r, g, b, _] = given.copied().unwrap_or([BRIGHTEST; 4]);
        let most = r.max(g).max(b);
        // All alike, so that the hue stays.
        let tone = if most > BRIGHTEST { BRIGHTEST / most } else { 1.0 };
        let color = DVec3::new(f64::from(r * tone), f64::from(g * tone), f64::from(b * tone));
        if surfaces.part(id).material != cut_material {
            return color;
        }
        // A section reads by its colour: as light whichever way it faces.
        let light = irradiance(surfaces.normal(id), 1.0).element_sum() / 3.0;
        color * (1.0 / light).clamp(0.7, 2.5)
    };
    let mut picture = light_through(0.0, scene, frame, view, &surfaces, color);
    finish(&mut picture, frame, &surfaces, cut_material);
    picture.halved()
}

/// Puts the backdrop behind everything, and hatching and outlines onto cut faces; the picture is of the
/// frame's size.
fn finish(picture: &mut Picture, frame: &Frame, surfaces: &Surfaces<'_>, cut_material: u32) {
    let (width, height) = (frame.width as usize, frame.height as usize);
    // The slot of the cut face on each pixel.
    let mut last = (PixelId::NONE, u32::MAX);
    let cuts: Vec<u32> = (frame.ids.iter())
        .map(|&id| {
            if id != last.0 {
                let is_cut = id != PixelId::NONE && surfaces.part(id).material == cut_material;
                last = (id, if is_cut { id.slot } else { u32::MAX });
            }
            last.1
        })
        .collect();
    for y in 0..height {
        let share = y as f64 / height.max(2) as f64;
        let backdrop = mix(BACKDROP[0], BACKDROP[1], share);
        for x in 0..width {
            let at = y * width + x;
            let pixel = [x as i64, y as i64];
            if frame.ids[at] == PixelId::NONE {
                picture.fill(pixel, [1, 1], backdrop, 1.0);
            }
            let own = cuts[at];
            // Of each border the pixels above and to the left: thin walls keep room for their colour.
            let differs = |dx: usize, dy: usize| {
                let (x, y) = (x + dx, y + dy);
                x < width && y < height && cuts[y * width + x] != own
            };
            if differs(2, 0) || differs(0, 2) {
                picture.fill(pixel, [1, 1], INK, 0.85);
            } else if own != u32::MAX {
                let [across, down] = pixel;
                let along = if own.is_multiple_of(2) { across + down } else { across - down };
                if along.rem_euclid(HATCH[0]) < HATCH[1] {
                    picture.fill(pixel, [1, 1], INK, 0.38);
                }
            }
        }
    }
}

/// Draws a scene cut open, seen from `from`: each triangle in the colour of its fate in `view`, cut
/// faces in that of their instance, darker, with the frustum, and a legend where it would cover less than a
/// quarter. The counts of the legend are those of the whole scene.
///
/// `visible` must be of the whole `scene` and have reasons, and triangles if single ones shall be told apart.
/// An instance of `left` that is no more in the whole scene is drawn as dropped. Cost: two frames, of `scene` and of
/// `left`, some 0.3 µs a pixel, and as much for a triangle of an instance that is kept.
#[must_use]
pub fn opened(
    scene: &Scene,
    view: &View,
    visible: &Visible,
    left: &OpenedScene<'_>,
    from: &View,
) -> Picture {
    let frozen = FrozenView::new(scene, Cow::Borrowed(view), Cow::Borrowed(visible));
    let fates = frozen.fates();
    let from = from_outside(from);
    let frame = from_far(left.scene, &from);
    let surfaces = Surfaces::new(left.scene, &frame.ids);
    let fate = |id: PixelId| {
        let handle = left.scene.handle(id.slot)?;
        let slot = scene.slot(*left.origin.get(handle.index as usize)?).ok()?;
        let cut =
            left.triangles.get(left.scene.mesh_id(id.slot) as usize).filter(|c| !c.is_empty());
        let triangle = cut.map_or(Some(id.triangle), |c| c.get(id.triangle as usize).copied());
        // A cut face belongs to no triangle.
        let triangle = triangle.filter(|t| *t < scene.mesh(slot).triangle_count());
        Some(triangle.map_or(fates.of_slot(slot), |triangle| fates.of(PixelId { slot, triangle })))
    };
    let color = |id: PixelId| {
        let [r, g, b] = fate(id).unwrap_or(Fate::Dropped(None)).color().map(linear);
        let cut = surfaces.part(id).material == left.cut_material;
        DVec3::new(r, g, b) * if cut { CUT_LIGHT } else { 1.0 }
    };
    // Colours carry the meaning: no haze.
    let mut picture = light_through(0.0, left.scene, &frame, &from, &surfaces, color);
    finish(&mut picture, &frame, &surfaces, left.cut_material);
    let mut picture = picture.halved();
    let lines = draw_frustum(&mut picture, scene, view, &from, &frame);
    explain(&mut picture, &frame, &lines, &fates.counts());
    picture
}
