//! A scene cut open: as a section drawing, or with what became of everything in a view.

use std::borrow::Cow;

use cullet::bounds::Side;
use cullet::{Scene, View, Visible};
use glam::DVec3;

use super::Picture;
use super::frozen::FrozenView;
use super::kinds::explain;
use super::outside::{draw_frustum, from_outside};
use super::palette::{INK, mix};
use super::shaded::{irradiance, light_through, linear};
use super::space::{Surfaces, framing};
use crate::clip::{Clipper, HalfSpace, Region};
use crate::cut::{Cut, render_cut, to_world, world};
use crate::frame::{Frame, PixelId, RenderOptions};

/// How much of its light a cut face keeps where its colour says what became of it: less, so that a
/// section reads as one.
const CUT_LIGHT: f64 = 0.42;
/// The brightest that a surface is drawn: white ones would lose their shading in the light.
const BRIGHTEST: f32 = 0.52;
/// From one line of the hatching to the next, and how thick a line is, in halves of a pixel.
const HATCH: [i64; 2] = [17, 4];
/// The background, from the top of the picture to its bottom.
const BACKDROP: [[u8; 3]; 2] = [[0xF1, 0xF3, 0xF5], [0xCB, 0xD1, 0xD8]];

/// Draws what is left of a scene that was cut open as a section drawing: lit, without haze, its cut
/// faces outlined and hatched, each instance's the other way than that before it.
///
/// `frame` must be of `view`, at scale 2 ([`RenderOptions::scale`](crate::RenderOptions::scale));
/// the picture has half its size. `material_colors` are as for [`shaded`](fn@super::shaded); ones
/// too bright to show their shading are toned down. Blended triangles are not drawn. Cost: some 0.3
/// µs a pixel of the frame.
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
    let mut picture = light_through(0.0, scene, frame, view, &surfaces, &color);
    finish(&mut picture, frame, &|id| surfaces.part(id).material == cut_material);
    picture.halved()
}

/// Puts the backdrop behind everything, and hatching and outlines onto cut faces; the picture is of
/// the frame's size.
fn finish(picture: &mut Picture, frame: &Frame, is_cut: &dyn Fn(PixelId) -> bool) {
    let (width, height) = (frame.width as usize, frame.height as usize);
    // The slot of the cut face on each pixel.
    let mut last = (PixelId::NONE, u32::MAX);
    let cuts: Vec<u32> = (frame.ids.iter())
        .map(|&id| {
            if id != last.0 {
                let is_cut = id != PixelId::NONE && is_cut(id);
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
            // Of each border the pixels above and to the left: thin walls keep room for their
            // colour.
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

/// A scene that is cut open, and from where one looks into it.
#[derive(Clone, Debug)]
pub struct Opening {
    cut: Cut,
    from: View,
}

impl Opening {
    /// Opens a scene at the planes of a convex region of the world, of which the inside is left, or
    /// all that is outside, and stands before it for a picture of `size`. Closed meshes have cut
    /// faces there, unless they are around the point `hollow`: one looks into those. `None` if
    /// nothing of the scene is left.
    ///
    /// Cost: some 10 ns a vertex of what is left.
    #[must_use]
    pub fn new(
        scene: &Scene,
        region: Region<f64, 3>,
        outside: bool,
        hollow: Option<[f64; 3]>,
        size: [u32; 2],
    ) -> Option<Self> {
        let cut = Cut { region, outside, hollow };
        let from = before_cut(&left(scene, &cut), &cut.region, outside, size)?;
        Some(Self { cut, from })
    }

    /// Draws what is left: each triangle in the colour of its fate in `view`, cut faces in that of
    /// their instance, darker, with the frustum, and a legend where it would cover less than a
    /// quarter. The counts of the legend are those of the whole scene.
    ///
    /// `visible` must have reasons, and triangles if single ones shall be told apart. Cost: two
    /// frames, some 0.3 µs a pixel, and as much for a triangle of an instance that is kept.
    #[must_use]
    pub fn draw(&self, scene: &Scene, view: &View, visible: &Visible) -> Picture {
        let frozen = FrozenView::new(scene, Cow::Borrowed(view), Cow::Borrowed(visible));
        let fates = frozen.fates();
        let from = from_outside(&self.from);
        let options = RenderOptions { scale: 2, ..RenderOptions::default() };
        let frame = render_cut(scene, &from, &self.cut, &options);
        let normal = |side: &HalfSpace<f64, 3>| DVec3::from(side.normal()).normalize_or_zero();
        let normals = self.cut.region.sides().map(|(_, side)| normal(side)).collect();
        let surfaces = Surfaces::of_cut(scene, &frame.ids, normals);
        let is_cut = |id: PixelId| surfaces.cut_normal(id).is_some();
        let color = |id: PixelId| match is_cut(id) {
            true => DVec3::from(fates.of_slot(id.slot).color().map(linear)) * CUT_LIGHT,
            false => fates.color_of(id),
        };
        // Colours carry the meaning: no haze.
        let mut picture = light_through(0.0, scene, &frame, &from, &surfaces, &color);
        finish(&mut picture, &frame, &is_cut);
        let mut picture = picture.halved();
        let lines = draw_frustum(&mut picture, scene, view, &from, &frame);
        explain(&mut picture, &frame, &lines, &fates.counts());
        picture
    }
}

/// Points of the world that span what a cut leaves.
fn left(scene: &Scene, cut: &Cut) -> Vec<DVec3> {
    let whole = || vec![cut.region.clone()];
    // What is outside of a region is outside of some plane.
    let beyond = |(_, side): (usize, &HalfSpace<f64, 3>)| {
        let flipped = HalfSpace::new(side.normal().map(|v| -v), -side.d());
        Region::new(flipped.ok())
    };
    let parts = if cut.outside { cut.region.sides().flat_map(beyond).collect() } else { whole() };
    let (mut points, mut clipper) = (Vec::new(), Clipper::new());
    for slot in scene.slots() {
        let (side, mesh, to_world) =
            (cut.side(scene, slot), scene.mesh(slot), to_world(scene, slot));
        match side {
            Side::Outside => {}
            Side::Inside => {
                points.extend(mesh.bounds().corners().map(|c| DVec3::from(world(&to_world, c))));
            }
            Side::Straddling => {
                for corners in (0..mesh.triangle_count()).map(|t| mesh.corners(t)) {
                    let corners = corners.map(|c| world(&to_world, c));
                    for part in &parts {
                        points.extend(clipper.clip(part, &corners).iter().map(|&p| DVec3::from(p)));
                    }
                }
            }
        }
    }
    points
}

/// The vertical field of view from where one looks into a cut: narrow, so that it keeps its shape.
const FOV_DEGREES: f64 = 35.0;

/// Stands before what is left of a scene that was cut open at the planes of a region, so that all
/// of these points are in a picture of `size`: above and to the side of the cut. `outside` says
/// that what is outside of the region is left. `None` without points, and where their numbers make
/// no view.
#[must_use]
pub fn before_cut(
    points: &[DVec3],
    region: &Region<f64, 3>,
    outside: bool,
    size: [u32; 2],
) -> Option<View> {
    // A region's faces point all ways; of a box the corner towards +X, +Y and +Z is opened.
    let mut sides = region.sides();
    let open = match (sides.next(), sides.next()) {
        (Some((_, side)), None) => {
            DVec3::from(side.normal()).normalize_or_zero() * if outside { -1.0 } else { 1.0 }
        }
        _ => DVec3::ZERO,
    };
    let towards = if open.y.abs() > 0.8 {
        // From the longer side, which then lies along the picture's width.
        let low = points.iter().copied().reduce(DVec3::min)?;
        let half = points.iter().copied().reduce(DVec3::max)? - low;
        let long = if half.x >= half.z { [0.28, 0.75] } else { [0.75, 0.28] };
        open * 1.1 + DVec3::new(long[0], 0.0, long[1])
    } else if open == DVec3::ZERO {
        DVec3::new(0.6, 0.6, 0.8)
    } else {
        let side = open.cross(DVec3::Y).normalize_or(DVec3::X);
        open + DVec3::Y * 0.5 - side * 0.45
    };
    framing(points, towards, FOV_DEGREES.to_radians(), size)
}
