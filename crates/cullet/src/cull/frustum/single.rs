//! Frustum tests of single points, spheres and boxes.
//!
//! The fast forms answer with proof: [`Side::Outside`] only where no point of the item can be inside,
//! [`Side::Inside`] only where none can be outside, both in f64 with a bound of its rounding. What is neither is
//! [`Side::Straddling`], which means *keep*. The textbook's loops in plain f64 are oracles of the tests, in
//! `cullet_testkit::oracles::frustum`; they may differ only where an item touches a plane to within rounding.
//!
//! None of them is exact for large items: a box beside a corner of the frustum may be outside without
//! being outside of any one plane. See [`exact`](super::exact).

use crate::bounds::{Aabb, Plane, Side, Sphere};
use crate::view::Frustum;

/// Where a sphere lies, and the number of the first plane that rejects it. O(planes), early out.
///
/// Empty is outside, with no plane to blame; NaN or infinite is straddling.
#[must_use]
pub fn classify_sphere(frustum: &Frustum, sphere: &Sphere) -> (Side, Option<u8>) {
    classify(frustum, sphere.is_empty(), sphere.is_finite(), |plane| sphere.side(plane))
}

/// Where an axis-aligned box lies, and the number of the first plane that rejects it. O(planes), early
/// out.
///
/// Empty is outside, with no plane to blame; NaN is straddling; an infinite side counts as what it is, but
/// such a box is never inside.
///
/// ```
/// use cullet::bounds::{Aabb, Side};
/// use cullet::cull::frustum::single::classify_aabb;
/// use cullet::view::{FrustumPlane, View};
///
/// let view = View::perspective([0.0, 0.0, 5.0], [0.0; 3], 1.0, 0.1, 100.0, [640, 480])?;
/// let behind = Aabb::new([-1.0, -1.0, 6.0], [1.0, 1.0, 8.0]);
/// let (side, plane) = classify_aabb(&view.frustum(), &behind);
/// assert_eq!((side, plane), (Side::Outside, Some(FrustumPlane::Near as u8)));
/// # Ok::<(), cullet::view::ViewError>(())
/// ```
#[must_use]
pub fn classify_aabb(frustum: &Frustum, b: &Aabb) -> (Side, Option<u8>) {
    classify(frustum, b.is_empty(), b.is_finite(), |plane| b.side(plane))
}

fn classify(
    frustum: &Frustum,
    empty: bool,
    finite: bool,
    side: impl Fn(&Plane) -> Side,
) -> (Side, Option<u8>) {
    if empty {
        return (Side::Outside, None);
    }
    let mut inside = finite;
    for (number, plane) in frustum.planes() {
        match side(plane) {
            Side::Outside => return (Side::Outside, Some(number as u8)),
            Side::Straddling => inside = false,
            Side::Inside => {}
        }
    }
    (if inside { Side::Inside } else { Side::Straddling }, None)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::{Camera, FrustumPlane, Projection};

    fn unit_cube() -> Frustum {
        let p = Projection::Orthographic {
            left: -1.0,
            right: 1.0,
            bottom: -1.0,
            top: 1.0,
            near: -1.0,
            far: 1.0,
        };
        Camera::look_at([0.0; 3], [0.0, 0.0, -1.0], p).frustum().unwrap()
    }

    #[test]
    fn each_plane_of_a_cube_rejects_what_is_beyond_it() {
        let f = unit_cube();
        let beyond = [
            (FrustumPlane::Left, [-3.0, 0.0, 0.0]),
            (FrustumPlane::Right, [3.0, 0.0, 0.0]),
            (FrustumPlane::Bottom, [0.0, -3.0, 0.0]),
            (FrustumPlane::Top, [0.0, 3.0, 0.0]),
            (FrustumPlane::Near, [0.0, 0.0, 3.0]),
            (FrustumPlane::Far, [0.0, 0.0, -3.0]),
        ];
        for (plane, c) in beyond {
            let expected = (Side::Outside, Some(plane as u8));
            let b = Aabb::new(c.map(|v| v - 1.0), c.map(|v| v + 1.0));
            assert_eq!(classify_aabb(&f, &b), expected);
            assert_eq!(classify_sphere(&f, &Sphere::new(c, 1.0)), expected);
        }
    }

    #[test]
    fn inside_only_when_inside_all() {
        let f = unit_cube();
        assert_eq!(classify_sphere(&f, &Sphere::new([0.0; 3], 0.5)), (Side::Inside, None));
        assert_eq!(
            classify_sphere(&f, &Sphere::new([0.6, 0.0, 0.0], 0.5)),
            (Side::Straddling, None)
        );
        let b = Aabb::new([-0.5; 3], [0.5; 3]);
        assert_eq!(classify_aabb(&f, &b), (Side::Inside, None));
    }

    #[test]
    fn empty_nan_and_infinite_things() {
        for f in [unit_cube(), Frustum::everything()] {
            assert_eq!(classify_aabb(&f, &Aabb::EMPTY), (Side::Outside, None));
            assert_eq!(classify_sphere(&f, &Sphere::EMPTY), (Side::Outside, None));
            assert_eq!(classify_aabb(&f, &Aabb::EVERYTHING), (Side::Straddling, None));
            assert_eq!(classify_sphere(&f, &Sphere::EVERYTHING), (Side::Straddling, None));
            let nan = Aabb::new([f32::NAN, 9.0, 9.0], [9.0; 3]);
            assert_eq!(classify_aabb(&f, &nan), (Side::Straddling, None));
        }
    }
}
