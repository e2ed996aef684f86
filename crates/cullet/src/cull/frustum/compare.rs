//! Which bound suits a scene: spheres, boxes and oriented boxes by what each keeps in vain and costs.

use super::exact::ExactFrustum;
use super::single::{classify_aabb, classify_obb, classify_sphere};
use crate::bounds::{Aabb, Obb, Side, Sphere};
use crate::view::Frustum;

/// What one kind of bound did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Kept {
    /// How many objects it kept.
    pub kept: u64,
    /// Of those, how many some other bound, or the exact test, proves to be outside.
    pub false_keeps: u64,
    /// How many planes it was held against until the answer was known.
    pub plane_tests: u64,
    /// Bytes that a test of all objects must read.
    pub bytes: u64,
    /// How long it took by the caller's clock, one object at a time; batches are many times faster.
    pub nanoseconds: Option<u64>,
}

/// What each kind of bound did for the same objects.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BoundsComparison {
    /// How many objects there were.
    pub objects: u64,
    /// How many no test proves to be outside.
    pub needed: u64,
    /// Spheres.
    pub spheres: Kept,
    /// Axis-aligned boxes.
    pub boxes: Kept,
    /// Oriented boxes; all zero where none were given.
    pub oriented: Kept,
}

/// Holds every object against a frustum by its sphere, its box, its oriented box, and its box by
/// the exact test. What any of them proves outside is a false keep of those that kept it; so the count is a
/// lower bound, got without looking at a triangle.
///
/// The slices go by object and are read up to the length of the shorter of `spheres` and `boxes`; `oriented` may
/// be empty. `clock` gives nanoseconds; without one no time is taken. Sums over views are the caller's.
#[must_use]
pub fn compare_bounds(
    frustum: &Frustum,
    spheres: &[Sphere],
    boxes: &[Aabb],
    oriented: &[Obb],
    clock: Option<fn() -> u64>,
) -> BoundsComparison {
    let count = spheres.len().min(boxes.len());
    let oriented = oriented.get(..count).unwrap_or(&[]);
    let mut needed = vec![true; count];
    let planes = frustum.planes().count() as u64;
    // How many planes come before one, itself included.
    let tested = |plane: Option<u8>| match plane {
        Some(p) => frustum.planes().take_while(|(i, _)| *i <= usize::from(p)).count() as u64,
        None => planes,
    };
    let mut sweep = |size: usize, classify: &dyn Fn(usize) -> (Side, Option<u8>), n: usize| {
        let mut kept = vec![false; n];
        let mut row = Kept { bytes: (n * size) as u64, ..Kept::default() };
        let began = clock.map(|now| now());
        for (i, kept) in kept.iter_mut().enumerate() {
            let (side, plane) = classify(i);
            *kept = side != Side::Outside;
            row.kept += u64::from(*kept);
            row.plane_tests += tested(plane);
        }
        row.nanoseconds = clock.zip(began).map(|(now, began)| now().saturating_sub(began));
        needed.iter_mut().zip(&kept).for_each(|(needed, kept)| *needed &= kept);
        (row, kept)
    };
    let (mut s, by_sphere) =
        sweep(size_of::<Sphere>(), &|i| classify_sphere(frustum, &spheres[i]), count);
    let (mut b, by_box) = sweep(size_of::<Aabb>(), &|i| classify_aabb(frustum, &boxes[i]), count);
    let (mut o, by_oriented) =
        sweep(size_of::<Obb>(), &|i| classify_obb(frustum, &oriented[i]), oriented.len());
    let exact = ExactFrustum::new(frustum);
    for (needed, b) in needed.iter_mut().zip(boxes) {
        *needed &= !exact.is_outside_beyond_planes(b);
    }
    let in_vain = |kept: &[bool]| {
        kept.iter().zip(&needed).filter(|(kept, needed)| **kept && !**needed).count() as u64
    };
    s.false_keeps = in_vain(&by_sphere);
    b.false_keeps = in_vain(&by_box);
    o.false_keeps = in_vain(&by_oriented);
    let needed = needed.iter().filter(|n| **n).count() as u64;
    BoundsComparison { objects: count as u64, needed, spheres: s, boxes: b, oriented: o }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::View;

    #[test]
    fn a_thin_rod_is_kept_in_vain_by_its_sphere() {
        let view =
            View::perspective([0.0, 0.0, 10.0], [0.0; 3], 1.0, 0.1, 100.0, [100, 100]).unwrap();
        // Upright beside the view: 8 units right of an edge that is 5.5 away.
        let rod = Aabb::new([8.0, -6.0, -0.1], [8.2, 6.0, 0.1]);
        let seen = Aabb::new([-1.0; 3], [1.0; 3]);
        let boxes = [rod, seen];
        let spheres = boxes.map(|b| Sphere::from(&b));
        let c = compare_bounds(&view.frustum(), &spheres, &boxes, &[], None);
        assert_eq!((c.objects, c.needed), (2, 1));
        assert_eq!((c.spheres.kept, c.spheres.false_keeps), (2, 1));
        assert_eq!((c.boxes.kept, c.boxes.false_keeps), (1, 0));
        assert_eq!(c.oriented, Kept::default());
        assert!(c.boxes.plane_tests < c.spheres.plane_tests && c.boxes.nanoseconds.is_none());
    }

    #[test]
    fn no_objects_make_no_figures() {
        let c = compare_bounds(&Frustum::everything(), &[], &[], &[], None);
        assert_eq!(c, BoundsComparison::default());
    }

    #[test]
    fn the_clock_is_the_callers() {
        fn now() -> u64 {
            7
        }
        let boxes = [Aabb::new([0.0; 3], [1.0; 3])];
        let spheres = [Sphere::from(&boxes[0])];
        let c = compare_bounds(&Frustum::everything(), &spheres, &boxes, &[], Some(now));
        assert_eq!(c.boxes.nanoseconds, Some(0));
    }
}
