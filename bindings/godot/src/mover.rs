//! A child of a drawn node that reports when the node moves, or is shown or hidden.
//!
//! Godot tells a node of its own movement and nobody else; asking 20,000 nodes where they are takes
//! several milliseconds a frame. A child is told whenever its parent or any node above moves, and
//! costs nothing while they stand.

use godot::classes::notify::Node3DNotification;
use godot::classes::{INode3D, Node, Node3D};
use godot::obj::InstanceId;
use godot::prelude::*;

use crate::inbox::{Event, Inbox};

/// Reports movement of its parent to a `CulletWorld`, which adds and removes it by itself.
#[derive(GodotClass)]
#[class(init, internal, base = Node3D)]
pub(crate) struct CulletMover {
    inbox: Inbox,
    parent: Option<InstanceId>,
    base: Base<Node3D>,
}

#[godot_api]
impl INode3D for CulletMover {
    fn on_notification(&mut self, what: Node3DNotification) {
        let is_told =
            [Node3DNotification::TRANSFORM_CHANGED, Node3DNotification::VISIBILITY_CHANGED];
        if is_told.contains(&what)
            && let Some(parent) = self.parent
        {
            self.inbox.push(Event::Moved(parent));
        }
    }
}

/// Adds a mover below `node`.
pub(crate) fn add(node: &Gd<Node>, inbox: &Inbox) -> Gd<CulletMover> {
    let mut mover = CulletMover::new_alloc();
    {
        let mut bound = mover.bind_mut();
        bound.inbox = inbox.clone();
        bound.parent = Some(node.instance_id());
        bound.base_mut().set_notify_transform(true);
    }
    let mode = godot::classes::node::InternalMode::BACK;
    node.clone().add_child_ex(&mover).internal(mode).done();
    mover
}
