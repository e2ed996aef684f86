//! Outcodes: one bit for each plane of a convex region that a point is outside of.
//!
//! After Cohen & Sutherland (Newman & Sproull, *Principles of Interactive Computer Graphics*,
//! 1973): a triangle whose corners are all outside one plane is rejected, one whose corners are all
//! inside every plane is accepted, and the rest are candidates for clipping. Here the region has up
//! to 32 planes and is moved into the space of the mesh, so that vertices are tested as they are
//! stored; and both answers are proofs, with a third in between for what rounding leaves open.

use std::ops::Range;

use cullet::bounds::Side;
use cullet::cull::frustum::triangles::ObjectRegion;
use cullet::{Transform, view::Frustum};
use glam::DVec3;

use super::polygon::Clipper;
use super::region::{HalfSpace, Region};

/// Where a point lies against each plane of a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Outcode {
    /// Bit i: proved outside plane i.
    pub outside: u32,
    /// Bit i: not proved inside plane i. Holds every bit of `outside`.
    pub not_inside: u32,
}

/// Result of outcodes alone for a line, a triangle, or the convex hull of any points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum OutcodeResult {
    /// Inside every plane: no clipping needed. The OR of the codes is 0.
    Accepted,
    /// Wholly outside each of these planes: the AND of the codes.
    Rejected(u32),
    /// To be clipped by these planes, outside of which some of the points may be: the OR of the
    /// codes, which for a line that is not rejected is their XOR. It may miss the region all the
    /// same.
    Candidate(u32),
}

impl OutcodeResult {
    /// The result for points with these codes. No points are accepted.
    #[must_use]
    pub fn of(codes: impl IntoIterator<Item = Outcode>) -> Self {
        let (mut and, mut or) = (u32::MAX, 0);
        for code in codes {
            and &= code.outside;
            or |= code.not_inside;
        }
        match (or, and) {
            (0, _) => Self::Accepted,
            (_, 0) => Self::Candidate(or),
            _ => Self::Rejected(and),
        }
    }
}

/// Triangles sorted by their outcodes; keeps its memory from call to call.
#[derive(Clone, Debug, Default)]
pub struct Sorted {
    /// Triangles that need no clipping, ascending.
    pub accepted: Vec<u32>,
    /// Triangles that may need clipping, ascending. Some of them miss the region, unless
    /// [`resolve`](OutcodeRegion::resolve) took them out.
    pub candidates: Vec<u32>,
    /// How many were rejected.
    pub rejected: u32,
    /// How many candidates have been found to miss the region.
    pub false_positives: u32,
    codes: Vec<Outcode>,
}

/// A convex region in the space of a mesh, for outcodes.
///
/// A plane whose numbers are not finite in that space, because the transform's are not, excludes
/// nothing and includes nothing.
#[derive(Clone, Debug)]
pub struct OutcodeRegion(ObjectRegion);

impl OutcodeRegion {
    /// Returns `frustum` in the space of an instance. Both are relative to the same origin; a
    /// transform of any rank will do.
    #[must_use]
    pub fn new(frustum: &Frustum, transform: &Transform) -> Self {
        Self(ObjectRegion::new(frustum, transform))
    }

    /// Bit i is set where plane i exists.
    #[must_use]
    pub fn present(&self) -> u32 {
        self.0.present()
    }

    /// Where a point lies. One that is not finite is neither outside nor inside of anything.
    #[must_use]
    pub fn outcode(&self, point: [f32; 3]) -> Outcode {
        let p = point.map(f64::from);
        let mut code = Outcode::default();
        for (i, plane) in self.0.planes() {
            let (value, error) = plane.height(p);
            code.outside |= u32::from(value > error) << i;
            // From its opposite, so that a NaN is not inside.
            let inside = value < -error;
            code.not_inside |= u32::from(!inside) << i;
        }
        code
    }

    /// Rejects a triangle ([`Side::Outside`]: all corners outside one plane), accepts it
    /// ([`Side::Inside`]: all corners inside every plane, so that no clipping is needed), or calls
    /// it a candidate. It may be outside though it is a candidate.
    #[must_use]
    pub fn classify(&self, corners: &[[f32; 3]; 3]) -> Side {
        match self.test(corners) {
            OutcodeResult::Accepted => Side::Inside,
            OutcodeResult::Rejected(_) => Side::Outside,
            OutcodeResult::Candidate(_) => Side::Straddling,
        }
    }

    /// The result for the convex hull of some points: two are a line, three a triangle.
    #[must_use]
    pub fn test(&self, points: &[[f32; 3]]) -> OutcodeResult {
        OutcodeResult::of(points.iter().map(|&p| self.outcode(p)))
    }

    /// Whether a triangle misses the region though no single plane rejects it, as one that passes
    /// by a corner of the region does: proved by clipping it, in f64 and to a region wider by far
    /// more than rounding. `false` keeps it, also where a number is not finite.
    #[must_use]
    pub fn misses(&self, corners: &[[f32; 3]; 3]) -> bool {
        self.cuts_to_nothing(corners, &mut Clipper::new())
    }

    fn cuts_to_nothing(&self, corners: &[[f32; 3]; 3], clipper: &mut Clipper<[f64; 3]>) -> bool {
        /// Wider by this part of what a plane's terms amount to; cutting by 32 planes rounds some
        /// hundred times, by 1.1e-16 each.
        const WIDER: f64 = 1e-12;
        let corners = corners.map(|p| p.map(f64::from));
        if !corners.iter().flatten().all(|v| v.is_finite()) {
            return false;
        }
        let largest = corners.iter().fold(DVec3::ZERO, |m, &p| m.max(DVec3::from(p).abs()));
        let mut region = Region::everything();
        for (i, plane) in self.0.planes() {
            let size = DVec3::from(plane.normal).abs().dot(largest) + plane.d.abs();
            // The errors that outcodes allow for come on top: they may be of larger terms that
            // cancel.
            let room = size * WIDER + DVec3::from(plane.error_per).dot(largest) + plane.error;
            // A plane that is none, flattened by the transform, excludes nothing.
            if let Ok(side) = HalfSpace::new(plane.normal, plane.d + room) {
                region.set(i, side);
            }
        }
        clipper.clip(&region, &corners).is_empty()
    }

    /// Sorts the triangles of `range` by their outcodes, in place of what `sorted` held. `indices`
    /// is the whole index list; a triangle beyond it is left out, and one whose vertices are out of
    /// range is a candidate.
    ///
    /// Cost: an outcode for each of `positions`, then three look-ups a triangle.
    pub fn sort_into(
        &self,
        positions: &[[f32; 3]],
        indices: &[u32],
        range: Range<u32>,
        sorted: &mut Sorted,
    ) {
        sorted.accepted.clear();
        sorted.candidates.clear();
        (sorted.rejected, sorted.false_positives) = (0, 0);
        sorted.codes.clear();
        sorted.codes.extend(positions.iter().map(|&p| self.outcode(p)));
        let unknown = Outcode { outside: 0, not_inside: self.present() };
        each_triangle(indices, range, |t, corners| {
            let code = |v: u32| sorted.codes.get(v as usize).copied().unwrap_or(unknown);
            match OutcodeResult::of(corners.map(code)) {
                OutcodeResult::Accepted => sorted.accepted.push(t),
                OutcodeResult::Candidate(_) => sorted.candidates.push(t),
                OutcodeResult::Rejected(_) => sorted.rejected += 1,
            }
        });
    }

    /// Takes out the candidates that [miss](Self::misses) the region, and counts them. `positions`
    /// and `indices` are those that were sorted.
    pub fn resolve(&self, positions: &[[f32; 3]], indices: &[u32], sorted: &mut Sorted) {
        let mut clipper = Clipper::new();
        let before = sorted.candidates.len();
        sorted.candidates.retain(|&t| {
            let corner = |k: usize| {
                let v = *indices.get(t as usize * 3 + k)?;
                positions.get(v as usize).copied()
            };
            match (corner(0), corner(1), corner(2)) {
                (Some(a), Some(b), Some(c)) => !self.cuts_to_nothing(&[a, b, c], &mut clipper),
                _ => true,
            }
        });
        sorted.false_positives += (before - sorted.candidates.len()) as u32;
    }
}

/// Calls `f` with number and vertices of the triangles of `range` that `indices` has.
fn each_triangle(indices: &[u32], range: Range<u32>, mut f: impl FnMut(u32, [u32; 3])) {
    let end = (range.end as usize).min(indices.len() / 3);
    let start = (range.start as usize).min(end);
    let triangles = indices[start * 3..end * 3].as_chunks::<3>().0;
    for (t, &corners) in (range.start..).zip(triangles) {
        f(t, corners);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet::bounds::Plane;

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
    fn bits_name_the_planes() {
        let region = OutcodeRegion::new(&cube(), &Transform::IDENTITY);
        assert_eq!(region.outcode([0.0; 3]), Outcode::default());
        assert_eq!(region.outcode([-2.0, 2.0, 2.0]).outside, 0b011001);
        assert_eq!(region.outcode([0.0, 0.0, -9.0]), Outcode::default(), "there is no far plane");
        // On the plane: neither outside nor inside.
        assert_eq!(region.outcode([1.0, 0.0, 0.0]), Outcode { outside: 0, not_inside: 0b10 });
        let nan = region.outcode([f32::NAN, 0.0, 0.0]);
        assert_eq!((nan.outside, nan.not_inside), (0, 0b011111));
    }

    #[test]
    fn triangles_are_accepted_rejected_or_candidates() {
        let region = OutcodeRegion::new(&cube(), &Transform::from_translation([10.0, 0.0, 0.0]));
        let at = |x: f32| [[x, 0.0, 0.0], [x + 0.5, 0.5, 0.0], [x, 0.5, 0.5]];
        assert_eq!(region.classify(&at(-10.0)), Side::Inside);
        assert_eq!(region.classify(&at(-9.2)), Side::Straddling);
        assert_eq!(region.classify(&at(0.0)), Side::Outside);
        // Around a corner of the region: outside, but of no single plane.
        let around = [[-7.0, 0.0, 0.0], [-10.0, 3.0, 0.0], [-8.0, 2.0, 0.0]];
        assert_eq!(region.classify(&around), Side::Straddling);
    }

    #[test]
    fn a_transform_that_is_not_finite_keeps_everything() {
        let broken = Transform { linear: [[f32::NAN; 3]; 3], ..Transform::IDENTITY };
        let region = OutcodeRegion::new(&cube(), &broken);
        assert_eq!(region.classify(&[[9.0; 3], [8.0; 3], [7.0; 3]]), Side::Straddling);
        let far = Transform::from_translation([f64::INFINITY, 0.0, 0.0]);
        let region = OutcodeRegion::new(&cube(), &far);
        assert_eq!(
            region.classify(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
            Side::Straddling
        );
    }
}
