//! Bounds of one kind around those of another.

use glam::DVec3;

use super::aabb::round_up;
use super::obb::IDENTITY;
use super::plane::ROUNDING;
use super::sphere::grown;
use super::{Aabb, Obb, Plane, Sphere};

impl From<&Sphere> for Aabb {
    /// The box around a sphere, rounded outward; [`Aabb::EVERYTHING`] where the sphere is not finite.
    fn from(s: &Sphere) -> Self {
        if s.has_nan() {
            return Self::EVERYTHING;
        }
        if s.is_empty() {
            return Self::EMPTY;
        }
        let r = f64::from(s.radius);
        let edge = |sign: f64| {
            s.center.map(|c| {
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

impl From<&Obb> for Aabb {
    /// The box around an oriented box, rounded outward; [`Aabb::EVERYTHING`] where it is not finite.
    fn from(b: &Obb) -> Self {
        if b.is_empty() {
            return Self::EMPTY;
        }
        if !b.is_finite() {
            return Self::EVERYTHING;
        }
        let side = |a: usize, sign: f64| {
            let mut axis = [0.0; 3];
            axis[a] = sign;
            sign * b.span(&Plane::new(axis, 0.0))[1]
        };
        let [min, max] = [-1.0, 1.0].map(|sign| std::array::from_fn(|a| side(a, sign)));
        Self::rounded_out(min, max)
    }
}

impl From<&Aabb> for Sphere {
    /// The sphere around a box's corners, rounded outward; [`Sphere::EVERYTHING`] where the box is not
    /// finite.
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

impl From<&Obb> for Sphere {
    /// The sphere around an oriented box's corners, rounded outward; [`Sphere::EVERYTHING`] where the
    /// box is not finite.
    fn from(b: &Obb) -> Self {
        if b.is_empty() {
            return Self::EMPTY;
        }
        if !b.is_finite() {
            return Self::EVERYTHING;
        }
        // From the centre, where no large coordinate cancels.
        let [x, y, z] =
            std::array::from_fn(|a| DVec3::from(b.axes[a].map(f64::from)) * f64::from(b.half[a]));
        let corners = [x + y + z, x + y - z, x - y + z, x - y - z];
        let reach = corners.iter().map(|c| c.length()).fold(0.0, f64::max);
        Self { center: b.center, radius: grown(reach) }
    }
}

impl From<&Aabb> for Obb {
    /// The same box, rounded outward: the centre is an f32, so far from the origin the box may grow by
    /// a unit in the last place of its coordinates. [`Obb::EVERYTHING`] where the box is not finite.
    fn from(b: &Aabb) -> Self {
        if b.is_empty() {
            return Self::EMPTY;
        }
        if !b.is_finite() {
            return Self::EVERYTHING;
        }
        let center = b.center().map(|v| v as f32);
        let half = std::array::from_fn(|a| {
            let c = f64::from(center[a]);
            let reach = (f64::from(b.max[a]) - c).max(c - f64::from(b.min[a]));
            round_up(reach * (1.0 + ROUNDING))
        });
        let b = Self { center, axes: IDENTITY, half };
        if b.is_finite() { b } else { Self::EVERYTHING }
    }
}

impl From<&Sphere> for Obb {
    /// The axis-aligned cube around a sphere; [`Obb::EVERYTHING`] where the sphere is not finite.
    fn from(s: &Sphere) -> Self {
        if s.is_empty() {
            Self::EMPTY
        } else if s.is_finite() {
            Self { center: s.center, axes: IDENTITY, half: [s.radius; 3] }
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

    #[test]
    fn around_boxes_of_nothing_and_of_everything() {
        assert_eq!(Obb::from(&Aabb::EVERYTHING), Obb::EVERYTHING);
        assert_eq!(Obb::from(&Aabb::EMPTY), Obb::EMPTY);
        assert_eq!(Aabb::from(&Obb::EMPTY), Aabb::EMPTY);
    }
}
