//! Everything of one world that is followed.

use std::collections::HashMap;

use godot::classes::class_db::ApiType;
use godot::classes::{
    ClassDb, GeometryInstance3D, GpuParticlesCollisionHeightField3D, GridMap, Light3D, Node,
    Node3D, ReflectionProbe, Viewport, VisualInstance3D, VoxelGi,
};
use godot::obj::{InstanceId, Singleton};
use godot::prelude::*;

use crate::dark::Dark;
use crate::inbox::{self, Event};
use crate::item::Item;
use crate::marks::{CulletOccluder, NoCulletOccluder};
use crate::mirror::Mirror;
use crate::mover;
use crate::pvs::live::Live;

/// How movement is followed.
#[derive(GodotConvert, Var, Export, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[godot(via = i64)]
pub(crate) enum Follow {
    /// Few nodes are asked in each frame; where there are many, each gets a child that reports.
    #[default]
    Auto,
    /// All nodes are asked in each frame.
    Ask,
    /// Each node gets a child that reports, at once.
    Report,
}

/// Nodes that are asked in each frame, at the most, where there is a choice.
const FEW: usize = 256;
/// Frames after which a node is taken for one that stays.
const STAYS: u64 = 30;
/// Nodes that get a child in one frame, and those that are looked at again without a reason.
const AT_ONCE: usize = 256;
const IN_TURN: usize = 3;

/// The followed nodes of one world.
#[derive(Default)]
pub(crate) struct Registry {
    pub(crate) mirror: Mirror,
    pub(crate) viewports: Vec<Gd<Viewport>>,
    pub(crate) lights: Vec<Gd<Light3D>>,
    pub(crate) probes: Vec<Gd<ReflectionProbe>>,
    pub(crate) dark: Dark,
    pub(crate) pvs: Live,
    height_fields: Vec<InstanceId>,
    /// Nodes into which lamps shine though no camera sees them.
    lit: Vec<InstanceId>,
    /// Nodes of other extensions, which may draw by means of their own.
    foreign: Vec<InstanceId>,
    classes: HashMap<String, bool>,
    /// Items that are asked in each frame where they are.
    asked: Vec<u32>,
    loose: Vec<u32>,
    is_stale: bool,
    next: usize,
    events: Vec<Event>,
    world: Option<Rid>,
}

impl Registry {
    /// Takes over all of a tree that is in the world of `scenario`.
    pub(crate) fn collect(&mut self, root: &Gd<Node>, scenario: Rid) {
        self.clear();
        self.world = Some(scenario);
        // All of it is found below.
        self.mirror.inbox.take(&mut self.events);
        let mut nodes = Vec::new();
        inbox::walk(root, &mut |node| nodes.push(node.clone()));
        nodes.iter().for_each(|node| self.add(node));
    }

    pub(crate) fn world(&self) -> Option<Rid> {
        self.world
    }

    /// Gives everything back.
    pub(crate) fn clear(&mut self) {
        self.mirror.clear();
        self.dark.give_back();
        let inbox = self.mirror.inbox.clone();
        let frame = self.mirror.frame;
        *self = Self::default();
        (self.mirror.inbox, self.mirror.frame) = (inbox, frame);
    }

    /// Whether shadow maps alone decide what casts: nothing that draws by other means needs it.
    pub(crate) fn may_drop_casters(&self) -> bool {
        self.height_fields.is_empty()
    }

    /// Whether anything may be drawn that is in no list of ours.
    pub(crate) fn has_foreign(&self) -> bool {
        !self.foreign.is_empty()
    }

    /// Hides lamps that light no node of `seen`; `is_known` is false where more than that is lit.
    pub(crate) fn darken(&mut self, is_known: bool, seen: &[u64]) {
        match self.world.filter(|_| is_known && self.knows_receivers()) {
            Some(world) => self.dark.update(&self.lights, world, &self.mirror, seen),
            None => self.dark.give_back(),
        }
    }

    /// Returns the number of lamps that `darken` would hide, and hides none.
    pub(crate) fn count_dark(&self, is_known: bool, seen: &[u64]) -> usize {
        let world = self.world.filter(|_| is_known && self.knows_receivers());
        let find = |world| Dark::default().find(&self.lights, world, &self.mirror, seen);
        world.map_or(0, |world| find(world).len())
    }

    /// Whether the bounds of everything that a lamp may light are in a list.
    fn knows_receivers(&self) -> bool {
        // Cells of a GridMap are drawn, and their bounds are in no list.
        self.lit.is_empty() && self.foreign.is_empty() && self.mirror.grid_count == 0
    }

    fn add(&mut self, node: &Gd<Node>) {
        if let Ok(viewport) = node.clone().try_cast::<Viewport>() {
            if !self.viewports.contains(&viewport) {
                self.viewports.push(viewport);
            }
            return;
        }
        let Ok(node) = node.clone().try_cast::<Node3D>() else { return };
        let id = node.instance_id();
        let is_drawn = node.clone().try_cast::<GeometryInstance3D>().is_ok();
        if is_drawn || node.clone().try_cast::<GridMap>().is_ok() {
            self.add_drawn(&node);
            return;
        }
        if node.clone().try_cast::<VisualInstance3D>().is_ok() {
            self.add_visual(&node);
        } else if node.clone().try_cast::<CulletOccluder>().is_ok()
            || node.clone().try_cast::<NoCulletOccluder>().is_ok()
        {
            self.mark_changed(&node);
            return;
        }
        let class = node.get_class().to_string();
        let classes = &mut self.classes;
        if *classes.entry(class).or_insert_with_key(|class| is_foreign(class)) {
            self.foreign.push(id);
        }
    }

    fn add_visual(&mut self, node: &Gd<Node3D>) {
        if let Ok(light) = node.clone().try_cast::<Light3D>() {
            self.lights.push(light);
            return;
        }
        if let Ok(probe) = node.clone().try_cast::<ReflectionProbe>() {
            self.probes.push(probe);
            return;
        }
        if node.clone().try_cast::<GpuParticlesCollisionHeightField3D>().is_ok() {
            self.height_fields.push(node.instance_id());
        }
        if node.clone().try_cast::<VoxelGi>().is_ok() {
            self.lit.push(node.instance_id());
        }
    }

    fn add_drawn(&mut self, node: &Gd<Node3D>) {
        let own = node.get_world_3d().map(|world| world.get_scenario());
        if own.is_some() && own == self.world {
            self.mirror.add(node);
            self.is_stale = true;
        }
    }

    fn remove(&mut self, id: InstanceId) {
        self.viewports.retain(|node| node.instance_id_unchecked() != id);
        self.lights.retain(|node| node.instance_id_unchecked() != id);
        self.probes.retain(|node| node.instance_id_unchecked() != id);
        self.height_fields.retain(|&own| own != id);
        self.foreign.retain(|&own| own != id);
        self.lit.retain(|&own| own != id);
        if self.mirror.marks.remove(id) {
            self.look_at_all();
        }
        if self.mirror.index(id).is_some() {
            self.mirror.remove(id);
            self.is_stale = true;
        }
    }

    fn mark_changed(&mut self, mark: &Gd<Node3D>) {
        self.mirror.marks.put(mark);
        let Some(parent) = mark.get_parent() else { return };
        let mut below = Vec::new();
        inbox::walk(&parent, &mut |node| below.push(node.instance_id()));
        for id in below {
            if let Some(index) = self.mirror.index(id) {
                self.mirror.look_again(index);
            }
        }
    }

    fn look_at_all(&mut self) {
        (0..self.mirror.items.len()).for_each(|index| {
            self.mirror.look_again(index);
        });
    }

    /// Takes over what Godot reported since the last frame, asks the nodes that report nothing, and
    /// makes the scene ready to be culled.
    pub(crate) fn follow(&mut self, how: Follow) {
        self.mirror.frame += 1;
        self.mirror.materials.clear();
        self.mirror.meshes.ask_again();
        let mut events = std::mem::take(&mut self.events);
        self.mirror.inbox.take(&mut events);
        // Who left for good must not be asked for what was reported before that.
        for event in &events {
            if let Event::Removed(id) = *event {
                let node = Gd::<Node>::try_from_instance_id(id).ok();
                if node.is_none_or(|node| !node.is_inside_tree()) {
                    self.remove(id);
                }
            }
        }
        for event in &events {
            self.take_over(*event);
        }
        self.events = events;
        self.ask(how);
        self.mirror.receive_meshes();
        self.look_in_turn(IN_TURN);
        self.mirror.settle();
    }

    fn take_over(&mut self, event: Event) {
        match event {
            // It may be gone again already.
            Event::Added(id) => {
                let node = Gd::<Node>::try_from_instance_id(id).ok();
                if let Some(node) = node.filter(|node| node.is_inside_tree()) {
                    self.add(&node);
                }
            }
            Event::Removed(id) => self.remove(id),
            Event::Moved(id) => {
                if let Some(index) = self.mirror.index(id) {
                    self.mirror.place(index);
                }
            }
            Event::Changed(id) => {
                if let Some(index) = self.mirror.index(id) {
                    self.mirror.changed(index);
                }
            }
            Event::Resource(id) => self.mirror.resource_changed(id),
        }
    }

    /// Asks nodes without a mover where they are.
    fn ask(&mut self, how: Follow) {
        let stays = self.mirror.frame.is_multiple_of(STAYS);
        if std::mem::take(&mut self.is_stale) || stays {
            self.list(how);
        }
        for &index in &self.asked {
            self.mirror.place(index as usize);
        }
        for &index in &self.loose {
            self.mirror.bounds_again(index as usize);
        }
        if self.mirror.is_interpolated {
            // Between two steps of physics nodes are drawn on their way, without a report.
            let frame = self.mirror.frame;
            let on_the_way = |item: &Item| item.mover.is_some() && frame - item.moved_at < 60;
            for index in 0..self.mirror.items.len() {
                if self.mirror.item(index).is_some_and(on_the_way) {
                    self.mirror.place(index);
                }
            }
        }
    }

    fn list(&mut self, how: Follow) {
        self.asked.clear();
        self.loose.clear();
        for (index, item) in self.mirror.items.iter().enumerate() {
            let Some(item) = item else { continue };
            if item.mover.is_none() {
                self.asked.push(index as u32);
            }
            if item.is_loose() {
                self.loose.push(index as u32);
            }
        }
        let at_once = how == Follow::Report;
        if at_once {
            self.add_movers(usize::MAX, 0);
        }
    }

    /// Gives nodes that stay a child that reports, some in each frame. Not while a frame is drawn.
    pub(crate) fn add_some_movers(&mut self, how: Follow) {
        if how == Follow::Auto && self.mirror.len() > FEW && !self.asked.is_empty() {
            self.add_movers(AT_ONCE, STAYS);
        }
    }

    fn add_movers(&mut self, most: usize, age: u64) {
        let mut left = most;
        let frame = self.mirror.frame;
        let mirror = &mut self.mirror;
        let inbox = mirror.inbox.clone();
        self.asked.retain(|&index| {
            let Some(item) = mirror.items.get_mut(index as usize).and_then(Option::as_mut) else {
                return false;
            };
            if left == 0 || frame < item.born + age || !item.node.is_instance_valid() {
                return true;
            }
            left -= 1;
            item.mover = Some(mover::add(&item.node.clone().upcast(), &inbox));
            false
        });
    }

    /// Looks at a few nodes without a reason: materials change without any signal.
    pub(crate) fn look_in_turn(&mut self, most: usize) {
        let count = self.mirror.items.len();
        for _ in 0..most.min(count) {
            self.next = (self.next + 1) % count;
            self.mirror.look_again(self.next);
        }
    }
}

/// Whether a class comes from another extension.
fn is_foreign(class: &str) -> bool {
    let is_own = class.starts_with("Cullet") || class.starts_with("NoCullet");
    !is_own && ClassDb::singleton().class_get_api_type(class) == ApiType::EXTENSION
}
