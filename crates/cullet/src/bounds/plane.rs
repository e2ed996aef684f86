//! Planes n·x = d and the side of them a thing is on.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

/// Where something lies relative to a plane, or to a convex region of planes that point out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// Wholly on the negative side of every plane.
    Inside,
    /// Neither proved inside nor proved outside.
    Straddling,
    /// Wholly on the positive side of some plane.
    Outside,
}

/// The plane n·x = d. With a unit normal, n·x − d is the signed distance of x: positive on the side
/// the normal points to, which for the planes of a frustum is the outside.
#[derive(Clone, Copy, Debug, PartialEq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct Plane {
    /// The normal, of unit length unless a function says otherwise.
    pub normal: [f64; 3],
    /// The offset along the normal.
    pub d: f64,
}

impl Plane {
    /// The plane with this normal and offset, as they are: the normal is not normalised.
    #[must_use]
    pub const fn new(normal: [f64; 3], d: f64) -> Self {
        Self { normal, d }
    }

    /// The plane through `point` with this normal, which is normalised.
    ///
    /// `None` where the normal has no direction (zero or not finite).
    #[must_use]
    pub fn from_point_normal(
        point: impl Into<[f64; 3]>,
        normal: impl Into<[f64; 3]>,
    ) -> Option<Self> {
        let n = DVec3::from(normal.into()).try_normalize()?;
        Some(Self { normal: n.into(), d: n.dot(DVec3::from(point.into())) })
    }

    /// The plane through three points, its normal towards the side from which they are seen
    /// counter-clockwise. `None` where they are collinear.
    #[must_use]
    pub fn from_points(
        a: impl Into<[f64; 3]>,
        b: impl Into<[f64; 3]>,
        c: impl Into<[f64; 3]>,
    ) -> Option<Self> {
        let (a, b, c) = (DVec3::from(a.into()), DVec3::from(b.into()), DVec3::from(c.into()));
        Self::from_point_normal(a, (b - a).cross(c - a))
    }

    /// The same plane with a normal of unit length; `None` where the normal has no direction.
    #[must_use]
    pub fn normalized(self) -> Option<Self> {
        let length = DVec3::from(self.normal).length();
        (length > 0.0 && length.is_finite()).then(|| Self {
            normal: (DVec3::from(self.normal) / length).into(),
            d: self.d / length,
        })
    }

    /// n·x − d: the signed distance of `point` when the normal has unit length.
    #[must_use]
    pub fn distance(&self, point: impl Into<[f64; 3]>) -> f64 {
        DVec3::from(self.normal).dot(DVec3::from(point.into())) - self.d
    }
}
