//! The frustum: a convex region of planes that point out.

use glam::{DMat4, DVec3, DVec4};

use super::corners::{self, Corner};
use super::{Depth, ViewError};
use crate::array::Each;
use crate::bounds::{Aabb, Plane, ROUNDING, dot2};
use crate::transform::Transform;

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

/// Up to [`Frustum::MAX_PLANES`] half-spaces n·x ≤ d with outward unit normals. The first six are
/// the view's own, each at the number of its [`FrustumPlane`]; a missing one (a far plane at
/// infinity) keeps its number and rejects nothing. More, with numbers from 6, may be added: a
/// portal's edges, a section plane.
///
/// A frustum made from a [`View`](super::View) is never smaller than the volume the view's matrix
/// shows, nor than what a renderer that works in f64 lets through after rounding.
#[derive(Clone, Debug, PartialEq)]
pub struct Frustum {
    planes: [Plane; Self::MAX_PLANES],
    /// Bit i: plane i exists.
    present: u32,
}

impl Frustum {
    /// The most planes that a region may have: one bit each in a u32.
    pub const MAX_PLANES: usize = 32;

    /// The region without planes, which rejects nothing.
    #[must_use]
    pub fn everything() -> Self {
        Self::from_planes([None; 6])
    }

    /// The region within six planes, each taken as it is; `None` for one that is not there. A plane
    /// with a number that is not finite, or with a zero normal, counts as not there: it proves
    /// nothing.
    #[must_use]
    pub fn from_planes(planes: [Option<Plane>; 6]) -> Self {
        let mut f = Self { planes: [Plane::default(); Self::MAX_PLANES], present: 0 };
        for (i, plane) in planes.into_iter().enumerate() {
            if let Some(plane) = plane {
                f.set(i, plane);
            }
        }
        f
    }

    pub(super) fn set(&mut self, i: usize, plane: Plane) {
        if plane.is_finite() && plane.normal != [0.0; 3] {
            self.planes[i] = plane;
            self.present |= 1 << i;
        }
    }

    /// Adds one more half-space, normalised, and returns its number, the lowest free one from 6 on.
    ///
    /// # Errors
    /// If all 26 numbers are taken, or the plane's normal has no direction, or a number is not
    /// finite.
    pub fn push(&mut self, plane: Plane) -> Result<usize, ViewError> {
        let normalized = plane.normalized().ok_or(ViewError::NoPlane(plane))?;
        let number = (6..Self::MAX_PLANES)
            .find(|i| self.present >> i & 1 == 0)
            .ok_or(ViewError::TooManyPlanes { limit: Self::MAX_PLANES })?;
        self.set(number, normalized);
        Ok(number)
    }

    /// The planes of a matrix that takes world to clip space, by its rows (Gribb & Hartmann, *Fast
    /// Extraction of Viewing Frustum Planes*, 2001), turned to point out.
    pub(super) fn from_matrix(m: &DMat4, depth: Depth) -> Self {
        let (x, y, z, w) = (m.row(0), m.row(1), m.row(2), m.row(3));
        let zero = DVec4::ZERO;
        // A point inside has a non-negative value in every row: the sum of these two.
        let rows = match depth {
            Depth::Standard => [(w, x), (w, -x), (w, y), (w, -y), (z, zero), (w, -z)],
            Depth::Reversed => [(w, x), (w, -x), (w, y), (w, -y), (w, -z), (z, zero)],
        };
        let mut f = Self::from_planes(rows.each(|(a, b)| {
            let inside = a + b;
            let n = -inside.truncate();
            // Where nothing but the rounding of the two rows is left of the normal, the plane is at
            // infinity: what direction remains is noise. Dropping a plane errs towards keep, so the
            // threshold may be generous; 16 u costs a far plane only beyond 1e14 times the distance
            // of the near one.
            let noise = (a.truncate().length() + b.truncate().length()) * ROUNDING;
            // Plain length: rows that over- or underflow make no plane that could be trusted.
            let length = n.length();
            (length > noise).then(|| Plane { normal: (n / length).into(), d: inside.w / length })
        }));
        // A renderer compares two rounded rows (z ≤ w), and is off by their size, not by that of
        // their difference: near the far plane 1e-16 in clip depth can be whole units of the scene.
        // A plane whose rows cancel gives way by as much as that is at its farthest corner; the
        // tests allow for the rest.
        for (i, (a, b)) in rows.into_iter().enumerate() {
            let size = |v: DVec4| v.truncate().length();
            let cancels = size(a) + size(b) > 4.0 * size(a + b);
            if !cancels || f.present >> i & 1 == 0 {
                continue;
            }
            let Some(corners) = f.corners_with_error() else { break };
            let give = (0..8)
                .filter(|&c| corners::lies_on(c, i) && !corners[c].at_infinity)
                .map(|c| (a.abs() + b.abs()).dot(corners[c].point.abs().extend(1.0)))
                .fold(0.0, f64::max);
            let give = give * ROUNDING / size(a + b);
            if give.is_finite() {
                f.planes[i].d += give;
            }
        }
        f
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

    /// Whether `point` is inside every plane or on it, by f64 arithmetic. NaN is inside: nothing
    /// rejects it.
    #[must_use]
    pub fn contains(&self, point: impl Into<[f64; 3]>) -> bool {
        let p = point.into();
        !self.planes().any(|(_, plane)| plane.distance(p) > 0.0)
    }

    /// The eight corners as homogeneous points: (x, y, z, 1), or (direction, 0) for the far corners
    /// of a frustum without a far plane. Bit 0, 1, 2 of the index choose the right, top, far side.
    ///
    /// `None` where a side or the near plane is missing, or where the planes do not make the six
    /// sides of such a body (a view whose far plane is behind its eye, planes that are almost
    /// parallel). Planes from 6 on are not looked at. Rounded.
    #[must_use]
    pub fn corners(&self) -> Option<[[f64; 4]; 8]> {
        self.corners_with_error()
            .map(|all| all.each(|c| c.point.extend(if c.at_infinity { 0.0 } else { 1.0 }).into()))
    }

    /// Returns a box around the frustum, rounded outward; `None` where it has no end or its corners
    /// are unknown.
    pub(crate) fn bounds(&self) -> Option<Aabb> {
        let corners = self.corners_with_error()?;
        if corners.iter().any(|corner| corner.at_infinity) {
            return None;
        }
        let (min, max) =
            corners.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), c| {
                (min.min(c.point - c.error), max.max(c.point + c.error))
            });
        Some(Aabb::rounded_out(min.into(), max.into()))
    }

    /// [`corners`](Self::corners), with what rounding may have done to each.
    pub(crate) fn corners_with_error(&self) -> Option<[Corner; 8]> {
        corners::of(FrustumPlane::ALL.each(|which| self.plane(which)))
    }

    /// The same region for coordinates relative to `origin`. Each d is rounded once, however large
    /// the origin is.
    #[must_use]
    pub fn relative_to(&self, origin: [f64; 3]) -> Self {
        let mut f = Self { present: 0, ..self.clone() };
        for (i, plane) in self.planes() {
            f.set(i, plane.relative_to(origin));
        }
        f
    }

    /// The same region in the space of an object that `transform` (relative to the same origin as
    /// the frustum) puts into the world: x is in it iff its image is in the frustum. Normals go by
    /// the transpose of the linear part, so mirrored, sheared and singular transforms are right,
    /// and are made unit again: distances are in units of the object.
    ///
    /// Each number is computed in twice the precision of f64 and rounded once. A plane whose normal
    /// vanishes (a transform flattened along it) or drowns in rounding is left out and so rejects
    /// nothing: the object's box in the world is what such a plane can be tested with. A transform
    /// that is not finite gives a region without planes.
    #[must_use]
    pub fn to_object_space(&self, transform: &Transform) -> Self {
        let mut f = Self::everything();
        for (i, plane) in self.planes_in_object_space(transform, u32::MAX) {
            f.set(i, plane);
        }
        f
    }

    /// The planes of [`to_object_space`](Self::to_object_space) whose bits are set in `wanted`,
    /// with their numbers.
    pub(crate) fn planes_in_object_space(
        &self,
        transform: &Transform,
        wanted: u32,
    ) -> impl Iterator<Item = (usize, Plane)> {
        let wanted = if transform.is_finite() { wanted } else { 0 };
        let planes = self.planes().filter(move |(i, _)| wanted >> i & 1 == 1);
        planes.filter_map(move |(i, plane)| {
            let columns = transform.linear.each(|c| dot2(plane.normal, c.each(f64::from), 0.0));
            let normal = DVec3::from(columns.each(|c| c.0));
            let error = columns.iter().map(|c| c.1).fold(0.0, f64::max);
            let length = normal.length();
            let d = -dot2(plane.normal, transform.translation, -plane.d).0;
            let plane = Plane { normal: (normal / length).into(), d: d / length };
            (error <= length * ROUNDING && plane.is_finite()).then_some((i, plane))
        })
    }
}
