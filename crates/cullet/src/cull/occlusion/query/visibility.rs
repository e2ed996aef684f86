//! Test of one box, in f64: the oracle of [batches](super::batch).

use super::super::raster::{OcclusionBuffer, ScreenBounds};
use crate::array::{self, Each};
use crate::bounds::Aabb;
#[cfg(not(feature = "std"))]
use crate::math::Float as _;

/// Result of a test against a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum Visibility {
    /// It reaches no pixel of the buffer: it is out of the view.
    Outside,
    /// A pixel that it may touch is open to it, or that cannot be told: it crosses the near plane,
    /// or is not finite.
    Visible,
    /// Everything of it that is in the view lies behind what is proved to be covered.
    Hidden,
}

impl OcclusionBuffer {
    /// Whether a box, given relative to the buffer's origin, is hidden. NaN and infinite boxes are
    /// visible, and so is everything before [`begin`](Self::begin); an empty box is outside.
    #[must_use]
    pub fn test_box(&self, b: &Aabb) -> Visibility {
        match self.project(b) {
            Ok(Some(bounds)) if self.first_open(&bounds).is_none() => Visibility::Hidden,
            Ok(None) => Visibility::Outside,
            Ok(Some(_)) | Err(Unbounded) => Visibility::Visible,
        }
    }

    /// The pixels that a box may touch, given relative to the buffer's origin; `None` where it
    /// reaches none, crosses the near plane or is not finite.
    #[must_use]
    pub fn screen_bounds(&self, b: &Aabb) -> Option<ScreenBounds> {
        self.project(b).ok().flatten()
    }

    /// Whether what lies within some screen bounds, and is no nearer than they say, is hidden: for
    /// callers that project by themselves. Pixels beyond an edge count as out of the view. Visible
    /// before [`begin`](Self::begin), and where the nearness is NaN or at most 0. Tests a tile at a
    /// time, and ends at the first that is open.
    #[must_use]
    pub fn test_bounds(&self, simd: crate::Simd, bounds: &ScreenBounds) -> Visibility {
        let ScreenBounds { min, max, nearness } = *bounds;
        let last = self.size().each(|s| s - 1);
        if (0..2).any(|a| min[a] > last[a] || min[a] > max[a]) {
            return Visibility::Outside;
        }
        let within = ScreenBounds { max: [0, 1].each(|a| max[a].min(last[a])), ..*bounds };
        let is_open = self.screen().is_none() || nearness.is_nan() || nearness <= 0.0;
        if is_open || !self.covers(simd, &within) {
            return Visibility::Visible;
        }
        Visibility::Hidden
    }

    /// The pixels that a box may touch; `None` where it reaches none.
    fn project(&self, b: &Aabb) -> Result<Option<ScreenBounds>, Unbounded> {
        if b.is_empty() {
            return Ok(None);
        }
        let Some((screen, _)) = self.screen() else { return Err(Unbounded) };
        let (rows, apart) = (screen.rows(), screen.apart());
        let (mut min, mut max) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let mut nearest = f64::NEG_INFINITY;
        let (mut crosses, mut behind) = (false, true);
        for p in b.corners().each(|c| c.each(f64::from)) {
            let sum = |r: [f64; 4]| r[0] * p[0] + r[1] * p[1] + r[2] * p[2] + r[3];
            let error = |row: usize| {
                let r = rows[row];
                let size =
                    (r[0] * p[0]).abs() + (r[1] * p[1]).abs() + (r[2] * p[2]).abs() + r[3].abs();
                size * 32.0 * f64::EPSILON + apart[row]
            };
            let [x, y, nearness, near, w] = rows.each(sum);
            let [ex, ey, en, enear, ew] = [0, 1, 2, 3, 4].each(error);
            // A NaN fails both.
            if !(near >= -enear && w > 2.0 * ew) {
                crosses = true;
                behind &= near < -enear;
                continue;
            }
            behind = false;
            let low = w - ew;
            let off =
                |value: f64, error: f64| (error + value.abs() * ew) / low + value.abs() * 1e-15;
            for (axis, (value, error)) in [(x / w, ex), (y / w, ey)].into_iter().enumerate() {
                let off = off(value, error);
                min[axis] = min[axis].min(value - off);
                max[axis] = max[axis].max(value + off);
            }
            let value = nearness / w;
            nearest = nearest.max(value + off(value, en));
        }
        if crosses {
            return if behind { Ok(None) } else { Err(Unbounded) };
        }
        if !(min.iter().chain(&max).all(|v| v.is_finite()) && nearest.is_finite()) {
            return Err(Unbounded);
        }
        let size = self.size().each(f64::from);
        if (0..2).any(|a| max[a] < 0.0 || min[a] > size[a]) {
            return Ok(None);
        }
        let pixel = |v: f64, a: usize| v.floor().clamp(0.0, size[a] - 1.0) as u32;
        Ok(Some(ScreenBounds {
            min: array::from_fn(|a| pixel(min[a], a)),
            max: array::from_fn(|a| pixel(max[a], a)),
            nearness: (nearest as f32).next_up(),
        }))
    }

    /// The first pixel that lets some screen bounds through, row by row; `None` where they are
    /// covered.
    pub(crate) fn first_open(&self, bounds: &ScreenBounds) -> Option<[u32; 2]> {
        let ScreenBounds { min, max, nearness } = *bounds;
        let all = (min[1]..=max[1]).flat_map(|y| (min[0]..=max[0]).map(move |x| [x, y]));
        all.into_iter().find(|&[x, y]| self.lets_through(x, y, nearness))
    }
}

/// A box whose projection has no bounds.
#[derive(Clone, Copy, Debug)]
struct Unbounded;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cull::occlusion::Convex;
    use crate::{Simd, Transform, View};

    #[test]
    fn bounds_are_hidden_where_the_box_is_and_cut_off_at_edges() {
        let view =
            View::perspective([0.0, 0.0, 10.0], [0.0; 3], 1.0, 0.1, 100.0, [203, 125]).unwrap();
        let mut buffer = OcclusionBuffer::new([203, 125]).unwrap();
        let whole = ScreenBounds { min: [0; 2], max: [202, 124], nearness: 0.01 };
        let level = Simd::best();
        assert_eq!(buffer.test_bounds(level, &whole), Visibility::Visible);
        buffer.begin(&view, [0.0; 3]);
        let wall = Convex::from_box(&Aabb::new([-3.0, -2.0, -0.1], [2.0, 4.0, 0.1])).unwrap();
        wall.draw(level, &mut buffer, &Transform::IDENTITY);
        let mut hidden = 0;
        for i in 0..400_u32 {
            let min = [-6.0 + (i % 20) as f32 * 0.5, -3.0 + (i / 20) as f32 * 0.3, -2.0];
            let b = Aabb::new(min, min.map(|v| v + 0.4));
            let Some(bounds) = buffer.screen_bounds(&b) else { continue };
            let found = buffer.test_bounds(level, &bounds);
            assert_eq!(found, buffer.test_box(&b));
            hidden += u32::from(found == Visibility::Hidden);
            let nan = ScreenBounds { nearness: f32::NAN, ..bounds };
            assert_eq!(buffer.test_bounds(level, &nan), Visibility::Visible);
        }
        assert!(hidden > 50, "{hidden}");
        let far = ScreenBounds { min: [100, 0], max: [u32::MAX; 2], nearness: 0.01 };
        assert_eq!(buffer.test_bounds(level, &far), Visibility::Visible);
        let beyond = ScreenBounds { min: [203, 0], ..far };
        assert_eq!(buffer.test_bounds(level, &beyond), Visibility::Outside);
        let turned = ScreenBounds { min: [5, 5], max: [4, 9], nearness: 0.01 };
        assert_eq!(buffer.test_bounds(level, &turned), Visibility::Outside);
    }
}
