//! The eye as the bounds of clusters take it.

use super::ClusterPlanes;
use crate::array::{self, Each};

/// A homogeneous eye prepared for the bounds of clusters: a position or a direction, in f32.
///
/// Made once a view and mesh. Rounding to f32 is in the slack of the bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClusterEye {
    xyz: [f32; 3],
    /// 1 for a position, 0 for a direction.
    w: f32,
}

impl ClusterEye {
    /// From (position, 1) or (direction towards the viewer, 0), or a positive multiple of either,
    /// in the space of the cluster.
    ///
    /// `None`, which proves nothing, for a number that is not finite, a negative weight, a
    /// direction of no length, and a position beyond 1e14 units, whose squares f32 could not hold.
    #[must_use]
    pub fn new(eye: [f64; 4]) -> Option<Self> {
        let [x, y, z, w] = eye;
        let scale = if w > 0.0 { w } else { x.abs().max(y.abs()).max(z.abs()) };
        let xyz = [x, y, z].each(|v| v / scale);
        // Written so that NaN is not an eye. A direction has 1 for its largest number here.
        (w >= 0.0
            && w.is_finite()
            && scale > 0.0
            && xyz.iter().all(|v| v.abs() <= ClusterPlanes::LARGEST))
        .then(|| Self { xyz: xyz.each(|v| v as f32), w: f32::from(w > 0.0) })
    }

    /// Bound that a difference of squares must exceed: squares smaller than f32's normal numbers
    /// are off by 1e-45 or, where a processor flushes them, by 1e-38.
    pub const LEAST_SQUARE: f32 = 1e-36;

    /// The position, or the direction towards the viewer.
    #[inline(always)]
    #[must_use]
    pub fn xyz(&self) -> [f32; 3] {
        self.xyz
    }

    /// 1 for a position, 0 for a direction.
    #[inline(always)]
    #[must_use]
    pub fn weight(&self) -> f32 {
        self.w
    }

    /// From an apex to this eye.
    #[inline(always)]
    #[must_use]
    pub fn way_from(&self, apex: [f32; 3]) -> [f32; 3] {
        array::from_fn(|k| self.xyz[k] - apex[k] * self.w)
    }
}
