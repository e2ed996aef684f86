//! Instances in the place of others.

use cullet::Scene;

use crate::sort;

/// Instances with the mesh and, bit for bit, the transform of one with a lower slot; ascending. O(n
/// log n).
#[must_use]
pub fn twins(scene: &Scene) -> Vec<u32> {
    let key = |slot: u32| {
        let t = scene.transform(slot);
        let linear = t.linear.map(|c| c.map(f32::to_bits));
        (scene.mesh_id(slot), linear, t.translation.map(f64::to_bits))
    };
    let hash = |&slot: &u32| {
        let (mesh, linear, translation) = key(slot);
        let words = linear.as_flattened().iter().map(|&v| u64::from(v)).chain(translation);
        // Any odd number with bits all over.
        words.fold(u64::from(mesh), |h, v| {
            (h.rotate_left(5) ^ v).wrapping_mul(0x9E37_79B9_7F4A_7C15)
        })
    };
    let slots: Vec<u32> = scene.slots().collect();
    let mut twins = Vec::new();
    for alike in sort::sorted_by(&slots, hash).chunk_by(|a, b| hash(a) == hash(b)) {
        for (i, &slot) in alike.iter().enumerate() {
            if alike[..i].iter().any(|&other| key(other) == key(slot)) {
                twins.push(slot);
            }
        }
    }
    sort::sorted_by(&twins, |&slot| slot.into())
}

#[cfg(test)]
mod tests {
    use cullet::{Instance, Transform};
    use cullet_testkit::meshes;

    use super::*;

    #[test]
    fn the_first_of_those_in_one_place_is_no_twin() {
        let mut scene = Scene::new();
        let meshes = [1.0, 2.0].map(|v| scene.add_mesh(meshes::block([0.0; 3], [v; 3])));
        let mut expected = Vec::new();
        for (i, x) in [(0, 1.0), (0, 2.0), (1, 1.0), (0, 1.0), (1, 2.0), (0, 1.0), (1, 1.0)] {
            let place = Transform::from_translation([x, 0.0, 0.0]);
            scene.add(Instance::new(meshes[i], place)).unwrap();
            expected.push((i, x));
        }
        let twins = twins(&scene);
        let is_twin = |slot: usize| expected[..slot].contains(&expected[slot]);
        let expected: Vec<u32> = (0..7).filter(|&slot| is_twin(slot)).map(|s| s as u32).collect();
        assert_eq!((twins.len(), twins), (3, expected));
    }
}
