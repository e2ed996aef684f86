//! Axis-aligned boxes.

use bytemuck::{Pod, Zeroable};

/// An axis-aligned box. Empty when some `min` exceeds its `max`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
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
    /// A NaN coordinate is skipped.
    #[must_use]
    pub fn from_points(points: &[[f32; 3]]) -> Self {
        let mut b = Self::EMPTY;
        for p in points {
            for axis in 0..3 {
                b.min[axis] = b.min[axis].min(p[axis]);
                b.max[axis] = b.max[axis].max(p[axis]);
            }
        }
        b
    }

    /// The smallest f32 box that holds the f64 box `min`..`max`: rounded outward.
    #[must_use]
    pub fn rounded_out(min: [f64; 3], max: [f64; 3]) -> Self {
        Self { min: min.map(round_down), max: max.map(round_up) }
    }

    /// Whether there is no point in the box.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        (0..3).any(|a| self.min[a] > self.max[a])
    }

    /// Whether all six numbers are finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.min.iter().chain(&self.max).all(|v| v.is_finite())
    }

    /// The smallest box around both.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        let mut b = *self;
        for a in 0..3 {
            b.min[a] = b.min[a].min(other.min[a]);
            b.max[a] = b.max[a].max(other.max[a]);
        }
        b
    }

    /// Whether `point` is in the box, its surface included.
    #[must_use]
    pub fn contains(&self, point: [f32; 3]) -> bool {
        (0..3).all(|a| self.min[a] <= point[a] && point[a] <= self.max[a])
    }

    /// The middle of the box, in f64 so that nothing is rounded away.
    #[must_use]
    pub fn center(&self) -> [f64; 3] {
        std::array::from_fn(|a| (f64::from(self.min[a]) + f64::from(self.max[a])) * 0.5)
    }

    /// Half the length of each side.
    #[must_use]
    pub fn half_extent(&self) -> [f64; 3] {
        std::array::from_fn(|a| (f64::from(self.max[a]) - f64::from(self.min[a])) * 0.5)
    }

    /// The eight corners; bit 0, 1, 2 of the index choose the high x, y, z.
    #[must_use]
    pub fn corners(&self) -> [[f32; 3]; 8] {
        std::array::from_fn(|i| {
            std::array::from_fn(|a| if i >> a & 1 == 1 { self.max[a] } else { self.min[a] })
        })
    }
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
