//! An eye for which a scene is simplified: what is far may be farther off.

use cullet::{Scene, Transform};
use cullet_bake::levels::Group;

use super::uses::{Uses, largest_scale};

/// Lines of the image that pixels are of, and the tangent of half its field of view, 60 degrees.
const LINES: f64 = 1080.0;
const HALF_TANGENT: f64 = 0.577_350_269_189_625_8;

/// An eye before the scene, on the side of +Z.
#[derive(Clone, Copy, Debug)]
pub(super) struct Eye {
    at: [f64; 3],
    /// How far something may be off, as a share of its distance.
    share: f64,
    /// Nothing is taken for nearer than this.
    near: f64,
}

impl Eye {
    /// The eye at so many radii from the middle of a scene, for which nothing may be off by more than so many pixels.
    pub(super) fn new(uses: &Uses, pixels: f64, distance: f64) -> Self {
        let mut at = uses.middle;
        at[2] += distance * uses.radius;
        let near = uses.radius * 1e-3;
        Self { at, share: pixels * HALF_TANGENT / (LINES * 0.5), near }
    }

    /// How far a sphere of a mesh may be off, in units of the mesh, so that no instance of it is too far off: it may be as near
    /// as any of it is.
    pub(super) fn bound(&self, instances: &[Placed], centre: [f32; 3], radius: f32) -> f64 {
        let bound = |placed: &Placed| {
            let c = centre.map(f64::from);
            let apart: f64 = (0..3)
                .map(|a| {
                    let turned: f64 = (0..3).map(|k| placed.columns[k][a] * c[k]).sum();
                    (turned + placed.translation[a] - self.at[a]).powi(2)
                })
                .sum();
            let distance = (apart.sqrt() - placed.scale * f64::from(radius)).max(self.near);
            if placed.scale > 0.0 { self.share * distance / placed.scale } else { f64::INFINITY }
        };
        instances.iter().map(bound).fold(f64::INFINITY, f64::min)
    }

    /// Whether a group of clusters is too far off for the eye, in any instance.
    pub(super) fn is_over(&self, instances: &[Placed], group: &Group) -> bool {
        f64::from(group.error) > self.bound(instances, group.centre, group.radius)
    }
}

/// Where an instance is, relative to the scene's origin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    columns: [[f64; 3]; 3],
    translation: [f64; 3],
    scale: f64,
}

impl Placed {
    fn new(transform: &Transform, origin: [f64; 3]) -> Self {
        Self {
            columns: transform.linear.map(|c| c.map(f64::from)),
            translation: std::array::from_fn(|a| transform.translation[a] - origin[a]),
            scale: largest_scale(transform.linear),
        }
    }

    /// The instances of each mesh.
    pub(super) fn all(scene: &Scene) -> Vec<Vec<Self>> {
        let mut all = vec![Vec::new(); scene.meshes().len()];
        for slot in scene.slots() {
            let placed = Self::new(scene.transform(slot), scene.origin());
            all[scene.mesh_id(slot) as usize].push(placed);
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet::Instance;
    use cullet_testkit::meshes;

    #[test]
    fn a_pixel_is_as_large_as_it_looks_at_the_nearest_instance() {
        let mut scene = Scene::new();
        let mesh = scene.add_mesh(meshes::ball(8));
        scene.add(Instance::new(mesh, Transform::IDENTITY)).unwrap();
        let at = Transform::from_scale_translation([2.0; 3], [0.0, 0.0, -20.0]);
        scene.add(Instance::new(mesh, at)).unwrap();
        scene.commit();
        let uses = Uses::of(&scene);
        let eye = Eye::new(&uses, 1.0, 3.0);
        let placed = &Placed::all(&scene)[0];
        assert_eq!(placed.len(), 2);
        let far = |z: f64, scale: f64| (eye.at[2] - z - scale) / scale * HALF_TANGENT / 540.0;
        let bound = eye.bound(placed, [0.0; 3], 1.0);
        assert!((bound - far(0.0, 1.0).min(far(-20.0, 2.0))).abs() < 1e-9, "{bound}");
        let group = |error: f64| Group { radius: 1.0, error: error as f32, ..Group::default() };
        assert!(!eye.is_over(placed, &group(bound * 0.99)));
        assert!(eye.is_over(placed, &group(bound * 1.01)));
    }
}
