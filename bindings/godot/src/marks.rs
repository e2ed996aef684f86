//! Nodes by which people say what hides and what does not.

use std::collections::HashMap;

use godot::classes::{INode3D, Mesh, Node3D};
use godot::obj::InstanceId;
use godot::prelude::*;

/// Something that hides what is behind it.
///
/// Below a `MeshInstance3D` and without a `mesh` of its own, it says that all of the parent's mesh
/// is drawn opaque and just where its vertices lie, whatever its materials are: a shader that moves
/// no vertex and cuts nothing out. With a `mesh` it stands for itself, at its own place: a simple
/// shape inside a building, say. Whatever it hides must be hidden by something that is drawn.
#[derive(GodotClass)]
#[class(tool, init, base = Node3D)]
pub(crate) struct CulletOccluder {
    /// The shape that hides; none for the parent's mesh.
    #[export]
    pub(crate) mesh: Option<Gd<Mesh>>,
    /// Whether it hides seen from the back of its triangles too.
    #[export]
    pub(crate) double_sided: bool,
    base: Base<Node3D>,
}

#[godot_api]
impl INode3D for CulletOccluder {}

/// Mark that keeps its parent, and every node below that, from hiding anything.
#[derive(GodotClass)]
#[class(tool, init, base = Node3D)]
pub(crate) struct NoCulletOccluder {
    base: Base<Node3D>,
}

#[godot_api]
impl INode3D for NoCulletOccluder {}

/// Marks that hold for one node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Mark {
    /// A `CulletOccluder` without a mesh: whether both sides are drawn.
    pub(crate) hides: Option<bool>,
    /// A `NoCulletOccluder` above it.
    pub(crate) never_hides: bool,
}

/// All marks in the tree, by the node that each is a child of.
#[derive(Debug, Default)]
pub(crate) struct Marks {
    parents: HashMap<InstanceId, InstanceId>,
    occluders: HashMap<InstanceId, Vec<Gd<CulletOccluder>>>,
    /// How many `NoCulletOccluder`s there are below a node.
    never: HashMap<InstanceId, usize>,
}

impl Marks {
    /// Takes over a mark that came, or has another parent than before.
    pub(crate) fn put(&mut self, mark: &Gd<Node3D>) {
        let id = mark.instance_id();
        self.remove(id);
        let Some(parent) = mark.get_parent() else { return };
        let parent = parent.instance_id();
        self.parents.insert(id, parent);
        match mark.clone().try_cast::<CulletOccluder>() {
            Ok(occluder) => self.occluders.entry(parent).or_default().push(occluder),
            Err(_) => *self.never.entry(parent).or_default() += 1,
        }
    }

    /// Lets a node go. Returns whether it was a mark.
    pub(crate) fn remove(&mut self, id: InstanceId) -> bool {
        let Some(parent) = self.parents.remove(&id) else { return false };
        if let Some(own) = self.occluders.get_mut(&parent) {
            let before = own.len();
            own.retain(|occluder| occluder.instance_id_unchecked() != id);
            if own.len() < before {
                return true;
            }
        }
        if let Some(count) = self.never.get_mut(&parent) {
            *count -= 1;
            if *count == 0 {
                self.never.remove(&parent);
            }
        }
        true
    }

    /// Returns the mark of a node, from its children and the children of the nodes above it. The marks are
    /// looked up from the node upwards, for it may have many neighbours.
    pub(crate) fn of(&self, node: &Gd<Node3D>) -> Mark {
        let mut mark = Mark::default();
        if self.parents.is_empty() {
            return mark;
        }
        let own = self.occluders.get(&node.instance_id()).into_iter().flatten();
        for occluder in own.filter(|occluder| occluder.is_instance_valid()) {
            let occluder = occluder.bind();
            if occluder.mesh.is_none() {
                let both = mark.hides.unwrap_or(true) && occluder.double_sided;
                mark.hides = Some(both);
            }
        }
        let mut above = Some(node.clone().upcast::<Node>());
        while let Some(node) = above {
            mark.never_hides |= self.never.contains_key(&node.instance_id());
            above = node.get_parent();
        }
        mark
    }
}
