//! Points on surfaces: the same for the same triangles, whoever asks.

use glam::DVec3;

use crate::random::Random;

/// A point of a surface and the triangle it lies on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// The point, rounded to f32.
    pub point: [f32; 3],
    /// The triangle, by its place in the list of indices.
    pub triangle: u32,
}

/// `count` points within a triangle, evenly distributed: the same for the same seed and number of
/// the triangle, whatever the others are. Corners that are not finite give points that are not.
pub fn inner_points(
    corners: [[f32; 3]; 3],
    seed: u64,
    triangle: u32,
    count: u32,
) -> impl Iterator<Item = [f32; 3]> {
    let corners = corners.map(double);
    let mut random = Random::new(seed, [triangle, 0]);
    (0..count).map(move |_| inner(corners, &mut random))
}

/// `count` points of a surface, evenly distributed by area: each triangle has as many as its share
/// of the area says, rounded up or down, so that small triangles have one now and then. The same
/// for the same seed.
///
/// None where there is no area. Triangles with a corner that is not finite or does not exist have
/// none.
#[must_use]
pub fn surface_points(
    positions: &[[f32; 3]],
    indices: &[u32],
    count: usize,
    seed: u64,
) -> Vec<SurfacePoint> {
    let corners = |t: &[u32]| {
        let [a, b, c] = [t[0], t[1], t[2]].map(|i| positions.get(i as usize).copied().map(double));
        Some([a?, b?, c?])
    };
    let area = |t: &[u32]| {
        let area = corners(t).map_or(0.0, |[a, b, c]| (b - a).cross(c - a).length());
        if area.is_finite() { area } else { 0.0 }
    };
    let total: f64 = indices.chunks_exact(3).map(area).sum();
    let mut points = Vec::new();
    if !(total > 0.0 && total.is_finite()) {
        return points;
    }
    points.reserve_exact(count);
    let mut random = Random::new(seed, [0, 1]);
    // Marks at equal steps along the areas laid end to end; the first anywhere in its step.
    let start = random.unit();
    let mut before = 0.0;
    for (t, triangle) in indices.chunks_exact(3).enumerate() {
        before += area(triangle);
        let mark = |made: usize| (made as f64 + start) / count as f64 * total;
        let Some(corners) = corners(triangle) else { continue };
        while points.len() < count && mark(points.len()) < before {
            points.push(SurfacePoint { point: inner(corners, &mut random), triangle: t as u32 });
        }
    }
    points
}

fn double(p: [f32; 3]) -> DVec3 {
    DVec3::from_array(p.map(f64::from))
}

fn inner([a, b, c]: [DVec3; 3], random: &mut Random) -> [f32; 3] {
    let (mut u, mut v) = (random.unit(), random.unit());
    // The far half of the parallelogram, folded back.
    if u + v > 1.0 {
        (u, v) = (1.0 - u, 1.0 - v);
    }
    (a + (b - a) * u + (c - a) * v).as_vec3().to_array()
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet_testkit::soups;

    #[test]
    fn points_follow_the_area_and_lie_on_their_triangles() {
        let (positions, mut indices) = soups::bumpy_ball(12, 0.2);
        // Without area, with a corner that is missing.
        indices.extend([0, 0, 1, 0, 1, 90_000]);
        let count = 5000;
        let points = surface_points(&positions, &indices, count, 3);
        assert_eq!(points.len(), count);
        assert_eq!(points, surface_points(&positions, &indices, count, 3));
        assert_ne!(points, surface_points(&positions, &indices, count, 4));
        let corners = |t: usize| [0, 1, 2].map(|k| positions[indices[t * 3 + k] as usize]);
        let area = |t: usize| {
            let [a, b, c] = corners(t).map(double);
            (b - a).cross(c - a).length()
        };
        let triangles = indices.len() / 3 - 2;
        let total: f64 = (0..triangles).map(area).sum();
        let mut counts = vec![0_u32; triangles];
        for p in &points {
            let t = p.triangle as usize;
            counts[t] += 1;
            let [a, b, c] = corners(t).map(double);
            let normal = (b - a).cross(c - a).normalize();
            assert!((double(p.point) - a).dot(normal).abs() < 1e-6);
        }
        for (t, &n) in counts.iter().enumerate() {
            let due = area(t) / total * count as f64;
            assert!((f64::from(n) - due).abs() <= 1.0 + 1e-6, "{t}: {n} of {due}");
        }
    }

    #[test]
    fn inner_points_depend_on_their_triangle_alone_and_are_inside() {
        let corners = [[1.0, 2.0, 3.0], [4.0, 2.0, 3.0], [1.0, 7.0, 3.0]];
        let points: Vec<_> = inner_points(corners, 9, 5, 200).collect();
        assert_eq!(points[..50], inner_points(corners, 9, 5, 50).collect::<Vec<_>>());
        for [x, y, z] in points.iter().copied() {
            let (u, v) = ((x - 1.0) / 3.0, (y - 2.0) / 5.0);
            assert!(u >= 0.0 && v >= 0.0 && u + v <= 1.0 + 1e-6 && z == 3.0);
        }
        // All over it, not in one half.
        let far = points.iter().filter(|p| (p[0] - 1.0) / 3.0 + (p[1] - 2.0) / 5.0 > 0.7).count();
        assert!((70..135).contains(&far), "{far}");
    }

    #[test]
    fn nothing_has_no_points() {
        assert_eq!(surface_points(&[], &[], 10, 1), []);
        assert_eq!(surface_points(&[[0.0; 3]], &[0, 0, 0], 10, 1), []);
        assert_eq!(surface_points(&[[f32::NAN; 3]; 3], &[0, 1, 2], 10, 1), []);
    }
}
