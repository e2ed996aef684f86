//! How large a box can look at the most, wherever it is within another.

use glam::{DMat4, DVec3, DVec4};

use super::{Depth, View};
use crate::array::{self, Each};
use crate::bounds::{Aabb, ROUNDING};
use crate::transform::Transform;

/// Bounds of projected sizes in one view, of boxes in one space.
///
/// Cheaper than [`View::project_box`], and of many boxes at once, but no more than bounds: never smaller than the
/// rectangle that it finds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SizeBounds {
    /// Rows of x, y, depth and w: what each unit along an axis adds.
    rows: [DVec3; 4],
    /// Values of the rows at the zero of the space.
    at_zero: [f64; 4],
    /// Half the viewport, in pixels.
    half: [f64; 2],
}

/// Rows of clip x, y, of the depth beyond the near plane, and of w.
fn depth_rows(view: &View, clip: &DMat4) -> [DVec4; 4] {
    let row = |r: usize| clip.row(r);
    let depth = match view.depth {
        Depth::Standard => row(2),
        Depth::Reversed => row(3) - row(2),
    };
    [row(0), row(1), depth, row(3)]
}

impl View {
    /// Rows of clip x, y, of the depth beyond the near plane, and of w, for points relative to `origin`.
    pub(crate) fn depth_rows(&self, origin: [f64; 3]) -> [[f64; 4]; 4] {
        let clip = self.clip_from_world * DMat4::from_translation(origin.into());
        depth_rows(self, &clip).each(Into::into)
    }
}

impl SizeBounds {
    /// Makes the bounds for boxes given relative to `origin`.
    pub(crate) fn of_world(view: &View, origin: [f64; 3]) -> Self {
        Self::new(view, &(view.clip_from_world * DMat4::from_translation(origin.into())))
    }

    /// Makes the bounds for boxes in the space of an instance with `transform`.
    pub(crate) fn of_object(view: &View, transform: &Transform) -> Self {
        let own = DMat4::from_cols_array(&transform.to_matrix());
        Self::new(view, &(view.clip_from_world * own))
    }

    fn new(view: &View, clip: &DMat4) -> Self {
        let all = depth_rows(view, clip);
        Self {
            rows: all.each(DVec4::truncate),
            at_zero: all.each(|r| r.w),
            half: view.viewport.each(|size| f64::from(size) * 0.5),
        }
    }

    /// Width and height in pixels that the picture of no box exceeds that lies in `within` and is not larger than `size`
    /// along any axis. `None` where there is no such bound: where `within` reaches in front of the near plane or behind the
    /// eye, or is empty or not finite.
    pub(crate) fn of(&self, within: &Aabb, size: [f32; 3]) -> Option<[f64; 2]> {
        if within.is_empty() || !within.is_finite() {
            return None;
        }
        let (min, max) =
            (DVec3::from(within.min.each(f64::from)), DVec3::from(within.max.each(f64::from)));
        let (centre, reach) = ((min + max) * 0.5, (max - min) * 0.5);
        // f32 rounds the size of a box to either side.
        let size = DVec3::from(size.each(f64::from)) * (1.0 + 4.0 * f64::from(f32::EPSILON));
        let farthest = min.abs().max(max.abs());
        let middle = |r: usize| self.rows[r].dot(centre) + self.at_zero[r];
        // More than all that f64 rounds here and where a box is projected by its corners.
        let error =
            |r: usize| 8.0 * ROUNDING * (self.rows[r].abs().dot(farthest) + self.at_zero[r].abs());
        let nearest = middle(3) - self.rows[3].abs().dot(reach) - 4.0 * error(3);
        let depth = middle(2) - self.rows[2].abs().dot(reach) - error(2) - error(3);
        if !(nearest > 0.0 && depth >= 0.0) {
            return None;
        }
        let deep = self.rows[3].abs().dot(size);
        let sizes = [0, 1].each(|r| {
            // |x/w − x'/w'| ≤ (|x − x'| + |x'/w'| |w − w'|) / w.
            let off = (middle(r).abs() + self.rows[r].abs().dot(reach) + error(r)) / nearest;
            let wide = self.rows[r].abs().dot(size) + off * deep;
            let rounding = 4.0 * (error(r) + off * error(3)) / nearest + (off + 1.0) * 1e-9;
            (wide / nearest * (1.0 + 1e-9) + rounding) * self.half[r]
        });
        sizes.iter().all(|v| v.is_finite()).then_some(sizes)
    }

    /// Returns the bound of [`of`](Self::of) for the single box `b`: its width and height in
    /// pixels.
    pub(crate) fn of_box(&self, b: &Aabb) -> Option<[f64; 2]> {
        self.of(b, array::from_fn(|a| b.max[a] - b.min[a]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::{Camera, Projection};

    /// A small generator: the testkit's builds on this crate.
    fn next(state: &mut u64) -> f64 {
        *state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 11) as f64 / (1u64 << 53) as f64
    }

    #[test]
    fn no_box_within_looks_larger() {
        let mut state = 7;
        let (mut bounded, mut tight) = (0, 0);
        for case in 0..4000 {
            let mut r = |low: f64, high: f64| low + (high - low) * next(&mut state);
            let eye = [r(-50.0, 50.0), r(-50.0, 50.0), r(-50.0, 50.0)];
            let target = [r(-50.0, 50.0), r(-50.0, 50.0), r(-50.0, 50.0)];
            let projection = match case % 3 {
                0 => Projection::Perspective {
                    fov_y_radians: r(0.2, 2.0),
                    aspect: r(0.5, 2.0),
                    near: 0.1,
                    far: 1e3,
                },
                1 => Projection::Orthographic {
                    left: -9.0,
                    right: 12.0,
                    bottom: -5.0,
                    top: 7.0,
                    near: -1e3,
                    far: 1e3,
                },
                _ => Projection::Perspective {
                    fov_y_radians: 1.0,
                    aspect: 1.0,
                    near: 1.0,
                    far: f64::INFINITY,
                },
            };
            let depth = if case % 2 == 0 { Depth::Standard } else { Depth::Reversed };
            let camera = Camera::look_at(eye, target, projection);
            let Ok(view) = View::new(&camera, depth, [640, 360]) else { continue };
            let origin = [r(-9.0, 9.0), 0.0, r(-1e3, 1e3)];
            let min: [f32; 3] = array::from_fn(|a| (r(-60.0, 60.0) - origin[a]) as f32);
            let max: [f32; 3] = array::from_fn(|a| min[a] + r(0.0, 20.0) as f32);
            let within = Aabb { min, max };
            let size: [f32; 3] = array::from_fn(|a| (max[a] - min[a]) * r(0.0, 0.3) as f32);
            let sizes = SizeBounds::of_world(&view, origin);
            if sizes.of(&within, size).is_none() {
                continue;
            }
            bounded += 1;
            let mut largest: f64 = 0.0;
            for _ in 0..12 {
                let low: [f32; 3] = array::from_fn(|a| {
                    min[a] + (max[a] - size[a] - min[a]).max(0.0) * next(&mut state) as f32
                });
                let high: [f32; 3] = array::from_fn(|a| (low[a] + size[a]).min(max[a]));
                // Its corners are rounded, so that it may be a little larger than was meant.
                let size = array::from_fn(|a| size[a].max(high[a] - low[a]));
                let [width, height] = sizes.of(&within, size).expect("as before");
                let seen = view.project_box(&Aabb { min: low, max: high }, origin);
                let seen = seen.expect("beyond the near plane");
                assert!(seen.width() <= width && seen.height() <= height, "{seen:?}");
                largest = largest.max(seen.width() / width);
            }
            tight += u32::from(largest > 0.3);
        }
        assert!(bounded > 600 && tight > bounded / 3, "{tight} of {bounded}");
    }

    #[test]
    fn nothing_bounds_what_crosses_the_near_plane() {
        let view =
            View::perspective([0.0; 3], [0.0, 0.0, -1.0], 1.0, 1.0, 100.0, [64, 64]).unwrap();
        let sizes = SizeBounds::of_world(&view, [0.0; 3]);
        let from = |z: f32| Aabb { min: [-1.0, -1.0, z - 2.0], max: [1.0, 1.0, z] };
        assert!(sizes.of_box(&from(-1.1)).is_some() && sizes.of_box(&from(-0.9)).is_none());
        assert!(sizes.of_box(&from(5.0)).is_none() && sizes.of_box(&Aabb::EVERYTHING).is_none());
        assert!(sizes.of_box(&Aabb::EMPTY).is_none());
    }
}
