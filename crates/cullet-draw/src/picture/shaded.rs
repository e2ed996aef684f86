//! The scene as a pleasant flat-shaded picture.

use std::f64::consts::FRAC_PI_8;

use cullet::bounds::Aabb;
use cullet::{Scene, View, Visible};
use glam::DVec3;

use super::Picture;
use super::outside::extent;
use super::palette;
use super::space::{Space, Surfaces, pixel_centre};
use crate::frame::{Frame, PixelId, RenderOptions, Selection};
use crate::parallel;
use crate::render::render;

/// Where the sun stands.
const SUN: DVec3 = DVec3::new(0.62, 0.66, 0.42);
/// How many places around a pixel are tested for standing above its surface.
const AMBIENT_SAMPLES: usize = 10;
/// How far those places lie, as a share of the frame's height.
const AMBIENT_RADIUS: f64 = 0.035;

/// A picture of a frame: flat shading under a sun and a sky, corners darkened, a little haze, and
/// edges between instances.
///
/// `frame` must be of `view`, at any scale ([`RenderOptions::scale`](crate::RenderOptions::scale)
/// of 2 and [`Picture::halved`] give smooth edges). `material_colors` are linear colours by the
/// number of the material; materials beyond them get a colour of their own, from their number.
/// Blended triangles are not drawn.
///
/// Cost: some 0.3 µs a pixel on one core.
#[must_use]
pub fn shaded(scene: &Scene, frame: &Frame, view: &View, material_colors: &[[f32; 4]]) -> Picture {
    shade(HAZE, scene, frame, view, material_colors, &Surfaces::new(scene, &frame.ids))
}

/// Draws like [`shaded`], for a frame of a visible set in which instances have levels of detail.
#[must_use]
pub fn shaded_levels(
    scene: &Scene,
    frame: &Frame,
    view: &View,
    visible: &Visible,
    material_colors: &[[f32; 4]],
) -> Picture {
    shade(HAZE, scene, frame, view, material_colors, &Surfaces::of_visible(scene, visible))
}

/// Draws like [`shaded_levels`], without haze: for a model that is alone, seen from any distance.
#[must_use]
pub fn shaded_clear(
    scene: &Scene,
    frame: &Frame,
    view: &View,
    visible: &Visible,
    material_colors: &[[f32; 4]],
) -> Picture {
    shade(0.0, scene, frame, view, material_colors, &Surfaces::of_visible(scene, visible))
}

fn shade(
    haze: f64,
    scene: &Scene,
    frame: &Frame,
    view: &View,
    material_colors: &[[f32; 4]],
    surfaces: &Surfaces,
) -> Picture {
    light_through(haze, scene, frame, view, surfaces, &material(surfaces, material_colors))
}

/// The colour of each owner's material.
fn material(surfaces: &Surfaces, material_colors: &[[f32; 4]]) -> impl Fn(PixelId) -> DVec3 + Sync {
    move |id: PixelId| {
        let part = surfaces.part(id);
        let given = material_colors.get(part.material as usize);
        given.map_or_else(
            || {
                let n = part.material.wrapping_add(surfaces.mesh(id).unwrap_or(0));
                DVec3::from(palette::material_color(n).map(linear))
            },
            |c| DVec3::new(f64::from(c[0]), f64::from(c[1]), f64::from(c[2])),
        )
    }
}

/// How much haze there is far away in a landscape.
const HAZE: f64 = 0.42;

/// Lights a frame whose surfaces have these linear colours, with so much haze far away, 0 to 1:
/// none where colours carry the meaning.
pub fn light_through(
    air: f64,
    scene: &Scene,
    frame: &Frame,
    view: &View,
    surfaces: &Surfaces,
    color: &(dyn Fn(PixelId) -> DVec3 + Sync),
) -> Picture {
    let space = Space::new(view);
    let (width, height) = (frame.width as usize, frame.height as usize);
    let size = [frame.width, frame.height];
    let mut picture = Picture::new(frame.width, frame.height, [0; 3]);
    if width == 0 || height == 0 {
        return picture;
    }
    let mut points = vec![DVec3::ZERO; width * height];
    parallel::for_each_chunk(&mut points, width, &|y, row| {
        for (x, point) in row.iter_mut().enumerate() {
            let [ndc_x, ndc_y] = pixel_centre(x as u32, y as u32, size);
            *point = space.point(ndc_x, ndc_y, frame.depth[y * width + x]);
        }
    });
    let open = Ambient::new(frame, &points, surfaces, &space);
    let bytes = SrgbTable::new();
    // Haze grows over the size of the scene.
    let extent = if air > 0.0 { extent(scene) } else { Aabb::EMPTY };
    let reach = if extent.is_empty() { 1.0 } else { DVec3::from(extent.half_extent()).length() };
    parallel::for_each_chunk(&mut picture.rgb, width * 3, &|y, row| {
        let mut last = (PixelId::NONE, DVec3::ZERO, DVec3::ZERO);
        for x in 0..width {
            let at = y * width + x;
            let id = frame.ids[at];
            let [ndc_x, ndc_y] = pixel_centre(x as u32, y as u32, size);
            let lit = if id == PixelId::NONE {
                sky(space.ray(ndc_x, ndc_y).1)
            } else {
                if id != last.0 {
                    last = (id, surfaces.normal(id), color(id));
                }
                let (_, n, albedo) = last;
                let p = points[at];
                let n = space.turned(n, p);
                let seen = albedo * irradiance(n, open.at(x, y)) * edge(frame, [x, y]);
                if air > 0.0 {
                    let (from, sight) = space.ray(ndc_x, ndc_y);
                    let haze = air * (1.0 - (-(p - from).length() / (2.2 * reach)).exp());
                    seen.lerp(sky(DVec3::new(sight.x, sight.y.max(0.0) * 0.3, sight.z)), haze)
                } else {
                    seen
                }
            };
            for (c, v) in lit.to_array().into_iter().enumerate() {
                row[x * 3 + c] = bytes.of(v);
            }
        }
    });
    picture
}

/// Colour behind all surfaces where light is even.
const PLAIN_SKY: [u8; 3] = [0xDD, 0xE4, 0xE9];

/// A view of what a culler left, in even light: each triangle of one shade, by its normal and its
/// material alone, and a plain sky. Few colours lie side by side, so films of it are small.
/// `material_colors` are as for [`shaded`].
///
/// Cost: a frame of four times the view's pixels, and some 20 ns for each of those.
#[must_use]
pub fn even(
    scene: &Scene,
    view: &View,
    visible: &Visible,
    material_colors: &[[f32; 4]],
) -> Picture {
    even_doubled(scene, view, Some(visible), material_colors).halved()
}

/// The same at twice the size; all of the scene where no visible set is given.
pub fn even_doubled(
    scene: &Scene,
    view: &View,
    visible: Option<&Visible>,
    material_colors: &[[f32; 4]],
) -> Picture {
    let options = RenderOptions { scale: 2, ..RenderOptions::default() };
    let selection = visible.map_or(Selection::All, Selection::Visible);
    let frame = render(scene, view, selection, &options);
    let surfaces = match visible {
        Some(visible) => Surfaces::of_visible(scene, visible),
        None => Surfaces::new(scene, &frame.ids),
    };
    light_evenly(&frame, view, &surfaces, &material(&surfaces, material_colors))
}

/// Lights like [`light_through`], except that a triangle has one shade, by its normal: without
/// haze, and without shade from its surroundings.
pub fn light_evenly(
    frame: &Frame,
    view: &View,
    surfaces: &Surfaces,
    color: &(dyn Fn(PixelId) -> DVec3 + Sync),
) -> Picture {
    let space = Space::new(view);
    let (width, size) = (frame.width as usize, [frame.width, frame.height]);
    let mut picture = Picture::new(frame.width, frame.height, PLAIN_SKY);
    let bytes = SrgbTable::new();
    parallel::for_each_chunk(&mut picture.rgb, width * 3, &|y, row| {
        let mut last = (PixelId::NONE, DVec3::ZERO);
        for x in 0..width {
            let id = frame.ids[y * width + x];
            if id == PixelId::NONE {
                continue;
            }
            if id != last.0 {
                let [ndc_x, ndc_y] = pixel_centre(x as u32, y as u32, size);
                let n = surfaces.normal(id);
                let p = space.point(ndc_x, ndc_y, frame.depth[y * width + x]);
                last = (id, color(id) * irradiance(space.turned(n, p), 1.0));
            }
            let lit = last.1 * edge(frame, [x, y]);
            for (c, v) in lit.to_array().into_iter().enumerate() {
                row[x * 3 + c] = bytes.of(v);
            }
        }
    });
    picture
}

/// Light on a surface: sun, and a sky above a paler ground.
pub fn irradiance(n: DVec3, open: f64) -> DVec3 {
    let up = n.y * 0.5 + 0.5;
    let sky = DVec3::new(0.42, 0.47, 0.58);
    let ground = DVec3::new(0.25, 0.22, 0.19);
    let sun = DVec3::new(1.0, 0.92, 0.78) * n.dot(SUN.normalize()).max(0.0);
    ground.lerp(sky, up) * open + sun * 1.05 * (0.5 + 0.5 * open)
}

/// How open the surroundings of pixels are, 0 to 1: what stands above the surface nearby shades it,
/// as seen in the depth of the frame alone.
struct Ambient {
    /// Pixels along a side of a square that shares one value: 2 in large frames, which are halved
    /// later, or would hardly show it.
    step: usize,
    width: usize,
    open: Vec<f64>,
}

impl Ambient {
    fn new(frame: &Frame, points: &[DVec3], surfaces: &Surfaces, space: &Space) -> Self {
        let (frame_width, frame_height) = (frame.width as usize, frame.height as usize);
        let step = if frame_height > 500 { 2 } else { 1 };
        let width = frame_width.div_ceil(step);
        let radius = AMBIENT_RADIUS * frame_height as f64;
        // Each of 4 × 4 neighbours turns its places by another angle.
        let places: Vec<[[i32; 2]; AMBIENT_SAMPLES]> = (0..16)
            .map(|turn| {
                std::array::from_fn(|k| {
                    let r = radius * ((k as f64 + 0.5) / AMBIENT_SAMPLES as f64);
                    let (s, c) = (f64::from(turn) * FRAC_PI_8 + k as f64 * 2.399_963).sin_cos();
                    [c * r, s * r].map(|v| v.floor() as i32)
                })
            })
            .collect();
        let height = frame_height.div_ceil(step);
        let mut raw = vec![1.0; width * height];
        parallel::for_each_chunk(&mut raw, width, &|cy, row| {
            let mut last = (PixelId::NONE, DVec3::ZERO);
            for (cx, open) in row.iter_mut().enumerate() {
                let (x, y) = (cx * step, cy * step);
                let at = y * frame_width + x;
                let id = frame.ids[at];
                if id == PixelId::NONE {
                    continue;
                }
                if id != last.0 {
                    last = (id, surfaces.normal(id));
                }
                let n = space.turned(last.1, points[at]);
                *open = openness(frame, points, [x, y], n, &places[cx % 4 * 4 + cy % 4], radius);
            }
        });
        // The turns make a pattern of 4 × 4: a mean over as many, of the same instance, has none.
        let slot = |cx: usize, cy: usize| frame.ids[cy * step * frame_width + cx * step].slot;
        let mut open = vec![0.0; width * height];
        parallel::for_each_chunk(&mut open, width, &|cy, row| {
            for (cx, mean) in row.iter_mut().enumerate() {
                let own = slot(cx, cy);
                let (mut sum, mut n) = (0.0, 0.0);
                for y in cy.saturating_sub(1)..(cy + 3).min(height) {
                    for x in cx.saturating_sub(1)..(cx + 3).min(width) {
                        if slot(x, y) == own {
                            sum += raw[y * width + x];
                            n += 1.0;
                        }
                    }
                }
                *mean = sum / n;
            }
        });
        Self { step, width, open }
    }

    fn at(&self, x: usize, y: usize) -> f64 {
        self.open[y / self.step * self.width + x / self.step]
    }
}

fn openness(
    frame: &Frame,
    points: &[DVec3],
    [x, y]: [usize; 2],
    n: DVec3,
    places: &[[i32; 2]; AMBIENT_SAMPLES],
    radius: f64,
) -> f64 {
    let (width, height) = (frame.width as usize, frame.height as usize);
    let p = points[y * width + x];
    // The size of a pixel at this distance, from a neighbour on about the same surface.
    let right = points[y * width + if x + 1 < width { x + 1 } else { x.saturating_sub(1) }];
    let below = points[if y + 1 < height { y + 1 } else { y.saturating_sub(1) } * width + x];
    let world = radius * (right - p).length().min((below - p).length());
    let mut shade = 0.0;
    for [dx, dy] in places {
        // A place above or to the left of the frame becomes one far beyond it.
        let (sx, sy) = ((x as i32 + dx) as usize, (y as i32 + dy) as usize);
        if sx >= width || sy >= height {
            continue;
        }
        let at = sy * width + sx;
        if frame.ids[at] == PixelId::NONE {
            continue;
        }
        let v = points[at] - p;
        let above = n.dot(v);
        // Half of all samples are not above the surface, and are done with before the root.
        if above > 0.0 && world > 0.0 {
            let length = v.length();
            // A place much farther than the radius is not near at all.
            let far = length / (3.0 * world);
            shade += (above / length - 0.08).max(0.0) / (1.0 + far * far);
        }
    }
    (1.0 - 1.9 * shade / AMBIENT_SAMPLES as f64).max(0.12)
}

/// Darkens a pixel whose neighbour to the right or below belongs to another instance.
fn edge(frame: &Frame, [x, y]: [usize; 2]) -> f64 {
    let (width, height) = (frame.width as usize, frame.height as usize);
    let at = y * width + x;
    let own = frame.ids[at].slot;
    let other =
        |x: usize, y: usize| x < width && y < height && frame.ids[y * width + x].slot != own;
    if other(x + 1, y) || other(x, y + 1) { 0.72 } else { 1.0 }
}

/// The colour of the sky in a direction.
fn sky(direction: DVec3) -> DVec3 {
    let horizon = DVec3::new(0.80, 0.85, 0.88);
    if direction.y < 0.0 {
        return horizon.lerp(DVec3::new(0.55, 0.56, 0.55), (-direction.y * 2.0).min(1.0));
    }
    horizon.lerp(DVec3::new(0.20, 0.42, 0.74), direction.y.min(1.0).sqrt())
}

/// From linear values to bytes in sRGB, by a table: a power for each colour of each pixel is slow.
struct SrgbTable(Vec<u8>);

impl SrgbTable {
    const STEPS: f64 = 8192.0;

    fn new() -> Self {
        let byte = |i: u32| {
            let v = f64::from(i) / Self::STEPS;
            let s = if v <= 0.003_130_8 { v * 12.92 } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
            (s * 255.0).round() as u8
        };
        Self((0..=Self::STEPS as u32).map(byte).collect())
    }

    /// NaN is black.
    fn of(&self, v: f64) -> u8 {
        // A cast saturates at 0, and sends NaN there.
        self.0[(v.min(1.0) * Self::STEPS + 0.5) as usize]
    }
}

/// The linear value of a byte in sRGB.
pub fn linear(v: u8) -> f64 {
    let s = f64::from(v) / 255.0;
    if s <= 0.040_45 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) }
}
