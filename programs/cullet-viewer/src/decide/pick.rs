//! Finds the triangle that a line of sight meets first: tests boxes of instances, then of clusters,
//! then triangles.

use cullet::Scene;
use cullet::bounds::Aabb;
use cullet::view::Ray;
use glam::{DMat3, DVec3};

/// The triangle that a line of sight meets first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The instance's slot.
    pub slot: u32,
    /// The original triangle.
    pub triangle: u32,
    /// How far along the ray, in world units.
    pub distance: f64,
}

/// The nearest triangle on the ray among the slots for which `wanted` holds, of instances and of
/// those that stand for others, from both sides. `None` where there is none. Costs a box test an
/// instance, and triangle tests in the clusters that the ray passes.
pub fn pick(scene: &Scene, ray: &Ray, wanted: impl Fn(u32) -> bool) -> Option<Hit> {
    let origin = DVec3::from(ray.origin) - DVec3::from(scene.origin());
    let direction = DVec3::from(ray.direction);
    let mut boxes: Vec<(f64, u32)> = scene
        .slots()
        .chain(scene.stand_in_slots())
        .filter(|&slot| wanted(slot))
        .filter_map(|slot| Some((enters(&scene.bounds(slot), origin, direction)?, slot)))
        .collect();
    boxes.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let mut best: Option<Hit> = None;
    for (entry, slot) in boxes {
        // All that follow begin farther away.
        if best.is_some_and(|b| b.distance < entry) {
            break;
        }
        if let Some(hit) = in_instance(scene, slot, ray)
            && best.is_none_or(|b| hit.distance < b.distance)
        {
            best = Some(hit);
        }
    }
    best
}

fn in_instance(scene: &Scene, slot: u32, ray: &Ray) -> Option<Hit> {
    let transform = scene.transform(slot);
    let mesh = scene.mesh(slot);
    let linear = DMat3::from_cols_array_2d(&transform.linear.map(|c| c.map(f64::from)));
    let inverse = linear.inverse();
    if !inverse.is_finite() {
        return None;
    }
    // The direction is not made unit again: distances stay those of the world.
    let origin = inverse * (DVec3::from(ray.origin) - DVec3::from(transform.translation));
    let direction = inverse * DVec3::from(ray.direction);
    let mut best: Option<Hit> = None;
    let clusters = mesh.clusters().iter().zip(0..mesh.cluster_boxes().len());
    for (cluster, i) in clusters {
        if enters(&mesh.cluster_boxes().get(i), origin, direction).is_none() {
            continue;
        }
        for t in cluster.triangles() {
            let corners = mesh.corners(t).map(|p| DVec3::from(p.map(f64::from)));
            if let Some(distance) = meets(corners, origin, direction)
                && best.is_none_or(|b| distance < b.distance)
            {
                let triangle = mesh.original_triangle()[t as usize];
                best = Some(Hit { slot, triangle, distance });
            }
        }
    }
    best
}

/// Where a ray enters a box, 0 if it begins inside; `None` if it misses. A box without end is
/// entered.
fn enters(b: &Aabb, origin: DVec3, direction: DVec3) -> Option<f64> {
    if b.is_empty() {
        return None;
    }
    let (mut near, mut far) = (0.0f64, f64::INFINITY);
    for a in 0..3 {
        let (low, high) = (f64::from(b.min[a]), f64::from(b.max[a]));
        if direction[a] == 0.0 {
            if origin[a] < low || origin[a] > high {
                return None;
            }
            continue;
        }
        let (s, t) = ((low - origin[a]) / direction[a], (high - origin[a]) / direction[a]);
        near = near.max(s.min(t));
        far = far.min(s.max(t));
    }
    // A little slack: a flat box is as thin as its rounding.
    (near <= far + far.abs() * 1e-9).then_some(near)
}

/// Where a ray meets a triangle (Möller and Trumbore, *Fast, Minimum Storage Ray/Triangle
/// Intersection*, 1997), from either side.
fn meets([a, b, c]: [DVec3; 3], origin: DVec3, direction: DVec3) -> Option<f64> {
    let (ab, ac) = (b - a, c - a);
    let p = direction.cross(ac);
    let det = ab.dot(p);
    if det == 0.0 {
        return None;
    }
    let to = origin - a;
    let u = to.dot(p) / det;
    let q = to.cross(ab);
    let v = direction.dot(q) / det;
    let t = ac.dot(q) / det;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= 0.0).then_some(t)
}
