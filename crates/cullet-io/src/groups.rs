//! The node tree of a file, as groups to cull by.

use cullet::hierarchy::{Groups, GroupsError};

use crate::Model;

/// The nodes of a file, or of whatever made the model. Empty for formats that have none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NodeTree {
    /// The parent of each node; [`Groups::NONE`] for a root.
    pub parents: Vec<u32>,
    /// The name of each node; empty where it has none.
    pub names: Vec<String>,
    /// The transform of each node to its parent, column-major, a root's to the scene; as the file has it,
    /// whatever moved since. Empty unless [`LoadOptions::details`](crate::LoadOptions::details) asked for it.
    pub locals: Vec<[f64; 16]>,
    /// The node that drew each instance, by the index of the instance's handle. Those beyond the end were
    /// drawn by none.
    pub node_of_instance: Vec<u32>,
}

impl NodeTree {
    /// How many nodes there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.parents.len()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.parents.is_empty()
    }

    /// What to call a node: its name, or its number (`node 12`).
    #[must_use]
    pub fn name(&self, node: u32) -> String {
        match self.names.get(node as usize) {
            Some(name) if !name.is_empty() => name.clone(),
            _ => format!("node {node}"),
        }
    }
}

impl Model {
    /// The model's node tree as groups over the scene's slots: group g is node g, and item s the instance in
    /// slot s, with the bounds that the scene culls it by; a removed instance is nowhere. Right until slots
    /// are permuted or instances added (see [`cullet::Scene::order_version`]). Instances that no node drew
    /// are in no group.
    ///
    /// # Errors
    /// If the tree is none: a file's is, one that was written by hand may have a loop.
    pub fn groups(&self) -> Result<Groups, GroupsError> {
        let scene = &self.scene;
        let node_of = |slot: u32| {
            let handle = scene.handle(slot)?;
            self.node_tree.node_of_instance.get(handle.index as usize).copied()
        };
        let members: Vec<[u32; 2]> =
            scene.slots().filter_map(|slot| Some([node_of(slot)?, slot])).collect();
        Groups::over(&self.node_tree.parents, &members, scene.boxes())
    }
}
