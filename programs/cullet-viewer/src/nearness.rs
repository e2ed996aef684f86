//! The occlusion buffer as a picture, in the greys of [`Paint::Depth`](crate::draw::Paint), so that
//! it can lie beside the true depth of the same view: what of the two differs is what the buffer
//! does not know.

use cullet::View;
use cullet::cull::occlusion::{OcclusionBuffer, TILE};
use glam::DVec3;

/// Colour of pixels that no occluder covers: a dark blue that no distance is painted in.
pub const OPEN: [u8; 3] = [16, 26, 60];

/// The picture of a buffer: width, height, and sRGB with straight alpha, row by row from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Width and height in pixels.
    pub size: [usize; 2],
    /// The pixels.
    pub pixels: Vec<[u8; 4]>,
}

/// Paints a buffer that was made for `view`. Covered pixels are as light as
/// [`Paint::Depth`](crate::draw::Paint) paints their distance where `radius` is that of the scene;
/// in a view without perspective the nearest of the picture is white and the farthest dark. `tiles`
/// paints the coarser level, a pixel a tile. With `over` what is open is clear and the rest lets
/// the picture below through. O(pixels).
#[must_use]
pub fn paint(
    buffer: &OcclusionBuffer,
    view: &View,
    radius: f64,
    tiles: bool,
    over: bool,
) -> Picture {
    let [width, height] = buffer.size();
    let step = if tiles { TILE } else { [1, 1] };
    let size = [width as usize, height as usize];
    let size = [0, 1].map(|a: usize| size[a].div_ceil(step[a]));
    let value = |x: usize, y: usize| {
        let [x, y] = [(x * step[0]) as u32, (y * step[1]) as u32];
        if tiles { buffer.tile_nearness(x, y) } else { buffer.nearness(x, y) }
    };
    let all = || (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
    let depth = if view.is_orthographic() {
        let covered = || all().map(|(x, y)| value(x, y)).filter(|v| *v > 0.0 && v.is_finite());
        Depth::Parallel(covered().fold(f32::INFINITY, f32::min), covered().fold(0.0, f32::max))
    } else {
        Depth::Perspective { half: radius * 0.5, slopes: slopes(view) }
    };
    let (opaque, open) = if over { (150, [0; 4]) } else { (255, [OPEN[0], OPEN[1], OPEN[2], 255]) };
    let pixels = all()
        .map(|(x, y)| {
            let near = value(x, y);
            if near <= 0.0 {
                return open;
            }
            let across = |i: usize, step: usize, of: u32| {
                ((i as f64 + 0.5) * step as f64 / f64::from(of)) * 2.0 - 1.0
            };
            let middle = [across(x, step[0], width), across(y, step[1], height)];
            let grey = depth.grey(near, middle);
            [grey, grey, grey, opaque]
        })
        .collect();
    Picture { size, pixels }
}

/// How nearness becomes a grey.
enum Depth {
    /// The distance that is half dark, and the slopes of the view's edges.
    Perspective { half: f64, slopes: [f64; 2] },
    /// The farthest and the nearest there is.
    Parallel(f32, f32),
}

impl Depth {
    fn grey(&self, near: f32, at: [f64; 2]) -> u8 {
        let share = match self {
            Self::Perspective { half, slopes: [x, y] } => {
                // The buffer knows w, which is measured along the view's axis; distance is along
                // the ray.
                let slant = (1.0 + (at[0] * x).powi(2) + (at[1] * y).powi(2)).sqrt();
                half / (half + slant / f64::from(near))
            }
            Self::Parallel(low, high) => {
                let wide = f64::from(high - low);
                let share = if wide > 0.0 { f64::from(near - low) / wide } else { 1.0 };
                0.15 + 0.85 * share
            }
        };
        (share.clamp(0.0, 1.0) * 255.0).round() as u8
    }
}

/// How far the right and the lower edge of a view lie from its axis, at a distance of one.
fn slopes(view: &View) -> [f64; 2] {
    let [w, h] = view.viewport().map(f64::from);
    let ray = |p| view.ray(p).map_or(DVec3::NEG_Z, |r| DVec3::from(r.direction));
    let middle = ray([w * 0.5, h * 0.5]);
    [[w, h * 0.5], [w * 0.5, h]].map(|edge| {
        let cos = middle.dot(ray(edge)).clamp(1e-6, 1.0);
        (1.0 - cos * cos).sqrt() / cos
    })
}
