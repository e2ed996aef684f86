//! Projected sizes, in pixels.

use glam::{DMat4, DVec3, DVec4};

use super::View;
use crate::bounds::Aabb;

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
}

impl View {
    /// The rectangle around the projection of a box given relative to `origin`; `None` where the box
    /// reaches in front of the near plane or behind the eye, or is not finite: its size has no bound.
    #[must_use]
    pub fn project_box(&self, b: &Aabb, origin: [f64; 3]) -> Option<ScreenRect> {
        let m = DMat4::from_cols_array(&self.clip_from_world());
        let [width, height] = self.viewport().map(f64::from);
        let mut rect = ScreenRect { min: [f64::INFINITY; 2], max: [f64::NEG_INFINITY; 2] };
        for c in b.corners() {
            let p = DVec3::from(c.map(f64::from)) + DVec3::from(origin);
            let clip: DVec4 = m * p.extend(1.0);
            let nearest = match self.depth() {
                super::Depth::Standard => clip.z,
                super::Depth::Reversed => clip.w - clip.z,
            };
            if !(clip.w > 0.0 && nearest >= 0.0 && clip.is_finite()) {
                return None;
            }
            let at =
                [(clip.x / clip.w * 0.5 + 0.5) * width, (0.5 - clip.y / clip.w * 0.5) * height];
            for a in 0..2 {
                rect.min[a] = rect.min[a].min(at[a]);
                rect.max[a] = rect.max[a].max(at[a]);
            }
        }
        Some(rect)
    }
}
