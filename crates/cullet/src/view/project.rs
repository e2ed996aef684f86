//! Projected sizes, in pixels.

use glam::{DMat4, DVec3, DVec4};

use super::{Depth, View};
use crate::array::{self, Each};
use crate::bounds::{Aabb, ROUNDING};

/// A rectangle on the screen, in pixels from the top left corner; it may reach beyond the viewport.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScreenRect {
    /// Left and top edge.
    pub min: [f64; 2],
    /// Right and bottom edge.
    pub max: [f64; 2],
}

impl ScreenRect {
    /// Width in pixels.
    #[must_use]
    pub fn width(&self) -> f64 {
        self.max[0] - self.min[0]
    }

    /// Height in pixels.
    #[must_use]
    pub fn height(&self) -> f64 {
        self.max[1] - self.min[1]
    }

    /// Whether a point of the screen is in the rectangle, its edges included.
    #[must_use]
    pub fn contains(&self, pixel: [f64; 2]) -> bool {
        (0..2).all(|a| self.min[a] <= pixel[a] && pixel[a] <= self.max[a])
    }

    /// The part of the rectangle that is on a viewport; `None` if there is none.
    #[must_use]
    pub fn clipped(&self, viewport: [u32; 2]) -> Option<Self> {
        let min = self.min.each(|v| v.max(0.0));
        let max = array::from_fn(|a| self.max[a].min(f64::from(viewport[a])));
        (min[0] <= max[0] && min[1] <= max[1]).then_some(Self { min, max })
    }
}

impl View {
    /// Rows of clip x, y, of the depth beyond the near plane, and of w, for points that `place`
    /// puts into the world.
    pub(crate) fn depth_rows(&self, place: &[f64; 16]) -> [[f64; 4]; 4] {
        let clip = self.clip_from_world * DMat4::from_cols_array(place);
        let row = |r: usize| clip.row(r);
        let depth = match self.depth {
            Depth::Standard => row(2),
            Depth::Reversed => row(3) - row(2),
        };
        [row(0), row(1), depth, row(3)].each(Into::into)
    }

    /// The rectangle around the projection of a box given relative to `origin`, never smaller than
    /// it: rounded outward.
    ///
    /// `None` where the box reaches in front of the near plane or behind the eye, where its size
    /// has no bound; where it is not finite; and where it is empty.
    #[must_use]
    pub fn project_box(&self, b: &Aabb, origin: [f64; 3]) -> Option<ScreenRect> {
        if b.is_empty() || !b.is_finite() {
            return None;
        }
        let m = &self.clip_from_world;
        let sizes = absolute(m);
        let mut rect = ScreenRect { min: [f64::INFINITY; 2], max: [f64::NEG_INFINITY; 2] };
        for c in b.corners() {
            let p = DVec3::from(c.each(f64::from));
            let clip: DVec4 = *m * (p + DVec3::from(origin)).extend(1.0);
            // Error bound of each number of `clip`.
            let error = sizes * (p.abs() + DVec3::from(origin).abs()).extend(1.0) * ROUNDING;
            let depth_error = match self.depth {
                Depth::Standard => error.z,
                Depth::Reversed => error.z + error.w,
            };
            let nearest = match self.depth {
                Depth::Standard => clip.z,
                Depth::Reversed => clip.w - clip.z,
            };
            let proved = clip.w > 2.0 * error.w && nearest >= -depth_error && clip.is_finite();
            if !proved {
                return None;
            }
            for a in 0..2 {
                let at = clip[a] / clip.w;
                let off =
                    (error[a] + at.abs() * error.w) / (clip.w - error.w) + at.abs() * ROUNDING;
                self.extend(&mut rect, a, at - off, at + off);
            }
        }
        Some(rect)
    }

    /// The rectangle around that part of a box given relative to `origin` that lies beyond the near
    /// plane, within the screen: 0 to 1 from its top left corner. `None` where there is no such
    /// part, and where a number is not finite. An estimate: nothing is proved by it.
    pub(crate) fn part_of_box(&self, b: &Aabb, origin: [f64; 3]) -> Option<[[f64; 2]; 2]> {
        if b.is_empty() || !b.is_finite() {
            return None;
        }
        let clip = |p: [f32; 3]| {
            self.clip_from_world
                * (DVec3::from(p.each(f64::from)) + DVec3::from(origin)).extend(1.0)
        };
        let depth = |c: DVec4| match self.depth {
            Depth::Standard => c.z,
            Depth::Reversed => c.w - c.z,
        };
        let corners = b.corners().each(clip);
        let (mut min, mut max) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let mut take = |c: DVec4| {
            for a in 0..2 {
                let v = 0.5 + c[a] / c.w * if a == 0 { 0.5 } else { -0.5 };
                (min[a], max[a]) = (min[a].min(v), max[a].max(v));
            }
        };
        for i in 0..8_usize {
            let (c, near) = (corners[i], depth(corners[i]));
            if near >= 0.0 && c.w > 0.0 {
                take(c);
            }
            // Where the edges to the three corners above it cross the near plane.
            for other in [1, 2, 4].each(|axis| i | axis).into_iter().filter(|&o| o != i) {
                let end = corners[other];
                let far = depth(end);
                if (near < 0.0) != (far < 0.0) {
                    take(c + (end - c) * (near / (near - far)));
                }
            }
        }
        let on = (0..2).all(|a| min[a] <= 1.0 && max[a] >= 0.0 && (max[a] - min[a]).is_finite());
        on.then(|| [min.each(|v| v.max(0.0)), max.each(|v| v.min(1.0))])
    }

    /// Stretches `rect` along an axis over `low`..`high` in device coordinates, rounding outward.
    fn extend(&self, rect: &mut ScreenRect, axis: usize, low: f64, high: f64) {
        let size = f64::from(self.viewport[axis]);
        let (low, high) = match axis {
            0 => ((low * 0.5 + 0.5) * size, (high * 0.5 + 0.5) * size),
            // Pixels count down from the top.
            _ => ((0.5 - high * 0.5) * size, (0.5 - low * 0.5) * size),
        };
        let slack = |v: f64| (v.abs() + size) * ROUNDING;
        rect.min[axis] = rect.min[axis].min(low - slack(low));
        rect.max[axis] = rect.max[axis].max(high + slack(high));
    }
}

fn absolute(m: &DMat4) -> DMat4 {
    DMat4::from_cols(m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs(), m.w_axis.abs())
}
