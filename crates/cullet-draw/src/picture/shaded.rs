//! The scene as a pleasant flat-shaded picture.

use cullet::{Scene, View};
use glam::DVec3;
use rayon::prelude::*;

use super::Picture;
use super::space::{Space, Surfaces, pixel_centre};
use crate::frame::{Frame, PixelId};

/// Where the sun stands.
const SUN: DVec3 = DVec3::new(0.46, 0.76, 0.46);
/// How many places around a pixel are asked whether they stand above its surface.
const AMBIENT_SAMPLES: usize = 10;
/// How far those places lie, as a share of the frame's height.
const AMBIENT_RADIUS: f64 = 0.035;

/// A picture of a frame: flat shading under a sun and a sky, corners darkened, a little haze, and
/// edges between instances.
///
/// `frame` must be of `view`, at any scale ([`RenderOptions::scale`](crate::RenderOptions::scale) of 2
/// and [`Picture::halved`] give smooth edges). `material_colors` are linear colours by the number of
/// the material; materials beyond them get a colour of their own, from their number. Blended triangles
/// are not drawn.
///
/// Cost: some 0.2 µs a pixel.
#[must_use]
pub fn shaded(
    scene: &Scene,
    frame: &Frame,
    view: &View,
    material_colors: &[[f32; 4]],
) -> Picture {
    let surfaces = Surfaces::new(scene, &frame.ids);
    let color = |id: PixelId| {
        let part = surfaces.part(id);
        let given = material_colors.get(part.material as usize);
        given.map_or_else(
            || default_color(part.material.wrapping_add(surfaces.mesh(id).unwrap_or(0))),
            |c| DVec3::new(f64::from(c[0]), f64::from(c[1]), f64::from(c[2])),
        )
    };
    light(scene, frame, view, &surfaces, color)
}

/// Lights a frame whose surfaces have these linear colours.
pub(crate) fn light(
    scene: &Scene,
    frame: &Frame,
    view: &View,
    surfaces: &Surfaces,
    color: impl Fn(PixelId) -> DVec3 + Sync,
) -> Picture {
    let space = Space::new(view);
    let (width, height) = (frame.width as usize, frame.height as usize);
    let size = [frame.width, frame.height];
    let mut picture = Picture::new(frame.width, frame.height, [0; 3]);
    if width == 0 || height == 0 {
        return picture;
    }
    let points: Vec<DVec3> = (0..width * height)
        .into_par_iter()
        .map(|at| {
            let [x, y] = pixel_centre((at % width) as u32, (at / width) as u32, size);
            space.point(x, y, frame.depth[at])
        })
        .collect();
    // Haze grows over the size of the scene.
    let extent = scene.extent();
    let reach = if extent.is_empty() { 1.0 } else { DVec3::from(extent.half_extent()).length() };
    let rows = picture.rgb.par_chunks_mut(width * 3).enumerate();
    rows.for_each(|(y, row)| {
        let mut last = (PixelId::NONE, DVec3::ZERO, DVec3::ZERO);
        for x in 0..width {
            let at = y * width + x;
            let id = frame.ids[at];
            let [ndc_x, ndc_y] = pixel_centre(x as u32, y as u32, size);
            let (from, sight) = space.ray(ndc_x, ndc_y);
            let lit = if id == PixelId::NONE {
                sky(sight)
            } else {
                if id != last.0 {
                    last = (id, surfaces.normal(id), color(id));
                }
                let (_, n, albedo) = last;
                let p = points[at];
                // The side that is seen.
                let n = if n.dot(space.towards_eye(p)) < 0.0 { -n } else { n };
                let open = ambient(&points, frame, [x, y], n);
                let seen = albedo * irradiance(n, open) * edge(frame, [x, y]);
                let haze = 0.5 * (1.0 - (-(p - from).length() / (2.2 * reach)).exp());
                seen.lerp(sky(DVec3::new(sight.x, sight.y.max(0.0) * 0.3, sight.z)), haze)
            };
            for (c, v) in lit.to_array().into_iter().enumerate() {
                row[x * 3 + c] = srgb(v);
            }
        }
    });
    picture
}

/// A colour for a material that has none: pale, of any hue.
pub(crate) fn default_color(n: u32) -> DVec3 {
    // Hues a golden angle apart are never alike among few.
    let hue = f64::from(n) * 2.399_963;
    let turn = |k: f64| 0.5 + 0.5 * (hue + k * std::f64::consts::TAU / 3.0).cos();
    DVec3::new(turn(0.0), turn(1.0), turn(2.0)) * 0.28 + DVec3::splat(0.42)
}

/// Light on a surface: sun, and a sky above a paler ground.
fn irradiance(n: DVec3, open: f64) -> DVec3 {
    let up = n.y * 0.5 + 0.5;
    let sky = DVec3::new(0.40, 0.44, 0.55);
    let ground = DVec3::new(0.26, 0.23, 0.20);
    let sun = DVec3::new(1.0, 0.93, 0.80) * n.dot(SUN.normalize()).max(0.0);
    ground.lerp(sky, up) * open + sun * 0.78 * (0.5 + 0.5 * open)
}

/// How open the surroundings of a pixel are, 0 to 1: what stands above its surface nearby shades it,
/// as seen in the depth of the frame alone.
fn ambient(points: &[DVec3], frame: &Frame, [x, y]: [usize; 2], n: DVec3) -> f64 {
    let (width, height) = (frame.width as usize, frame.height as usize);
    let p = points[y * width + x];
    let radius = AMBIENT_RADIUS * height as f64;
    // The size of a pixel at this distance, from a neighbour on about the same surface.
    let right = points[y * width + if x + 1 < width { x + 1 } else { x.saturating_sub(1) }];
    let below = points[if y + 1 < height { y + 1 } else { y.saturating_sub(1) } * width + x];
    let world = radius * (right - p).length().min((below - p).length());
    // Each pixel of a 4 × 4 square turns its places by another angle.
    let turn = ((x % 4) * 4 + (y % 4)) as f64 * 0.392_7;
    let mut shade = 0.0;
    for k in 0..AMBIENT_SAMPLES {
        let r = radius * ((k as f64 + 0.5) / AMBIENT_SAMPLES as f64);
        let (s, c) = (turn + k as f64 * 2.399_963).sin_cos();
        let (sx, sy) = (x as f64 + c * r, y as f64 + s * r);
        if !(sx >= 0.0 && sy >= 0.0 && sx < width as f64 && sy < height as f64) {
            continue;
        }
        let at = sy as usize * width + sx as usize;
        if frame.ids[at] == PixelId::NONE {
            continue;
        }
        let v = points[at] - p;
        let length = v.length();
        if length > 0.0 {
            // What is much farther than the radius is not near at all.
            let near = 1.0 / (1.0 + (length / (3.0 * world)).powi(2));
            shade += (n.dot(v) / length - 0.08).max(0.0) * near;
        }
    }
    (1.0 - 1.9 * shade / AMBIENT_SAMPLES as f64).max(0.12)
}

/// Darkens a pixel whose neighbour to the right or below belongs to another instance.
fn edge(frame: &Frame, [x, y]: [usize; 2]) -> f64 {
    let (width, height) = (frame.width as usize, frame.height as usize);
    let at = y * width + x;
    let own = frame.ids[at].slot;
    let other = |x: usize, y: usize| {
        x < width && y < height && frame.ids[y * width + x].slot != own
    };
    if other(x + 1, y) || other(x, y + 1) { 0.72 } else { 1.0 }
}

/// The colour of the sky in a direction.
fn sky(direction: DVec3) -> DVec3 {
    let horizon = DVec3::new(0.80, 0.85, 0.88);
    if direction.y < 0.0 {
        return horizon.lerp(DVec3::new(0.55, 0.56, 0.55), (-direction.y * 2.0).min(1.0));
    }
    horizon.lerp(DVec3::new(0.26, 0.46, 0.75), direction.y.min(1.0).sqrt() * 0.9)
}

/// A linear value as a byte in sRGB.
pub(crate) fn srgb(v: f64) -> u8 {
    let v = if v > 0.0 { v.min(1.0) } else { 0.0 };
    let s = if v <= 0.003_130_8 { v * 12.92 } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
    (s * 255.0).round() as u8
}

/// The linear value of a byte in sRGB.
pub(crate) fn linear(v: u8) -> f64 {
    let s = f64::from(v) / 255.0;
    if s <= 0.040_45 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) }
}
