//! Queries for scripts.

use cullet_cells::query::{Find, SightOptions, line_of_sight};
use godot::classes::{Camera3D, Node3D};
use godot::obj::InstanceId;
use godot::prelude::*;

use crate::convert;
use crate::watched;
use crate::world::CulletWorld;

#[godot_api(secondary)]
impl CulletWorld {
    /// Whether nothing opaque stands between two points: only meshes that hide, the same that hide
    /// from cameras. What the culler does not follow, and what a shader moves or cuts out, does not
    /// block.
    #[func]
    fn line_of_sight(&self, from: Vector3, to: Vector3) -> bool {
        let options = SightOptions { find: Find::Any, ..SightOptions::default() };
        let (from, to) = (convert::point(from), convert::point(to));
        !line_of_sight(&self.mirror().scene, from, to, &options).is_blocked()
    }

    /// Whether `camera` may see `node`, as the last frame had it. False is proved; true is not. A
    /// node that the culler does not follow, and a camera that draws nothing, see nothing.
    #[func]
    fn is_visible_from(&self, camera: Gd<Camera3D>, node: Gd<Node3D>) -> bool {
        watched::is_seen(self.mirror(), self.frame(), camera.instance_id(), node.instance_id())
    }

    /// The cameras in whose picture `position` lies with nothing opaque before it, as the last frame
    /// had them.
    #[func]
    fn who_sees(&self, position: Vector3) -> Array<Gd<Camera3D>> {
        let at = convert::point(position);
        let mut cameras = Array::new();
        for (eye, _) in self.frame().answers() {
            let [width, height] = eye.view.viewport().map(f64::from);
            let inside = |[x, y, z]: [f64; 3]| {
                (0.0..=width).contains(&x)
                    && (0.0..=height).contains(&y)
                    && (0.0..=1.0).contains(&z)
            };
            let camera = Gd::<Camera3D>::try_from_instance_id(eye.camera).ok();
            let Some(camera) = camera.filter(|_| eye.view.project_point(at).is_some_and(inside))
            else {
                continue;
            };
            let [x, y, z, w] = eye.view.eye();
            // Along parallel lines, from the plane of the camera.
            let from = if w == 0.0 {
                let depth = eye.far - eye.near;
                std::array::from_fn(|a| at[a] + [x, y, z][a] * depth)
            } else {
                [x / w, y / w, z / w]
            };
            let options = SightOptions { find: Find::Any, ..SightOptions::default() };
            let is_clear = !line_of_sight(&self.mirror().scene, from, at, &options).is_blocked();
            if is_clear && !cameras.contains(&camera) {
                cameras.push(&camera);
            }
        }
        cameras
    }

    /// Begins to emit `sight_changed` for `node`, or ends it.
    #[func]
    fn watch(&mut self, node: Gd<Node3D>, on: bool) {
        self.watched_mut().set(node.instance_id(), on);
    }

    /// Emits `sight_changed`; called after a frame in which something changed.
    #[func]
    fn tell_sight(&mut self, camera: i64, node: i64, is_seen: bool) {
        let camera = Gd::<Camera3D>::try_from_instance_id(InstanceId::from_i64(camera));
        let node = Gd::<Node3D>::try_from_instance_id(InstanceId::from_i64(node));
        if let (Ok(camera), Ok(node)) = (camera, node) {
            self.signals().sight_changed().emit(&camera, &node, is_seen);
        }
    }
}
