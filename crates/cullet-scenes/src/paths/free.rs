//! Where an eye may stand: how near geometry is to a point, whether something closed is around it,
//! how far one sees from it, and where there is ground.

use cullet::bounds::Aabb;
use cullet::math;
use cullet::{Mesh, Scene, Transform};
use glam::{DMat3, DVec3};

/// For each box, in coordinates relative to the scene's origin, the slots whose bounds meet it. One
/// pass over the scene; slots without finite bounds are passed over.
pub(super) fn gather(scene: &Scene, queries: &[[DVec3; 2]]) -> Vec<Vec<u32>> {
    let mut found = vec![Vec::new(); queries.len()];
    let whole = queries.iter().copied().reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]);
    let Some([low, high]) = whole else { return found };
    // A grid over x and z tells which few queries an instance may meet.
    const SIDE: usize = 64;
    let step = ((high - low) / SIDE as f64).max(DVec3::splat(f64::MIN_POSITIVE));
    let cell = |v: f64, a: usize| (((v - low[a]) / step[a]).max(0.0) as usize).min(SIDE - 1);
    let mut grid = vec![Vec::new(); SIDE * SIDE];
    for (q, [a, b]) in queries.iter().enumerate() {
        for z in cell(a.z, 2)..=cell(b.z, 2) {
            for x in cell(a.x, 0)..=cell(b.x, 0) {
                grid[z * SIDE + x].push(q);
            }
        }
    }
    let meet = |[a, b]: &[DVec3; 2], [c, d]: &[DVec3; 2]| a.cmple(*d).all() && b.cmpge(*c).all();
    let endless = |v: f32| v.abs() >= cullet::bounds::Boxes::LIMIT;
    for s in scene.slots() {
        let stored = scene.boxes().get(s as usize);
        let b = [stored.min, stored.max].map(|v| DVec3::from(v.map(f64::from)));
        if !meet(&b, &[low, high]) || stored.min.into_iter().chain(stored.max).any(endless) {
            continue;
        }
        for z in cell(b[0].z, 2)..=cell(b[1].z, 2) {
            for x in cell(b[0].x, 0)..=cell(b[1].x, 0) {
                for &q in &grid[z * SIDE + x] {
                    // An instance over several cells meets the same query in each, with no other
                    // instance in between.
                    if meet(&b, &queries[q]) && found[q].last() != Some(&s) {
                        found[q].push(s);
                    }
                }
            }
        }
    }
    found
}

/// A slot's geometry in world space.
struct PlacedMesh<'a> {
    mesh: &'a Mesh,
    transform: &'a Transform,
    linear: DMat3,
    translation: DVec3,
}

impl<'a> PlacedMesh<'a> {
    fn new(scene: &'a Scene, slot: u32) -> Self {
        let transform = scene.transform(slot);
        let column = |c: usize| DVec3::from(transform.linear[c].map(f64::from));
        Self {
            mesh: scene.mesh(slot),
            transform,
            linear: DMat3::from_cols(column(0), column(1), column(2)),
            translation: transform.translation.into(),
        }
    }

    /// Calls `each` with the corners of every triangle of every cluster whose world box `wanted`
    /// wants.
    fn triangles(
        &self,
        mut wanted: impl FnMut(DVec3, DVec3) -> bool,
        mut each: impl FnMut([DVec3; 3]),
    ) {
        let corner = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        for (i, c) in self.mesh.clusters().iter().enumerate() {
            let b: Aabb = self.transform.transform_box(&self.mesh.cluster_boxes().get(i), [0.0; 3]);
            if !wanted(corner(b.min), corner(b.max)) {
                continue;
            }
            for t in c.first_triangle..c.first_triangle + c.triangle_count {
                each(self.mesh.corners(t).map(|p| self.linear * corner(p) + self.translation));
            }
        }
    }

    /// How often the surface winds about a point: 1 inside of a solid, 0 outside, between at holes
    /// (Jacobson, Kavan, Sorkine-Hornung, *Robust Inside-Outside Segmentation Using Generalized
    /// Winding Numbers*, 2013; angle of a triangle: Van Oosterom, Strackee, *The Solid Angle of a
    /// Plane Triangle*, 1983). 0 where the transform is singular.
    fn winding(&self, point: DVec3) -> f64 {
        let inverse = self.linear.inverse();
        let p = inverse * (point - self.translation);
        if !p.is_finite() {
            return 0.0;
        }
        let positions = self.mesh.positions();
        let mut angle = 0.0;
        for t in self.mesh.indices().chunks_exact(3) {
            let [a, b, c] =
                [t[0], t[1], t[2]].map(|v| DVec3::from(positions[v as usize].map(f64::from)) - p);
            let (la, lb, lc) = (a.length(), b.length(), c.length());
            let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
            angle += 2.0 * math::atan2(a.dot(b.cross(c)), below);
        }
        angle / (4.0 * std::f64::consts::PI)
    }
}

/// Whether an eye may be at `point`: no triangle of `slots` is nearer than `clearance`, and none of
/// them is closed around it.
pub(super) fn is_free(scene: &Scene, slots: &[u32], point: DVec3, clearance: f64) -> bool {
    let origin = DVec3::from(scene.origin());
    slots.iter().all(|&slot| {
        let placed = PlacedMesh::new(scene, slot);
        let mut free = true;
        let near = |low: DVec3, high: DVec3| point.clamp(low, high).distance(point) < clearance;
        placed.triangles(near, |t| free &= distance(point, t) >= clearance);
        if !free {
            return false;
        }
        let b = scene.bounds(slot);
        let within = b.contains((point - origin).as_vec3().to_array());
        !within || placed.winding(point) < 0.5
    })
}

/// Heights, ascending, at which a plumb line through (x, z) meets triangles of `slots`.
pub(super) fn heights(scene: &Scene, slots: &[u32], x: f64, z: f64) -> Vec<f64> {
    let mut found = Vec::new();
    for &slot in slots {
        let over = |low: DVec3, high: DVec3| low.x <= x && x <= high.x && low.z <= z && z <= high.z;
        PlacedMesh::new(scene, slot).triangles(over, |[a, b, c]| {
            let side = |p: DVec3, q: DVec3| (q.x - p.x) * (z - p.z) - (q.z - p.z) * (x - p.x);
            let (u, v, w) = (side(b, c), side(c, a), side(a, b));
            let sum = u + v + w;
            let same = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
            if same && sum != 0.0 {
                found.push((a.y * u + b.y * v + c.y * w) / sum);
            }
        });
    }
    found.sort_by(f64::total_cmp);
    found
}

/// How far one sees from `point` along the unit vector `along` before a triangle of `slots`, at
/// most `far`.
pub(super) fn sight(scene: &Scene, slots: &[u32], point: DVec3, along: DVec3, far: f64) -> f64 {
    let mut nearest = far;
    for &slot in slots {
        let reach = std::cell::Cell::new(nearest);
        let crosses = |low: DVec3, high: DVec3| {
            let (a, b) = ((low - point) / along, (high - point) / along);
            let enter = a.min(b).max_element().max(0.0);
            let leave = a.max(b).min_element().min(reach.get());
            // A NaN (0/0) means that the line runs in a face of the box: look inside.
            enter <= leave || enter.is_nan() || leave.is_nan()
        };
        PlacedMesh::new(scene, slot).triangles(crosses, |[a, b, c]| {
            // Möller, Trumbore, *Fast, Minimum Storage Ray/Triangle Intersection*, 1997.
            let (e1, e2) = (b - a, c - a);
            let p = along.cross(e2);
            let det = e1.dot(p);
            let s = point - a;
            let q = s.cross(e1);
            let (u, v, t) = (s.dot(p) / det, along.dot(q) / det, e2.dot(q) / det);
            if u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= 0.0 {
                reach.set(reach.get().min(t));
            }
        });
        nearest = reach.get();
    }
    nearest
}

/// The distance of a point from a triangle (Ericson, *Real-Time Collision Detection*, 2004, 5.1.5).
fn distance(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let segment = |p: DVec3, a: DVec3, e: DVec3| {
        let t = ((p - a).dot(e) / e.length_squared()).clamp(0.0, 1.0);
        // A segment without length gives NaN: then its start is as near as any point of it.
        if t.is_nan() { p.distance(a) } else { p.distance(a + e * t) }
    };
    let n = ab.cross(ac);
    let (u, v) = (n.dot(ap.cross(ac)), n.dot(ab.cross(ap)));
    let nn = n.length_squared();
    if nn > 0.0 && u >= 0.0 && v >= 0.0 && u + v <= nn {
        return n.dot(ap).abs() / nn.sqrt();
    }
    segment(p, a, ab).min(segment(p, a, ac)).min(segment(p, b, c - b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet::{Instance, MeshData};

    fn cube() -> Mesh {
        let positions = (0..8)
            .map(|i| std::array::from_fn(|a| if i >> a & 1 == 1 { 1.0 } else { -1.0 }))
            .collect();
        let quads =
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let indices = quads.iter().flat_map(|[a, b, c, d]| [*a, *b, *c, *a, *c, *d]).collect();
        Mesh::new(MeshData { positions, indices, ..MeshData::default() }).unwrap()
    }

    fn scene() -> Scene {
        let mut scene = Scene::new();
        let mesh = scene.add_mesh(cube());
        // Mirrored and stretched: it fills −2..2 × −1..1 × −1..1 about (10, 0, 0).
        let t = Transform::from_scale_translation([-2.0, 1.0, 1.0], [10.0, 0.0, 0.0]);
        scene.add(Instance::new(mesh, t)).unwrap();
        scene
    }

    #[test]
    fn a_point_is_free_away_from_surfaces_and_outside_of_solids() {
        let scene = scene();
        let free = |x: f64, y: f64, clearance: f64| {
            let p = DVec3::new(x, y, 0.1);
            let near = gather(&scene, &[[p - clearance, p + clearance]]);
            is_free(&scene, &near[0], p, clearance)
        };
        assert!(!free(10.0, 0.0, 0.1), "inside");
        assert!(!free(12.05, 0.0, 0.1), "too near");
        assert!(free(12.2, 0.0, 0.1) && free(0.0, 0.0, 5.0) && free(10.0, 1.2, 0.1));
    }

    #[test]
    fn winding_tells_inside_from_outside() {
        let scene = scene();
        let placed = PlacedMesh::new(&scene, 0);
        assert!((placed.winding(DVec3::new(11.5, 0.3, -0.2)) - 1.0).abs() < 1e-9);
        assert!(placed.winding(DVec3::new(13.0, 0.3, -0.2)).abs() < 1e-9);
    }

    #[test]
    fn plumb_line_and_sight_meet_the_surface() {
        let scene = scene();
        let at = heights(&scene, &[0], 11.0, 0.3);
        assert!(at.len() >= 2 && at[0] == -1.0 && at[at.len() - 1] == 1.0, "{at:?}");
        assert!(heights(&scene, &[0], 13.0, 0.3).is_empty());
        let see = |x: f64| sight(&scene, &[0], DVec3::new(x, 0.1, 0.2), DVec3::X, 50.0);
        assert!((see(0.0) - 8.0).abs() < 1e-12);
        assert_eq!(see(20.0), 50.0);
    }

    #[test]
    fn distance_agrees_with_sampling() {
        let t = [DVec3::ZERO, DVec3::new(2.0, 0.0, 0.3), DVec3::new(0.5, 1.5, -0.2)];
        for p in [[3.0, 1.0, 1.0], [0.5, 0.4, 2.0], [-1.0, -1.0, 0.0], [0.6, 3.0, -1.0]] {
            let p = DVec3::from(p);
            let mut least = f64::INFINITY;
            for i in 0..=200 {
                for j in 0..=200 - i {
                    let (u, v) = (f64::from(i) / 200.0, f64::from(j) / 200.0);
                    least = least.min(p.distance(t[0] + (t[1] - t[0]) * u + (t[2] - t[0]) * v));
                }
            }
            let d = distance(p, t);
            assert!(d <= least + 1e-12 && d > least - 0.02, "{d} {least}");
        }
        assert_eq!(distance(DVec3::X, [DVec3::ZERO; 3]), 1.0);
    }

    #[test]
    fn gathering_finds_what_a_loop_finds() {
        let mut scene = Scene::new();
        let mesh = scene.add_mesh(cube());
        let mut rng = crate::Rng::new(7, 7);
        for _ in 0..300 {
            let at = [rng.range(-50.0, 50.0), rng.range(-5.0, 5.0), rng.range(-50.0, 50.0)];
            let size = rng.range(0.1, 20.0) as f32;
            let t = Transform::from_scale_translation([size, 1.0, size], at);
            scene.add(Instance::new(mesh, t)).unwrap();
        }
        let queries: Vec<[DVec3; 2]> = (0..40)
            .map(|_| {
                let at = DVec3::new(rng.range(-60.0, 60.0), 0.0, rng.range(-60.0, 60.0));
                [at, at + DVec3::splat(rng.range(0.0, 3.0))]
            })
            .collect();
        for (q, found) in queries.iter().zip(gather(&scene, &queries)) {
            let meets = |s: &u32| {
                let b = scene.boxes().get(*s as usize);
                (0..3).all(|a| f64::from(b.min[a]) <= q[1][a] && f64::from(b.max[a]) >= q[0][a])
            };
            assert_eq!(found, scene.slots().filter(meets).collect::<Vec<_>>());
        }
    }
}
