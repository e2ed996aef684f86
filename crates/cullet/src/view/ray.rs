//! From the screen back into the world.

use glam::{DVec3, DVec4};

use super::{Depth, View};
use crate::array::Each;
use crate::bounds::{Plane, unit};

/// A line of sight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it meets the near plane.
    pub origin: [f64; 3],
    /// Its unit direction, away from the viewer.
    pub direction: [f64; 3],
}

impl View {
    /// The line of sight through a point of the screen, in pixels from the top left corner (the
    /// middle of the first pixel is at 0.5, 0.5); points beyond the viewport have one too.
    ///
    /// Found from the rows of the matrix without its inverse, so it is as exact as the matrix is.
    /// `None` where a number is not finite, or the line of sight runs along the near plane.
    #[must_use]
    pub fn ray(&self, pixel: [f64; 2]) -> Option<Ray> {
        let [a, b] = self.planes_of_sight(pixel);
        let (n, m) = (DVec3::from(a.normal), DVec3::from(b.normal));
        let direction = unit(n.cross(m))?;
        let w = self.clip_from_world.row(3).truncate();
        // In perspective w grows away from the viewer; in parallel the eye is the way back.
        let ahead = if self.is_orthographic() {
            -direction.dot(self.eye.truncate())
        } else {
            direction.dot(w)
        };
        let direction = direction * ahead.signum();
        let near = match self.depth {
            Depth::Standard => 0.0,
            Depth::Reversed => 1.0,
        };
        let origin = Plane::meet(&a, &b, &self.plane_of_depth(near)?)?;
        Some(Ray { origin, direction: direction.into() })
    }

    /// Where a point is seen: pixels from the top left corner, and clip depth. `None` for a point
    /// that is not in front of the eye (w ≤ 0) or not finite. It may lie beyond the viewport or the
    /// depth range.
    #[must_use]
    pub fn project_point(&self, point: impl Into<[f64; 3]>) -> Option<[f64; 3]> {
        let clip = self.clip_from_world * DVec3::from(point.into()).extend(1.0);
        let [width, height] = self.viewport.each(f64::from);
        let p = clip.truncate() / clip.w;
        (clip.w > 0.0 && p.is_finite()).then_some([
            (p.x * 0.5 + 0.5) * width,
            (0.5 - p.y * 0.5) * height,
            p.z,
        ])
    }

    /// The planes that a column and a row of the screen come from: x = k·w and y = l·w in clip
    /// space.
    fn planes_of_sight(&self, pixel: [f64; 2]) -> [Plane; 2] {
        let [width, height] = self.viewport.each(f64::from);
        let (k, l) = (pixel[0] / width * 2.0 - 1.0, 1.0 - pixel[1] / height * 2.0);
        let (m, w) = (&self.clip_from_world, self.clip_from_world.row(3));
        [plane(m.row(0) - w * k), plane(m.row(1) - w * l)]
    }

    /// The plane of one clip depth; `None` where it is at infinity.
    fn plane_of_depth(&self, depth: f64) -> Option<Plane> {
        let m = &self.clip_from_world;
        plane(m.row(2) - m.row(3) * depth).normalized()
    }
}

/// The plane where a row of clip space is zero; unit where it can be, so that small rows meet too.
fn plane(row: DVec4) -> Plane {
    let p = Plane { normal: row.truncate().into(), d: -row.w };
    p.normalized().unwrap_or(p)
}
