//! The exact size of a scene.

use cullet::Scene;
use glam::{DMat3, DVec3};

/// Returns the lowest and highest corner of all that is drawn with finite bounds, in world space:
/// of the vertices themselves, where [`Scene::extent`] is of boxes, which a turn makes larger.
/// `None` where there is nothing.
///
/// O(instances), and O(triangles) for those that reach the outside; nothing is copied.
#[must_use]
pub fn extent(scene: &Scene) -> Option<[[f64; 3]; 2]> {
    // The farthest first: most of the rest is then inside, and costs one box each.
    let mut farthest = [(f64::NEG_INFINITY, None); 6];
    for slot in scene.slots() {
        let Some([low, high]) = loose(scene, slot) else { continue };
        let reach = [-low.x, -low.y, -low.z, high.x, high.y, high.z];
        for (most, reach) in farthest.iter_mut().zip(reach).filter(|(most, r)| *r > most.0) {
            *most = (reach, Some(slot));
        }
    }
    let mut all = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    let mut done: Vec<u32> = farthest.iter().filter_map(|(_, slot)| *slot).collect();
    done.sort_unstable();
    done.dedup();
    done.iter().for_each(|&slot| add(&mut all, scene, slot));
    for slot in scene.slots().filter(|slot| !done.contains(slot)) {
        let Some([low, high]) = loose(scene, slot) else { continue };
        if low.cmplt(all[0]).any() || high.cmpgt(all[1]).any() {
            add(&mut all, scene, slot);
        }
    }
    all[0].is_finite().then(|| all.map(|corner| corner.to_array()))
}

/// The linear part of an instance's transform, and where it is.
fn place(scene: &Scene, slot: u32) -> (DMat3, DVec3) {
    let transform = scene.transform(slot);
    let column = |c: [f32; 3]| DVec3::from(c.map(f64::from));
    let [x, y, z] = transform.linear.map(column);
    (DMat3::from_cols(x, y, z), transform.translation.into())
}

/// A box around an instance; `None` where its bounds are not finite.
fn loose(scene: &Scene, slot: u32) -> Option<[DVec3; 2]> {
    let point = |v: [f32; 3]| DVec3::from(v.map(f64::from));
    let mesh = scene.mesh(slot);
    let known = scene.bounds(slot);
    if !known.is_finite() {
        return None;
    }
    if mesh.clusters().is_empty() {
        let origin = DVec3::from(scene.origin());
        return Some([point(known.min) + origin, point(known.max) + origin]);
    }
    let (linear, translation) = place(scene, slot);
    let (low, high) = (point(mesh.bounds().min), point(mesh.bounds().max));
    let (centre, half) = ((low + high) * 0.5, (high - low) * 0.5);
    let centre = linear * centre + translation;
    let [x, y, z] = [linear.x_axis, linear.y_axis, linear.z_axis].map(DVec3::abs);
    let reach = x * half.x + y * half.y + z * half.z;
    Some([centre - reach, centre + reach])
}

/// Takes in the corners of all triangles of an instance that have area.
fn add(all: &mut [DVec3; 2], scene: &Scene, slot: u32) {
    let mesh = scene.mesh(slot);
    if mesh.clusters().is_empty() {
        let [low, high] = loose(scene, slot).unwrap_or(*all);
        *all = [all[0].min(low), all[1].max(high)];
        return;
    }
    let (linear, translation) = place(scene, slot);
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for t in 0..mesh.triangle_count() - mesh.degenerate_count() {
        for corner in mesh.corners(t) {
            let at = linear * DVec3::from(corner.map(f64::from));
            (low, high) = (low.min(at), high.max(at));
        }
    }
    *all = [all[0].min(low + translation), all[1].max(high + translation)];
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
