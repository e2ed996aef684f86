//! The engine's scene, kept in step with the entities that have a mesh.

use bevy_asset::AssetId;
use bevy_ecs::entity::EntityHashSet;
use bevy_ecs::prelude::*;
use bevy_math::Vec3A;
use engine::bounds::Aabb;
use engine::{
    Handle, Instance, InstanceFlags, Mesh, MeshData, MeshId, Scene, Transform, prepared::Prepared,
    scene::BoundsOverride,
};

use crate::bits::{slots, slots_of};
use crate::seen::SeenItem;

/// The engine's scene: an instance for each entity with a mesh that Bevy culls on the CPU.
///
/// It follows the entities by itself, in [`CulletSystems::Follow`](crate::CulletSystems::Follow).
#[derive(Debug, Resource)]
pub struct CulletScene {
    pub(crate) scene: Scene,
    // By index of entity.
    records: Vec<Option<Record>>,
    // How many of them are not empty.
    len: usize,
    // By index of entity: what a moved one is written to. It lies closer than the records, which
    // are as large as a line of the cache.
    plain: Vec<u32>,
    /// Entities that the hierarchy alone does not decide: see [`SeenItem::needs_check`].
    pub(crate) checked: EntityHashSet,
    // Instances that are new or gone, and those that were found to move, since the slots were
    // sorted.
    unsorted: usize,
    restless: usize,
    has_moved_occluders: bool,
    updates: u32,
    /// Rises with each frame in which any slot changed.
    pub(crate) step: u64,
    /// One bit a word of slots, in words of 64 of them: one of its slots changed in the last step.
    touched: Vec<u64>,
    is_touched: bool,
    // Used again in each frame.
    moved: Vec<Moved>,
    // By slot, for those with a bit: in which list of what moved, and where in it.
    at_slot: Vec<[u32; 2]>,
    is_moved: Vec<u64>,
    pub(crate) spare: Vec<Found>,
    /// Entities whose meshes are being made into occluders, and whether both sides are drawn.
    pub(crate) waiting: Vec<(Entity, AssetId<bevy_mesh::Mesh>, bool)>,
}

/// In [`CulletScene::plain`]: the entity is known to move often.
const RESTLESS: u32 = 1 << 31;
/// In [`CulletScene::plain`]: not there, or drawn as an occluder.
const NOT_PLAIN: u32 = u32::MAX;

/// An entity that moved.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moved {
    slot: u32,
    /// Index of the entity, where it is not known yet that it moves often; else `u32::MAX`.
    index: u32,
    bounds: Aabb,
}

/// Changes in a part of a table. Its memory is reused in each frame: fresh pages cost more than
/// writing to them.
#[derive(Debug, Default)]
pub(crate) struct Found {
    /// Moved, and nothing else.
    pub(crate) moved: Vec<Moved>,
    /// To be looked at whole.
    pub(crate) changed: Vec<Entity>,
}

#[derive(Clone, Copy, Debug)]
struct Record {
    entity: Entity,
    handle: Handle,
    /// The frame in which it last moved.
    moved_at: u32,
    layers: u32,
    flags: InstanceFlags,
    /// The engine's mesh: 0 for what hides nothing.
    mesh: MeshId,
}

impl Default for CulletScene {
    fn default() -> Self {
        let mut scene = Scene::new();
        // Entities have boxes of their own: what they share is a mesh of one triangle.
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let data = MeshData { positions, indices: vec![0, 1, 2], ..MeshData::default() };
        scene.add_mesh(Mesh::new(data).unwrap_or_else(|_| unreachable!("a triangle is a mesh")));
        Self {
            scene,
            records: Vec::new(),
            len: 0,
            plain: Vec::new(),
            checked: EntityHashSet::default(),
            unsorted: 0,
            restless: 0,
            has_moved_occluders: false,
            updates: 0,
            step: 0,
            touched: Vec::new(),
            is_touched: false,
            moved: Vec::new(),
            at_slot: Vec::new(),
            is_moved: Vec::new(),
            spare: Vec::new(),
            waiting: Vec::new(),
        }
    }
}

impl CulletScene {
    /// The engine's scene, to look at.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The handle of an entity's instance; `None` where it has none: no `Mesh3d`, or
    /// `NoCpuCulling`.
    #[must_use]
    pub fn handle(&self, entity: Entity) -> Option<Handle> {
        self.record(entity).map(|record| record.handle)
    }

    /// The entity of a slot; `None` for an empty one.
    #[must_use]
    pub fn entity(&self, slot: u32) -> Option<Entity> {
        let handle = self.scene.handle(slot)?;
        let slot = self.scene.slot(handle).ok()?;
        Entity::try_from_bits(self.scene.user_data(slot))
    }

    fn record(&self, entity: Entity) -> Option<&Record> {
        let record = self.records.get(entity.index_u32() as usize)?.as_ref()?;
        (record.entity == entity).then_some(record)
    }

    /// How many entities there are.
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// The entity of an index.
    pub(crate) fn of_index(&self, index: usize) -> Option<Entity> {
        self.records.get(index)?.as_ref().map(|record| record.entity)
    }

    /// Begins a frame.
    pub(crate) fn begin(&mut self) {
        self.updates = self.updates.wrapping_add(1);
        if std::mem::take(&mut self.is_touched) {
            self.touched.fill(0);
        }
    }

    /// Takes note that a slot changed.
    fn touch(&mut self, slot: u32) {
        if !std::mem::replace(&mut self.is_touched, true) {
            self.step += 1;
        }
        let word = slot as usize / 64;
        if self.touched.len() <= word / 64 {
            self.touched.resize(word / 64 + 1, 0);
        }
        self.touched[word / 64] |= 1 << (word % 64);
    }

    fn touch_handle(&mut self, handle: Handle) {
        if let Ok(slot) = self.scene.slot(handle) {
            self.touch(slot);
        }
    }

    /// The words of slots that changed in the last step, ascending.
    pub(crate) fn touched(&self) -> impl Iterator<Item = usize> + '_ {
        slots(&self.touched).map(|word| word as usize)
    }

    /// Returns what is to be written for an entity that moved and changed in nothing else since it
    /// was taken over; `None` where more follows from it.
    #[inline]
    pub(crate) fn moved(&self, index: u32, bounds: Aabb) -> Option<Moved> {
        let plain = self.plain.get(index as usize).copied().filter(|&plain| plain != NOT_PLAIN)?;
        if !bounds.is_finite() || bounds.is_empty() {
            return None;
        }
        let index = if plain & RESTLESS == 0 { index } else { u32::MAX };
        Some(Moved { slot: plain & !RESTLESS, index, bounds })
    }

    /// Brings `plain` after the record of an index.
    fn note(&mut self, index: usize) {
        if self.plain.len() <= index {
            self.plain.resize(index + 1, NOT_PLAIN);
        }
        let record = self.records[index].filter(|record| record.mesh == 0);
        let slot = record.and_then(|record| self.scene.slot(record.handle).ok());
        let restless = record.map_or(0, |record| u32::from(record.flags.dynamic) << 31);
        self.plain[index] =
            slot.filter(|slot| slot & RESTLESS == 0).map_or(NOT_PLAIN, |s| s | restless);
    }

    /// Takes an entity over as it is now.
    pub(crate) fn put(&mut self, seen: &SeenItem<'_, '_>) {
        self.take_over(seen);
        self.note(seen.entity.index_u32() as usize);
    }

    fn take_over(&mut self, seen: &SeenItem<'_, '_>) {
        let at = seen.entity.index_u32() as usize;
        if self.records.len() <= at {
            self.records.resize(at + 1, None);
        }
        if let Some(old) = self.records[at].filter(|r| r.entity != seen.entity) {
            self.remove(old.entity);
        }
        if seen.needs_check() {
            self.checked.insert(seen.entity);
        } else if !self.checked.is_empty() {
            self.checked.remove(&seen.entity);
        }
        let mesh = self.records[at].map_or(0, |record| record.mesh);
        let mesh = if mesh != 0 && self.is_drawn_as_it_is(seen, mesh) { mesh } else { 0 };
        if let Some(record) = self.records[at].filter(|record| record.mesh != mesh) {
            self.touch_handle(record.handle);
            let _ = self.scene.remove(record.handle);
            self.records[at] = None;
            self.len -= 1;
        }
        let (bounds, layers) = (seen.bounds(), seen.layers());
        // A sphere is no box to Bevy's lights: they list what has one whatever they show.
        let has_sphere_alone = seen.aabb.is_none() && seen.sphere.is_some();
        let always_visible = seen.no_frustum_culling || seen.is_never_hidden() || has_sphere_alone;
        let now = self.updates;
        let transform = if mesh == 0 { Transform::IDENTITY } else { seen.transform() };
        let bounds = if mesh == 0 { bounds } else { BoundsOverride::Mesh };
        let Some(record) = &mut self.records[at] else {
            let flags = InstanceFlags { always_visible, ..InstanceFlags::default() };
            let user_data = seen.entity.to_bits();
            let instance = Instance::new(mesh, transform);
            let added = self.scene.add(Instance { bounds, layers, flags, user_data, ..instance });
            // Full at four thousand million, which no world reaches: its entities would not fit
            // either.
            let Ok(handle) = added else { return };
            let entity = seen.entity;
            self.records[at] = Some(Record { entity, handle, moved_at: now, layers, flags, mesh });
            self.len += 1;
            self.unsorted += 1;
            self.touch_handle(handle);
            return;
        };
        let handle = record.handle;
        let moves_on = now.wrapping_sub(record.moved_at) == 1;
        record.moved_at = now;
        let dynamic = record.flags.dynamic || moves_on;
        let flags = InstanceFlags { always_visible, dynamic, ..record.flags };
        // None of these is refused: the handle is this scene's, and was not removed.
        if flags != record.flags {
            self.restless += usize::from(dynamic != record.flags.dynamic);
            record.flags = flags;
            let _ = self.scene.set_flags(handle, flags);
        }
        if layers != record.layers {
            record.layers = layers;
            let _ = self.scene.set_layers(handle, layers);
        }
        let Ok(slot) = self.scene.slot(handle) else { return };
        self.touch(slot);
        match bounds {
            BoundsOverride::World(bounds) => {
                self.moved.push(Moved { slot, index: u32::MAX, bounds });
            }
            BoundsOverride::Mesh => {
                let _ = self.scene.set_transform(handle, transform);
                self.has_moved_occluders = true;
            }
            other => {
                let _ = self.scene.set_bounds(handle, other);
            }
        }
    }

    /// Adds a mesh that hides, if there is one.
    pub(crate) fn take(&mut self, made: Option<(Mesh, Prepared)>) -> Option<MeshId> {
        made.map(|(mesh, prepared)| self.scene.add_prepared_mesh(mesh, prepared))
    }

    /// Gives an entity another of the engine's meshes, if it is there.
    pub(crate) fn set_mesh(
        &mut self,
        entity: Entity,
        mesh: MeshId,
        seen: Option<&SeenItem<'_, '_>>,
    ) {
        let (Some(record), Some(seen)) = (self.record(entity).copied(), seen) else { return };
        if record.mesh == mesh || mesh != 0 && !self.is_drawn_as_it_is(seen, mesh) {
            return;
        }
        let bounds = if mesh == 0 { seen.bounds() } else { BoundsOverride::Mesh };
        let transform = if mesh == 0 { Transform::IDENTITY } else { seen.transform() };
        let (layers, flags, user_data) = (record.layers, record.flags, entity.to_bits());
        let instance = Instance::new(mesh, transform);
        if let Ok(handle) =
            self.scene.add(Instance { bounds, layers, flags, user_data, ..instance })
        {
            self.touch_handle(handle);
            self.touch_handle(record.handle);
            let _ = self.scene.remove(record.handle);
            self.records[entity.index_u32() as usize] = Some(Record { handle, mesh, ..record });
            self.unsorted += 2;
            self.note(entity.index_u32() as usize);
        }
    }

    /// Whether an entity is drawn just where its mesh lies, so that the mesh hides what is behind
    /// it.
    fn is_drawn_as_it_is(&self, seen: &SeenItem<'_, '_>, mesh: MeshId) -> bool {
        let Some(aabb) = seen.aabb else { return false };
        let own = self.scene.meshes()[mesh as usize].bounds();
        let (min, max) = (Vec3A::from_array(own.min), Vec3A::from_array(own.max));
        let slack = (min.abs().max(max.abs())) * 1e-5;
        let is_own = (aabb.min() - min).abs().cmple(slack).all()
            && (aabb.max() - max).abs().cmple(slack).all();
        let turns_over = seen.transform.affine().matrix3.determinant() <= 0.0;
        is_own && !turns_over && !seen.is_skinned && !seen.has_morphs() && !seen.needs_check()
    }

    /// Takes an entity out, if it is there.
    pub(crate) fn remove(&mut self, entity: Entity) {
        self.checked.remove(&entity);
        let Some(&Record { handle, .. }) = self.record(entity) else { return };
        self.touch_handle(handle);
        let _ = self.scene.remove(handle);
        self.records[entity.index_u32() as usize] = None;
        self.len -= 1;
        self.unsorted += 1;
        self.note(entity.index_u32() as usize);
    }

    /// Writes the boxes that changed, fits the nodes above them, and sorts where that is due.
    pub(crate) fn settle<'a>(&mut self, moved: impl Iterator<Item = &'a [Moved]>) {
        // In the order of the slots: a box is written to lines of the cache far apart, which boxes
        // beside it share.
        self.at_slot.resize(self.scene.slot_count() as usize, [0; 2]);
        self.is_moved.resize(self.at_slot.len().div_ceil(64), 0);
        let mut more = std::mem::take(&mut self.moved);
        // Those of entities that changed in more come last, and so are those that are kept.
        let mut lists: Vec<&[Moved]> = moved.collect();
        lists.push(&more);
        for (list, all) in lists.iter().enumerate() {
            for (at, &Moved { slot, index, .. }) in all.iter().enumerate() {
                self.at_slot[slot as usize] = [list as u32, at as u32];
                self.is_moved[slot as usize / 64] |= 1 << (slot % 64);
                let Some(Some(record)) = self.records.get_mut(index as usize) else { continue };
                let moves_on = self.updates.wrapping_sub(record.moved_at) == 1;
                record.moved_at = self.updates;
                if moves_on && !record.flags.dynamic {
                    record.flags.dynamic = true;
                    self.restless += 1;
                    let _ = self.scene.set_flags(record.handle, record.flags);
                    self.plain[index as usize] |= RESTLESS;
                }
            }
        }
        if self.is_touched || lists.iter().any(|list| !list.is_empty()) {
            let mut is_moved = std::mem::take(&mut self.is_moved);
            for (word, bits) in is_moved.iter().enumerate().filter(|(_, bits)| **bits != 0) {
                self.touch(word as u32 * 64 + bits.trailing_zeros());
            }
            let mut near = [Aabb::EMPTY; 64];
            self.scene.write_bounds(|boxes| {
                for (word, &bits) in is_moved.iter().enumerate().filter(|(_, bits)| **bits != 0) {
                    // Read before any is written: reads that miss the cache wait for each other the
                    // least when nothing is between them.
                    for (near, slot) in near.iter_mut().zip(slots_of(word, bits)) {
                        let [list, at] = self.at_slot[slot as usize];
                        *near = lists[list as usize][at as usize].bounds;
                    }
                    let own = slots_of(word, bits).zip(&near);
                    own.for_each(|(slot, bounds)| boxes.set(slot, bounds));
                }
            });
            is_moved.fill(0);
            self.is_moved = is_moved;
        }
        more.clear();
        self.moved = more;
        if std::mem::take(&mut self.has_moved_occluders) {
            self.scene.refit();
        }
        // Sorting costs as much as many frames of a few stray slots; those that move loosen the
        // nodes of all around them.
        let slots = self.scene.slot_count() as usize;
        if self.unsorted > 64 + slots / 8 || self.restless > 64 + slots / 64 {
            self.scene.sort();
            (self.unsorted, self.restless) = (0, 0);
            (0..self.records.len()).for_each(|index| self.note(index));
        }
    }
}
