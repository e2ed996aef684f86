//! A convex body by its corners, which planes cut.

use glam::DVec3;

use crate::bounds::{Plane, ROUNDING};
use crate::view::corners::Corner;

/// A box cut by p planes has at most 2 (6 + p) − 4 corners, 80 for 36 planes; the rest is for
/// corners that rounding makes twice.
const MAX_VERTICES: usize = 128;

/// 6 faces of a box, 32 planes of a frustum and 8 sides of a cone; one bit each.
const MAX_PLANES: usize = 6 + 32 + super::Light::CONE_SIDES;

/// Largest displacement of a corner by all cuts together, relative to the size of its coordinates:
/// three roundings and one of [`ROUNDING`] for each of at most 40 cuts, with room to spare.
const CUTS: f64 = 64.0 * ROUNDING;

/// A corner and the planes that it lies on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    /// The point; a unit direction where it is at infinity.
    pub(super) point: DVec3,
    pub(super) at_infinity: bool,
    /// Bit i: it lies on plane i.
    pub(super) planes: u64,
}

/// A convex body: the hull of its corners.
///
/// Corners are told apart by the planes they lie on and not by where they are, so that the body
/// stays consistent however degenerate it is: an edge is a pair of corners that share two planes.
/// Where rounding makes pairs that are no edges, their cuts add corners within the body, which do
/// no harm.
#[derive(Clone, Debug)]
pub(super) struct Body {
    vertices: [Vertex; MAX_VERTICES],
    count: usize,
    planes: [Plane; MAX_PLANES],
    plane_count: usize,
    /// No point of the true body is farther than this from the hull of the corners.
    pub(super) error: f64,
    /// The same for corners at infinity, as a part of their unit length.
    pub(super) direction_error: f64,
}

impl Body {
    fn empty() -> Self {
        let vertex = Vertex { point: DVec3::ZERO, at_infinity: false, planes: 0 };
        Self {
            vertices: [vertex; MAX_VERTICES],
            count: 0,
            planes: [Plane::default(); MAX_PLANES],
            plane_count: 0,
            error: 0.0,
            direction_error: 0.0,
        }
    }

    /// A box, with planes low x, high x, low y and so on. Flat ones are bodies as well.
    pub(super) fn in_box(min: DVec3, max: DVec3) -> Self {
        let mut body = Self::empty();
        body.plane_count = 6;
        for (axis, unit) in DVec3::AXES.into_iter().enumerate() {
            body.planes[2 * axis] = Plane { normal: (-unit).into(), d: -min[axis] };
            body.planes[2 * axis + 1] = Plane { normal: unit.into(), d: max[axis] };
        }
        for corner in 0..8 {
            let mut v = Vertex { point: min, at_infinity: false, planes: 0 };
            for axis in 0..3 {
                let high = corner >> axis & 1;
                v.planes |= 1 << (2 * axis + high);
                if high == 1 {
                    v.point[axis] = max[axis];
                }
            }
            body.vertices[corner] = v;
        }
        body.count = 8;
        body.error = min.abs().max(max.abs()).element_sum() * CUTS;
        body
    }

    /// A frustum with these corners and its first six planes; a missing far plane lies at infinity.
    pub(super) fn of_corners(planes: [Option<Plane>; 6], corners: &[Corner; 8]) -> Self {
        let mut body = Self::empty();
        body.plane_count = 6;
        for (to, plane) in body.planes.iter_mut().zip(planes) {
            *to = plane.unwrap_or_default();
        }
        for (i, corner) in corners.iter().enumerate() {
            let sides = [i & 1, 2 + (i >> 1 & 1), 4 + (i >> 2)];
            let planes = sides.iter().fold(0, |bits, side| bits | 1 << side);
            body.vertices[i] =
                Vertex { point: corner.point, at_infinity: corner.at_infinity, planes };
            let size = corner.point.abs().element_sum() * ROUNDING;
            let error =
                if corner.at_infinity { &mut body.direction_error } else { &mut body.error };
            *error = error.max(corner.error * 2.0 + size);
        }
        body.count = 8;
        body
    }

    pub(super) fn vertices(&self) -> &[Vertex] {
        &self.vertices[..self.count]
    }

    /// The planes, with their numbers; those that have been cut away included.
    pub(super) fn planes(&self) -> impl Iterator<Item = (usize, &Plane)> {
        self.planes[..self.plane_count].iter().enumerate()
    }

    pub(super) fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Pairs of corners that share two planes: all edges, and what degeneracy adds.
    pub(super) fn edges(&self) -> impl Iterator<Item = (&Vertex, &Vertex)> {
        let all = self.vertices();
        all.iter().enumerate().flat_map(move |(i, a)| {
            all[i + 1..]
                .iter()
                .filter(move |b| (a.planes & b.planes).count_ones() >= 2)
                .map(move |b| (a, b))
        })
    }

    /// Cuts off what is outside a plane, which gets the next number; returns that. `None` where the
    /// plane is not needed (it cuts nothing off, or there is no room for its corners) and the body
    /// stays as it is, which is right as well: it may be larger than it need be.
    ///
    /// Why nothing is lost: the plane is first moved out by more than a corner's distance to it may
    /// be off by. Of an edge that it cuts, what is left therefore reaches beyond the true plane,
    /// whatever the angle between the two; and the hull of those parts holds all that the plane
    /// leaves of the body.
    ///
    /// For bodies without corners at infinity.
    pub(super) fn cut(&mut self, plane: &Plane) -> Option<usize> {
        if self.plane_count == MAX_PLANES {
            return None;
        }
        let n = DVec3::from(plane.normal);
        let d = plane.d + self.error * 2.0 + plane.d.abs() * ROUNDING;
        let mut distance = [0.0; MAX_VERTICES];
        let distance = &mut distance[..self.count];
        for (s, v) in distance.iter_mut().zip(self.vertices()) {
            *s = n.dot(v.point) - d;
        }
        // Coordinates so large that they overflow are not cut.
        if !distance.iter().all(|s| s.is_finite()) {
            return None;
        }
        let inside = |i: usize| distance[i] <= 0.0;
        let before = self.count;
        if (0..before).all(inside) {
            return None;
        }
        let number = self.plane_count;
        for i in (0..before).filter(|&i| inside(i)) {
            for j in (0..before).filter(|&j| !inside(j)) {
                let (a, b) = (self.vertices[i], self.vertices[j]);
                let shared = a.planes & b.planes;
                if shared.count_ones() < 2 {
                    continue;
                }
                let t = distance[i] / (distance[i] - distance[j]);
                let point = a.point + (b.point - a.point) * t;
                let Some(place) = self.vertices.get_mut(self.count) else {
                    self.count = before;
                    return None;
                };
                *place = Vertex { point, planes: shared | 1 << number, ..a };
                self.count += 1;
            }
        }
        // Those that are left, with the new ones after them.
        let left = (0..self.count).filter(|&i| i >= before || inside(i));
        let mut count = 0;
        for i in left {
            self.vertices[count] = self.vertices[i];
            count += 1;
        }
        self.count = count;
        self.planes[number] = *plane;
        self.plane_count += 1;
        Some(number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn extent(body: &Body, axis: usize) -> [f64; 2] {
        body.vertices().iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| {
            [low.min(v.point[axis]), high.max(v.point[axis])]
        })
    }

    #[test]
    fn a_cube_without_a_corner_has_ten() {
        let mut body = Body::in_box(DVec3::ZERO, DVec3::ONE);
        assert_eq!((body.vertices().len(), body.edges().count()), (8, 12));
        let n = DVec3::ONE.normalize();
        let corner = Plane { normal: n.into(), d: n.dot(DVec3::splat(0.9)) };
        assert_eq!(body.cut(&corner), Some(6));
        assert_eq!((body.vertices().len(), body.edges().count()), (10, 15));
        let away = Plane { normal: n.into(), d: 2.0 };
        assert_eq!(body.cut(&away), None);
        assert_eq!(body.vertices().len(), 10);
    }

    #[test]
    fn cuts_through_corners_and_along_faces_stay_consistent() {
        let mut body = Body::in_box(DVec3::ZERO, DVec3::ONE);
        let h = 0.5_f64.sqrt();
        // Through four corners, twice the same, and one along a face.
        body.cut(&Plane { normal: [h, h, 0.0], d: h });
        body.cut(&Plane { normal: [h, h, 0.0], d: h });
        body.cut(&Plane { normal: [0.0, 0.0, 1.0], d: 1.0 });
        body.cut(&Plane { normal: [1.0, 0.0, 0.0], d: 0.25 });
        for (axis, high) in [0.25, 1.0, 1.0].into_iter().enumerate() {
            let [low, top] = extent(&body, axis);
            assert!(low.abs() < 1e-9 && (top - high).abs() < 1e-9, "axis {axis}: {low}..{top}");
        }
        body.cut(&Plane { normal: [-1.0, 0.0, 0.0], d: -0.5 });
        assert!(body.is_empty());
    }

    #[test]
    fn a_flat_box_is_cut_as_well() {
        let mut body = Body::in_box(DVec3::new(-1.0, 3.0, -1.0), DVec3::new(1.0, 3.0, 1.0));
        body.cut(&Plane { normal: [0.6, 0.8, 0.0], d: 0.6 * 0.5 + 0.8 * 3.0 });
        assert!((extent(&body, 0)[1] - 0.5).abs() < 1e-9);
        assert_eq!(extent(&body, 1), [3.0, 3.0]);
    }
}
