//! Baked sets in a frame: what no cell that a camera is in can see, before occlusion.

use std::collections::HashMap;
use std::rc::Rc;

use cullet::{Handle, Scene, View, Visible};
use cullet_cells::portal::PortalView;
use godot::classes::Node;
use godot::obj::InstanceId;
use godot::prelude::*;

use super::bound::{Bound, Wall, has};
use super::resource::CulletPvs;
use super::sums::MeshSums;
use crate::mirror::{Mirror, item_and_part};
use crate::told;

/// The sets of a world, and what they hide.
#[derive(Default)]
pub(crate) struct Live {
    bounds: Vec<Bound>,
    /// Rises with each change of what the sets hide.
    version: u64,
    /// Items as they were when they were last looked at.
    known: Vec<Option<(InstanceId, Option<Handle>)>>,
    /// Numbers of a node in the sets, by item.
    numbers: HashMap<u32, Vec<(usize, u32)>>,
    sums: MeshSums,
    /// Items that hide others in some set.
    walls: Vec<u64>,
    eyes: Vec<Eye>,
    is_new: bool,
}

/// Slots that the sets hide from one camera.
#[derive(Debug, Default)]
struct Eye {
    /// Versions of the sets and of the scene's order for which the mask was made.
    of: Option<(u64, u64)>,
    /// The cells, by their sets.
    cells: Vec<(usize, Vec<u32>)>,
    /// One bit a slot: all that may be seen.
    mask: Vec<u64>,
    hidden: usize,
    is_used: bool,
}

/// Counts of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Counts {
    /// Most nodes that the sets hide from a camera.
    pub(crate) hidden: usize,
    /// Cameras for which sets were used.
    pub(crate) cameras: usize,
    /// Nodes of the sets that are not what they were.
    pub(crate) stale: usize,
}

impl Live {
    /// Takes over the sets to be used by a `CulletWorld`.
    pub(crate) fn bind(&mut self, wanted: &Array<Option<Gd<CulletPvs>>>, world: &Gd<Node>) {
        if wanted.is_empty() && self.bounds.is_empty() {
            return;
        }
        let mut sets = Vec::new();
        for resource in wanted.iter_shared().flatten() {
            let resource = resource.bind();
            let root = world.get_node_or_null(&resource.root);
            sets.extend(resource.baked.clone().zip(root));
        }
        let all = self.bounds.iter().zip(&sets);
        let are_same =
            self.bounds.len() == sets.len() && all.into_iter().all(|(b, s)| b.is_of(&s.0));
        if are_same {
            return;
        }
        self.bounds =
            sets.into_iter().filter_map(|(b, root)| Bound::new(Rc::clone(&b), root)).collect();
        self.known.clear();
        self.numbers.clear();
        self.version += 1;
        self.is_new = true;
    }

    /// Takes over what changed in the scene.
    pub(crate) fn update(&mut self, mirror: &mut Mirror) {
        let mut touched = std::mem::take(&mut mirror.touched);
        if !self.bounds.is_empty() {
            let version = self.version;
            if std::mem::take(&mut self.is_new) {
                touched = (0..mirror.items.len() as u32).collect();
                self.version += 1;
            }
            touched.iter().for_each(|&index| self.look_at(index, mirror));
            if version != self.version {
                self.end_update(mirror);
            }
        }
        touched.clear();
        mirror.touched = touched;
        self.eyes.iter_mut().for_each(|eye| eye.is_used = false);
    }

    fn end_update(&mut self, mirror: &Mirror) {
        self.walls.clear();
        self.walls.resize(mirror.items.len().div_ceil(64), 0);
        for state in self.bounds.iter().flat_map(|bound| &bound.nodes) {
            if let Some(item) = state.item.filter(|_| state.wall == Wall::Stands) {
                told::set(&mut self.walls, item as usize, true);
            }
        }
        if mirror.meshes.waiting() == 0 {
            self.bounds.iter_mut().for_each(Bound::warn);
        }
    }

    fn look_at(&mut self, index: u32, mirror: &Mirror) {
        let at = index as usize;
        self.known.resize(self.known.len().max(at + 1), None);
        let item = mirror.item(at);
        let now = item.map(|item| (item.node.instance_id_unchecked(), item.handle));
        let before = std::mem::replace(&mut self.known[at], now);
        if before.map(|b| b.0) != now.map(|n| n.0) {
            for (set, number) in self.numbers.remove(&index).unwrap_or_default() {
                self.bounds[set].judge(number, None, mirror, &mut self.sums);
                self.version += 1;
            }
            if let Some(item) = item {
                let node = item.node.clone().upcast();
                for (set, bound) in self.bounds.iter().enumerate() {
                    let number = bound.number(&node);
                    let is_free = |n: &u32| bound.nodes[*n as usize].item.is_none();
                    if let Some(number) = number.filter(is_free) {
                        self.numbers.entry(index).or_default().push((set, number));
                    }
                }
            }
        }
        let Some(numbers) = self.numbers.get(&index) else { return };
        let mut is_other = before != now;
        for &(set, number) in numbers {
            is_other |= self.bounds[set].judge(number, Some(index), mirror, &mut self.sums);
        }
        self.version += u64::from(is_other);
    }

    /// Returns the cells that a camera is in, by their sets; `None` for one that the sets say nothing of.
    fn cells(&self, view: &View) -> Option<Vec<(usize, Vec<u32>)>> {
        let stands = PortalView::new(view)?;
        let near = stands.near_box()?;
        let of_set = |(set, bound): (usize, &Bound)| {
            let mut own = Vec::new();
            bound.stand(stands.eye(), near, view.layers, &mut own);
            (!own.is_empty()).then_some((set, own))
        };
        Some(self.bounds.iter().enumerate().filter_map(of_set).collect())
    }

    /// Returns what [`mask`](Self::mask) does for a view that is asked once.
    pub(crate) fn mask_once(&self, view: &View, mirror: &Mirror) -> Option<Vec<u64>> {
        let mut eye = Eye { cells: self.cells(view)?, ..Eye::default() };
        eye.make(&self.bounds, mirror);
        (eye.hidden > 0).then_some(eye.mask)
    }

    /// Returns which slots the camera of a number may see, one bit each; `None` where the sets hide
    /// nothing from it.
    pub(crate) fn mask(
        &mut self,
        number: usize,
        view: &View,
        mirror: &Mirror,
    ) -> Option<&Vec<u64>> {
        if self.bounds.is_empty() {
            return None;
        }
        let cells = self.cells(view)?;
        self.eyes.resize_with(self.eyes.len().max(number + 1), Eye::default);
        let eye = &mut self.eyes[number];
        let of = Some((self.version, mirror.scene.order_version()));
        if eye.of != of || eye.cells != cells {
            (eye.of, eye.cells) = (of, cells);
            eye.make(&self.bounds, mirror);
        }
        // Slots that came since are of nodes in no set.
        eye.mask.resize(mirror.scene.slot_count().div_ceil(64) as usize, u64::MAX);
        eye.is_used = eye.hidden > 0;
        eye.is_used.then_some(&eye.mask)
    }

    /// Appends the slots of all walls that a camera saw. What is behind them stays hidden for as
    /// long as they are what they were; those that nobody sees hide nothing in this picture.
    pub(crate) fn add_walls(
        &self,
        number: usize,
        scene: &Scene,
        seen: &Visible,
        to: &mut Vec<u32>,
    ) {
        if !self.eyes.get(number).is_some_and(|eye| eye.is_used) {
            return;
        }
        let is_wall = |slot: &u32| {
            let (item, _) = item_and_part(scene.user_data(*slot));
            self.walls.get(item / 64).is_some_and(|word| word >> (item % 64) & 1 == 1)
        };
        to.extend(seen.slots().filter(is_wall));
    }

    pub(crate) fn counts(&self) -> Counts {
        let used = || self.eyes.iter().filter(|eye| eye.is_used);
        Counts {
            hidden: used().map(|eye| eye.hidden).max().unwrap_or(0),
            cameras: used().count(),
            stale: self.bounds.iter().map(Bound::stale).sum(),
        }
    }
}

impl Eye {
    fn make(&mut self, bounds: &[Bound], mirror: &Mirror) {
        let scene = &mirror.scene;
        self.mask.clear();
        self.mask.resize(scene.slot_count().div_ceil(64) as usize, u64::MAX);
        self.hidden = 0;
        for (set, cells) in &self.cells {
            let bound = &bounds[*set];
            let Some(row) = bound.row(cells) else { continue };
            for (number, state) in bound.nodes.iter().enumerate() {
                let item = state.item.filter(|_| state.is_same && !has(&row, number));
                let Some(item) = item.and_then(|index| mirror.item(index as usize)) else {
                    continue;
                };
                let handles = item.handle.into_iter().chain(item.parts.iter().map(|p| p.handle));
                handles.filter_map(|handle| scene.slot(handle).ok()).for_each(|slot| {
                    told::set(&mut self.mask, slot as usize, false);
                });
                self.hidden += 1;
            }
        }
    }
}
