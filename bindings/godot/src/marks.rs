//! Nodes by which people say what hides and what does not.

use godot::classes::{INode3D, Mesh, Node3D};
use godot::prelude::*;

/// Something that hides what is behind it.
///
/// Below a `MeshInstance3D` and without a `mesh` of its own, it says that all of the parent's mesh
/// is drawn opaque and just where its vertices lie, whatever its materials are: a shader that moves
/// no vertex and cuts nothing out. With a `mesh` it stands for itself, at its own place: a simple
/// shape inside a building, say. Whatever it hides must be hidden by something that is drawn.
#[derive(GodotClass)]
#[class(init, base = Node3D)]
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
#[class(init, base = Node3D)]
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

/// Returns the mark of `node`, from its children and the children of the nodes above it.
pub(crate) fn of(node: &Gd<Node>) -> Mark {
    let mut mark = Mark::default();
    for child in node.get_children().iter_shared() {
        if let Ok(occluder) = child.try_cast::<CulletOccluder>() {
            let occluder = occluder.bind();
            if occluder.mesh.is_none() {
                mark.hides = Some(occluder.double_sided);
            }
        }
    }
    let mut above = Some(node.clone());
    while let Some(node) = above {
        let children = node.get_children();
        mark.never_hides |=
            children.iter_shared().any(|child| child.try_cast::<NoCulletOccluder>().is_ok());
        above = node.get_parent();
    }
    mark
}
