//! Nodes of which scripts want to know when a camera begins to see them, and when it ends.

use std::collections::HashMap;

use godot::obj::InstanceId;

use crate::frame::Frame;
use crate::mirror::{Mirror, item_and_part};

/// Nodes whose sight is reported.
#[derive(Debug, Default)]
pub(crate) struct Watched {
    nodes: Vec<InstanceId>,
    /// Whether a node was seen, by node and camera.
    seen: HashMap<(InstanceId, InstanceId), bool>,
}

/// A node that came into or left a camera's sight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Sighted {
    pub(crate) node: InstanceId,
    pub(crate) camera: InstanceId,
    pub(crate) is_seen: bool,
}

impl Watched {
    /// Begins or ends to report a node.
    pub(crate) fn set(&mut self, node: InstanceId, on: bool) {
        self.nodes.retain(|&own| own != node);
        self.seen.retain(|&(own, _), _| own != node);
        if on {
            self.nodes.push(node);
        }
    }

    /// Returns what changed since the last frame. A node that is seen by no camera at first is no
    /// change.
    pub(crate) fn changes(&mut self, mirror: &Mirror, frame: &Frame) -> Vec<Sighted> {
        let mut changes = Vec::new();
        for &node in &self.nodes {
            for (eye, _) in frame.answers() {
                let is_seen = is_seen(mirror, frame, eye.camera, node);
                let before = self.seen.insert((node, eye.camera), is_seen).unwrap_or(false);
                if before != is_seen {
                    changes.push(Sighted { node, camera: eye.camera, is_seen });
                }
            }
        }
        changes
    }
}

/// Whether a node may be seen by a camera, as it was in the last frame.
pub(crate) fn is_seen(
    mirror: &Mirror,
    frame: &Frame,
    camera: InstanceId,
    node: InstanceId,
) -> bool {
    let Some(index) = mirror.index(node) else { return false };
    let own = |slot: u32| item_and_part(mirror.scene.user_data(slot)) == (index, 0);
    let of_camera = frame.answers().filter(|(eye, _)| eye.camera == camera);
    of_camera.into_iter().any(|(_, visible)| visible.slots().any(own))
}
