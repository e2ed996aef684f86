//! The meshes of a scene, and what is prepared of them.

use alloc::vec;
use alloc::vec::Vec;

use super::{MeshId, Scene, SceneError};
use crate::cull::backface::Facing;
use crate::cull::occlusion::Occluder;
use crate::mesh::{MAX_CLUSTER_TRIANGLES, Mesh};
use crate::prepared::{Preparation, Prepared, add_all};

/// The fewest triangles of a mesh of which clusters are culled by themselves, as many as two
/// clusters hold. Of less so little goes that finding it costs more than drawing it.
const LEAST_PARTED: u32 = 2 * MAX_CLUSTER_TRIANGLES as u32;

/// Whether it pays to cull the clusters of a mesh by themselves.
pub(crate) fn is_parted(mesh: &Mesh) -> bool {
    mesh.triangle_count() > LEAST_PARTED
}

/// Facts of a mesh that decide whether its instances are drawn whole: a byte for each mesh, so that
/// scenes of as many meshes as instances need not read the meshes themselves in every frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MeshKind(u8);

impl MeshKind {
    const PARTED: u8 = 1;
    const BACKS: u8 = 2;
    const FRONTS: u8 = 4;

    fn of(mesh: &Mesh, prepared: &Prepared) -> Self {
        let has_sides = !mesh.is_two_sided() && !mesh.is_deformable();
        let has = |facing| has_sides && prepared.cluster_cones(facing).is_some();
        let bit = |is_set: bool, bit: u8| if is_set { bit } else { 0 };
        Self(
            bit(is_parted(mesh), Self::PARTED)
                | bit(has(Facing::Back), Self::BACKS)
                | bit(has(Facing::Front), Self::FRONTS),
        )
    }

    /// Whether it [pays](is_parted) to cull the clusters of the mesh by themselves.
    pub(crate) fn is_parted(self) -> bool {
        self.0 & Self::PARTED != 0
    }

    /// Whether some cluster of an instance of the mesh may show an eye nothing but the side that is
    /// culled.
    pub(crate) fn may_be_culled(self, culled: Facing) -> bool {
        let side = if culled == Facing::Front { Self::FRONTS } else { Self::BACKS };
        self.0 & side != 0
    }
}

impl Scene {
    /// Returns the facts of each mesh that decide whether its instances are drawn whole.
    pub(crate) fn mesh_kinds(&self) -> &[MeshKind] {
        &self.kinds
    }

    /// Adds a mesh that instances may share. What culling needs of it is made by the next
    /// [`commit`](Self::commit) or [`prepare`](Self::prepare); until then stages keep what they
    /// cannot test.
    pub fn add_mesh(&mut self, mesh: Mesh) -> MeshId {
        self.add_prepared_mesh(mesh, Prepared::default())
    }

    /// Adds a mesh with what was prepared of it before, by jobs or by a bake.
    pub fn add_prepared_mesh(&mut self, mesh: Mesh, prepared: Prepared) -> MeshId {
        if let Some(id) = self.free_meshes.pop() {
            self.put_mesh(id as usize, mesh, prepared);
            // What is kept of meshes elsewhere is by their numbers.
            self.change += 1;
            self.mesh_version += 1;
            return id;
        }
        self.tallies.add_mesh(&mesh);
        self.kinds.push(MeshKind::of(&mesh, &prepared));
        self.meshes.push(mesh);
        self.prepared.push(prepared);
        (self.meshes.len() - 1) as MeshId
    }

    /// Removes a mesh without instances, with its levels and those that it holds, and returns it. The
    /// memory is given back, and the next mesh that is added gets its number. O(slots).
    ///
    /// # Errors
    /// If there is no such mesh, or an instance has it.
    pub fn remove_mesh(&mut self, mesh: MeshId) -> Result<Mesh, SceneError> {
        self.find_mesh(mesh)?;
        let is_of = |slot: &u32| self.mesh[*slot as usize] == mesh;
        if let Some(instance) = (0..self.slot_count()).filter(is_of).find_map(|s| self.handle(s)) {
            return Err(SceneError::MeshInUse { mesh, instance });
        }
        self.no_mesh = self.no_mesh.filter(|no_mesh| *no_mesh != mesh);
        self.clear_levels(mesh);
        let removed = self.put_mesh(mesh as usize, Mesh::default(), Prepared::default());
        let at = self.free_meshes.partition_point(|&free| free > mesh);
        self.free_meshes.insert(at, mesh);
        // Others lose the levels that it held.
        let mut edited = vec![false; self.meshes.len()];
        for (edited, levels) in edited.iter_mut().zip(&self.levels) {
            *edited = levels.iter().any(|levels| levels.mesh == mesh);
        }
        self.leave_stand_ins_of(&edited);
        self.drop_stale_levels();
        self.change += 1;
        self.mesh_version += 1;
        Ok(removed)
    }

    /// Puts a mesh in the place of one without instances, and returns that.
    fn put_mesh(&mut self, at: usize, mesh: Mesh, prepared: Prepared) -> Mesh {
        self.tallies.set_mesh(at, &mesh);
        self.kinds[at] = MeshKind::of(&mesh, &prepared);
        self.prepared[at] = prepared;
        core::mem::replace(&mut self.meshes[at], mesh)
    }

    /// Returns an error unless there is a mesh of this number.
    pub(super) fn find_mesh(&self, mesh: MeshId) -> Result<(), SceneError> {
        let meshes = self.meshes.len();
        if (mesh as usize) < meshes && !self.free_meshes.contains(&mesh) {
            return Ok(());
        }
        Err(SceneError::NoMesh { mesh, meshes })
    }

    /// All meshes by their numbers; an empty one for each number that a
    /// [removed](Self::remove_mesh) mesh left.
    #[must_use]
    pub fn meshes(&self) -> &[Mesh] {
        &self.meshes
    }

    /// Data prepared of each mesh.
    #[must_use]
    pub fn prepared(&self) -> &[Prepared] {
        &self.prepared
    }

    /// Data prepared of the mesh of a slot.
    ///
    /// # Panics
    /// If there is no such slot.
    #[must_use]
    pub fn prepared_of(&self, slot: u32) -> &Prepared {
        &self.prepared[self.mesh[slot as usize] as usize]
    }

    /// Gives a mesh an occluder, such as one that was baked: its shapes must lie within what the
    /// mesh hides. Nothing if there is no such mesh.
    pub fn set_occluder(&mut self, mesh: MeshId, occluder: Occluder) {
        if self.find_mesh(mesh).is_ok() {
            let own = &mut self.prepared[mesh as usize];
            *own = core::mem::take(own).with_occluder(occluder);
            self.change += 1;
        }
    }

    /// Calls `edit` with every mesh, to change its sides or to put another in its place. Returns
    /// the meshes that lost an occluder that was [given](Self::set_occluder).
    ///
    /// Where a mesh came out changed, what had been prepared of it is made anew, as by
    /// [`prepare`](Self::prepare); an occluder that was given may stand for what the mesh no longer
    /// hides, so one of the new mesh takes its place. Bounds and counts of its instances follow:
    /// O(instances), once for all meshes. Meshes that came out as they were cost nothing, and keep
    /// all that they have.
    pub fn edit_meshes(&mut self, mut edit: impl FnMut(MeshId, &mut Mesh)) -> Vec<MeshId> {
        self.edit_meshes_of(0..self.meshes.len(), &mut edit)
    }

    /// Edits one mesh, as [`edit_meshes`](Self::edit_meshes) edits all. Returns whether it lost an
    /// occluder that was given. Does nothing if there is no such mesh.
    pub fn edit_mesh(&mut self, mesh: MeshId, edit: impl FnOnce(&mut Mesh)) -> bool {
        let at = mesh as usize;
        let mut edit = Some(edit);
        at < self.meshes.len()
            && !self
                .edit_meshes_of(at..at + 1, &mut |_, mesh| {
                    if let Some(edit) = edit.take() {
                        edit(mesh);
                    }
                })
                .is_empty()
    }

    fn edit_meshes_of(
        &mut self,
        range: core::ops::Range<usize>,
        edit: &mut dyn FnMut(MeshId, &mut Mesh),
    ) -> Vec<MeshId> {
        let mut lost = Vec::new();
        let (mut edited, mut counts_change) = (vec![false; self.meshes.len()], false);
        for at in range {
            if self.free_meshes.contains(&(at as MeshId)) {
                continue;
            }
            let mesh = &mut self.meshes[at];
            let (revision, bounds) = (mesh.revision(), mesh.bounds());
            edit(at as MeshId, mesh);
            if mesh.revision() == revision {
                continue;
            }
            edited[at] = true;
            lost.extend(self.prepared[at].given_occluder().map(|_| at as MeshId));
            let made = self.prepared[at].made();
            self.prepared[at] = Prepared::of(mesh, made);
            self.kinds[at] = MeshKind::of(mesh, &self.prepared[at]);
            counts_change |= self.tallies.set_mesh(at, mesh) || mesh.bounds() != bounds;
        }
        if !edited.contains(&true) {
            return lost;
        }
        self.leave_stand_ins_of(&edited);
        if counts_change {
            let present = self.hierarchy.present();
            self.tallies.recount(0..present.len(), &self.mesh, present);
            let stands = self.stand_ins.as_deref();
            let has_left = |slot: usize| stands.is_some_and(|s| s.has(slot));
            self.tallies.recount_layers(&self.mesh, &self.layers, present, has_left);
            for slot in 0..self.slot_count() {
                if edited[self.mesh[slot as usize] as usize] {
                    self.update_slot(slot);
                }
            }
            self.hierarchy.refit();
        }
        self.drop_stale_levels();
        self.change += 1;
        self.mesh_version += 1;
        lost
    }

    /// Makes what is wanted of every mesh, and not yet there. Nothing of it for two-sided and for
    /// deformable meshes; see [`Prepared::of`] for the cost.
    ///
    /// Runs on this thread; with the feature `rayon` on the threads of its pool. To use others,
    /// make [`Prepared::of`] each mesh on them and hand it to
    /// [`add_prepared_mesh`](Self::add_prepared_mesh) with the mesh.
    pub fn prepare(&mut self, wanted: impl Into<Preparation>) {
        let wanted = wanted.into();
        if self.prepared.iter().all(|prepared| prepared.made().and(wanted) == prepared.made()) {
            return;
        }
        self.change += 1;
        add_all(&mut self.prepared, &self.meshes, wanted);
        let meshes = self.meshes.iter().zip(&self.prepared);
        self.kinds = meshes.map(|(mesh, prepared)| MeshKind::of(mesh, prepared)).collect();
    }
}
