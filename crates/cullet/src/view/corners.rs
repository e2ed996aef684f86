//! The corners of a frustum, with what rounding may have done to them.

use glam::{DMat3, DVec3};

use crate::array::Each;
use crate::bounds::{Plane, ROUNDING, meet_homogeneous, unit};

/// A corner of a frustum, or the direction in which it has none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Corner {
    /// The point; a unit direction where the corner is at infinity.
    pub(crate) point: DVec3,
    /// Whether it is at infinity.
    pub(crate) at_infinity: bool,
    /// No coordinate is farther than this from the true one.
    pub(crate) error: f64,
}

/// Whether corner `corner` (bits right, top, far) lies on plane `plane`.
pub(super) fn lies_on(corner: usize, plane: usize) -> bool {
    plane < 6 && corner >> (plane / 2) & 1 == plane & 1
}

/// Corners less exact than this are not used: 1 / the sine of the angles at which the planes meet.
const MAX_CONDITION: f64 = 1e6;

/// The corners by the six planes of a view, bit 0, 1, 2 of the index for right, top, far. `None`
/// unless they are the corners of exactly that region: then the region is their convex hull.
///
/// Why checking each corner against all planes is enough: from a corner that satisfies them all,
/// the region goes on along three edges, each of which ends in another of the eight (or runs to
/// infinity as one of the four directions). The edges of a convex body connect all its corners, so
/// there are no more.
pub(super) fn of(planes: [Option<&Plane>; 6]) -> Option<[Corner; 8]> {
    let plane = |which: usize| planes[which];
    let mut corners = [Corner { point: DVec3::ZERO, at_infinity: false, error: 0.0 }; 8];
    for (i, corner) in corners.iter_mut().enumerate() {
        let (x, y) = (plane(i & 1)?, plane(2 + (i >> 1 & 1))?);
        let near = plane(4)?;
        *corner = match (i >> 2, plane(5)) {
            (0, _) => point(x, y, near)?,
            (_, Some(far)) => point(x, y, far)?,
            (_, None) => direction(x, y, near)?,
        };
    }
    let fits = |c: &Corner| {
        (0..6).filter_map(plane).all(|p| {
            let n = DVec3::from(p.normal);
            let d = if c.at_infinity { 0.0 } else { p.d };
            let size = n.abs().dot(c.point.abs()) + d.abs();
            n.dot(c.point) - d <= 3.0 * c.error + size * ROUNDING
        })
    };
    corners.iter().all(fits).then_some(corners)
}

fn point(a: &Plane, b: &Plane, c: &Plane) -> Option<Corner> {
    let (p, w) = meet_homogeneous(a, b, c);
    let mut point = p / w;
    let planes = [a, b, c];
    let [x, y, z] = planes.each(|p| DVec3::from(p.normal));
    let inverse = DMat3::from_cols(x, y, z).transpose().inverse();
    let condition = inverse.x_axis.length() + inverse.y_axis.length() + inverse.z_axis.length();
    if !(point.is_finite() && condition < MAX_CONDITION) {
        return None;
    }
    // One step of Newton's, then what the planes are still missed by, carried back to coordinates.
    let residual = |point: DVec3| DVec3::from(planes.each(|p| p.distance(point)));
    point -= inverse * residual(point);
    let size = planes
        .each(|p| DVec3::from(p.normal).abs().dot(point.abs()) + p.d.abs())
        .into_iter()
        .fold(0.0, f64::max);
    let missed = residual(point).abs().max_element() + size * ROUNDING;
    Some(Corner { point, at_infinity: false, error: condition * missed * 2.0 })
}

/// The direction of the edge of two sides, away from the near plane.
fn direction(a: &Plane, b: &Plane, near: &Plane) -> Option<Corner> {
    let cross = DVec3::from(a.normal).cross(DVec3::from(b.normal));
    let sine = cross.length();
    let edge = unit(cross)?;
    let back = edge.dot(DVec3::from(near.normal));
    // Along the near plane there is no telling which way is away.
    if !(sine * MAX_CONDITION > 1.0 && back.abs() * MAX_CONDITION > 1.0) {
        return None;
    }
    Some(Corner { point: edge * -back.signum(), at_infinity: true, error: 2.0 * ROUNDING / sine })
}
