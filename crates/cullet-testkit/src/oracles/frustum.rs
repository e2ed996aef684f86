//! Slow oracles of the frustum tests: plain f64, literally as the lectures have them.

use cullet::bounds::{Aabb, Plane, Side, Sphere};
use cullet::view::Frustum;
use glam::DVec3;

/// The lecture's loop, literally: the planes in camera space, out at the first plane that the sphere is
/// wholly outside of, inside only when it is inside of all.
///
/// `camera_space` is [`cullet::Projection::frustum`], `center` is the sphere's centre
/// in camera space. Plain f64; NaN is straddling.
pub fn classify_sphere_ref(camera_space: &Frustum, center: [f64; 3], radius: f64) -> Side {
    let mut inside_of = 0;
    let mut planes = 0;
    for (_, plane) in camera_space.planes() {
        planes += 1;
        let distance = plane.distance(center);
        if distance > radius {
            return Side::Outside;
        }
        if distance < -radius {
            inside_of += 1;
        }
    }
    if inside_of == planes { Side::Inside } else { Side::Straddling }
}

/// All eight corners against every plane: outside where one plane has all of them outside, inside where
/// all planes have all of them inside. Plain f64; NaN is straddling.
pub fn classify_aabb_ref(frustum: &Frustum, b: &Aabb) -> Side {
    let corners = b.corners().map(|c| c.map(f64::from));
    let mut inside = true;
    for (_, plane) in frustum.planes() {
        if corners.iter().all(|&c| plane.distance(c) > 0.0) {
            return Side::Outside;
        }
        inside &= corners.iter().all(|&c| plane.distance(c) < 0.0);
    }
    if inside { Side::Inside } else { Side::Straddling }
}

/// The slow oracle: whether box and frustum share a point, in plain f64. The six faces of the box are cut by all
/// planes of the frustum (Sutherland & Hodgman, *Reentrant Polygon Clipping*, 1974); if nothing is left of any,
/// the frustum may still lie wholly in the box.
///
/// `None` where the box is not finite, or where the frustum has no near corner to test.
pub fn intersects_ref(frustum: &Frustum, b: &Aabb) -> Option<bool> {
    if !b.is_finite() {
        return None;
    }
    let corners = b.corners().map(|c| DVec3::from(c.map(f64::from)));
    const FACES: [[usize; 4]; 6] =
        [[0, 2, 6, 4], [1, 3, 7, 5], [0, 1, 5, 4], [2, 3, 7, 6], [0, 1, 3, 2], [4, 5, 7, 6]];
    for face in FACES {
        let mut polygon = face.map(|c| corners[c]).to_vec();
        for (_, plane) in frustum.planes() {
            polygon = clipped(&polygon, plane);
        }
        if !polygon.is_empty() {
            return Some(true);
        }
    }
    let [x, y, z, _] = frustum.corners()?[0];
    let p = [x, y, z];
    Some((0..3).all(|a| f64::from(b.min[a]) <= p[a] && p[a] <= f64::from(b.max[a])))
}

fn clipped(polygon: &[DVec3], plane: &Plane) -> Vec<DVec3> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for i in 0..polygon.len() {
        let (p, q) = (polygon[i], polygon[(i + 1) % polygon.len()]);
        let (s, t) = (plane.distance(p), plane.distance(q));
        if s <= 0.0 {
            kept.push(p);
        }
        if (s < 0.0 && t > 0.0) || (s > 0.0 && t < 0.0) {
            kept.push(p + (q - p) * (s / (s - t)));
        }
    }
    kept
}

/// Where a sphere lies, with proof, in f64 with a bound of its rounding; and the number of the first plane that
/// rejects it. Empty is outside, with no plane to blame; NaN or infinite is straddling.
pub fn classify_sphere(frustum: &Frustum, sphere: &Sphere) -> (Side, Option<u8>) {
    classify(frustum, sphere.is_empty(), sphere.is_finite(), |plane| sphere.side(plane))
}

/// Where a box lies, with proof, in f64 with a bound of its rounding; and the number of the first plane that
/// rejects it. Empty is outside, with no plane to blame; NaN is straddling; an infinite side counts as what it is,
/// but such a box is never inside.
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
