//! The exact test of a box against a frustum: its corners against the faces of the box.
//!
//! The plane test keeps a box that is outside of no single plane, though a big box beside the
//! frustum's edge or behind its eye may be clear of it. The other half of the proof looks from the
//! box: if all corners of the frustum are beyond one face of the box, they are apart (Quílez,
//! *Correct Frustum Culling*, 2013). With the planes that hold an edge of each, the list of
//! possible separating planes is complete (Gottschalk, *Separating Axis Theorem*, 1996), and the
//! test is exact but for rounding.
//!
//! For a view whose planes are known, all these are planes too: a direction, and how far the
//! frustum reaches along it. So they are found once per view, and each box is tested against a
//! list.

use glam::DVec3;

use crate::bounds::{Aabb, Plane, ROUNDING, Side, unit};
use crate::view::Frustum;
use crate::view::corners::Corner;

/// 32 planes of the frustum, 6 faces of a box, and both directions of 3 × 12 pairs of edges.
const MAX_TESTS: usize = Frustum::MAX_PLANES + 6 + 72;

/// A frustum made ready for exact tests of axis-aligned boxes. Made once per view, in a few
/// microseconds, without allocation; 4 KiB.
#[derive(Clone, Debug)]
pub struct ExactFrustum {
    /// Half-spaces that hold the whole frustum.
    planes: [Plane; MAX_TESTS],
    count: usize,
    own: usize,
    complete: bool,
}

impl ExactFrustum {
    /// Prepares `frustum`. Where it has no far plane its far corners are directions, and the tests
    /// that these would void are left out. Where a side or the near plane is missing, or the six
    /// planes make no such body (see [`Frustum::corners`]), only the plane test is left. Planes
    /// from 6 on reject by the plane test.
    #[must_use]
    pub fn new(frustum: &Frustum) -> Self {
        let planes = [Plane::default(); MAX_TESTS];
        let mut exact = Self { planes, count: 0, own: 0, complete: false };
        frustum.planes().for_each(|(_, plane)| exact.push(*plane));
        exact.own = exact.count;
        if let Some(corners) = frustum.corners_with_error() {
            exact.complete = true;
            let axes = DVec3::AXES;
            for axis in axes {
                exact.add_both(axis, &corners);
            }
            let mut done: [DVec3; 12] = [DVec3::ZERO; 12];
            let mut count = 0;
            for edge in edges(&corners) {
                // The near and far edges of a view come in parallel pairs.
                if done[..count].iter().any(|d| d.cross(edge).length() < 1e-9) {
                    continue;
                }
                done[count] = edge;
                count += 1;
                for axis in axes {
                    // An edge along the axis of the box spans no plane with it.
                    if axis.cross(edge).length() > 1e-6 {
                        exact.add_both(axis.cross(edge), &corners);
                    }
                }
            }
        }
        exact
    }

    /// Whether the box is proved to share no point with the frustum. `false` is no proof of the
    /// contrary, only of none: it means *keep*. NaN gives `false`; an empty box gives `true`.
    ///
    /// Cost: the frustum's planes, 6 faces, and for an ordinary view 36 more planes, until the
    /// first that separates; the most for a box that none does.
    #[must_use]
    pub fn is_outside(&self, b: &Aabb) -> bool {
        any_rejects(&self.planes[..self.count], b)
    }

    /// Tests a box that the plane test has already kept, like [`is_outside`](Self::is_outside).
    /// Does only the tests that the plane test lacks.
    #[must_use]
    pub fn is_outside_beyond_planes(&self, b: &Aabb) -> bool {
        any_rejects(&self.planes[self.own..self.count], b)
    }

    /// Whether the frustum's corners are known, so that there is more than the plane test.
    #[must_use]
    pub fn has_corners(&self) -> bool {
        self.complete
    }

    fn push(&mut self, plane: Plane) {
        self.planes[self.count] = plane;
        self.count += 1;
    }

    fn add_both(&mut self, axis: DVec3, corners: &[Corner; 8]) {
        for axis in [axis, -axis] {
            if let Some(plane) = supporting(axis, corners) {
                self.push(plane);
            }
        }
    }
}

/// Whether any of the planes has all of the box on its positive side. [`Aabb::side`] says the same
/// of each; for a box whose numbers are finite this is its loop without the questions.
fn any_rejects(planes: &[Plane], b: &Aabb) -> bool {
    if !b.is_finite() {
        return b.is_empty() || planes.iter().any(|p| b.side(p) == Side::Outside);
    }
    if b.is_empty() {
        return true;
    }
    let (middle, half) = (DVec3::from(b.center()), DVec3::from(b.half_extent()));
    let size = middle.abs() + half;
    planes.iter().any(|p| {
        let n = DVec3::from(p.normal);
        let low = n.dot(middle) - n.abs().dot(half) - p.d;
        low > (n.abs().dot(size) + p.d.abs()) * ROUNDING + f64::MIN_POSITIVE
    })
}

/// The half-space with this outward normal that just holds all corners; `None` where there is none,
/// that is, where a corner at infinity may lie in its direction.
fn supporting(axis: DVec3, corners: &[Corner; 8]) -> Option<Plane> {
    let n = unit(axis)?;
    let ones = n.abs().element_sum();
    let mut d = f64::NEG_INFINITY;
    for c in corners {
        let slack = c.error * ones + n.abs().dot(c.point.abs()) * ROUNDING;
        let reach = n.dot(c.point) + slack;
        if c.at_infinity {
            // However little it leans outward, far enough out it is beyond any plane.
            if reach > 0.0 {
                return None;
            }
        } else {
            d = d.max(reach);
        }
    }
    d.is_finite().then(|| Plane { normal: n.into(), d })
}

/// Unit directions of the twelve edges; those that rounding leaves none of are left out.
fn edges(corners: &[Corner; 8]) -> impl Iterator<Item = DVec3> {
    (0..8).flat_map(move |from| {
        (0..3).filter(move |bit| from >> bit & 1 == 0).filter_map(move |bit| {
            let (a, b) = (&corners[from], &corners[from | 1 << bit]);
            match (a.at_infinity, b.at_infinity) {
                (false, false) => unit(b.point - a.point),
                (false, true) => Some(b.point),
                // An edge at infinity has no direction.
                _ => None,
            }
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cull::frustum::batch::Planes;
    use crate::view::View;

    #[test]
    fn a_big_box_beside_a_far_corner_is_dropped() {
        let view = View::perspective([0.0; 3], [0.0, 0.0, -1.0], 1.2, 0.1, 100.0, [800, 600]);
        let f = view.unwrap().frustum();
        let exact = ExactFrustum::new(&f);
        assert!(exact.has_corners());
        // The far corners are at x = ±91.2. Farther back than they are, the left plane lets it in.
        let beside = |x: f32| Aabb::new([-500.0, -50.0, -500.0], [x, 50.0, -50.0]);
        assert_eq!(Planes::new(&f).classify_box(&beside(-95.0)), Side::Straddling);
        assert!(exact.is_outside(&beside(-95.0)) && exact.is_outside_beyond_planes(&beside(-95.0)));
        assert!(!exact.is_outside(&beside(-91.0)));
    }

    #[test]
    fn the_faces_of_a_box_help_where_there_is_no_far_plane() {
        // Looking along the diagonal, all of the frustum is where x, y and z grow.
        let view = View::perspective([0.0; 3], [1.0; 3], 0.5, 1.0, f64::INFINITY, [1, 1]).unwrap();
        let f = view.frustum();
        let exact = ExactFrustum::new(&f);
        assert!(exact.has_corners());
        let below = |x: f32| Aabb::new([-400.0; 3], [x, 400.0, 400.0]);
        assert_eq!(Planes::new(&f).classify_box(&below(0.1)), Side::Straddling);
        assert!(exact.is_outside(&below(0.1)));
        assert!(!exact.is_outside(&below(2.0)));
    }

    #[test]
    fn nan_is_kept_and_empty_is_not() {
        let view = View::perspective([0.0; 3], [0.0, 0.0, -1.0], 1.2, 0.1, 9.0, [8, 6]).unwrap();
        let exact = ExactFrustum::new(&view.frustum());
        assert!(exact.is_outside(&Aabb::EMPTY));
        assert!(!exact.is_outside(&Aabb::EVERYTHING));
        assert!(!exact.is_outside(&Aabb::new([f32::NAN, 50.0, 50.0], [60.0; 3])));
    }

    #[test]
    fn without_sides_only_the_planes_are_left() {
        let mut f = Frustum::everything();
        f.push(Plane::new([2.0, 0.0, 0.0], 2.0)).unwrap();
        let exact = ExactFrustum::new(&f);
        assert!(!exact.has_corners());
        assert!(exact.is_outside(&Aabb::new([1.1, 0.0, 0.0], [2.0; 3])));
        assert!(!exact.is_outside(&Aabb::new([0.9, 0.0, 0.0], [2.0; 3])));
    }
}
