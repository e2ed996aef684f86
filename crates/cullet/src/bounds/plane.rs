//! Planes n·x = d and the side of them that a point, box or sphere is on.

use crate::array::Each;
use crate::math::{two_product, two_sum};
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

impl Side {
    /// The side of an item whose lowest and highest signed distance to a plane are `span`: outside
    /// where even the lowest is positive, inside where even the highest is negative, else (NaN
    /// included) straddling.
    #[must_use]
    pub(crate) fn from_span(span: [f64; 2]) -> Self {
        if span[0] > 0.0 {
            Self::Outside
        } else if span[1] < 0.0 {
            Self::Inside
        } else {
            Self::Straddling
        }
    }
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
        let n = unit(normal.into().into())?;
        Some(Self { normal: n.into(), d: n.dot(DVec3::from(point.into())) })
    }

    /// The plane through three points, its normal towards the side from which they are seen
    /// counter-clockwise. `None` where they are collinear or not finite.
    #[must_use]
    pub fn from_points(
        a: impl Into<[f64; 3]>,
        b: impl Into<[f64; 3]>,
        c: impl Into<[f64; 3]>,
    ) -> Option<Self> {
        let (a, b, c) = (DVec3::from(a.into()), DVec3::from(b.into()), DVec3::from(c.into()));
        // Each edge is brought to unit length first: the product of two tiny ones would underflow.
        Self::from_point_normal(a, unit(b - a)?.cross(unit(c - a)?))
    }

    /// The same plane with a normal of unit length; `None` where the normal has no direction, or
    /// the offset is not finite.
    #[must_use]
    pub fn normalized(self) -> Option<Self> {
        let n = DVec3::from(self.normal);
        let scale = n.abs().max_element();
        let length = (n / scale).length() * scale;
        let plane = Self { normal: unit(n)?.into(), d: self.d / length };
        plane.d.is_finite().then_some(plane)
    }

    /// The same plane seen from its other side.
    #[must_use]
    pub fn flipped(self) -> Self {
        Self { normal: self.normal.each(|n| -n), d: -self.d }
    }

    /// Whether all four numbers are finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.normal.iter().all(|n| n.is_finite()) && self.d.is_finite()
    }

    /// n·x − d: the signed distance of `point` when the normal has unit length. Plain f64, rounded.
    #[must_use]
    pub fn distance(&self, point: impl Into<[f64; 3]>) -> f64 {
        DVec3::from(self.normal).dot(DVec3::from(point.into())) - self.d
    }

    /// The side of the plane that `point` is proved to lie on; straddling where rounding hides it,
    /// as for a point on the plane, or where a number is NaN.
    #[must_use]
    pub fn side_of(&self, point: impl Into<[f64; 3]>) -> Side {
        let p: [f64; 3] = point.into();
        let mut size = self.d.abs();
        for a in 0..3 {
            size += (self.normal[a] * p[a]).abs();
        }
        let slack = size * ROUNDING + f64::MIN_POSITIVE;
        let distance = self.distance(p);
        Side::from_span([distance - slack, distance + slack])
    }

    /// The same plane for coordinates relative to `origin`: d' = d − n·origin, rounded once.
    #[must_use]
    pub fn relative_to(&self, origin: [f64; 3]) -> Self {
        let d = -dot2(self.normal, origin, -self.d).0;
        Self { normal: self.normal, d }
    }

    /// The point that three planes share; `None` where they share none or a line, or where the
    /// point is not finite. Rounded; planes almost parallel give a point that is far off.
    #[must_use]
    pub fn meet(a: &Self, b: &Self, c: &Self) -> Option<[f64; 3]> {
        let (p, w) = meet_homogeneous(a, b, c);
        let p = p / w;
        p.is_finite().then(|| p.into())
    }
}

/// Error bound of n·x − d in f64, relative to Σ|nᵢ||xᵢ| + |d|: 16 u with u = 2⁻⁵³. Evaluating it
/// costs 4 u; the rest is for coefficients that have been rounded a few times themselves.
pub(crate) const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// The unit vector along `v`, at any length that f64 can hold; `None` for zero or not finite.
pub(crate) fn unit(v: DVec3) -> Option<DVec3> {
    let scale = v.abs().max_element();
    if !v.is_finite() || scale == 0.0 {
        return None;
    }
    // Scaled first: the square of a length beyond 1e±154 would over- or underflow.
    let v = v / scale;
    Some(v / v.length())
}

/// The homogeneous point (p, w) of three planes: their generalised cross product. The point is p /
/// w, or the direction p where w is 0.
pub(crate) fn meet_homogeneous(a: &Plane, b: &Plane, c: &Plane) -> (DVec3, f64) {
    let (n, m, l) = (DVec3::from(a.normal), DVec3::from(b.normal), DVec3::from(c.normal));
    (m.cross(l) * a.d + l.cross(n) * b.d + n.cross(m) * c.d, n.dot(m.cross(l)))
}

/// a·b + c and a bound of its absolute error. Computed as if in twice the precision and rounded
/// once, so that what cancels leaves a true remainder.
///
/// (Ogita, Rump & Oishi, *Accurate Sum and Dot Product*, 2005: Dot2.)
pub(crate) fn dot2(a: [f64; 3], b: [f64; 3], c: f64) -> (f64, f64) {
    let (mut sum, mut carry, mut size) = (c, 0.0, c.abs());
    for i in 0..3 {
        let (p, e) = two_product(a[i], b[i]);
        let (s, f) = two_sum(sum, p);
        sum = s;
        carry += e + f;
        size += p.abs();
    }
    let value = sum + carry;
    // γ₄² of the sizes, and where numbers are too large or small for the splitting, plain rounding.
    let exact = size < 1e280 && value.is_finite();
    if exact {
        (value, value.abs() * f64::EPSILON + size * 1e-30 + f64::MIN_POSITIVE)
    } else {
        (sum, size * ROUNDING)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_points_seen_counter_clockwise_face_the_eye() {
        let p = Plane::from_points([0.0, 0.0, 2.0], [1.0, 0.0, 2.0], [0.0, 1.0, 2.0]).unwrap();
        assert_eq!(p, Plane::new([0.0, 0.0, 1.0], 2.0));
        assert_eq!(p.flipped().distance([0.0, 0.0, 5.0]), -3.0);
        assert_eq!(Plane::from_points([0.0; 3], [1.0, 1.0, 1.0], [2.0, 2.0, 2.0]), None);
        assert_eq!(Plane::from_points([0.0; 3], [f64::NAN, 1.0, 1.0], [2.0, 0.0, 2.0]), None);
    }

    #[test]
    fn huge_and_tiny_normals_have_a_direction() {
        for scale in [1e-300, 1e-160, 1.0, 1e160, 1e300] {
            let p = Plane::from_point_normal([1.0, 2.0, 3.0], [0.0, scale, 0.0]).unwrap();
            assert_eq!(p, Plane::new([0.0, 1.0, 0.0], 2.0));
            let q = Plane::new([0.0, scale, 0.0], 2.0 * scale).normalized().unwrap();
            assert_eq!(q, p);
        }
        assert_eq!(Plane::new([0.0; 3], 1.0).normalized(), None);
        assert_eq!(Plane::new([f64::INFINITY, 0.0, 0.0], 1.0).normalized(), None);
    }

    #[test]
    fn relative_to_rounds_only_once() {
        // d and n·origin agree in their first 60 bits: plain f64 would keep nothing of the rest.
        let third = 1.0 / 3.0;
        let p = Plane::new([third, 0.0, 0.0], third * 3e17);
        let moved = p.relative_to([3e17, 0.0, 0.0]);
        let (product, error) = two_product(third, 3e17);
        assert_eq!(moved.d, p.d - product - error);
        assert_ne!(error, 0.0);
    }

    #[test]
    fn planes_meet_in_a_point_or_not_at_all() {
        let x = Plane::new([1.0, 0.0, 0.0], 2.0);
        let y = Plane::new([0.0, -1.0, 0.0], 3.0);
        let z = Plane::new([0.0, 0.0, 1.0], 5.0);
        assert_eq!(Plane::meet(&x, &y, &z), Some([2.0, -3.0, 5.0]));
        assert_eq!(Plane::meet(&x, &y, &x), None);
    }

    #[test]
    fn a_point_on_the_plane_is_on_neither_side() {
        let p = Plane::from_point_normal([1e7, 2e7, -3e7], [1.0, 2.0, 3.0]).unwrap();
        assert_eq!(p.side_of([1e7, 2e7, -3e7]), Side::Straddling);
        assert_eq!(p.side_of([1e7 + 1e-3, 2e7, -3e7]), Side::Outside);
        assert_eq!(p.side_of([1e7 - 1e-3, 2e7, -3e7]), Side::Inside);
        assert_eq!(p.side_of([f64::NAN, 0.0, 0.0]), Side::Straddling);
    }
}
