//! The exact size of a scene.

use cullet::Scene;

use crate::place::{WorldBox, world, world_box};

/// Returns the lowest and highest corner of all that is drawn with finite bounds, in world space:
/// of the vertices themselves, where [`Scene::extent`] is of boxes, which a turn makes larger.
/// `None` where there is nothing.
///
/// O(instances), and O(triangles) for those that reach the outside; nothing is copied.
#[must_use]
pub fn extent(scene: &Scene) -> Option<WorldBox> {
    // The farthest first: most of the rest is then inside, and costs one box each.
    let mut farthest = [(f64::NEG_INFINITY, None); 6];
    for slot in scene.slots() {
        let Some([low, high]) = loose(scene, slot) else { continue };
        let reach = [-low[0], -low[1], -low[2], high[0], high[1], high[2]];
        for (most, reach) in farthest.iter_mut().zip(reach).filter(|(most, r)| *r > most.0) {
            *most = (reach, Some(slot));
        }
    }
    let mut done: Vec<u32> = farthest.iter().filter_map(|(_, slot)| *slot).collect();
    done.sort_unstable();
    done.dedup();
    let mut all = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    done.iter().for_each(|&slot| add(&mut all, scene, slot));
    for slot in scene.slots().filter(|slot| !done.contains(slot)) {
        let Some([low, high]) = loose(scene, slot) else { continue };
        if (0..3).any(|a| low[a] < all[0][a] || high[a] > all[1][a]) {
            add(&mut all, scene, slot);
        }
    }
    (!done.is_empty()).then_some(all)
}

/// A box around an instance; `None` where its bounds are not finite.
fn loose(scene: &Scene, slot: u32) -> Option<WorldBox> {
    let known = Some(scene.bounds(slot)).filter(cullet::bounds::Aabb::is_finite)?;
    if !scene.mesh(slot).clusters().is_empty() {
        return world_box(scene, slot);
    }
    let origin = scene.origin();
    Some([known.min, known.max].map(|v| std::array::from_fn(|a| f64::from(v[a]) + origin[a])))
}

/// Takes in the corners of all triangles of an instance that have area.
fn add(all: &mut WorldBox, scene: &Scene, slot: u32) {
    let mut take = |p: [f64; 3]| {
        all[0] = std::array::from_fn(|a| all[0][a].min(p[a]));
        all[1] = std::array::from_fn(|a| all[1][a].max(p[a]));
    };
    let (mesh, transform) = (scene.mesh(slot), scene.transform(slot));
    if mesh.clusters().is_empty() {
        loose(scene, slot).into_iter().flatten().for_each(&mut take);
    }
    for t in 0..mesh.triangle_count() - mesh.degenerate_count() {
        mesh.corners(t).into_iter().for_each(|corner| take(world(transform, corner)));
    }
}

#[cfg(test)]
mod tests {
    use cullet::{Instance, Mesh, MeshData, Transform};

    use super::*;

    #[test]
    fn a_turned_ball_is_as_large_as_before() {
        let n = 32;
        let ring = |k: usize| {
            let angle = std::f32::consts::TAU * k as f32 / n as f32;
            [angle.cos(), angle.sin(), 0.0]
        };
        let positions: Vec<[f32; 3]> = (0..n).map(ring).chain([[9.0; 3]]).collect();
        let indices = (1..n as u32 - 1).flat_map(|k| [0, k, k + 1]).collect();
        // The last vertex is in no triangle, so it is nowhere.
        let mesh = Mesh::new(MeshData { positions, indices, ..MeshData::default() }).unwrap();
        let mut scene = Scene::new();
        assert_eq!(extent(&scene), None);
        let mesh = scene.add_mesh(mesh);
        let (s, c) = std::f32::consts::FRAC_PI_4.sin_cos();
        for far in [1e6, 1e6 + 0.25, 1e6 - 0.25] {
            let transform = Transform {
                linear: [[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]],
                translation: [far, 0.0, 0.0],
            };
            scene.add(Instance::new(mesh, transform)).unwrap();
        }
        scene.rebase([1e6, 0.0, 0.0]);
        let [low, high] = extent(&scene).unwrap();
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-6, "{a} is not {b}");
        near(high[0] - low[0], 2.5);
        near(high[1] - low[1], 2.0);
        near(low[0], 1e6 - 1.25);
        assert!(scene.extent().max[1] > 1.4, "a box of boxes is larger");
    }
}
