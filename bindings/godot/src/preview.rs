//! Decisions that hide nothing: for the dock in the editor, and for scripts that want to see what a
//! camera would leave out.

use std::collections::HashMap;

use cullet::scene::BoundsOverride;
use godot::classes::{Camera3D, Node3D};
use godot::obj::InstanceId;
use godot::prelude::*;

use crate::explain;
use crate::frame::{Fate, Frame, Stats, culler};
use crate::mirror;
use crate::shown::Shown;
use crate::views::{self, Eye};
use crate::world::CulletWorld;

/// A decision of `CulletWorld.preview()`: what a camera would draw and what it would leave out, and
/// why. Nothing is hidden by it. It stays as it was made while the camera and nodes move on.
///
/// Each node has one of these fates: `drawn`; `always`, for it can not be hidden; `probe`, for a
/// reflection probe may see it; or the stage that left it out, `layer`, `frustum`, `occlusion` or
/// `pvs`.
#[derive(GodotClass)]
#[class(tool, no_init, base = RefCounted)]
pub(crate) struct CulletPreview {
    world: InstanceId,
    eye: Eye,
    occlusion: Option<(u32, f32)>,
    nodes: HashMap<InstanceId, Told>,
    stats: Stats,
}

/// Decision about a node.
struct Told {
    fate: Fate,
    shown: Shown,
    /// Least and largest corner; none where they are unknown.
    bounds: Option<[Vector3; 2]>,
}

#[godot_api(secondary)]
impl CulletWorld {
    /// Decides what `camera` would draw in a picture of `size` pixels, by the settings of this node,
    /// and hides nothing. It works in the editor too, where nothing is culled. It costs a frame's
    /// work after a jump of the camera, and asks every node for its place. Returns `null` where
    /// another `CulletWorld` culls this world, or the camera shows no volume.
    #[func]
    fn preview(&mut self, camera: Gd<Camera3D>, size: Vector2i) -> Option<Gd<CulletPreview>> {
        let eye = views::of_size(&camera, size)?;
        let settings = self.settings();
        let world = self.base().instance_id();
        let registry = self.up_to_date()?;
        let decision = Frame::default().decide(registry, settings, eye.clone());
        let told = |(id, (fate, shown)): (InstanceId, (Fate, Shown))| {
            let item = registry.mirror.item(registry.mirror.index(id)?)?;
            let bounds = match mirror::world_box(item) {
                BoundsOverride::World(b) => Some([corner(b.min), corner(b.max)]),
                _ => None,
            };
            Some((id, Told { fate, shown, bounds }))
        };
        let nodes = decision.fates.into_iter().filter_map(told).collect();
        let (occlusion, stats) = (settings.occlusion, decision.stats);
        Some(Gd::from_object(CulletPreview { world, eye, occlusion, nodes, stats }))
    }

    /// The version of the library, as in `plugin.cfg`.
    #[func]
    fn version() -> GString {
        env!("CARGO_PKG_VERSION").into()
    }
}

#[godot_api]
impl CulletPreview {
    /// Counts: `nodes` and how many of them have each fate; `shadow_only`, left out of the picture
    /// and kept in shadow maps; `casters`, left out of shadow maps too; `dark_lamps`; `occluders`.
    #[func]
    fn counts(&self) -> VarDictionary {
        let mut counts = vdict! {
            "nodes" => self.nodes.len() as i64,
            "shadow_only" => self.stats.shadow_only as i64,
            "casters" => self.stats.gone as i64,
            "dark_lamps" => self.stats.dark as i64,
            "occluders" => self.stats.occluders as i64,
        };
        let mut of: HashMap<&str, i64> = HashMap::new();
        for told in self.nodes.values() {
            *of.entry(told.fate.name()).or_default() += 1;
        }
        for name in ["drawn", "always", "probe", "layer", "frustum", "occlusion", "pvs"] {
            counts.set(name, of.get(name).copied().unwrap_or(0));
        }
        counts
    }

    /// The fate of `node`; empty for one that is not followed.
    #[func]
    fn fate_of(&self, node: Gd<Node3D>) -> GString {
        self.nodes.get(&node.instance_id()).map_or("", |told| told.fate.name()).into()
    }

    /// Corners of the boxes around the nodes of one fate, two a node: the least and the largest.
    #[func]
    fn boxes(&self, fate: GString) -> PackedVector3Array {
        self.bounds_of(&fate).flatten().collect()
    }

    /// Ends of the edges of those boxes, 24 a node, for a mesh of lines.
    #[func]
    fn lines(&self, fate: GString) -> PackedVector3Array {
        self.bounds_of(&fate).flat_map(edges).collect()
    }

    /// Ends of the edges of the volume that the camera shows, as deep as `depth` at the most.
    #[func]
    fn frustum(&self, depth: f64) -> PackedVector3Array {
        let deepest = self.eye.far.min(depth).max(self.eye.near * 2.0);
        let slice = self.eye.view.slice(self.eye.near, deepest);
        let corners = slice.ok().and_then(|view| view.frustum().corners());
        let Some(corners) = corners else { return PackedVector3Array::new() };
        let corner = |[x, y, z, w]: [f64; 4]| corner([x / w, y / w, z / w].map(|c| c as f32));
        edge_ends().map(|end| corner(corners[end])).collect()
    }

    /// Says why `node` is drawn or not, as `CulletWorld.explain()` does, for the camera as it was.
    #[func]
    fn explain(&self, node: Gd<Node3D>) -> GString {
        let Ok(world) = Gd::<CulletWorld>::try_from_instance_id(self.world) else {
            return "The CulletWorld of this decision is gone.".into();
        };
        let shown = self.nodes.get(&node.instance_id()).map_or(Shown::Whole, |told| told.shown);
        let culler = culler(self.occlusion);
        let text = explain::text(world.bind().registry(), &culler, &self.eye, &node, shown);
        text.as_str().into()
    }

    /// The nodes that hide `node`, the nearest first.
    #[func]
    fn hidden_by(&self, node: Gd<Node3D>) -> Array<Gd<Node3D>> {
        let world = Gd::<CulletWorld>::try_from_instance_id(self.world);
        let Ok(world) = world else { return Array::new() };
        let culler = culler(self.occlusion);
        explain::hiders(world.bind().registry(), &culler, &self.eye, node.instance_id())
    }
}

impl CulletPreview {
    fn bounds_of<'a>(&'a self, fate: &GString) -> impl Iterator<Item = [Vector3; 2]> + use<'a> {
        let fate = fate.to_string();
        let of_fate = self.nodes.values().filter(move |told| told.fate.name() == fate);
        of_fate.filter_map(|told| told.bounds)
    }
}

fn corner(c: [f32; 3]) -> Vector3 {
    Vector3::new(c[0], c[1], c[2])
}

/// Returns the ends of a box's edges.
fn edges([low, high]: [Vector3; 2]) -> impl Iterator<Item = Vector3> {
    let of = |bit: usize, low: f32, high: f32| if bit == 0 { low } else { high };
    edge_ends().map(move |end| {
        let x = of(end & 1, low.x, high.x);
        Vector3::new(x, of(end & 2, low.y, high.y), of(end & 4, low.z, high.z))
    })
}

/// Returns pairs of corners that share an edge, a bit of a corner's number an axis.
fn edge_ends() -> impl Iterator<Item = usize> {
    let from = |axis: usize| (0..8_usize).filter(move |end| end & axis == 0);
    [1, 2, 4].into_iter().flat_map(move |axis| from(axis).flat_map(move |end| [end, end | axis]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_has_twelve_edges_each_along_one_axis() {
        let ends: Vec<Vector3> = edges([Vector3::ZERO, Vector3::new(1.0, 2.0, 4.0)]).collect();
        let mut lengths: Vec<f32> = ends
            .chunks(2)
            .map(|e| (e[1].x - e[0].x) + (e[1].y - e[0].y) + (e[1].z - e[0].z))
            .collect();
        lengths.sort_by(f32::total_cmp);
        assert_eq!(lengths, [[1.0; 4], [2.0; 4], [4.0; 4]].concat());
    }
}
