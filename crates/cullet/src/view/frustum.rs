//! The frustum: a convex region of planes that point out.

use glam::{DMat4, DVec3, DVec4};

use super::Depth;
use crate::bounds::Plane;

/// The name of a plane of a frustum. Its number is what reasons and outcodes carry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
pub enum FrustumPlane {
    /// x = −w in clip space.
    Left = 0,
    /// x = w.
    Right = 1,
    /// y = −w.
    Bottom = 2,
    /// y = w.
    Top = 3,
    /// Where depth is nearest.
    Near = 4,
    /// Where depth is farthest; absent in a view without an end.
    Far = 5,
}

impl FrustumPlane {
    /// All six, by number.
    pub const ALL: [Self; 6] =
        [Self::Left, Self::Right, Self::Bottom, Self::Top, Self::Near, Self::Far];

    /// The plane's name, in lower case.
    #[must_use]
    pub const fn name(self) -> &'static str {
        ["left", "right", "bottom", "top", "near", "far"][self as usize]
    }
}

/// Up to [`Frustum::MAX_PLANES`] half-spaces n·x ≤ d with outward unit normals. The first six are the
/// view's own, each at the number of its [`FrustumPlane`]; a missing one (a far plane at infinity)
/// keeps its number and rejects nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct Frustum {
    planes: [Plane; Self::MAX_PLANES],
    /// Bit i: plane i exists.
    present: u32,
}

impl Frustum {
    /// The most planes that a region may have: one bit each in a u32.
    pub const MAX_PLANES: usize = 32;

    /// The region within six planes; `None` for one that is not there.
    #[must_use]
    pub fn from_planes(planes: [Option<Plane>; 6]) -> Self {
        let mut f = Self { planes: [Plane::default(); Self::MAX_PLANES], present: 0 };
        for (i, plane) in planes.into_iter().enumerate() {
            if let Some(plane) = plane {
                f.planes[i] = plane;
                f.present |= 1 << i;
            }
        }
        f
    }

    /// The planes of a matrix that takes world to clip space, by its rows (Gribb & Hartmann, *Fast
    /// Extraction of Viewing Frustum Planes*, 2001), turned to point out.
    pub(super) fn from_matrix(m: &DMat4, depth: Depth) -> Self {
        let (x, y, z, w) = (m.row(0), m.row(1), m.row(2), m.row(3));
        let (near, far) = match depth {
            Depth::Standard => (z, w - z),
            Depth::Reversed => (w - z, z),
        };
        // What is inside has a non-negative value in every row; the outward plane is its negation.
        let outward = |inside: DVec4, size: f64| {
            let n = -inside.truncate();
            let length = n.length();
            // Where nothing but rounding is left of the normal, the plane is at infinity.
            (length > size * 1e-14)
                .then(|| Plane { normal: (n / length).into(), d: inside.w / length })
        };
        let sizes = [w + x, w - x, w + y, w - y, near, far].map(|row| {
            outward(row, w.truncate().length() + z.truncate().length().min(x.truncate().length()))
        });
        Self::from_planes(sizes)
    }

    /// The planes that exist, with their numbers.
    pub fn planes(&self) -> impl Iterator<Item = (usize, &Plane)> {
        (0..Self::MAX_PLANES).filter(|i| self.present >> i & 1 == 1).map(|i| (i, &self.planes[i]))
    }

    /// Plane `which` of the view's six, if it exists.
    #[must_use]
    pub fn plane(&self, which: FrustumPlane) -> Option<&Plane> {
        (self.present >> which as u8 & 1 == 1).then(|| &self.planes[which as usize])
    }

    /// Bit i is set where plane i exists.
    #[must_use]
    pub fn present(&self) -> u32 {
        self.present
    }

    /// The same region for coordinates relative to `origin`.
    #[must_use]
    pub fn relative_to(&self, origin: [f64; 3]) -> Self {
        let mut f = self.clone();
        for p in &mut f.planes {
            p.d -= DVec3::from(p.normal).dot(DVec3::from(origin));
        }
        f
    }
}
