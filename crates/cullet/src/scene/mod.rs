//! A scene: meshes, and instances of them in dense slots.

use alloc::boxed::Box;
use alloc::vec::Vec;

use crate::bounds::{Aabb, Boxes, LANES};
use crate::hierarchy::{Handle, Hierarchy};
use crate::math;
use crate::mesh::Mesh;
use crate::prepared::Prepared;
use crate::transform::Transform;

mod audit;
mod column;
mod edit;
mod instance;
mod levels;
mod log;
mod meshes;
mod order;
mod stand_ins;
mod tally;

pub use audit::BoundsViolation;
use column::{Bits, Column};
pub use edit::SceneBoundsMut;
pub use instance::{BoundsOverride, Instance, InstanceFlags, MeshId, SceneError, SceneVersion};
pub use levels::MeshLevels;
use log::Log;
pub use log::SceneChange;
pub(crate) use meshes::MeshKind;
pub(crate) use meshes::is_parted;
pub(crate) use stand_ins::{NO_STAND_IN, StandIns};
use tally::Tallies;
pub(crate) use tally::Tally;

/// Meshes shared by instances.
///
/// Instances live in **slots**, dense numbers that every hot array uses; a removed instance leaves
/// an empty slot until [`commit`](Self::commit), which sorts the slots by place: it and
/// [`commit_slice`](Self::commit_slice) are the only calls that move instances between slots. A
/// handle finds its slot, and a slot its handle, in O(1).
///
/// An instance takes some 116 bytes, half of them its transform; [`commit`](Self::commit) takes up
/// to 32 more while it sorts. Flags, bounds, size weights and the caller's numbers take 45 more of
/// every instance, each kind as soon as one instance has other than the default.
#[derive(Debug)]
pub struct Scene {
    id: u64,
    origin: [f64; 3],
    change: u64,
    // Rises when the clusters of a mesh or of its levels may be others.
    mesh_version: u64,
    meshes: Vec<Mesh>,
    // By mesh.
    prepared: Vec<Prepared>,
    kinds: Vec<MeshKind>,
    // Numbers of meshes that were removed, for the next ones.
    /// Descending, so that the least is the last.
    free_meshes: Vec<MeshId>,
    // Empty for meshes beyond the last that has any.
    levels: Vec<Vec<MeshLevels>>,
    // How many levels there are of all meshes.
    level_count: usize,
    // The empty mesh of instances of bounds alone, once there is one.
    no_mesh: Option<MeshId>,
    // By slot.
    mesh: Vec<MeshId>,
    transforms: Vec<Transform>,
    layers: Vec<u32>,
    flags: Column<InstanceFlags>,
    overrides: Column<BoundsOverride>,
    size_weights: Column<f32>,
    user_data: Column<u64>,
    // Totals of instances: by mesh, by word of slots, by mask of layers.
    tallies: Tallies,
    // One bit a slot: no stage but the layer mask may cull it.
    exempt: Bits,
    // One bit a word of `exempt` that may not be zero.
    exempt_words: Vec<u64>,
    // One bit a slot: it has no triangle with an area.
    collapsed: Bits,
    // Bounds, handles, and the order of both.
    hierarchy: Hierarchy,
    // What changed last, for what depends on the scene.
    log: Log,
    // Which instances stand for which others.
    stand_ins: Option<Box<StandIns>>,
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
        Self {
            id: math::unique(),
            origin: [0.0; 3],
            change: 0,
            mesh_version: 0,
            meshes: Vec::new(),
            prepared: Vec::new(),
            kinds: Vec::new(),
            free_meshes: Vec::new(),
            levels: Vec::new(),
            level_count: 0,
            no_mesh: None,
            mesh: Vec::new(),
            transforms: Vec::new(),
            layers: Vec::new(),
            flags: Column::new(InstanceFlags::default()),
            overrides: Column::new(BoundsOverride::Mesh),
            size_weights: Column::new(1.0),
            user_data: Column::new(0),
            tallies: Tallies::default(),
            exempt: Bits::default(),
            exempt_words: Vec::new(),
            collapsed: Bits::default(),
            hierarchy: Hierarchy::new(),
            log: Log::default(),
            stand_ins: None,
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

    /// Versions that slots and clusters of a result belong to: see
    /// [`Visible::version`](crate::Visible::version).
    #[must_use]
    pub fn version(&self) -> SceneVersion {
        SceneVersion { scene: self.id, order: self.order_version(), meshes: self.mesh_version }
    }

    /// All that an answer depends on: with the same it is the same.
    pub(crate) fn versions(&self) -> [u64; 4] {
        // The nodes decide what is tested, so that counts of work depend on how they fit.
        let nodes = self.hierarchy.change_version();
        [self.id, self.mesh_version, self.change, nodes]
    }

    /// Rises with every change of any instance, and where more is prepared of a mesh.
    #[must_use]
    pub fn change_version(&self) -> u64 {
        self.change
    }

    /// The point that bounds are relative to.
    #[must_use]
    pub fn origin(&self) -> [f64; 3] {
        self.origin
    }

    /// How many slots there are, empty ones included.
    #[must_use]
    pub fn slot_count(&self) -> u32 {
        self.hierarchy.slot_count()
    }

    /// How many instances there are, without those that only [stand for others](Self::stand_for).
    #[must_use]
    pub fn instance_count(&self) -> u32 {
        let here = |slot: &u32| !self.is_removed(*slot);
        self.hierarchy.len() - self.stand_in_slots().filter(here).count() as u32
    }

    /// The slots that hold an instance, ascending, without those that only [stand for
    /// others](Self::stand_for).
    pub fn slots(&self) -> impl Iterator<Item = u32> {
        (0..self.slot_count()).filter(|&s| !self.is_removed(s) && !self.is_stand_in(s))
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
    ///
    /// # Panics
    /// If there is no such slot.
    #[must_use]
    pub fn mesh_id(&self, slot: u32) -> MeshId {
        self.mesh[slot as usize]
    }

    /// The mesh of a slot.
    ///
    /// # Panics
    /// If there is no such slot.
    #[must_use]
    pub fn mesh(&self, slot: u32) -> &Mesh {
        &self.meshes[self.mesh[slot as usize] as usize]
    }

    /// The transform of a slot.
    ///
    /// # Panics
    /// If there is no such slot.
    #[must_use]
    pub fn transform(&self, slot: u32) -> &Transform {
        &self.transforms[slot as usize]
    }

    /// The layers of a slot; 0 for an empty one.
    ///
    /// # Panics
    /// If there is no such slot.
    #[must_use]
    pub fn layers(&self, slot: u32) -> u32 {
        self.layers[slot as usize]
    }

    /// The caller's number of a slot; see [`Instance::user_data`].
    ///
    /// # Panics
    /// If there is no such slot.
    #[must_use]
    pub fn user_data(&self, slot: u32) -> u64 {
        self.user_data.get(slot as usize)
    }

    /// Returns the factor by which the size of the instance of `slot` counts; see
    /// [`Instance::size_weight`].
    ///
    /// # Panics
    /// If there is no such slot.
    #[must_use]
    pub fn size_weight(&self, slot: u32) -> f32 {
        self.size_weights.get(slot as usize)
    }

    /// The [weights](Self::size_weight) of up to sixteen slots from one on; `None` where all are 1.
    pub(crate) fn size_weights(&self, first: usize) -> Option<&[f32]> {
        let each = self.size_weights.each()?;
        Some(each.get(first..(first + LANES).min(each.len())).unwrap_or_default())
    }

    /// The largest of the [weights](Self::size_weight) of some slots; infinite where one is never
    /// culled for its size.
    pub(crate) fn largest_size_weight(&self, slots: core::ops::Range<usize>) -> f32 {
        let Some(each) = self.size_weights.each() else { return 1.0 };
        let own = each.get(slots.start..slots.end.min(each.len())).unwrap_or_default();
        own.iter().fold(0.0, |most, &w| if w >= 0.0 { most.max(w) } else { f32::INFINITY })
    }

    /// The flags of a slot.
    ///
    /// # Panics
    /// If there is no such slot.
    #[must_use]
    pub fn flags(&self, slot: u32) -> InstanceFlags {
        self.flags.get(slot as usize)
    }

    /// The bounds of a slot, relative to the origin; [`Aabb::EVERYTHING`] where there are none.
    ///
    /// # Panics
    /// If there is no such slot.
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

    /// One bit a slot: instances that no stage but the layer mask may cull, because they are
    /// flagged so, have no bounds, or have a transform that is not finite.
    #[must_use]
    pub fn exempt(&self) -> &[u64] {
        &self.exempt
    }

    /// The words of [`exempt`](Self::exempt) that may have a bit: one bit a word.
    pub(crate) fn exempt_words(&self) -> &[u64] {
        &self.exempt_words
    }

    /// Totals of all instances.
    pub(crate) fn tally(&self) -> Tally {
        self.tallies.all()
    }

    /// Totals of the instances in any of some layers.
    pub(crate) fn tally_of_layers(&self, layers: u32) -> Tally {
        self.tallies.in_layers(layers)
    }

    /// Totals of the instance of a slot.
    pub(crate) fn tally_of(&self, slot: u32) -> Tally {
        self.tallies.of_mesh(self.mesh_id(slot))
    }

    /// Totals of the instances of some bits of a word of slots; the slots must not be empty.
    pub(crate) fn tally_of_bits(&self, word: usize, bits: u64) -> Tally {
        self.tallies.of_bits(word, bits, self.hierarchy.present()[word], &self.mesh)
    }

    /// Totals of the instances of the bits of some words of slots, from one on; the slots must not
    /// be empty.
    pub(crate) fn tally_of_words(&self, first: usize, bits: &[u64]) -> Tally {
        let present = &self.hierarchy.present()[first..first + bits.len()];
        self.tallies.of_words(first, bits, present, &self.mesh)
    }

    /// One bit a slot: instances without a triangle that has an area, because their mesh has none
    /// or their transform flattens everything to a line or a point.
    #[must_use]
    pub(crate) fn collapsed(&self) -> &[u64] {
        &self.collapsed
    }

    /// Whether the instance is drawn just as its mesh says, so that its clusters and triangles may
    /// be culled on their own. Not so where the caller gave bounds (a shader may move the vertices)
    /// or the mesh can deform.
    ///
    /// # Panics
    /// If there is no such slot.
    #[must_use]
    pub fn is_rigid(&self, slot: u32) -> bool {
        self.overrides.get(slot as usize) == BoundsOverride::Mesh
            && !self.mesh(slot).is_deformable()
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
}
