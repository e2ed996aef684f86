//! A scene: meshes, and instances of them in dense slots.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::bits;
use crate::bounds::{Aabb, Boxes};
use crate::cull::occlusion::Occluder;
use crate::hierarchy::{Commit, Handle, Hierarchy, NO_SLOT};
use crate::mesh::Mesh;
use crate::prepared::{Preparation, Prepared, add_all};
use crate::transform::Transform;

mod audit;
mod instance;
mod tally;

pub use audit::Stray;
pub use instance::{BoundsOverride, Instance, InstanceFlags, MeshId, SceneError};
use tally::Tallies;
pub(crate) use tally::Tally;

/// Meshes shared by instances.
///
/// Instances live in **slots**, dense numbers that every hot array uses; a removed instance leaves an
/// empty slot until [`commit`](Self::commit), which sorts the slots by place: it and
/// [`commit_slice`](Self::commit_slice) are the only calls that move instances between slots.
/// A handle finds its slot, and a slot its handle, in O(1).
#[derive(Debug)]
pub struct Scene {
    id: u64,
    origin: [f64; 3],
    change: u64,
    meshes: Vec<Mesh>,
    // By mesh.
    prepared: Vec<Prepared>,
    // By slot.
    mesh: Vec<MeshId>,
    transforms: Vec<Transform>,
    layers: Vec<u32>,
    flags: Vec<InstanceFlags>,
    overrides: Vec<BoundsOverride>,
    users: Vec<u64>,
    // What instances hold: by mesh, by word of slots, by mask of layers.
    tallies: Tallies,
    // One bit a slot: no stage but the layer mask may cull it.
    exempt: Vec<u64>,
    // One bit a word of `exempt` that may not be zero.
    exempt_words: Vec<u64>,
    // One bit a slot: it has no triangle with an area.
    collapsed: Vec<u64>,
    // Bounds, handles, and the order of both.
    hierarchy: Hierarchy,
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
            change: 0,
            meshes: Vec::new(),
            prepared: Vec::new(),
            mesh: Vec::new(),
            transforms: Vec::new(),
            layers: Vec::new(),
            flags: Vec::new(),
            overrides: Vec::new(),
            users: Vec::new(),
            tallies: Tallies::default(),
            exempt: Vec::new(),
            exempt_words: Vec::new(),
            collapsed: Vec::new(),
            hierarchy: Hierarchy::new(),
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
        self.hierarchy.order_version()
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
        self.hierarchy.refit();
        self.change += 1;
    }

    /// Adds a mesh that instances may share. What culling needs of it is made by the next [`commit`](Self::commit) or
    /// [`prepare`](Self::prepare); until then stages keep what they cannot test.
    pub fn add_mesh(&mut self, mesh: Mesh) -> MeshId {
        self.add_prepared_mesh(mesh, Prepared::default())
    }

    /// Adds a mesh with what was prepared of it before, by jobs or by a bake.
    pub fn add_prepared_mesh(&mut self, mesh: Mesh, prepared: Prepared) -> MeshId {
        self.tallies.add_mesh(&mesh);
        self.meshes.push(mesh);
        self.prepared.push(prepared);
        (self.meshes.len() - 1) as MeshId
    }

    /// All meshes.
    #[must_use]
    pub fn meshes(&self) -> &[Mesh] {
        &self.meshes
    }

    /// What is prepared of each mesh.
    #[must_use]
    pub fn prepared(&self) -> &[Prepared] {
        &self.prepared
    }

    /// What is prepared of the mesh of a slot.
    #[must_use]
    pub fn prepared_of(&self, slot: u32) -> &Prepared {
        &self.prepared[self.mesh[slot as usize] as usize]
    }

    /// Gives a mesh what was prepared of it elsewhere: by jobs, by a bake or from a file. Nothing if there is no such
    /// mesh.
    pub fn set_prepared(&mut self, mesh: MeshId, prepared: Prepared) {
        if let Some(own) = self.prepared.get_mut(mesh as usize) {
            *own = prepared;
            self.change += 1;
        }
    }

    /// Gives a mesh an occluder, such as one that was baked: its shapes must lie within what the mesh hides. Nothing
    /// if there is no such mesh.
    pub fn set_occluder(&mut self, mesh: MeshId, occluder: Occluder) {
        if let Some(own) = self.prepared.get_mut(mesh as usize) {
            *own = std::mem::take(own).with_occluder(occluder);
            self.change += 1;
        }
    }

    /// Calls `edit` with every mesh, to change its sides or to put another in its place. Bounds and counts of the
    /// instances of a mesh that came out with others follow: O(instances), once for all meshes. What had been
    /// prepared of a mesh is made anew; an occluder that was given is to be given again.
    pub fn edit_meshes(&mut self, mut edit: impl FnMut(MeshId, &mut Mesh)) {
        self.edit_meshes_of(0..self.meshes.len(), &mut edit);
    }

    /// As [`edit_meshes`](Self::edit_meshes), of one mesh; nothing if there is no such mesh.
    pub fn edit_mesh(&mut self, mesh: MeshId, edit: impl FnOnce(&mut Mesh)) {
        let at = mesh as usize;
        if at < self.meshes.len() {
            let mut edit = Some(edit);
            self.edit_meshes_of(at..at + 1, &mut |_, mesh| {
                if let Some(edit) = edit.take() {
                    edit(mesh);
                }
            });
        }
    }

    fn edit_meshes_of(
        &mut self,
        range: std::ops::Range<usize>,
        edit: &mut dyn FnMut(MeshId, &mut Mesh),
    ) {
        let mut changed = vec![false; self.meshes.len()];
        for at in range {
            let mesh = &mut self.meshes[at];
            let bounds = mesh.bounds();
            edit(at as MeshId, mesh);
            let made = self.prepared[at].made();
            self.prepared[at] = Prepared::of(mesh, made);
            changed[at] = self.tallies.set_mesh(at, mesh) || mesh.bounds() != bounds;
        }
        if changed.contains(&true) {
            let present = self.hierarchy.present();
            self.tallies.recount(0..present.len(), &self.mesh, present);
            self.tallies.recount_layers(&self.mesh, &self.layers, present);
            for slot in 0..self.slot_count() {
                if changed[self.mesh[slot as usize] as usize] {
                    self.update_slot(slot);
                }
            }
            self.hierarchy.refit();
        }
        self.change += 1;
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
        let handle = self.hierarchy.insert(&Aabb::EMPTY)?;
        self.mesh.push(instance.mesh);
        self.transforms.push(instance.transform);
        self.layers.push(instance.layers);
        self.flags.push(instance.flags);
        self.overrides.push(instance.bounds);
        self.users.push(instance.user);
        self.tallies.add(self.mesh.len() - 1, instance.mesh, instance.layers);
        self.exempt.resize(self.mesh.len().div_ceil(64), 0);
        self.exempt_words.resize(self.exempt.len().div_ceil(64), 0);
        self.collapsed.resize(self.mesh.len().div_ceil(64), 0);
        self.update_slot(self.slot_count() - 1);
        self.change += 1;
        Ok(handle)
    }

    /// Removes an instance. Its slot stays empty until [`commit`](Self::commit).
    ///
    /// # Errors
    /// If the handle names no instance.
    pub fn remove(&mut self, handle: Handle) -> Result<(), SceneError> {
        let slot = self.slot(handle)?;
        self.hierarchy.remove(handle)?;
        let at = slot as usize;
        self.tallies.remove(at, self.mesh[at], self.layers[at]);
        self.layers[slot as usize] = 0;
        self.flags[slot as usize] = InstanceFlags::default();
        bits::set(&mut self.exempt, slot as usize, false);
        bits::set(&mut self.collapsed, slot as usize, false);
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
        let at = slot as usize;
        self.tallies.change_layers(self.mesh[at], self.layers[at], layers);
        self.layers[at] = layers;
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

    /// Sets the caller's number of an instance.
    ///
    /// # Errors
    /// If the handle names no instance.
    pub fn set_user(&mut self, handle: Handle, user: u64) -> Result<(), SceneError> {
        let slot = self.slot(handle)?;
        self.users[slot as usize] = user;
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

    /// Bounds in world space of many instances, written straight to their slots: for what the caller moves by
    /// means of its own (see [`BoundsOverride::World`]). Dropping it fits all nodes again, about 1 ms for a
    /// million instances.
    pub fn bounds_mut(&mut self) -> SceneBoundsMut<'_> {
        SceneBoundsMut { scene: self }
    }

    /// Fits the nodes of the hierarchy to what moved since the last time: makes the next cull faster,
    /// never different. The cost is that of what moved.
    pub fn refit(&mut self) {
        self.hierarchy.refit();
    }

    /// Sorts the slots by place, those of [dynamic](InstanceFlags::dynamic) instances after all others, and
    /// closes the gaps that removed instances left. Returns where each slot went. O(instances). Call it after
    /// loading, and again after much was added or moved far.
    ///
    /// Then [prepares](Self::prepare) the meshes that came since, for back faces and occlusion.
    pub fn commit(&mut self) -> Commit {
        self.prepare(Preparation::default());
        self.sort()
    }

    /// The part of [`commit`](Self::commit) that sorts, without preparing any mesh.
    pub fn sort(&mut self) -> Commit {
        let flags = &self.flags;
        let commit = self.hierarchy.commit_parts(|slot| flags[slot as usize].dynamic);
        let len = self.hierarchy.slot_count() as usize;
        let mut from = vec![0; len];
        for (old, &new) in commit.slot_of_old.iter().enumerate() {
            if new != NO_SLOT {
                from[new as usize] = old as u32;
            }
        }
        gather(&mut self.mesh, &from);
        gather(&mut self.transforms, &from);
        gather(&mut self.layers, &from);
        gather(&mut self.flags, &from);
        gather(&mut self.overrides, &from);
        gather(&mut self.users, &from);
        gather_bits(&mut self.exempt, &from);
        gather_bits(&mut self.collapsed, &from);
        self.note_exempt();
        let present = self.hierarchy.present();
        self.tallies.recount(0..present.len(), &self.mesh, present);
        self.change += 1;
        commit
    }

    /// As [`commit`](Self::commit), without sorting: for a scene whose instances were added in the order of the slots
    /// of one that was committed. The slots stay as they are, and no mesh is prepared. See
    /// [`Hierarchy::commit_in_order`].
    pub fn commit_in_order(&mut self) {
        self.hierarchy.commit_in_order();
        self.note_exempt();
        self.change += 1;
    }

    /// Sorts some of the slots: call it once or more a frame where much moves, so that the order does not
    /// decay and no frame waits for a [`commit`](Self::commit). Returns the slots that changed, as old and
    /// new. See [`Hierarchy::commit_slice`].
    pub fn commit_slice(&mut self) -> Vec<[u32; 2]> {
        let moves = self.hierarchy.commit_slice();
        rearrange(&mut self.mesh, &moves);
        rearrange(&mut self.transforms, &moves);
        rearrange(&mut self.layers, &moves);
        rearrange(&mut self.flags, &moves);
        rearrange(&mut self.overrides, &moves);
        rearrange(&mut self.users, &moves);
        rearrange_bits(&mut self.exempt, &moves);
        rearrange_bits(&mut self.collapsed, &moves);
        let mut words: Vec<usize> =
            moves.iter().flatten().map(|&slot| slot as usize / 64).collect();
        words.sort_unstable();
        words.dedup();
        self.tallies.recount(words.into_iter(), &self.mesh, self.hierarchy.present());
        for &[_, slot] in &moves {
            if bits::get(&self.exempt, slot as usize) {
                bits::set(&mut self.exempt_words, slot as usize / 64, true);
            }
        }
        self.change += u64::from(!moves.is_empty());
        moves
    }

    /// How many slots there are, empty ones included.
    #[must_use]
    pub fn slot_count(&self) -> u32 {
        self.hierarchy.slot_count()
    }

    /// How many instances there are.
    #[must_use]
    pub fn instance_count(&self) -> u32 {
        self.hierarchy.len()
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
        Ok(self.hierarchy.slot(handle)?)
    }

    /// The handle of the instance in a slot; `None` for an empty slot or one beyond the last.
    #[must_use]
    pub fn handle(&self, slot: u32) -> Option<Handle> {
        self.hierarchy.handle(slot)
    }

    /// Whether the slot's instance was removed.
    #[must_use]
    pub fn is_removed(&self, slot: u32) -> bool {
        self.hierarchy.handle(slot).is_none()
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

    /// The caller's number of a slot; see [`Instance::user`].
    #[must_use]
    pub fn user(&self, slot: u32) -> u64 {
        self.users[slot as usize]
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
        self.hierarchy.boxes()
    }

    /// The hierarchy over the slots.
    #[must_use]
    pub fn hierarchy(&self) -> &Hierarchy {
        &self.hierarchy
    }

    /// One bit a slot: instances that no stage but the layer mask may cull, because they are flagged
    /// so, have no bounds, or have a transform that is not finite.
    #[must_use]
    pub fn exempt(&self) -> &[u64] {
        &self.exempt
    }

    /// The words of [`exempt`](Self::exempt) that may have a bit, ascending.
    pub(crate) fn exempt_words(&self) -> impl Iterator<Item = usize> + '_ {
        bits::in_words(&self.exempt_words)
    }

    /// What all instances hold.
    pub(crate) fn tally(&self) -> Tally {
        self.tallies.all()
    }

    /// What the instances in any of some layers hold.
    pub(crate) fn tally_of_layers(&self, layers: u32) -> Tally {
        self.tallies.in_layers(layers)
    }

    /// What the instance of a slot holds.
    pub(crate) fn tally_of(&self, slot: u32) -> Tally {
        self.tallies.of_mesh(self.mesh_id(slot))
    }

    /// What the instances of some bits of a word of slots hold; the slots must not be empty.
    pub(crate) fn tally_of_bits(&self, word: usize, bits: u64) -> Tally {
        self.tallies.of_bits(word, bits, self.hierarchy.present()[word], &self.mesh)
    }

    /// One bit a slot: instances without a triangle that has an area, because their mesh has none or
    /// their transform flattens everything to a line or a point.
    #[must_use]
    pub(crate) fn collapsed(&self) -> &[u64] {
        &self.collapsed
    }

    /// Whether the instance is drawn just as its mesh says, so that its clusters and triangles may be
    /// culled on their own. Not so where the caller gave bounds (a shader may move the vertices) or
    /// the mesh can deform.
    #[must_use]
    pub fn is_rigid(&self, slot: u32) -> bool {
        self.overrides[slot as usize] == BoundsOverride::Mesh && !self.mesh(slot).is_deformable()
    }

    /// Makes what is wanted of every mesh, and not yet there. Nothing of it for two-sided and for deformable meshes; see
    /// [`Prepared::of`] for the cost.
    ///
    /// Runs on this thread; with the feature `rayon` on the threads of its pool. To use others, make [`Prepared::of`] each
    /// mesh on them and hand it to [`set_prepared`](Self::set_prepared).
    pub fn prepare(&mut self, wanted: Preparation) {
        add_all(&mut self.prepared, &self.meshes, wanted);
    }

    /// Triangles of all instances, degenerate ones included. O(different masks of layers).
    #[must_use]
    pub fn triangle_count(&self) -> u64 {
        self.tallies.all().counts.triangles
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

    /// Notes which words of `exempt` are not zero.
    fn note_exempt(&mut self) {
        self.exempt_words.clear();
        self.exempt_words.resize(self.exempt.len().div_ceil(64), 0);
        for (word, &bits) in self.exempt.iter().enumerate() {
            bits::set(&mut self.exempt_words, word, bits != 0);
        }
    }

    /// Recomputes what is derived from a slot's transform, flags and override.
    fn update_slot(&mut self, slot: u32) {
        if self.is_removed(slot) {
            return;
        }
        let at = slot as usize;
        let b = self.world_box(at);
        self.hierarchy.set_slot(at, &b);
        let finite = self.transforms[at].is_finite();
        let no_bounds = self.overrides[at] == BoundsOverride::None || !b.is_finite();
        let exempt = self.flags[at].always_visible || no_bounds || !finite;
        bits::set(&mut self.exempt, at, exempt);
        if exempt {
            bits::set(&mut self.exempt_words, at / 64, true);
        }
        let flat = finite && self.transforms[at].rank() <= 1 && self.is_rigid(slot);
        let nothing = self.mesh(slot).clusters().is_empty();
        bits::set(&mut self.collapsed, at, flat || nothing);
    }
}

/// The bounds of a [`Scene`], to be written in place.
#[derive(Debug)]
pub struct SceneBoundsMut<'a> {
    scene: &'a mut Scene,
}

impl SceneBoundsMut<'_> {
    /// Gives the instance of a slot this box, relative to the scene's origin, in place of its mesh's. An
    /// empty slot stays empty.
    ///
    /// # Panics
    /// If there is no such slot.
    pub fn set(&mut self, slot: u32, bounds: &Aabb) {
        let scene = &mut *self.scene;
        let at = slot as usize;
        let known = matches!(scene.overrides[at], BoundsOverride::World(_));
        scene.overrides[at] = BoundsOverride::World(*bounds);
        if scene.is_removed(slot) {
            return;
        }
        if known && bounds.is_finite() && !scene.flags[at].always_visible {
            // Neither exempt nor collapsed, if it was not: that is worked out once.
            scene.hierarchy.write(at, bounds);
            if !bits::get(&scene.exempt, at) {
                return;
            }
        }
        scene.update_slot(slot);
    }
}

impl Drop for SceneBoundsMut<'_> {
    fn drop(&mut self) {
        self.scene.hierarchy.refit_all();
        self.scene.change += 1;
    }
}

/// Puts `values[from[i]]` at i.
fn gather<T: Copy>(values: &mut Vec<T>, from: &[u32]) {
    *values = from.iter().map(|&old| values[old as usize]).collect();
}

fn gather_bits(words: &mut Vec<u64>, from: &[u32]) {
    let mut new = vec![0; from.len().div_ceil(64)];
    for (to, &old) in from.iter().enumerate() {
        bits::set(&mut new, to, bits::get(words, old as usize));
    }
    *words = new;
}

/// Moves values from old places to new ones, all at once.
fn rearrange<T: Copy>(values: &mut [T], moves: &[[u32; 2]]) {
    let moved: Vec<_> = moves.iter().map(|m| values[m[0] as usize]).collect();
    moves.iter().zip(moved).for_each(|(m, v)| values[m[1] as usize] = v);
}

fn rearrange_bits(words: &mut [u64], moves: &[[u32; 2]]) {
    let moved: Vec<_> = moves.iter().map(|m| bits::get(words, m[0] as usize)).collect();
    moves.iter().zip(moved).for_each(|(m, v)| bits::set(words, m[1] as usize, v));
}
