//! An eye for which a scene is simplified: what is far may be farther off.

use cullet::Scene;
use cullet::lod::{LevelEye, Lod, PixelScale};

use super::uses::Uses;

/// Lines of the image that pixels are of, and the tangent of half its field of view, 60 degrees.
const LINES: f64 = 1080.0;
const HALF_TANGENT: f64 = 0.577_350_269_189_625_8;

/// The eye at so many radii from the middle of a scene, on the side of +Z, for which nothing may be
/// off by more than so many pixels at the image's centre: for each mesh, as all its instances see
/// it, each in the mesh's own space.
pub(super) fn eyes(scene: &Scene, uses: &Uses, pixels: f64, distance: f64) -> Vec<Vec<LevelEye>> {
    let [x, y, z] = std::array::from_fn(|a| uses.middle[a] + scene.origin()[a]);
    let scale = PixelScale {
        eye: Some([x, y, z + distance * uses.radius]),
        pixels: LINES * 0.5 / HALF_TANGENT,
        near: uses.radius * 1e-3,
    };
    let lod = Lod::default().with_pixels(pixels);
    let mut of_meshes = vec![Vec::new(); scene.meshes().len()];
    for slot in scene.slots() {
        let eye = LevelEye::new(&lod, &scale, scene.transform(slot), None);
        of_meshes[scene.mesh_id(slot) as usize].push(eye);
    }
    of_meshes
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet::lod::Group;
    use cullet::{Instance, Transform};
    use cullet_testkit::meshes;

    #[test]
    fn a_pixel_is_as_large_as_it_looks_at_the_nearest_instance() {
        let mut scene = Scene::new();
        let mesh = scene.add_mesh(meshes::ball(8));
        scene.add(Instance::new(mesh, Transform::IDENTITY)).unwrap();
        let at = Transform::from_scale_translation([2.0; 3], [0.0, 0.0, -20.0]);
        scene.add(Instance::new(mesh, at)).unwrap();
        scene.commit(&cullet::Culler::default());
        let uses = Uses::of(&scene);
        let eyes = &eyes(&scene, &uses, 1.0, 3.0)[0];
        assert_eq!(eyes.len(), 2);
        let eye = uses.middle[2] + scene.origin()[2] + 3.0 * uses.radius;
        let far = |z: f64, scale: f64| (eye - z - scale) / scale * HALF_TANGENT / 540.0;
        // Slots are in no order of the instances.
        let mut wanted = [(0.0, 1.0), (-20.0, 2.0)].map(|(z, scale)| far(z, scale));
        let mut allowed: Vec<f64> = eyes.iter().map(|e| e.allowed([0.0; 3], 1.0).into()).collect();
        allowed.sort_unstable_by(f64::total_cmp);
        wanted.sort_unstable_by(f64::total_cmp);
        for (wanted, allowed) in wanted.into_iter().zip(allowed) {
            assert!(allowed <= wanted && allowed > wanted * 0.999, "{allowed} {wanted}");
        }
        let group = |error: f64| Group { radius: 1.0, error: error as f32, ..Group::default() };
        let is_over = |error| eyes.iter().any(|e| e.is_over(&group(error)));
        assert!(!is_over(wanted[0] * 0.999) && is_over(wanted[0] * 1.001));
    }
}
