//! Distances from points to triangles in double precision, one by one.

use glam::DVec3;

/// The distance from a point to the nearest triangle, and that triangle's number, by looking at all
/// in f64: what [`SurfaceTree::nearest`](super::SurfaceTree::nearest) is held against. Triangles are left out as there.
#[must_use]
pub fn nearest_ref(positions: &[[f32; 3]], indices: &[u32], point: [f32; 3]) -> Option<(f64, u32)> {
    let at = DVec3::from_array(point.map(f64::from));
    let mut best: Option<(f64, u32)> = None;
    for (t, corners) in indices.chunks_exact(3).enumerate() {
        let corners = [corners[0], corners[1], corners[2]].map(|i| {
            positions.get(i as usize).map_or(DVec3::NAN, |p| DVec3::from_array(p.map(f64::from)))
        });
        if !corners.iter().all(|c| c.is_finite()) {
            continue;
        }
        let distance = (closest_point(at, corners) - at).length();
        if distance.is_finite() && best.is_none_or(|b| distance < b.0) {
            best = Some((distance, t as u32));
        }
    }
    best
}

/// The point of a triangle that is nearest to another: the foot of the perpendicular where that is
/// inside, else the nearest point of the three edges.
pub fn closest_point(p: DVec3, [a, b, c]: [DVec3; 3]) -> DVec3 {
    let on_edge = |a: DVec3, b: DVec3| {
        let e = b - a;
        let t = (p - a).dot(e) / e.length_squared();
        // NaN for an edge without length.
        if t > 0.0 { a + e * t.min(1.0) } else { a }
    };
    let normal = (b - a).cross(c - a);
    let inside = |a: DVec3, b: DVec3| (b - a).cross(p - a).dot(normal) >= 0.0;
    if normal != DVec3::ZERO && inside(a, b) && inside(b, c) && inside(c, a) {
        let n = normal.normalize();
        return p - n * (p - a).dot(n);
    }
    let mut best = on_edge(a, b);
    for other in [on_edge(b, c), on_edge(c, a)] {
        if (other - p).length_squared() < (best - p).length_squared() {
            best = other;
        }
    }
    best
}
