//! The nodes of a scene, as the bakers of the engine take them.

use std::collections::HashMap;

use cullet::mesh::{Alpha, Part};
use cullet::scene::BoundsOverride;
use cullet::{
    Culler, Instance, Mesh, MeshData, MeshId, Scene, SceneError, Transform, bounds::Aabb,
};
use godot::classes::{CharacterBody3D, Node, RigidBody3D};
use godot::prelude::*;

use super::baked::Named;
use super::sums::{self, MeshSums};
use crate::mirror::{Mirror, world_box};

/// Nodes to be baked: plain data, which may go to another thread.
#[derive(Debug, Default)]
pub(crate) struct Gathered {
    pub(crate) nodes: Vec<Named>,
    meshes: Vec<Mesh>,
    bodies: Vec<(u32, Body)>,
}

/// Shape of a node, or of a part of it.
#[derive(Debug)]
enum Body {
    /// Triangles that hide, by the number of their mesh.
    Hides(usize, Transform),
    /// A box that is seen, and hides nothing.
    Seen(Aabb),
}

impl Gathered {
    /// Gathers all nodes from `root` down that stand still. Those below a size hide nothing.
    pub(crate) fn new(mirror: &Mirror, root: &Gd<Node>, smallest: f64) -> Self {
        let mut all = Self::default();
        let mut sums = MeshSums::default();
        let mut known: HashMap<MeshId, usize> = HashMap::new();
        for item in mirror.items.iter().flatten() {
            let node = item.node.clone().upcast::<Node>();
            let is_below = *root == node || root.is_ancestor_of(&node);
            if !is_below || moves(&node) {
                continue;
            }
            let bounds = match world_box(item) {
                BoundsOverride::World(bounds) => Some(bounds),
                _ => None,
            };
            let is_small =
                bounds.is_some_and(|b| b.half_extent().iter().all(|&h| h * 2.0 < smallest));
            let seen = sums::seen(item);
            let hides = if is_small { 0 } else { sums.hides(mirror, item) };
            if seen == 0 && hides == 0 {
                continue;
            }
            let number = all.nodes.len() as u32;
            let path = root.get_path_to(&node).to_string();
            all.nodes.push(Named { path, seen, hides, layers: item.look.layers });
            let hiding = if hides == 0 { Vec::new() } else { sums.hiding(mirror, item) };
            for (mesh, at) in hiding {
                let own = *known.entry(mesh).or_insert_with(|| {
                    all.meshes.push(mirror.scene.meshes()[mesh as usize].clone());
                    all.meshes.len() - 1
                });
                all.bodies.push((number, Body::Hides(own, at)));
            }
            // What hides is not all that is drawn where a surface is glass, or a pass lies around it.
            let look = &item.look;
            let is_all = look.mesh.zip(look.hides).is_some_and(|(mesh, hiding)| {
                look.grow == 0.0 && mirror.meshes.is_all_hiding(mesh, hiding)
            });
            let is_whole = hides != 0 && item.mesh.is_some() && is_all;
            if let Some(bounds) = bounds.filter(|_| !is_whole && seen != 0) {
                all.bodies.push((number, Body::Seen(bounds)));
            }
        }
        all
    }

    /// Returns the engine's scene of the nodes, and which node the handle of each index is of.
    pub(crate) fn scene(&mut self) -> Result<(Scene, Vec<u32>), SceneError> {
        let mut scene = Scene::new();
        let meshes: Vec<MeshId> =
            std::mem::take(&mut self.meshes).into_iter().map(|mesh| scene.add_mesh(mesh)).collect();
        let mut of_index = Vec::new();
        for (node, body) in std::mem::take(&mut self.bodies) {
            let instance = match body {
                Body::Hides(mesh, at) => Instance::new(meshes[mesh], at),
                Body::Seen(bounds) => {
                    let Ok(mesh) = Mesh::new(glass(&bounds)) else { continue };
                    Instance::new(scene.add_mesh(mesh), Transform::IDENTITY)
                }
            };
            let handle = scene.add(instance)?;
            of_index.resize(of_index.len().max(handle.index as usize + 1), u32::MAX);
            of_index[handle.index as usize] = node;
        }
        scene.commit(&Culler::default());
        Ok((scene, of_index))
    }
}

/// Whether a node is carried by a body that physics moves.
fn moves(node: &Gd<Node>) -> bool {
    let mut above = Some(node.clone());
    while let Some(node) = above {
        let is_body = node.clone().try_cast::<RigidBody3D>().is_ok()
            || node.clone().try_cast::<CharacterBody3D>().is_ok();
        if is_body {
            return true;
        }
        above = node.get_parent();
    }
    false
}

/// Returns a box that is looked through.
fn glass(b: &Aabb) -> MeshData {
    let corner =
        |i: u32| std::array::from_fn(|a| if i >> a & 1 == 1 { b.max[a] } else { b.min[a] });
    let quads: [[u32; 4]; 6] =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let indices = quads.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]).collect();
    let part =
        Part { triangle_count: 12, two_sided: true, alpha: Alpha::Blended, ..Part::default() };
    MeshData {
        positions: (0..8).map(corner).collect(),
        indices,
        parts: vec![part],
        ..MeshData::default()
    }
}
