//! Axis-aligned boxes.

use bytemuck::{Pod, Zeroable};

use super::plane::ROUNDING;
use super::{Plane, Side};
use crate::array::{self, Each};

/// An axis-aligned box. Empty when some `min` exceeds its `max`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(C)]
pub struct Aabb {
    /// The lowest corner.
    pub min: [f32; 3],
    /// The highest corner.
    pub max: [f32; 3],
}

impl Aabb {
    /// The box of nothing: joining it with another gives the other.
    pub const EMPTY: Self = Self { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };
    /// The whole of space; what stands for missing or non-finite bounds.
    pub const EVERYTHING: Self = Self { min: [f32::NEG_INFINITY; 3], max: [f32::INFINITY; 3] };

    /// The box between two corners, taken as they are.
    #[must_use]
    pub const fn new(min: [f32; 3], max: [f32; 3]) -> Self {
        Self { min, max }
    }

    /// The smallest box around `points`; [`Aabb::EMPTY`] for none. Exact: no rounding is involved.
    /// A NaN coordinate gives [`Aabb::EVERYTHING`]; an infinite one reaches to infinity.
    #[must_use]
    pub fn from_points(points: &[[f32; 3]]) -> Self {
        let mut b = Self::EMPTY;
        let mut nan = false;
        for p in points {
            for axis in 0..3 {
                b.min[axis] = b.min[axis].min(p[axis]);
                b.max[axis] = b.max[axis].max(p[axis]);
                nan |= p[axis].is_nan();
            }
        }
        if nan { Self::EVERYTHING } else { b }
    }

    /// The smallest f32 box that holds the f64 box `min`..`max`: rounded outward.
    #[must_use]
    pub fn rounded_out(min: [f64; 3], max: [f64; 3]) -> Self {
        Self { min: min.each(round_down), max: max.each(round_up) }
    }

    /// Whether there is no point in the box. One with a NaN coordinate is not empty: what it holds
    /// is not known.
    #[must_use]
    #[inline]
    pub fn is_empty(&self) -> bool {
        !self.has_nan() && (0..3).any(|a| self.min[a] > self.max[a])
    }

    /// Whether all six numbers are finite.
    #[must_use]
    #[inline]
    pub fn is_finite(&self) -> bool {
        self.min.iter().chain(&self.max).all(|v| v.is_finite())
    }

    #[inline]
    pub(crate) fn has_nan(&self) -> bool {
        self.min.iter().chain(&self.max).any(|v| v.is_nan())
    }

    /// The smallest box around both; [`Aabb::EVERYTHING`] where either has a NaN coordinate.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        if self.has_nan() || other.has_nan() {
            return Self::EVERYTHING;
        }
        let mut b = *self;
        for a in 0..3 {
            b.min[a] = b.min[a].min(other.min[a]);
            b.max[a] = b.max[a].max(other.max[a]);
        }
        b
    }

    /// Returns the box that lies in both; empty where they do not meet.
    #[must_use]
    pub fn intersection(&self, other: &Self) -> Self {
        let (mut min, mut max) = (self.min, self.max);
        for a in 0..3 {
            (min[a], max[a]) = (min[a].max(other.min[a]), max[a].min(other.max[a]));
        }
        Self { min, max }
    }

    /// Whether `point` is in the box, its surface included.
    #[must_use]
    pub fn contains(&self, point: [f32; 3]) -> bool {
        (0..3).all(|a| self.min[a] <= point[a] && point[a] <= self.max[a])
    }

    /// The middle of the box, in f64 so that nothing is rounded away.
    #[must_use]
    pub fn center(&self) -> [f64; 3] {
        array::from_fn(|a| (f64::from(self.min[a]) + f64::from(self.max[a])) * 0.5)
    }

    /// Half the length of each side.
    #[must_use]
    pub fn half_extent(&self) -> [f64; 3] {
        array::from_fn(|a| (f64::from(self.max[a]) - f64::from(self.min[a])) * 0.5)
    }

    /// The area of the surface; 0 for an empty box.
    #[must_use]
    pub fn surface_area(&self) -> f64 {
        if self.is_empty() { 0.0 } else { surface_area(self.half_extent()) }
    }

    /// The eight corners; bit 0, 1, 2 of the index choose the high x, y, z.
    #[must_use]
    pub fn corners(&self) -> [[f32; 3]; 8] {
        array::from_fn(|i| {
            array::from_fn(|a| if i >> a & 1 == 1 { self.max[a] } else { self.min[a] })
        })
    }

    /// The lowest and the highest n·x − d over the box (its n-vertex and p-vertex), each rounded
    /// outward so that the true values lie between them. The normal need not be of unit length.
    ///
    /// Empty gives `[∞, −∞]`, a NaN coordinate `[−∞, ∞]`; infinite sides count as what they are.
    ///
    /// (Assarsson & Möller, *Optimized View Frustum Culling Algorithms for Bounding Boxes*, 2000.)
    #[must_use]
    pub fn span(&self, plane: &Plane) -> [f64; 2] {
        if self.has_nan() {
            return [f64::NEG_INFINITY, f64::INFINITY];
        }
        if self.is_empty() {
            return [f64::INFINITY, f64::NEG_INFINITY];
        }
        let (mut low, mut high) = (-plane.d, -plane.d);
        let (mut low_size, mut high_size) = (plane.d.abs(), plane.d.abs());
        for a in 0..3 {
            let n = plane.normal[a];
            // 0 · ∞ is NaN, yet a side along the plane does not matter however long it is.
            if n == 0.0 {
                continue;
            }
            let (min, max) = (n * f64::from(self.min[a]), n * f64::from(self.max[a]));
            let (near, far) = if n > 0.0 { (min, max) } else { (max, min) };
            low += near;
            high += far;
            low_size += near.abs();
            high_size += far.abs();
        }
        let slack = |size: f64| size * ROUNDING + f64::MIN_POSITIVE;
        [low - slack(low_size), high + slack(high_size)]
    }

    /// Where the box lies: each of the two certain answers is proved, rounding included. Empty is
    /// [`Side::Outside`] (there is nothing to see), NaN is [`Side::Straddling`].
    #[must_use]
    pub fn side(&self, plane: &Plane) -> Side {
        Side::from_span(self.span(plane))
    }
}

/// The surface of a box with these half sides.
pub(crate) fn surface_area(h: [f64; 3]) -> f64 {
    8.0 * (h[0] * h[1] + h[1] * h[2] + h[2] * h[0])
}

/// The largest f32 not above `v`. NaN stays NaN.
pub(crate) fn round_down(v: f64) -> f32 {
    let f = v as f32;
    if f64::from(f) > v { f.next_down() } else { f }
}

/// The smallest f32 not below `v`. NaN stays NaN.
pub(crate) fn round_up(v: f64) -> f32 {
    let f = v as f32;
    if f64::from(f) < v { f.next_up() } else { f }
}

#[cfg(test)]
mod tests {
    use super::*;

    const X: Plane = Plane::new([1.0, 0.0, 0.0], 0.0);

    #[test]
    fn three_answers_and_their_edges() {
        let from = |min: f32, max: f32| Aabb::new([min, -1.0, -1.0], [max, 1.0, 1.0]);
        assert_eq!(from(1.0, 2.0).side(&X), Side::Outside);
        assert_eq!(from(-2.0, -1.0).side(&X), Side::Inside);
        assert_eq!(from(-1.0, 1.0).side(&X), Side::Straddling);
        assert_eq!(from(0.0, 1.0).side(&X), Side::Straddling, "touching is kept");
        assert_eq!(from(f32::MIN_POSITIVE, 1.0).side(&X), Side::Outside);
    }

    #[test]
    fn empty_nan_and_infinite_boxes() {
        assert_eq!(Aabb::EMPTY.side(&X), Side::Outside);
        assert_eq!(Aabb::EVERYTHING.side(&X), Side::Straddling);
        let mut b = Aabb::new([1.0; 3], [2.0; 3]);
        b.max[1] = f32::INFINITY;
        assert_eq!(b.side(&X), Side::Outside, "y does not matter to a plane of x");
        b.max[1] = f32::NAN;
        assert_eq!(b.side(&X), Side::Straddling);
        let half_space = Aabb::new([1.0, f32::NEG_INFINITY, f32::NEG_INFINITY], [f32::INFINITY; 3]);
        assert_eq!(half_space.side(&X), Side::Outside);
        assert_eq!(half_space.side(&Plane::new([0.6, 0.8, 0.0], 0.0)), Side::Straddling);
    }

    #[test]
    fn a_nan_point_gives_everything() {
        assert_eq!(Aabb::from_points(&[[0.0; 3], [f32::NAN, 1.0, 2.0]]), Aabb::EVERYTHING);
        assert_eq!(Aabb::from_points(&[]), Aabb::EMPTY);
    }
}
