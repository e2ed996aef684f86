//! The engine's scene, kept in step with the entities that have a mesh.

use std::any::TypeId;

use bevy_asset::AssetId;
use bevy_camera::primitives::{Aabb, Sphere};
use bevy_camera::visibility::{
    DynamicSkinnedMeshBounds, InheritedVisibility, NoCpuCulling, NoFrustumCulling, RenderLayers,
    ViewVisibility, VisibilityClass, VisibilityRange,
};
use bevy_ecs::entity::EntityHashSet;
use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;
use bevy_ecs::system::SystemParam;
use bevy_math::{Affine3A, Vec3A};
use bevy_mesh::Mesh3d;
use bevy_mesh::morph::{MeshMorphWeights, MorphWeights};
use bevy_mesh::skinning::SkinnedMesh;
use bevy_transform::components::GlobalTransform;
use engine::{
    BoundsOverride, Handle, Instance, InstanceFlags, Mesh, MeshData, MeshId, Prepared, Scene,
    Transform,
};

/// The layer of the engine that stands for all layers of Bevy from this one on.
const LAST_LAYER: u32 = 31;

/// The engine's scene: an instance for each entity with a mesh that Bevy culls on the CPU.
///
/// It follows the entities by itself, in [`CulletSystems::Follow`](crate::CulletSystems::Follow).
#[derive(Debug, Resource)]
pub struct CulletScene {
    pub(crate) scene: Scene,
    // By index of entity.
    records: Vec<Option<Record>>,
    /// Entities that the hierarchy alone does not decide: see [`Seen::needs_check`].
    pub(crate) checked: EntityHashSet,
    // Instances that are new, gone, or found to move, since the slots were sorted.
    unsorted: usize,
    has_moved_occluders: bool,
    updates: u32,
    // Lists that are used again in each frame.
    moved: Vec<(Handle, engine::bounds::Aabb)>,
    /// Entities whose meshes are being made into occluders, and whether both sides are drawn.
    pub(crate) waiting: Vec<(Entity, AssetId<bevy_mesh::Mesh>, bool)>,
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
            checked: EntityHashSet::default(),
            unsorted: 0,
            has_moved_occluders: false,
            updates: 0,
            moved: Vec::new(),
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

    /// The handle of an entity's instance; `None` where it has none: no `Mesh3d`, or `NoCpuCulling`.
    #[must_use]
    pub fn handle(&self, entity: Entity) -> Option<Handle> {
        self.record(entity).map(|record| record.handle)
    }

    /// The entity of a slot; `None` for an empty one.
    #[must_use]
    pub fn entity(&self, slot: u32) -> Option<Entity> {
        let handle = self.scene.handle(slot)?;
        let slot = self.scene.slot(handle).ok()?;
        Entity::try_from_bits(self.scene.user(slot))
    }

    fn record(&self, entity: Entity) -> Option<&Record> {
        let record = self.records.get(entity.index_u32() as usize)?.as_ref()?;
        (record.entity == entity).then_some(record)
    }

    /// Takes an entity over as it is now.
    fn put(&mut self, seen: &SeenItem<'_, '_>) {
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
            let _ = self.scene.remove(record.handle);
            self.records[at] = None;
        }
        let (bounds, layers) = (seen.bounds(), seen.layers());
        let always_visible = seen.no_frustum_culling || seen.is_deformed();
        let now = self.updates;
        let transform = if mesh == 0 { Transform::IDENTITY } else { seen.transform() };
        let bounds = if mesh == 0 { bounds } else { BoundsOverride::Mesh };
        let Some(record) = &mut self.records[at] else {
            let flags = InstanceFlags { always_visible, ..InstanceFlags::default() };
            let user = seen.entity.to_bits();
            let instance = Instance::new(mesh, transform);
            let added = self.scene.add(Instance { bounds, layers, flags, user, ..instance });
            // Full at four thousand million, which no world reaches: its entities would not fit either.
            let Ok(handle) = added else { return };
            let entity = seen.entity;
            self.records[at] = Some(Record { entity, handle, moved_at: now, layers, flags, mesh });
            self.unsorted += 1;
            return;
        };
        let handle = record.handle;
        let moves_on = now.wrapping_sub(record.moved_at) == 1;
        record.moved_at = now;
        let dynamic = record.flags.dynamic || moves_on;
        let flags = InstanceFlags { always_visible, dynamic, ..record.flags };
        // None of these is refused: the handle is this scene's, and was not removed.
        if flags != record.flags {
            self.unsorted += usize::from(dynamic != record.flags.dynamic);
            record.flags = flags;
            let _ = self.scene.set_flags(handle, flags);
        }
        if layers != record.layers {
            record.layers = layers;
            let _ = self.scene.set_layers(handle, layers);
        }
        match bounds {
            BoundsOverride::World(bounds) => self.moved.push((handle, bounds)),
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
        let (layers, flags, user) = (record.layers, record.flags, entity.to_bits());
        let instance = Instance::new(mesh, transform);
        // What waits to be written has the old handle.
        self.moved.retain(|(handle, _)| *handle != record.handle);
        if let Ok(handle) = self.scene.add(Instance { bounds, layers, flags, user, ..instance }) {
            let _ = self.scene.remove(record.handle);
            self.records[entity.index_u32() as usize] = Some(Record { handle, mesh, ..record });
            self.unsorted += 2;
        }
    }

    /// Whether an entity is drawn just where its mesh lies, so that the mesh hides what is behind it.
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
    fn remove(&mut self, entity: Entity) {
        self.checked.remove(&entity);
        let Some(record) = self.record(entity) else { return };
        let _ = self.scene.remove(record.handle);
        self.records[entity.index_u32() as usize] = None;
        self.unsorted += 1;
    }

    /// Writes the boxes that changed, fits the nodes above them, and sorts where that is due.
    fn settle(&mut self) {
        let count = self.moved.len();
        // Fitting all nodes once is quicker than letting each grow, from a few in a hundred on.
        if count > 64 && count * 32 > self.scene.slot_count() as usize {
            let slots = |scene: &Scene, handle| scene.slot(handle).ok();
            let moved: Vec<_> = self
                .moved
                .drain(..)
                .filter_map(|(handle, b)| Some((slots(&self.scene, handle)?, b)))
                .collect();
            let mut bounds = self.scene.bounds_mut();
            for (slot, b) in moved {
                bounds.set(slot, &b);
            }
        } else {
            for (handle, b) in self.moved.drain(..) {
                let _ = self.scene.set_bounds(handle, BoundsOverride::World(b));
            }
            if count > 0 || self.has_moved_occluders {
                self.scene.refit();
            }
        }
        self.has_moved_occluders = false;
        if self.unsorted > 64 + self.scene.slot_count() as usize / 8 {
            self.scene.sort();
            self.unsorted = 0;
        }
    }
}

/// All of an entity that its visibility depends on.
#[derive(QueryData)]
pub(crate) struct Seen {
    pub(crate) entity: Entity,
    pub(crate) inherited: &'static InheritedVisibility,
    pub(crate) class: Option<&'static VisibilityClass>,
    pub(crate) layers: Option<&'static RenderLayers>,
    pub(crate) aabb: Option<&'static Aabb>,
    pub(crate) sphere: Option<&'static Sphere>,
    pub(crate) transform: &'static GlobalTransform,
    pub(crate) no_frustum_culling: Has<NoFrustumCulling>,
    pub(crate) ranged: Has<VisibilityRange>,
    is_skinned: Has<SkinnedMesh>,
    has_dynamic_bounds: Has<DynamicSkinnedMeshBounds>,
    is_morphed: Has<MeshMorphWeights>,
    has_weights: Has<MorphWeights>,
}

impl SeenItem<'_, '_> {
    /// Whether more is to be asked than box and layers: ranges, layers beyond those of the engine, a sphere in place of a
    /// box, or lists of other classes.
    fn needs_check(&self) -> bool {
        let is_plain = |class: &VisibilityClass| class.0[..] == [TypeId::of::<Mesh3d>()];
        self.ranged
            || self.aabb.is_none() && self.sphere.is_some()
            || !self.class.is_some_and(is_plain)
            || self.layers.is_some_and(|layers| mask(layers) >> LAST_LAYER != 0)
    }

    fn has_morphs(&self) -> bool {
        self.is_morphed || self.has_weights
    }

    /// Whether its vertices may lie outside its `Aabb`, which is that of the pose in which it was made: it is tested against
    /// the frustum, as Bevy does, but is never taken for hidden.
    fn is_deformed(&self) -> bool {
        self.has_morphs() || self.is_skinned && !self.has_dynamic_bounds
    }

    fn transform(&self) -> Transform {
        let at = self.transform.affine();
        let linear = [at.matrix3.x_axis, at.matrix3.y_axis, at.matrix3.z_axis];
        let translation = at.translation.as_dvec3().to_array();
        Transform { linear: linear.map(|axis| axis.to_array()), translation }
    }

    fn layers(&self) -> u32 {
        if self.inherited.get() { mask(self.layers.unwrap_or_default()) } else { 0 }
    }

    fn bounds(&self) -> BoundsOverride {
        let bounds = match (self.aabb, self.sphere) {
            (Some(aabb), _) => world_box(aabb, &self.transform.affine()),
            (None, Some(s)) => around(s.center, Vec3A::splat(s.radius)),
            (None, None) => return BoundsOverride::None,
        };
        if bounds.is_finite() && !bounds.is_empty() {
            BoundsOverride::World(bounds)
        } else {
            BoundsOverride::None
        }
    }
}

/// Layers of Bevy as those of the engine: the first 31 are themselves, all others are the last.
pub(crate) fn mask(layers: &RenderLayers) -> u32 {
    let words = layers.bits();
    let first = words.first().copied().unwrap_or(0);
    let low = first as u32 & !(1 << LAST_LAYER);
    let others = first >> LAST_LAYER != 0 || words.iter().skip(1).any(|&word| word != 0);
    low | u32::from(others) << LAST_LAYER
}

/// A box in world space that holds a box of an entity, whatever f32 rounds.
fn world_box(aabb: &Aabb, at: &Affine3A) -> engine::bounds::Aabb {
    let m = &at.matrix3;
    let e = aabb.half_extents.abs();
    let extents = m.x_axis.abs() * e.x + m.y_axis.abs() * e.y + m.z_axis.abs() * e.z;
    let c = aabb.center.abs();
    let sizes = m.x_axis.abs() * c.x + m.y_axis.abs() * c.y + m.z_axis.abs() * c.z;
    // Four terms and their sums, each rounded by half of f32::EPSILON.
    let slack = (sizes + at.translation.abs() + extents) * (4.0 * f32::EPSILON);
    around(at.transform_point3a(aabb.center), extents + slack)
}

fn around(center: Vec3A, extents: Vec3A) -> engine::bounds::Aabb {
    // What cannot be told from a point still has to lie inside.
    let slack = (center.abs() + extents) * (2.0 * f32::EPSILON);
    let extents = extents + slack;
    engine::bounds::Aabb::new((center - extents).to_array(), (center + extents).to_array())
}

/// Components whose going makes an entity another one for visibility.
#[derive(SystemParam)]
pub(crate) struct Gone<'w, 's> {
    mesh: RemovedComponents<'w, 's, Mesh3d>,
    aabb: RemovedComponents<'w, 's, Aabb>,
    sphere: RemovedComponents<'w, 's, Sphere>,
    layers: RemovedComponents<'w, 's, RenderLayers>,
    inherited: RemovedComponents<'w, 's, InheritedVisibility>,
    view: RemovedComponents<'w, 's, ViewVisibility>,
    class: RemovedComponents<'w, 's, VisibilityClass>,
    transform: RemovedComponents<'w, 's, GlobalTransform>,
    no_frustum_culling: RemovedComponents<'w, 's, NoFrustumCulling>,
    no_cpu_culling: RemovedComponents<'w, 's, NoCpuCulling>,
    range: RemovedComponents<'w, 's, VisibilityRange>,
}

impl Gone<'_, '_> {
    fn read(&mut self) -> impl Iterator<Item = Entity> {
        let all = self.mesh.read().chain(self.aabb.read()).chain(self.sphere.read());
        let all = all.chain(self.layers.read()).chain(self.inherited.read());
        let all = all.chain(self.view.read()).chain(self.class.read());
        let all = all.chain(self.transform.read()).chain(self.no_frustum_culling.read());
        all.chain(self.no_cpu_culling.read()).chain(self.range.read())
    }
}

/// Entities that are culled on the CPU as meshes.
pub(crate) type OfMesh = (With<Mesh3d>, With<ViewVisibility>, Without<NoCpuCulling>);

/// What an entity's place in the scene follows from.
type Touched = Or<(
    Changed<GlobalTransform>,
    Changed<Aabb>,
    Changed<InheritedVisibility>,
    Changed<RenderLayers>,
    Changed<VisibilityClass>,
    Changed<Sphere>,
    Added<NoFrustumCulling>,
    Added<VisibilityRange>,
    Added<ViewVisibility>,
    // A `Mesh3d` that comes changes the class.
    Or<(Added<SkinnedMesh>, Added<MeshMorphWeights>, Added<MorphWeights>)>,
)>;

/// Takes over into the engine's scene what changed.
pub(crate) fn follow(
    mut mirror: ResMut<CulletScene>,
    touched: Query<Seen, (OfMesh, Touched)>,
    all: Query<Seen, OfMesh>,
    mut gone: Gone,
    off_cpu: Query<Entity, Added<NoCpuCulling>>,
) {
    let mirror = mirror.bypass_change_detection();
    mirror.updates = mirror.updates.wrapping_add(1);
    for entity in gone.read().chain(&off_cpu) {
        match all.get(entity) {
            Ok(seen) => mirror.put(&seen),
            Err(_) => mirror.remove(entity),
        }
    }
    for seen in &touched {
        mirror.put(&seen);
    }
    mirror.settle();
}
