//! Reports of Godot, kept until the next frame is culled.
//!
//! Signals and notifications come while other code runs, some of it in the middle of a change to
//! the tree. So they are only written down, by id: a node may be freed before it is looked at.

use std::cell::RefCell;
use std::rc::Rc;

use godot::classes::{Engine, Node, Node3D, Object, SceneTree, Viewport};
use godot::obj::{InstanceId, Singleton};
use godot::prelude::*;

/// A report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Event {
    /// A node came into the tree.
    Added(InstanceId),
    /// A node left the tree.
    Removed(InstanceId),
    /// A node moved, or was shown or hidden.
    Moved(InstanceId),
    /// A node may draw something else.
    Changed(InstanceId),
    /// A mesh or a material is another than it was.
    Resource(InstanceId),
}

/// Reports of one world. Clones share them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Inbox(Rc<RefCell<Vec<Event>>>);

impl Inbox {
    /// Adds a report.
    pub(crate) fn push(&self, event: Event) {
        self.0.borrow_mut().push(event);
    }

    /// Moves all reports into `events`, which is cleared first.
    pub(crate) fn take(&self, events: &mut Vec<Event>) {
        events.clear();
        std::mem::swap(&mut *self.0.borrow_mut(), events);
    }

    /// Returns a callable for a signal that hands over `id`.
    pub(crate) fn callable(&self, event: Event) -> Callable {
        let inbox = self.clone();
        Callable::from_fn("cullet", move |_| inbox.push(event))
    }

    /// Returns a callable for a signal whose first argument is a node.
    fn callable_of_node(&self, event: fn(InstanceId) -> Event) -> Callable {
        let inbox = self.clone();
        Callable::from_fn("cullet", move |arguments| {
            let node = arguments.first().and_then(|first| first.try_to::<Gd<Node>>().ok());
            // Nodes of other kinds draw nothing in 3D.
            if let Some(node) = node
                && (node.is_class("Node3D") || node.is_class("Viewport"))
            {
                inbox.push(event(node.instance_id()));
            }
        })
    }
}

/// Connections to the tree. Godot aborts at its end where a closure stays connected to a signal of
/// an object that outlives the library, so that they are undone by hand.
#[derive(Debug, Default)]
pub(crate) struct TreeSignals(Vec<(&'static str, Callable)>);

impl TreeSignals {
    /// Listens to what comes into the tree and leaves it.
    pub(crate) fn connect(&mut self, tree: &mut Gd<SceneTree>, inbox: &Inbox) {
        let signals = [
            ("node_added", inbox.callable_of_node(Event::Added)),
            ("node_removed", inbox.callable_of_node(Event::Removed)),
        ];
        for (name, callable) in signals {
            connect(tree, name, &callable);
            self.0.push((name, callable));
        }
    }

    /// Whether it listens.
    pub(crate) fn is_connected(&self) -> bool {
        !self.0.is_empty()
    }

    /// Stops listening.
    pub(crate) fn disconnect(&mut self, tree: &mut Gd<SceneTree>) {
        for (name, callable) in self.0.drain(..) {
            if tree.is_connected(name, &callable) {
                tree.disconnect(name, &callable);
            }
        }
    }
}

/// Connects a closure to a signal.
///
/// In the editor godot-rust keeps a list of such connections for a reload of the library, which this
/// one does not allow, and goes through all of it at each further one: there Godot is called itself.
pub(crate) fn connect<T: Inherits<Object>>(object: &Gd<T>, signal: &str, callable: &Callable) {
    let mut object = object.clone().upcast::<Object>();
    if Engine::singleton().is_editor_hint() {
        object.call("connect", &[signal.to_variant(), callable.to_variant()]);
    } else {
        object.connect(signal, callable);
    }
}

/// Calls `visit` with every node of kinds that matter at and below `node`, internal ones included.
pub(crate) fn walk(node: &Gd<Node>, visit: &mut dyn FnMut(&Gd<Node>)) {
    let mut stack = vec![node.clone()];
    while let Some(node) = stack.pop() {
        if node.clone().try_cast::<Node3D>().is_ok() || node.clone().try_cast::<Viewport>().is_ok()
        {
            visit(&node);
        }
        let children = node.get_children_ex().include_internal(true).done();
        stack.extend(children.iter_shared());
    }
}
