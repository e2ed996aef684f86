//! Triangles that cover no sample.
//!
//! A renderer draws a triangle at the samples of the pixels that it covers; one between all of them it sets up for
//! nothing. Which samples there are is the renderer's: one in the middle of each pixel, or several with multisampling.
//! For the pattern that is stated, what is dropped here is not lossy.

use crate::array::Each;
use crate::view::View;

/// The most samples a pixel.
pub const MAX_SAMPLES: usize = 16;

/// Where the samples of each pixel are, from its top left corner, 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum SamplePattern {
    /// One in the middle.
    Centre,
    /// The standard pattern of four that Direct3D and Vulkan prescribe.
    Four,
    /// The standard pattern of eight.
    Eight,
    /// Anywhere: nothing but what is beside all pixels covers no sample. For images that jitter.
    Anywhere,
}

impl SamplePattern {
    /// The samples, none for [`Anywhere`](Self::Anywhere).
    #[must_use]
    pub fn samples(self) -> &'static [[f64; 2]] {
        const fn at(x: i32, y: i32) -> [f64; 2] {
            [0.5 + x as f64 / 16.0, 0.5 + y as f64 / 16.0]
        }
        const FOUR: [[f64; 2]; 4] = [at(-2, -6), at(6, -2), at(-6, 2), at(2, 6)];
        const EIGHT: [[f64; 2]; 8] = [
            at(1, -3),
            at(-1, 3),
            at(5, 1),
            at(-3, -5),
            at(-5, 5),
            at(-7, -1),
            at(3, 7),
            at(7, -7),
        ];
        match self {
            Self::Centre => &[[0.5, 0.5]],
            Self::Four => &FOUR,
            Self::Eight => &EIGHT,
            Self::Anywhere => &[],
        }
    }
}

/// Error bound of a corner on the screen, in pixels. Renderers round corners to 1/256 of a pixel or
/// finer, and compute their places in f32.
const OFF: f64 = 1.0 / 256.0 + 1.0 / 1024.0;

/// The most pixels around a triangle whose samples are tested one by one; what is larger is kept.
const MOST_PIXELS: f64 = 16.0;

/// The pixels of a view, and its samples, for triangles in one space.
#[derive(Clone, Debug)]
pub struct SampleTest {
    clip: glam::DMat4,
    viewport: [f64; 2],
    samples: &'static [[f64; 2]],
}

impl SampleTest {
    /// For triangles of what has a transform in a view; `transform` column-major.
    #[must_use]
    pub fn new(view: &View, transform: [f64; 16], pattern: SamplePattern) -> Self {
        let own = glam::DMat4::from_cols_array(&transform);
        let clip = glam::DMat4::from_cols_array(&view.clip_from_world()) * own;
        Self { clip, viewport: view.viewport().each(f64::from), samples: pattern.samples() }
    }

    /// Whether a triangle covers no sample, wherever a renderer rounds its corners to. Never true of one that reaches
    /// behind the eye, has a corner that is not finite, or more than a few pixels around it.
    #[must_use]
    pub fn covers_none(&self, corners: &[[f32; 3]; 3]) -> bool {
        let mut points = [[0.0; 2]; 3];
        for (point, corner) in points.iter_mut().zip(corners) {
            let p = self.clip * glam::DVec3::from(corner.each(f64::from)).extend(1.0);
            if p.w.is_nan() || p.w <= 0.0 {
                return false;
            }
            *point = [
                (p.x / p.w * 0.5 + 0.5) * self.viewport[0],
                (0.5 - p.y / p.w * 0.5) * self.viewport[1],
            ];
        }
        let bound = |a: usize| {
            let v = points.each(|p| p[a]);
            let (low, high) = (v[0].min(v[1]).min(v[2]), v[0].max(v[1]).max(v[2]));
            // Far off the screen f32 is coarser.
            let off = OFF + low.abs().max(high.abs()) * 4.0 * f64::from(f32::EPSILON);
            (low - off, high + off, off)
        };
        let ((left, right, off_x), (top, bottom, off_y)) = (bound(0), bound(1));
        if !(right - left).is_finite() || !(bottom - top).is_finite() {
            return false;
        }
        let (left, right) = (left.floor().max(0.0), right.floor().min(self.viewport[0] - 1.0));
        let (top, bottom) = (top.floor().max(0.0), bottom.floor().min(self.viewport[1] - 1.0));
        if left > right || top > bottom {
            // Beside all pixels.
            return true;
        }
        if self.samples.is_empty() || (right - left + 1.0) * (bottom - top + 1.0) > MOST_PIXELS {
            return false;
        }
        let off = off_x.max(off_y);
        let mut y = top;
        while y <= bottom {
            let mut x = left;
            while x <= right {
                if self.samples.iter().any(|s| may_cover(&points, [x + s[0], y + s[1]], off)) {
                    return false;
                }
                x += 1.0;
            }
            y += 1.0;
        }
        true
    }
}

/// Whether a triangle may cover a point if each corner may be off by so much along both axes: whether no line along an
/// edge or an axis parts the point from all places of the triangle.
fn may_cover(points: &[[f64; 2]; 3], sample: [f64; 2], off: f64) -> bool {
    let parts = |normal: [f64; 2]| {
        let along = |p: [f64; 2]| normal[0] * p[0] + normal[1] * p[1];
        let (all, at) = (points.each(along), along(sample));
        let off = off * (normal[0].abs() + normal[1].abs());
        at < all[0].min(all[1]).min(all[2]) - off || at > all[0].max(all[1]).max(all[2]) + off
    };
    let edge = |i: usize| {
        let (a, b) = (points[i], points[(i + 1) % 3]);
        [a[1] - b[1], b[0] - a[0]]
    };
    !parts([1.0, 0.0]) && !parts([0.0, 1.0]) && !(0..3).any(|i| parts(edge(i)))
}
