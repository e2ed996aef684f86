//! The engine's scene, kept in step with the nodes of one world.

use std::collections::HashMap;

use cullet::scene::BoundsOverride;
use cullet::{Instance, InstanceFlags, Scene};
use godot::classes::{GeometryInstance3D, GridMap, Node3D, RenderingServer};
use godot::obj::{InstanceId, Singleton};
use godot::prelude::*;

use crate::convert;
use crate::inbox::{self, Event, Inbox};
use crate::item::Item;
use crate::look::{self, Bounds, Drawn, Kind, Known, Look};
use crate::marks::Marks;
use crate::material::{Facts, Hiding, Materials};
use crate::meshes::{Meshes, Wanted};
use crate::parts::{self, Place};
use crate::shown::{self, Shown};
use crate::told::Told;

/// The engine's scene and the nodes that it stands for.
#[derive(Default)]
pub(crate) struct Mirror {
    pub(crate) scene: Scene,
    pub(crate) items: Vec<Option<Item>>,
    free: Vec<u32>,
    by_id: HashMap<InstanceId, u32>,
    pub(crate) told: Told,
    pub(crate) meshes: Meshes,
    pub(crate) materials: Materials,
    pub(crate) inbox: Inbox,
    pub(crate) marks: Marks,
    /// `GridMap`s among the items.
    pub(crate) grid_count: usize,
    /// Rises with each frame.
    pub(crate) frame: u64,
    /// Whether Godot draws nodes between the places of physics steps.
    pub(crate) is_interpolated: bool,
    /// Items that came, went, moved or became others, for what is baked of them.
    pub(crate) touched: Vec<u32>,
    unsorted: usize,
    restless: usize,
    is_loosened: bool,
}

/// Returns the number of an item and of its part from a slot's number; part 0 is the item itself.
pub(crate) fn item_and_part(user_data: u64) -> (usize, usize) {
    ((user_data & 0xffff_ffff) as usize, (user_data >> 32) as usize)
}

impl Mirror {
    /// Returns how many nodes are followed.
    pub(crate) fn len(&self) -> usize {
        self.by_id.len()
    }

    pub(crate) fn index(&self, id: InstanceId) -> Option<usize> {
        self.by_id.get(&id).map(|&index| index as usize)
    }

    pub(crate) fn item(&self, index: usize) -> Option<&Item> {
        self.items.get(index)?.as_ref()
    }

    /// Takes a node over, if it draws anything. Does nothing with one that is known.
    pub(crate) fn add(&mut self, node: &Gd<Node3D>) {
        let id = node.instance_id();
        if self.by_id.contains_key(&id) {
            return;
        }
        let geometry = node.clone().try_cast::<GeometryInstance3D>().ok();
        let kind = match &geometry {
            Some(geometry) => look::kind(geometry),
            None => node.clone().try_cast::<GridMap>().is_ok().then_some(Kind::Grid),
        };
        let Some(kind) = kind else { return };
        let signal = match kind {
            Kind::Grid => Some("changed"),
            // Emitted when the mesh is another.
            Kind::Mesh => Some("property_list_changed"),
            _ => None,
        };
        let on_changed = signal.map(|signal| {
            let callable = self.inbox.callable(Event::Changed(id));
            inbox::connect(node, signal, &callable);
            (signal, callable)
        });
        let index = self.free.pop().unwrap_or_else(|| {
            self.items.push(None);
            self.items.len() as u32 - 1
        });
        self.items[index as usize] = Some(Item {
            node: node.clone(),
            rid: geometry.as_ref().map_or(Rid::Invalid, |geometry| geometry.get_instance()),
            drawn: geometry.map(Drawn::new),
            kind,
            look: Look::UNKNOWN,
            transform: Transform3D::IDENTITY,
            is_visible: false,
            handle: None,
            mesh: None,
            parts: Vec::new(),
            is_waiting: false,
            mover: None,
            on_changed,
            born: self.frame,
            moved_at: 0,
            held_at: 0,
            is_restless: false,
            shown: Shown::Whole,
        });
        self.by_id.insert(id, index);
        self.grid_count += usize::from(kind == Kind::Grid);
        self.told.put(index as usize, kind != Kind::Grid);
        self.look_again(index as usize);
    }

    /// Lets a node go, and gives it back to Godot as it says itself.
    pub(crate) fn remove(&mut self, id: InstanceId) {
        let Some(index) = self.by_id.remove(&id) else { return };
        let Some(mut item) = self.items[index as usize].take() else { return };
        self.touched.push(index);
        self.free.push(index);
        self.grid_count -= usize::from(item.kind == Kind::Grid);
        self.told.put(index as usize, false);
        self.drop_instances(&mut item);
        if item.node.is_instance_valid() {
            give_back(&mut RenderingServer::singleton(), &mut item);
            item.disconnect();
        }
    }

    /// Lets all nodes go that were freed.
    pub(crate) fn remove_freed(&mut self) {
        let freed = |item: &&Item| !item.node.is_instance_valid();
        let ids = self.items.iter().flatten().filter(freed);
        let ids: Vec<InstanceId> = ids.map(|item| item.node.instance_id_unchecked()).collect();
        ids.into_iter().for_each(|id| self.remove(id));
    }

    fn drop_instances(&mut self, item: &mut Item) {
        let own = item.handle.take().into_iter();
        for handle in own.chain(item.parts.drain(..).map(|part| part.handle)) {
            let _ = self.scene.remove(handle);
            self.unsorted += 1;
        }
        item.mesh = None;
    }

    /// Gives all nodes back to Godot, and lets them go.
    pub(crate) fn clear(&mut self) {
        let ids: Vec<InstanceId> = self.by_id.keys().copied().collect();
        ids.into_iter().for_each(|id| self.remove(id));
        self.meshes.disconnect();
    }

    /// Gives all nodes back to Godot, and goes on following them.
    pub(crate) fn show_all(&mut self) {
        let mut server = RenderingServer::singleton();
        self.items.iter_mut().flatten().for_each(|item| give_back(&mut server, item));
        self.told.forget_all();
    }

    /// Looks at a node anew. Returns whether anything of it changed.
    pub(crate) fn look_again(&mut self, index: usize) -> bool {
        let Some(mut item) = self.items[index].take() else { return false };
        let changed = self.look_at(&mut item, index);
        self.items[index] = Some(item);
        changed
    }

    fn look_at(&mut self, item: &mut Item, index: usize) -> bool {
        let look = self.look_of(item);
        let is_new = item.handle.is_none() && item.parts.is_empty();
        if look == item.look && !is_new {
            return self.place_item(item, index, false);
        }
        let hid = item.look.hides.is_some() || look.hides.is_some();
        if let Some(drawn) = &item.drawn {
            // What was told to the server was worked out from the look of before.
            let mut server = RenderingServer::singleton();
            if look.casts != item.look.casts || look.layers != item.look.layers {
                shown::tell(&mut server, item.rid, &drawn.node, item.shown, Shown::Whole);
                item.shown = Shown::Whole;
                self.told.forget(index);
            }
        }
        let only_layers = Look { layers: item.look.layers, casts: item.look.casts, ..look.clone() };
        let is_other = only_layers != item.look || item.kind == Kind::Grid;
        item.look = look;
        if is_new || is_other && hid {
            self.make_instances(item, index);
        } else {
            self.set_layers(item);
            self.place_item(item, index, true);
        }
        true
    }

    fn look_of(&mut self, item: &Item) -> Look {
        let mark = self.marks.of(&item.node);
        let Some(drawn) = &item.drawn else {
            return Look {
                hides: (!mark.never_hides).then_some(Hiding::all(false)),
                ..Look::UNKNOWN
            };
        };
        let (meshes, materials, inbox) = (&mut self.meshes, &mut self.materials, &self.inbox);
        look::look(drawn, item.kind, mark, &mut Known { meshes, materials, inbox })
    }

    /// Makes the engine's instances of an item anew.
    fn make_instances(&mut self, item: &mut Item, index: usize) {
        self.drop_instances(item);
        self.touched.push(index as u32);
        item.is_waiting = false;
        item.transform = item.place_now(self.is_interpolated);
        item.is_visible = item.node.is_visible_in_tree();
        let layers = layers(item);
        match item.kind {
            Kind::Multi | Kind::Grid => self.make_parts(item, index, layers),
            _ => item.mesh = self.own_mesh(item),
        }
        if item.kind == Kind::Grid {
            return;
        }
        let (mesh, user_data) = (item.mesh, index as u64);
        let flags = InstanceFlags { dynamic: item.is_restless, ..InstanceFlags::default() };
        let instance = match mesh {
            Some(mesh) => {
                let at = convert::transform(&item.transform);
                Instance { bounds: grown(item), ..Instance::new(mesh, at) }
            }
            None => of_box(world_box(item)),
        };
        let instance = Instance { layers, user_data, flags, ..instance };
        item.handle = self.scene.add(instance).ok();
        self.unsorted += 1;
    }

    /// Returns the engine's mesh that an item hides by; `None` for one that hides nothing.
    fn own_mesh(&mut self, item: &mut Item) -> Option<cullet::MeshId> {
        let hiding = item.look.hides?;
        let mesh = item.drawn.as_ref()?.mesh();
        let mesh = mesh.filter(|_| is_plain(&item.transform))?;
        match self.meshes.want(&mut self.scene, &mesh, hiding) {
            Wanted::Here(id) => Some(id),
            Wanted::Soon => {
                item.is_waiting = true;
                None
            }
            Wanted::Nothing => None,
        }
    }

    fn make_parts(&mut self, item: &mut Item, index: usize, layers: u32) {
        let Some(hiding) = item.look.hides else { return };
        let places: Vec<Place> = match item.kind {
            Kind::Multi => item.multi().map(|multi| parts::of_multi(&multi)).unwrap_or_default(),
            _ => item.grid().map(|grid| parts::of_grid(&grid)).unwrap_or_default(),
        };
        for (number, place) in places.iter().enumerate() {
            let mesh = if item.kind == Kind::Grid {
                let facts = self.meshes.facts(&place.mesh, &self.inbox);
                let id = place.mesh.instance_id();
                let own = self.meshes.own_materials(id, &mut self.materials).iter().copied();
                let hides = own.reduce(Facts::beside).and_then(|own| own.hides);
                match hides.filter(|_| facts.hides) {
                    Some(hiding) => self.meshes.want(&mut self.scene, &place.mesh, hiding),
                    None => Wanted::Nothing,
                }
            } else {
                self.meshes.want(&mut self.scene, &place.mesh, hiding)
            };
            item.is_waiting |= mesh == Wanted::Soon;
            let Wanted::Here(mesh) = mesh else { continue };
            let numbers = (index, number + 1);
            let part = place.add(&mut self.scene, mesh, &item.transform, layers, numbers);
            self.unsorted += usize::from(part.is_some());
            item.parts.extend(part);
        }
    }

    fn set_layers(&mut self, item: &Item) {
        let layers = layers(item);
        for handle in item.handle.iter().chain(item.parts.iter().map(|part| &part.handle)) {
            let _ = self.scene.set_layers(*handle, layers);
        }
    }

    /// Brings an item to where its node is now. Returns whether it moved, or was shown or hidden.
    pub(crate) fn place(&mut self, index: usize) -> bool {
        let Some(mut item) = self.items.get_mut(index).and_then(Option::take) else { return false };
        let moved = self.place_item(&mut item, index, false);
        self.items[index] = Some(item);
        moved
    }

    fn place_item(&mut self, item: &mut Item, index: usize, is_forced: bool) -> bool {
        let now = item.place_now(self.is_interpolated);
        let is_visible = item.node.is_visible_in_tree();
        let was_shown = is_visible != item.is_visible;
        if was_shown {
            item.is_visible = is_visible;
            self.set_layers(item);
        }
        if was_shown || now != item.transform || is_forced {
            self.touched.push(index as u32);
        }
        if now == item.transform && !is_forced {
            return was_shown;
        }
        let was_plain = is_plain(&item.transform);
        item.transform = now;
        self.note_movement(item);
        if was_plain != is_plain(&now) && item.look.hides.is_some() {
            // Mirrored, it shows other sides and hides nothing.
            self.make_instances(item, index);
            return true;
        }
        if let Some(handle) = item.handle {
            if item.mesh.is_some() {
                let _ = self.scene.set_transform(handle, convert::transform(&now));
                if item.look.grow > 0.0 {
                    let _ = self.scene.set_bounds(handle, grown(item));
                }
            } else {
                let _ = self.scene.set_bounds(handle, world_box(item));
            }
        }
        for part in &item.parts {
            let _ = self.scene.set_transform(part.handle, part.place(&now));
        }
        true
    }

    /// Puts what moves frame after frame apart, so that it loosens no node of what stands.
    fn note_movement(&mut self, item: &mut Item) {
        self.is_loosened = true;
        let moves_on = self.frame.wrapping_sub(item.moved_at) == 1;
        item.moved_at = self.frame;
        if moves_on && !item.is_restless {
            item.is_restless = true;
            self.restless += 1;
            let flags = InstanceFlags { dynamic: true, ..InstanceFlags::default() };
            let _ = item.handle.map(|handle| self.scene.set_flags(handle, flags));
        }
    }

    /// Brings the bounds of an item that may change without a signal up to date.
    pub(crate) fn bounds_again(&mut self, index: usize) {
        let Some(item) = self.item(index) else { return };
        let Some(drawn) = &item.drawn else { return };
        if item.look.bounds != Bounds::Unknown && drawn.node.get_aabb() != item.look.aabb {
            self.look_again(index);
        }
    }

    /// A node may draw something else: cells of a GridMap may be others.
    pub(crate) fn changed(&mut self, index: usize) {
        match self.item(index).map(|item| item.kind) {
            Some(Kind::Grid) => self.renew(index),
            _ => _ = self.look_again(index),
        }
    }

    /// Looks at a node and the triangles of its mesh anew.
    pub(crate) fn refresh(&mut self, id: InstanceId) {
        let Some(index) = self.index(id) else { return };
        self.materials.clear();
        self.meshes.ask_again();
        if let Some((mesh, _)) = self.item(index).and_then(|item| item.look.mesh) {
            self.resource_changed(mesh);
        }
        self.look_again(index);
    }

    /// Brings everything of an item up to date, its parts too.
    pub(crate) fn renew(&mut self, index: usize) {
        if let Some(item) = self.items.get_mut(index).and_then(Option::as_mut) {
            item.held_at = 0;
        }
        if !self.look_again(index)
            && let Some(mut item) = self.items.get_mut(index).and_then(Option::take)
        {
            self.make_instances(&mut item, index);
            self.items[index] = Some(item);
        }
    }

    /// Takes over the meshes that are ready, and looks again at the nodes that wait for them.
    pub(crate) fn receive_meshes(&mut self) {
        if !self.meshes.receive(&mut self.scene) {
            return;
        }
        for index in 0..self.items.len() {
            if let Some(mut item) = self.items[index].take_if(|item| item.is_waiting) {
                self.make_instances(&mut item, index);
                self.items[index] = Some(item);
            }
        }
    }

    /// A mesh changed: looks again at all nodes that draw it.
    pub(crate) fn resource_changed(&mut self, id: InstanceId) {
        if !self.meshes.forget(id) {
            return;
        }
        for index in 0..self.items.len() {
            let draws = |item: &Item| item.look.mesh.is_some_and(|mesh| mesh.0 == id);
            if self.item(index).is_some_and(|item| draws(item) || item.kind == Kind::Grid) {
                self.look_again(index);
            }
        }
    }

    /// Fits the hierarchy to what moved, and sorts it where that is due.
    pub(crate) fn settle(&mut self) {
        let slots = self.scene.slot_count() as usize;
        if self.unsorted > 64 + slots / 8 || self.restless > 64 + slots / 64 {
            self.scene.sort();
            (self.unsorted, self.restless) = (0, 0);
        } else if std::mem::take(&mut self.is_loosened) {
            self.scene.refit();
        }
    }

    /// Whether what is drawn of a slot that hides others is still what hides: asked after culling,
    /// of the few that did hide something, so that no change of theirs can be missed.
    pub(crate) fn still_hides(&mut self, slot: u32) -> bool {
        let (index, part) = item_and_part(self.scene.user_data(slot));
        let Some(item) = self.items.get_mut(index).and_then(Option::as_mut) else { return true };
        let known = item.parts.binary_search_by_key(&part, |known| known.number);
        let known = known.ok().map(|at| &item.parts[at]);
        // Where it is, its mover reports, or it was asked.
        let Some(drawn) = &item.drawn else {
            return item.grid().zip(known).is_some_and(|(grid, part)| part.is_in_grid(&grid));
        };
        // Nothing changes while a frame is culled: each node is asked once, however many parts it has.
        if item.held_at != self.frame {
            let mark = self.marks.of(&item.node);
            let (meshes, materials, inbox) = (&mut self.meshes, &mut self.materials, &self.inbox);
            let known = &mut Known { meshes, materials, inbox };
            if !look::still_hides(drawn, &item.look, mark, known) {
                return false;
            }
            item.held_at = self.frame;
        }
        if part == 0 {
            return true;
        }
        let known = known.zip(item.multi().zip(item.look.mesh));
        known.is_some_and(|(part, (multi, (mesh, _)))| part.is_in_multi(&multi, mesh))
    }
}

/// The layers that an item is in; none while it is not visible, so that it hides nothing.
fn layers(item: &Item) -> u32 {
    if item.is_visible { item.look.layers } else { 0 }
}

/// Whether a node at this place shows the sides that its mesh says.
fn is_plain(at: &Transform3D) -> bool {
    convert::is_finite(at) && at.basis.determinant() > 0.0
}

fn of_box(bounds: BoundsOverride) -> Instance {
    match bounds {
        BoundsOverride::World(bounds) => Instance::of_bounds(bounds),
        other => Instance { bounds: other, ..Instance::of_bounds(cullet::bounds::Aabb::EMPTY) },
    }
}

/// Returns the bounds of an item that is drawn by a mesh, which passes after the first may draw larger.
fn grown(item: &Item) -> BoundsOverride {
    if item.look.grow <= 0.0 {
        return BoundsOverride::Mesh;
    }
    let axes =
        [item.transform.basis.col_a(), item.transform.basis.col_b(), item.transform.basis.col_c()];
    // No direction is scaled by more.
    let scale = axes.iter().map(|axis| axis.length_squared()).sum::<f32>().sqrt();
    BoundsOverride::Margin(item.look.grow * scale * 1.001)
}

/// Returns the bounds of an item in world space.
pub(crate) fn world_box(item: &Item) -> BoundsOverride {
    let Bounds::Box(aabb, grown) = item.look.bounds else { return BoundsOverride::None };
    convert::world_box(&aabb, &item.transform, grown)
        .map_or(BoundsOverride::None, BoundsOverride::World)
}

/// Gives a node back to Godot.
fn give_back(server: &mut Gd<RenderingServer>, item: &mut Item) {
    if let Some(drawn) = item.drawn.as_ref().filter(|drawn| drawn.node.is_instance_valid()) {
        shown::tell(server, item.rid, &drawn.node, item.shown, Shown::Whole);
    }
    item.shown = Shown::Whole;
}
