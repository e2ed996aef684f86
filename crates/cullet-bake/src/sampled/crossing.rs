//! A ray against a triangle and a box, in f64.

use glam::DVec3;

/// Where a ray crosses a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Crossing {
    /// In lengths of the ray's direction, above 0.
    pub(super) distance: f64,
    /// Whether the corners turn counter-clockwise, seen from where the ray starts.
    pub(super) from_front: bool,
}

/// Where a ray crosses a triangle or its border. `None` where it does not, and for a triangle seen
/// edge-on.
///
/// The sign of an edge is the same number negated for the two triangles that share it by the
/// position of its ends, so that no ray slips through between them (after Woop, Benthin & Wald,
/// *Watertight Ray/Triangle Intersection*, 2013).
#[inline]
pub(super) fn crossing(start: DVec3, along: DVec3, corners: [[f32; 3]; 3]) -> Option<Crossing> {
    let [p, q, r] = corners.map(|v| DVec3::from(v.map(f64::from)) - start);
    let normal = q.cross(r);
    let u = along.dot(normal);
    let v = along.dot(r.cross(p));
    let w = along.dot(p.cross(q));
    let (least, most) = (u.min(v).min(w), u.max(v).max(w));
    if least < 0.0 && most > 0.0 {
        return None;
    }
    let through = u + v + w;
    if through == 0.0 {
        return None;
    }
    // By the plane's own normal: p · (q × r) would lose a small triangle far from the start.
    let normal = (q - p).cross(r - p);
    let distance = p.dot(normal) / along.dot(normal);
    (distance > 0.0 && distance.is_finite())
        .then_some(Crossing { distance, from_front: through < 0.0 })
}

/// Where a ray enters a box: 0 where it starts within, `None` where it misses it. Never later than
/// it does, but for what is rounded.
#[inline]
pub(super) fn enter_box(bounds: &[DVec3; 2], start: DVec3, along: DVec3) -> Option<f64> {
    let [near, far] = through_box(bounds, start, along);
    let near = near.max(0.0);
    // Both are rounded.
    if near > far * (1.0 + 1e-12) + 1e-300 { None } else { Some(near) }
}

/// One by the coordinates of a direction; of 0 something so large that no product with it is a NaN.
#[inline]
pub(super) fn inverse(along: DVec3) -> DVec3 {
    let one = |v: f64| if v == 0.0 { 1e300 } else { 1.0 / v };
    DVec3::new(one(along.x), one(along.y), one(along.z))
}

/// Whether a ray, of whose direction the [`inverse`] is given, meets a box up to a distance.
#[inline]
pub(super) fn reaches(bounds: &[DVec3; 2], start: DVec3, inverse: DVec3, limit: f64) -> bool {
    // A hair more, so that a ray along a face, of which a coordinate is 0, is within.
    const HAIR: DVec3 = DVec3::splat(1e-200);
    let (a, b) = ((bounds[0] - start - HAIR) * inverse, (bounds[1] - start + HAIR) * inverse);
    let near = a.min(b).max_element().max(0.0);
    let far = a.max(b).min_element().min(limit);
    // All are rounded.
    near <= far * (1.0 + 1e-12)
}

/// Where a line enters a box and leaves it; the first above the second where it misses it.
#[inline]
pub(super) fn through_box(bounds: &[DVec3; 2], start: DVec3, along: DVec3) -> [f64; 2] {
    let (mut near, mut far) = (f64::NEG_INFINITY, f64::INFINITY);
    for axis in 0..3 {
        let (mut a, mut b) = (bounds[0][axis] - start[axis], bounds[1][axis] - start[axis]);
        let d = along[axis];
        if d == 0.0 {
            if a > 0.0 || b < 0.0 {
                return [f64::INFINITY, f64::NEG_INFINITY];
            }
            continue;
        }
        if d < 0.0 {
            (a, b) = (b, a);
        }
        near = near.max(a / d);
        far = far.min(b / d);
    }
    [near, far]
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: [[f32; 3]; 3] = [[0.0, 0.0, -2.0], [1.0, 0.0, -2.0], [0.0, 1.0, -2.0]];

    #[test]
    fn a_ray_meets_the_inside_and_the_border_and_nothing_else() {
        let at = |x: f64, y: f64| crossing(DVec3::new(x, y, 0.0), DVec3::NEG_Z, TRIANGLE);
        for (x, y) in [(0.2, 0.2), (0.5, 0.0), (0.5, 0.5), (0.0, 0.0)] {
            assert_eq!(at(x, y), Some(Crossing { distance: 2.0, from_front: true }), "{x} {y}");
        }
        assert_eq!(at(-0.1, 0.2), None);
        assert_eq!(at(0.6, 0.6), None);
        let back = crossing(DVec3::new(0.2, 0.2, -4.0), DVec3::Z, TRIANGLE);
        assert_eq!(back, Some(Crossing { distance: 2.0, from_front: false }));
        assert_eq!(crossing(DVec3::new(0.2, 0.2, -4.0), DVec3::NEG_Z, TRIANGLE), None, "behind it");
        assert_eq!(crossing(DVec3::new(-1.0, 0.2, -2.0), DVec3::X, TRIANGLE), None, "edge-on");
    }

    #[test]
    fn a_box_is_entered_where_it_is() {
        let b = [DVec3::ZERO, DVec3::ONE];
        assert_eq!(enter_box(&b, DVec3::new(-2.0, 0.5, 0.5), DVec3::X), Some(2.0));
        assert_eq!(enter_box(&b, DVec3::splat(0.5), DVec3::X), Some(0.0));
        assert_eq!(enter_box(&b, DVec3::new(2.0, 0.5, 0.5), DVec3::X), None);
        assert_eq!(enter_box(&b, DVec3::new(-2.0, 1.5, 0.5), DVec3::X), None);
        assert_eq!(enter_box(&b, DVec3::new(-2.0, 1.0, 0.5), DVec3::X), Some(2.0), "along a face");
        let meets = |start, along, limit| reaches(&b, start, inverse(along), limit);
        for along in [DVec3::X, DVec3::new(2.0, 0.1, 0.0)] {
            for limit in [2.1, f64::INFINITY] {
                assert!(meets(DVec3::new(-2.0, 0.5, 0.5), along, limit));
            }
            assert!(!meets(DVec3::new(-2.0, 0.5, 0.5), along, 0.9));
            assert!(!meets(DVec3::new(-2.0, 1.5, 0.5), along, f64::INFINITY));
            assert!(!meets(DVec3::new(2.0, 0.5, 0.5), along, f64::INFINITY), "behind it");
        }
        assert!(meets(DVec3::new(-2.0, 1.0, 0.5), DVec3::X, 9.0), "along a face");
        assert!(meets(DVec3::splat(0.5), DVec3::Y, 0.1), "from within");
    }
}
