//! Bounds of one kind around those of another.

use super::{Aabb, Sphere};
use crate::array::Each;

impl From<&Sphere> for Aabb {
    /// The box around a sphere, rounded outward; [`Aabb::EVERYTHING`] where the sphere is not
    /// finite.
    fn from(s: &Sphere) -> Self {
        if s.has_nan() {
            return Self::EVERYTHING;
        }
        if s.is_empty() {
            return Self::EMPTY;
        }
        let r = f64::from(s.radius);
        let edge = |sign: f64| {
            s.center.each(|c| {
                let (c, r) = (f64::from(c), sign * r);
                c + r + sign * (c.abs() + r.abs()) * f64::EPSILON
            })
        };
        let (min, max) = (edge(-1.0), edge(1.0));
        // An infinite centre with an infinite radius.
        if min.iter().chain(&max).any(|v| v.is_nan()) {
            return Self::EVERYTHING;
        }
        Self::rounded_out(min, max)
    }
}

impl From<&Aabb> for Sphere {
    /// The sphere around a box's corners, rounded outward; [`Sphere::EVERYTHING`] where the box is
    /// not finite.
    fn from(b: &Aabb) -> Self {
        if b.is_empty() {
            Self::EMPTY
        } else if b.is_finite() {
            Self::at_center(b.center().into(), &b.corners())
        } else {
            Self::EVERYTHING
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn around_a_sphere_that_is_not_finite() {
        assert_eq!(Aabb::from(&Sphere::EVERYTHING), Aabb::EVERYTHING);
        assert_eq!(Aabb::from(&Sphere::EMPTY), Aabb::EMPTY);
        let s = Sphere { center: [f32::INFINITY, 0.0, 0.0], radius: f32::INFINITY };
        assert_eq!(Aabb::from(&s), Aabb::EVERYTHING);
    }
}
