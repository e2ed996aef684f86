//! A scene: meshes, and instances of them in dense slots.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::bounds::{Aabb, Boxes};
use crate::mesh::Mesh;
use crate::transform::Transform;

mod instance;

pub use instance::{BoundsOverride, Commit, Handle, Instance, InstanceFlags, MeshId, SceneError};

const NO_SLOT: u32 = u32::MAX;

/// Meshes shared by instances.
///
/// Instances live in **slots**, dense numbers that every hot array uses; a removed instance leaves an
/// empty slot until [`commit`](Self::commit), the only call that moves instances between slots.
/// A handle finds its slot, and a slot its handle, in O(1).
#[derive(Debug)]
pub struct Scene {
    id: u64,
    origin: [f64; 3],
    order_version: u64,
    change: u64,
    meshes: Vec<Mesh>,
    // By slot.
    mesh: Vec<MeshId>,
    transforms: Vec<Transform>,
    layers: Vec<u32>,
    flags: Vec<InstanceFlags>,
    overrides: Vec<BoundsOverride>,
    boxes: Boxes,
    // One bit a slot: no stage but the layer mask may cull it.
    exempt: Vec<u64>,
    // One bit a slot: it has no triangle with an area.
    collapsed: Vec<u64>,
    handles: Vec<Handle>,
    // By handle index: generation and slot.
    entries: Vec<(u32, u32)>,
    free: Vec<u32>,
    removed: u32,
}

impl Default for Scene {
    fn default() -> Self {
        Self::new()
    }
}

impl Scene {
    /// A scene of nothing, with its origin at zero.
    #[must_use]
    pub fn new() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        Self {
            id: NEXT.fetch_add(1, Ordering::Relaxed),
            origin: [0.0; 3],
            order_version: 0,
            change: 0,
            meshes: Vec::new(),
            mesh: Vec::new(),
            transforms: Vec::new(),
            layers: Vec::new(),
            flags: Vec::new(),
            overrides: Vec::new(),
            boxes: Boxes::new(),
            exempt: Vec::new(),
            collapsed: Vec::new(),
            handles: Vec::new(),
            entries: Vec::new(),
            free: Vec::new(),
            removed: 0,
        }
    }

    /// Tells this scene from every other of the process.
    #[must_use]
    pub fn id(&self) -> u64 {
        self.id
    }

    /// Rises whenever slots were permuted.
    #[must_use]
    pub fn order_version(&self) -> u64 {
        self.order_version
    }

    /// Rises with every change of any instance.
    #[must_use]
    pub fn change_version(&self) -> u64 {
        self.change
    }

    /// The point that bounds are relative to.
    #[must_use]
    pub fn origin(&self) -> [f64; 3] {
        self.origin
    }

    /// Moves the origin, and with it the point around which f32 bounds are finest. O(instances).
    /// World-space override boxes are relative to the origin, so they are shifted, and grow by their rounding.
    pub fn rebase(&mut self, origin: [f64; 3]) {
        let shift: [f64; 3] = std::array::from_fn(|a| self.origin[a] - origin[a]);
        for o in &mut self.overrides {
            if let BoundsOverride::World(b) = o {
                let moved = |v: [f32; 3]| std::array::from_fn(|a| f64::from(v[a]) + shift[a]);
                *b = Aabb::rounded_out(moved(b.min), moved(b.max));
            }
        }
        self.origin = origin;
        (0..self.slot_count()).for_each(|slot| self.update_slot(slot));
        self.change += 1;
    }

    /// Adds a mesh that instances may share.
    pub fn add_mesh(&mut self, mesh: Mesh) -> MeshId {
        self.meshes.push(mesh);
        (self.meshes.len() - 1) as MeshId
    }

    /// All meshes.
    #[must_use]
    pub fn meshes(&self) -> &[Mesh] {
        &self.meshes
    }

    /// All meshes, to change their sidedness.
    pub fn meshes_mut(&mut self) -> impl Iterator<Item = &mut Mesh> {
        self.change += 1;
        self.meshes.iter_mut()
    }

    /// Adds an instance, in a new slot.
    ///
    /// # Errors
    /// If the mesh does not exist or the scene is full.
    pub fn add(&mut self, instance: Instance) -> Result<Handle, SceneError> {
        if instance.mesh as usize >= self.meshes.len() {
            let meshes = self.meshes.len();
            return Err(SceneError::NoMesh { mesh: instance.mesh, meshes });
        }
        let slot = self.slot_count();
        if slot == NO_SLOT {
            return Err(SceneError::Full(NO_SLOT));
        }
        let index = self.free.pop().unwrap_or_else(|| {
            self.entries.push((0, NO_SLOT));
            (self.entries.len() - 1) as u32
        });
        let entry = &mut self.entries[index as usize];
        entry.1 = slot;
        let handle = Handle { index, generation: entry.0 };
        self.mesh.push(instance.mesh);
        self.transforms.push(instance.transform);
        self.layers.push(instance.layers);
        self.flags.push(instance.flags);
        self.overrides.push(instance.bounds);
        self.handles.push(handle);
        self.resize_slot_data();
        self.update_slot(slot);
        self.change += 1;
        Ok(handle)
    }

    /// Removes an instance. Its slot stays empty until [`commit`](Self::commit).
    ///
    /// # Errors
    /// If the handle names no instance.
    pub fn remove(&mut self, handle: Handle) -> Result<(), SceneError> {
        let slot = self.slot(handle)?;
        let entry = &mut self.entries[handle.index as usize];
        *entry = (entry.0.wrapping_add(1), NO_SLOT);
        self.free.push(handle.index);
        self.layers[slot as usize] = 0;
        self.flags[slot as usize] = InstanceFlags::default();
        self.handles[slot as usize] = Handle { index: NO_SLOT, generation: 0 };
        self.boxes.set(slot as usize, &Aabb::EMPTY);
        set_bit(&mut self.exempt, slot, false);
        set_bit(&mut self.collapsed, slot, false);
        self.removed += 1;
        self.change += 1;
        Ok(())
    }

    /// Moves an instance.
    ///
    /// # Errors
    /// If the handle names no instance.
    pub fn set_transform(
        &mut self,
        handle: Handle,
        transform: Transform,
    ) -> Result<(), SceneError> {
        let slot = self.slot(handle)?;
        self.transforms[slot as usize] = transform;
        self.update_slot(slot);
        self.change += 1;
        Ok(())
    }

    /// Sets the layers of an instance.
    ///
    /// # Errors
    /// If the handle names no instance.
    pub fn set_layers(&mut self, handle: Handle, layers: u32) -> Result<(), SceneError> {
        let slot = self.slot(handle)?;
        self.layers[slot as usize] = layers;
        self.change += 1;
        Ok(())
    }

    /// Sets the flags of an instance.
    ///
    /// # Errors
    /// If the handle names no instance.
    pub fn set_flags(&mut self, handle: Handle, flags: InstanceFlags) -> Result<(), SceneError> {
        let slot = self.slot(handle)?;
        self.flags[slot as usize] = flags;
        self.update_slot(slot);
        self.change += 1;
        Ok(())
    }

    /// Gives an instance bounds of the caller's.
    ///
    /// # Errors
    /// If the handle names no instance.
    pub fn set_bounds(&mut self, handle: Handle, bounds: BoundsOverride) -> Result<(), SceneError> {
        let slot = self.slot(handle)?;
        self.overrides[slot as usize] = bounds;
        self.update_slot(slot);
        self.change += 1;
        Ok(())
    }

    /// Closes the gaps that removed instances left, keeping the order. Returns where each slot went.
    pub fn commit(&mut self) -> Commit {
        let mut slot_of_old = Vec::with_capacity(self.handles.len());
        let mut next = 0u32;
        for old in 0..self.handles.len() {
            if self.is_removed(old as u32) {
                slot_of_old.push(NO_SLOT);
                continue;
            }
            slot_of_old.push(next);
            let new = next as usize;
            if new != old {
                self.mesh[new] = self.mesh[old];
                self.transforms[new] = self.transforms[old];
                self.layers[new] = self.layers[old];
                self.flags[new] = self.flags[old];
                self.overrides[new] = self.overrides[old];
                self.handles[new] = self.handles[old];
                self.entries[self.handles[new].index as usize].1 = next;
            }
            next += 1;
        }
        if next as usize != slot_of_old.len() {
            let len = next as usize;
            self.mesh.truncate(len);
            self.transforms.truncate(len);
            self.layers.truncate(len);
            self.flags.truncate(len);
            self.overrides.truncate(len);
            self.handles.truncate(len);
            self.resize_slot_data();
            (0..next).for_each(|slot| self.update_slot(slot));
            self.removed = 0;
            self.order_version += 1;
            self.change += 1;
        }
        Commit { slot_of_old, order_version: self.order_version }
    }

    /// How many slots there are, empty ones included.
    #[must_use]
    pub fn slot_count(&self) -> u32 {
        self.handles.len() as u32
    }

    /// How many instances there are.
    #[must_use]
    pub fn instance_count(&self) -> u32 {
        self.slot_count() - self.removed
    }

    /// The slots that hold an instance, ascending.
    pub fn slots(&self) -> impl Iterator<Item = u32> {
        (0..self.slot_count()).filter(|&s| !self.is_removed(s))
    }

    /// The slot of an instance.
    ///
    /// # Errors
    /// If the handle names no instance.
    pub fn slot(&self, handle: Handle) -> Result<u32, SceneError> {
        match self.entries.get(handle.index as usize) {
            Some(&(generation, slot)) if generation == handle.generation && slot != NO_SLOT => {
                Ok(slot)
            }
            _ => Err(SceneError::NoInstance(handle)),
        }
    }

    /// The handle of the instance in a slot; `None` for an empty slot or one beyond the last.
    #[must_use]
    pub fn handle(&self, slot: u32) -> Option<Handle> {
        self.handles.get(slot as usize).copied().filter(|h| h.index != NO_SLOT)
    }

    /// Whether the slot's instance was removed.
    #[must_use]
    pub fn is_removed(&self, slot: u32) -> bool {
        self.handles[slot as usize].index == NO_SLOT
    }

    /// The number of the mesh of a slot.
    #[must_use]
    pub fn mesh_id(&self, slot: u32) -> MeshId {
        self.mesh[slot as usize]
    }

    /// The mesh of a slot.
    #[must_use]
    pub fn mesh(&self, slot: u32) -> &Mesh {
        &self.meshes[self.mesh[slot as usize] as usize]
    }

    /// The transform of a slot.
    #[must_use]
    pub fn transform(&self, slot: u32) -> &Transform {
        &self.transforms[slot as usize]
    }

    /// The layers of a slot; 0 for an empty one.
    #[must_use]
    pub fn layers(&self, slot: u32) -> u32 {
        self.layers[slot as usize]
    }

    /// The flags of a slot.
    #[must_use]
    pub fn flags(&self, slot: u32) -> InstanceFlags {
        self.flags[slot as usize]
    }

    /// The bounds of a slot, relative to the origin; [`Aabb::EVERYTHING`] where there are none.
    #[must_use]
    pub fn bounds(&self, slot: u32) -> Aabb {
        self.world_box(slot as usize)
    }

    /// The bounds of all slots, made ready for batch tests.
    #[must_use]
    pub fn boxes(&self) -> &Boxes {
        &self.boxes
    }

    /// One bit a slot: instances that no stage but the layer mask may cull, because they are flagged
    /// so, have no bounds, or have a transform that is not finite.
    #[must_use]
    pub fn exempt(&self) -> &[u64] {
        &self.exempt
    }

    /// One bit a slot: instances without a triangle that has an area, because their mesh has none or
    /// their transform flattens everything to a line or a point.
    #[must_use]
    pub fn collapsed(&self) -> &[u64] {
        &self.collapsed
    }

    /// Whether the instance is drawn just as its mesh says, so that its clusters and triangles may be
    /// culled on their own. Not so where the caller gave bounds (a shader may move the vertices) or
    /// the mesh can deform.
    #[must_use]
    pub fn is_rigid(&self, slot: u32) -> bool {
        self.overrides[slot as usize] == BoundsOverride::Mesh && !self.mesh(slot).is_deformable()
    }

    /// Makes ahead what the culling of back faces needs of every mesh that has an instance with backs to
    /// cull. Without it the first cull that sees a mesh pays: some 70 ns a triangle, and 10 to 35 µs a
    /// cluster (half a second for a million triangles). Nothing for two-sided and for deformable meshes.
    ///
    /// Runs on this thread. To use more, call [`Mesh::prepare`] of [`meshes`](Self::meshes) on them.
    pub fn prepare(&self) {
        for slot in self.slots() {
            if self.is_rigid(slot) && !self.flags(slot).double_sided {
                self.mesh(slot).prepare();
            }
        }
    }

    /// Triangles of all instances, degenerate ones included.
    #[must_use]
    pub fn triangle_count(&self) -> u64 {
        self.slots().map(|s| u64::from(self.mesh(s).triangle_count())).sum()
    }

    /// The box around all bounds that are finite, relative to the origin; empty if there are none.
    #[must_use]
    pub fn extent(&self) -> Aabb {
        self.slots()
            .map(|s| self.bounds(s))
            .filter(Aabb::is_finite)
            .fold(Aabb::EMPTY, |a, b| a.union(&b))
    }

    fn world_box(&self, slot: usize) -> Aabb {
        let transform = &self.transforms[slot];
        let mesh = || {
            let b = self.meshes[self.mesh[slot] as usize].bounds();
            // A mesh without a drawable triangle is somewhere all the same: at its own origin.
            let b = if b.is_empty() { Aabb::new([0.0; 3], [0.0; 3]) } else { b };
            transform.transform_box(&b, self.origin)
        };
        match self.overrides[slot] {
            _ if !transform.is_finite() => Aabb::EVERYTHING,
            BoundsOverride::None => Aabb::EVERYTHING,
            BoundsOverride::Mesh => mesh(),
            BoundsOverride::World(b) => b,
            BoundsOverride::Margin(m) if m.is_nan() => Aabb::EVERYTHING,
            BoundsOverride::Margin(m) => {
                let b = mesh();
                let m = f64::from(m);
                let grow = |v: [f32; 3], by: f64| v.map(|v| f64::from(v) + by);
                Aabb::rounded_out(grow(b.min, -m), grow(b.max, m))
            }
        }
    }

    fn resize_slot_data(&mut self) {
        let slots = self.handles.len();
        self.boxes.resize(slots);
        self.exempt.resize(slots.div_ceil(64), 0);
        self.collapsed.resize(slots.div_ceil(64), 0);
    }

    /// Recomputes what is derived from a slot's transform, flags and override.
    fn update_slot(&mut self, slot: u32) {
        if self.is_removed(slot) {
            return;
        }
        let at = slot as usize;
        let b = self.world_box(at);
        self.boxes.set(at, &b);
        let finite = self.transforms[at].is_finite();
        let no_bounds = self.overrides[at] == BoundsOverride::None || !b.is_finite();
        set_bit(&mut self.exempt, slot, self.flags[at].always_visible || no_bounds || !finite);
        let flat = finite && self.transforms[at].rank() <= 1 && self.is_rigid(slot);
        let nothing = self.mesh(slot).clusters().is_empty();
        set_bit(&mut self.collapsed, slot, flat || nothing);
    }
}

fn set_bit(words: &mut [u64], bit: u32, value: bool) {
    let word = &mut words[bit as usize / 64];
    *word = *word & !(1 << (bit % 64)) | u64::from(value) << (bit % 64);
}
