//! Baked sets in the world in which they are used: which of their nodes are what they were.

use std::collections::HashMap;
use std::rc::Rc;

use cullet_cells::cell::{CellLocator, CellShapes};
use godot::classes::Node;
use godot::prelude::*;

use super::baked::Baked;
use super::sums::{self, MeshSums};
use crate::mirror::Mirror;

/// State of a node of the sets.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct State {
    /// Its item; none where it is not there.
    pub(super) item: Option<u32>,
    /// Whether it may be hidden: its bounds are those that were baked.
    pub(super) is_same: bool,
    pub(super) wall: Wall,
}

/// State of that by which a node hides others.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Wall {
    /// It hid nothing in the bake.
    #[default]
    None,
    /// It is as it was in the bake.
    Stands,
    /// Its mesh is being made.
    Waits,
    /// It moved, changed, is hidden or is not there.
    Gone,
}

/// Baked sets in a world.
#[derive(Debug)]
pub(super) struct Bound {
    pub(super) baked: Rc<Baked>,
    root: Gd<Node>,
    shapes: CellShapes,
    /// Combinations of layers of which a camera must see at least one each.
    layers: Vec<u32>,
    paths: HashMap<String, u32>,
    pub(super) nodes: Vec<State>,
    has_warned: bool,
}

impl Bound {
    /// Returns `None` for boxes that make no cells.
    pub(super) fn new(baked: Rc<Baked>, root: Gd<Node>) -> Option<Self> {
        let shapes = baked.shapes().ok()?;
        let state = |node: &super::baked::Named| State {
            wall: if node.hides == 0 { Wall::None } else { Wall::Gone },
            ..State::default()
        };
        let nodes = baked.nodes.iter().map(state).collect();
        let paths = (0..).zip(&baked.nodes).map(|(n, node)| (node.path.clone(), n)).collect();
        let layers = baked.layers();
        Some(Self { baked, root, shapes, layers, paths, nodes, has_warned: false })
    }

    pub(super) fn is_of(&self, baked: &Rc<Baked>) -> bool {
        Rc::ptr_eq(&self.baked, baked) && self.root.is_instance_valid()
    }

    /// Returns the number of a node, by its path from the root.
    pub(super) fn number(&self, node: &Gd<Node>) -> Option<u32> {
        if !self.root.is_instance_valid() || !self.root.is_inside_tree() {
            return None;
        }
        self.paths.get(&self.root.get_path_to(node).to_string()).copied()
    }

    /// Finds what a node is now. Returns whether anything of it is other than before.
    pub(super) fn judge(
        &mut self,
        number: u32,
        item: Option<u32>,
        mirror: &Mirror,
        sums: &mut MeshSums,
    ) -> bool {
        let named = &self.baked.nodes[number as usize];
        let now = item.and_then(|index| mirror.item(index as usize));
        let wall = match now {
            _ if named.hides == 0 => Wall::None,
            Some(now) if sums.hides(mirror, now) == named.hides => Wall::Stands,
            Some(now) if now.is_waiting => Wall::Waits,
            _ => Wall::Gone,
        };
        let is_there = now.is_some_and(|now| named.seen != 0 && sums::seen(now) == named.seen);
        let is_same = is_there && matches!(wall, Wall::None | Wall::Stands);
        let state = State { item, is_same, wall };
        state != std::mem::replace(&mut self.nodes[number as usize], state)
    }

    /// Appends the cells that an eye is in: all that its near plane may be in. Nothing where that
    /// reaches out of the cells: what the near plane cuts away there would hide nothing.
    pub(super) fn stand(&self, eye: [f64; 3], near: [[f64; 3]; 2], layers: u32, to: &mut Vec<u32>) {
        let sees_all = self.layers.iter().all(|of_wall| of_wall & layers != 0);
        if !sees_all || self.shapes.cell_of(eye).is_none() || !self.shapes.is_free(near[0], near[1])
        {
            return;
        }
        self.shapes.cells_touching(near[0], near[1], to);
        to.sort_unstable();
        to.dedup();
    }

    /// Returns the row of what may be seen from some cells; `None` where a wall that is seen from
    /// there is not what it was, so that anything may be seen past it.
    ///
    /// Walls that are not in the row cannot matter: no line from these cells reaches them.
    pub(super) fn row(&self, cells: &[u32]) -> Option<Vec<u64>> {
        let row = self.baked.sets.union(cells);
        let is_lost = |(number, state): (usize, &State)| {
            matches!(state.wall, Wall::Gone | Wall::Waits) && has(&row, number)
        };
        (!self.nodes.iter().enumerate().any(is_lost)).then_some(row)
    }

    /// Returns how many nodes are not what they were.
    pub(super) fn stale(&self) -> usize {
        self.nodes.iter().filter(|state| is_stale(state)).count()
    }

    /// Warns, once, of nodes that are not what they were.
    pub(super) fn warn(&mut self) {
        let stale = self.stale();
        if stale == 0 || std::mem::replace(&mut self.has_warned, true) {
            return;
        }
        let first = self.nodes.iter().position(is_stale).unwrap_or(0);
        let (all, path) = (self.nodes.len(), &self.baked.nodes[first].path);
        godot_warn!(
            "{stale} of {all} nodes of baked visibility are not what they were when it was baked, {path} first: they \
             are culled without it, and so is all that they hid. Bake again."
        );
    }
}

fn is_stale(state: &State) -> bool {
    state.wall == Wall::Gone || state.item.is_none() || !state.is_same && state.wall == Wall::None
}

pub(super) fn has(row: &[u64], number: usize) -> bool {
    row.get(number / 64).is_none_or(|word| word >> (number % 64) & 1 == 1)
}
