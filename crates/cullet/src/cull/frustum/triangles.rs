//! Triangles against the planes of a view: outcodes in the space of their mesh.
//!
//! A triangle is rejected if all its corners are proved outside one plane, and kept otherwise.

use alloc::vec::Vec;
use core::ops::Range;

use glam::DVec3;

use crate::array::Each;
use crate::bits;
use crate::transform::Transform;
use crate::view::Frustum;

/// Units of rounding that a vertex may be off: this test's own, and that of whoever transforms and
/// clips it in f64 with operations of their own (some twenty, each of half an epsilon).
const ROUNDING: f64 = 32.0 * f64::EPSILON;

/// A plane n·x = d in the space of a mesh, with the error of n·x − d.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ObjectPlane {
    /// n, which points out and need not have unit length.
    pub normal: [f64; 3],
    /// d.
    pub d: f64,
    /// Constant part of the error.
    pub error: f64,
    /// Part of the error that grows with each absolute coordinate.
    pub error_per: [f64; 3],
}

impl ObjectPlane {
    /// Returns n·p − d, and the most that rounding may have changed it by.
    #[inline]
    #[must_use]
    pub fn height(&self, p: [f64; 3]) -> (f64, f64) {
        let p = DVec3::from(p);
        let error = DVec3::from(self.error_per).dot(p.abs()) + self.error;
        (DVec3::from(self.normal).dot(p) - self.d, error)
    }
}

/// A convex region in the space of a mesh.
///
/// A plane whose numbers are not finite in that space, because the transform's are not, excludes
/// nothing and includes nothing.
#[derive(Clone, Debug)]
pub struct ObjectRegion {
    planes: [ObjectPlane; Frustum::MAX_PLANES],
    present: u32,
}

impl ObjectRegion {
    /// Returns `frustum` in the space of an instance. Both are relative to the same origin; a
    /// transform of any rank will do.
    #[must_use]
    pub fn new(frustum: &Frustum, transform: &Transform) -> Self {
        let mut planes = [ObjectPlane::default(); Frustum::MAX_PLANES];
        let l = transform.linear_f64();
        let t = DVec3::from(transform.translation);
        for (i, plane) in frustum.planes() {
            let n = DVec3::from(plane.normal);
            let columns = [l.x_axis, l.y_axis, l.z_axis];
            let size = n.abs().dot(t.abs()) + plane.d.abs();
            planes[i] = ObjectPlane {
                normal: columns.each(|c| c.dot(n)),
                d: plane.d - n.dot(t),
                error: size * ROUNDING + f64::MIN_POSITIVE,
                error_per: columns.each(|c| c.abs().dot(n.abs()) * ROUNDING),
            };
        }
        Self { planes, present: frustum.present() }
    }

    /// Bit i is set where plane i exists.
    #[must_use]
    pub fn present(&self) -> u32 {
        self.present
    }

    /// Returns the planes and their numbers, ascending.
    pub fn planes(&self) -> impl Iterator<Item = (usize, &ObjectPlane)> {
        bits::ones(u64::from(self.present)).map(|i| (i, &self.planes[i]))
    }

    /// Returns the number of the first plane of `active` that a triangle is wholly outside of: the
    /// planes that its cluster straddles are the only ones to test. `None` keeps it.
    #[inline]
    #[must_use]
    pub fn rejects(&self, corners: &[[f32; 3]; 3], active: u32) -> Option<u8> {
        let corners = corners.each(|p| p.each(f64::from));
        // False for a NaN.
        let is_outside = |plane: &ObjectPlane, p| {
            let (height, error) = plane.height(p);
            height > error
        };
        bits::ones(u64::from(active & self.present))
            .find(|&i| corners.iter().all(|&p| is_outside(&self.planes[i], p)))
            .map(|i| i as u8)
    }

    /// Appends the numbers of those triangles of `range` that are not rejected by a plane of
    /// `active`, ascending. Returns how many. `indices` is the whole index list; a triangle beyond
    /// it is left out, and one whose vertices are out of range is kept. At most `range.len()` are
    /// appended.
    pub fn keep_into(
        &self,
        positions: &[[f32; 3]],
        indices: &[u32],
        range: Range<u32>,
        active: u32,
        kept: &mut Vec<u32>,
    ) -> usize {
        let before = kept.len();
        let end = (range.end as usize).min(indices.len() / 3);
        let start = (range.start as usize).min(end);
        let triangles = indices[start * 3..end * 3].as_chunks::<3>().0;
        for (t, corners) in (range.start..).zip(triangles) {
            let at = |i: usize| positions.get(corners[i] as usize).copied();
            let rejected = match (at(0), at(1), at(2)) {
                (Some(a), Some(b), Some(c)) => self.rejects(&[a, b, c], active).is_some(),
                _ => false,
            };
            if !rejected {
                kept.push(t);
            }
        }
        kept.len() - before
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounds::Plane;

    /// The unit cube around the origin.
    fn cube() -> Frustum {
        let plane = |normal| Some(Plane::new(normal, 1.0));
        Frustum::from_planes([
            plane([-1.0, 0.0, 0.0]),
            plane([1.0, 0.0, 0.0]),
            plane([0.0, -1.0, 0.0]),
            plane([0.0, 1.0, 0.0]),
            plane([0.0, 0.0, 1.0]),
            None,
        ])
    }

    #[test]
    fn triangles_are_rejected_by_active_planes_alone() {
        let region = ObjectRegion::new(&cube(), &Transform::from_translation([10.0, 0.0, 0.0]));
        let at = |x: f32| [[x, 0.0, 0.0], [x + 0.5, 0.5, 0.0], [x, 0.5, 0.5]];
        assert_eq!(region.rejects(&at(-10.0), u32::MAX), None);
        assert_eq!(region.rejects(&at(-9.2), u32::MAX), None);
        assert_eq!(region.rejects(&at(0.0), u32::MAX), Some(1));
        assert_eq!(region.rejects(&at(0.0), 0b01), None, "only the active planes count");
        // Around a corner of the region: outside, but of no single plane.
        let around = [[-7.0, 0.0, 0.0], [-10.0, 3.0, 0.0], [-8.0, 2.0, 0.0]];
        assert_eq!(region.rejects(&around, u32::MAX), None);
    }

    #[test]
    fn a_triangle_in_a_plane_is_not_outside_of_it() {
        let plane = Some(Plane::new([0.0, 0.0, 1.0], 0.0));
        let frustum = Frustum::from_planes([plane, None, None, None, None, None]);
        let region = ObjectRegion::new(&frustum, &Transform::IDENTITY);
        let at = |z: f32| [[1.0, 0.0, z], [0.0, 1.0, z], [-1.0, 0.0, z]];
        assert_eq!(region.rejects(&at(0.0), u32::MAX), None);
        assert_eq!(region.rejects(&at(1e-30), u32::MAX), Some(0));
    }

    #[test]
    fn a_transform_that_is_not_finite_keeps_everything() {
        let broken = Transform { linear: [[f32::NAN; 3]; 3], ..Transform::IDENTITY };
        let region = ObjectRegion::new(&cube(), &broken);
        assert_eq!(region.rejects(&[[9.0; 3], [8.0; 3], [7.0; 3]], u32::MAX), None);
    }
}
