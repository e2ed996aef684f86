//! A followed node.

use cullet::{Handle, MeshId};
use godot::classes::{GridMap, MultiMesh, Node3D};
use godot::prelude::*;

use crate::look::{Drawn, Kind, Look};
use crate::mover::CulletMover;
use crate::parts::Part;
use crate::shown::Shown;

/// A followed node, and what is known of it.
pub(crate) struct Item {
    pub(crate) node: Gd<Node3D>,
    /// The node as one that Godot draws; a `GridMap` is none.
    pub(crate) drawn: Option<Drawn>,
    /// Instance in Godot's server.
    pub(crate) rid: Rid,
    pub(crate) kind: Kind,
    pub(crate) look: Look,
    pub(crate) transform: Transform3D,
    pub(crate) is_visible: bool,
    /// Instance in the engine's scene.
    pub(crate) handle: Option<Handle>,
    /// The engine's mesh of that instance; `None` for a box.
    pub(crate) mesh: Option<MeshId>,
    pub(crate) parts: Vec<Part>,
    /// Whether its occluder is being made.
    pub(crate) is_waiting: bool,
    pub(crate) mover: Option<Gd<CulletMover>>,
    pub(crate) on_changed: Option<(&'static str, Callable)>,
    /// The frame in which it came, and that in which it last moved.
    pub(crate) born: u64,
    pub(crate) moved_at: u64,
    /// The frame in which it was last found to hide as it did.
    pub(crate) held_at: u64,
    pub(crate) is_restless: bool,
    pub(crate) shown: Shown,
}

impl Item {
    /// Returns where Godot draws it.
    pub(crate) fn place_now(&mut self, interpolated: bool) -> Transform3D {
        if interpolated {
            self.node.get_global_transform_interpolated()
        } else {
            self.node.get_global_transform()
        }
    }

    /// Returns the MultiMesh, if it is one.
    pub(crate) fn multi(&self) -> Option<Gd<MultiMesh>> {
        self.drawn.as_ref()?.multi.as_ref()?.get_multimesh()
    }

    /// Returns the GridMap, if it is one.
    pub(crate) fn grid(&self) -> Option<Gd<GridMap>> {
        (self.kind == Kind::Grid).then_some(())?;
        self.node.clone().try_cast::<GridMap>().ok()
    }

    /// Whether its bounds may change without any signal.
    pub(crate) fn is_loose(&self) -> bool {
        matches!(self.kind, Kind::Multi | Kind::Csg | Kind::Flat)
    }

    /// Stops listening to it, and takes its mover away.
    pub(crate) fn disconnect(&mut self) {
        if !self.node.is_instance_valid() {
            return;
        }
        if let Some((signal, callable)) = self.on_changed.take()
            && self.node.is_connected(signal, &callable)
        {
            self.node.disconnect(signal, &callable);
        }
        if let Some(mut mover) = self.mover.take().filter(Gd::is_instance_valid) {
            mover.queue_free();
        }
    }
}
