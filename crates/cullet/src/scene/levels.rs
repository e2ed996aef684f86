//! Levels of detail of a scene's meshes.

use alloc::sync::Arc;
use alloc::vec;
use alloc::vec::Vec;
use core::any::Any;

use super::{MeshId, Scene};
use crate::bounds::Aabb;
use crate::lod::{Group, Levels, LevelsError, Lod, NO_GROUP};
#[cfg(not(feature = "std"))]
use crate::math::Float as _;
use crate::mesh::Mesh;

/// Levels of a mesh, and the mesh of the scene that holds their triangles.
#[derive(Clone, Debug)]
pub struct MeshLevels {
    /// The mesh with the clusters of all levels: one of the scene's, that needs no instance.
    pub mesh: MeshId,
    /// Its levels.
    pub levels: Levels,
    /// Where the mesh is no more than the box of an impostor: the picture of the caller's that is
    /// drawn in it.
    pub impostor: Option<Arc<dyn Any + Send + Sync>>,
    /// The box of the mesh that has them, as it was when they were added.
    bounds: Aabb,
}

impl MeshLevels {
    /// Whether they may be chosen with these settings.
    pub(crate) fn is_used(&self, lod: &Lod) -> bool {
        lod.impostors || self.impostor.is_none()
    }
}

impl Scene {
    /// Gives a mesh levels of detail, which are clusters of another mesh of the scene, in the same
    /// space: [`Culler::lod`](crate::Culler::lod) then draws those in place of the mesh's own. A
    /// mesh may have several, such as a chain of whole meshes and a hierarchy of clusters: of those
    /// the one with the fewest triangles is drawn. They are numbered from 1 in the order in which
    /// they were added, 0 being the mesh itself.
    ///
    /// Both meshes should have the same parts: sides and materials that are drawn are those of
    /// `held_by`. Levels go when [`edit_meshes`](Self::edit_meshes) gives the mesh that holds them
    /// another number of clusters.
    ///
    /// # Errors
    /// If one of the meshes is not there, or levels and mesh do not fit.
    pub fn add_levels(
        &mut self,
        mesh: MeshId,
        held_by: MeshId,
        levels: Levels,
    ) -> Result<(), LevelsError> {
        let meshes = self.meshes.len();
        for mesh in [mesh, held_by] {
            self.find_mesh(mesh).map_err(|_| LevelsError::NoMesh { mesh, meshes })?;
        }
        levels.check(&self.meshes[held_by as usize])?;
        self.levels.resize_with(meshes, Vec::new);
        let bounds = self.meshes[mesh as usize].bounds();
        let added = MeshLevels { mesh: held_by, levels, impostor: None, bounds };
        self.levels[mesh as usize].push(added);
        self.level_count += 1;
        self.change += 1;
        self.mesh_version += 1;
        Ok(())
    }

    /// Gives a mesh a coarser one to be drawn in its place where the eye is far enough: another
    /// mesh of the scene, in the same space, no point of which is farther than `error` from the
    /// surface of `mesh`, in units of the mesh, nor the other way round. Call it once for each
    /// level of a chain, in any order. For parts and sides see [`add_levels`](Self::add_levels).
    ///
    /// # Errors
    /// If one of the meshes is not there, `coarse` has degenerate triangles, or `error` is negative
    /// or not finite.
    pub fn add_lod(&mut self, mesh: MeshId, coarse: MeshId, error: f32) -> Result<(), LevelsError> {
        let meshes = self.meshes.len();
        let find = |mesh: MeshId| match self.find_mesh(mesh) {
            Ok(()) => Ok(&self.meshes[mesh as usize]),
            Err(_) => Err(LevelsError::NoMesh { mesh, meshes }),
        };
        let (fine, held) = (find(mesh)?, find(coarse)?);
        let around = fine.bounds().union(&held.bounds());
        let group = match around.is_empty() {
            true => Group { error, ..Group::default() },
            false => {
                let (centre, half) = (around.center(), around.half_extent());
                // Rounded up, with room for the rounding of the centre.
                let diagonal = half.iter().map(|h| h * h).sum::<f64>().sqrt();
                let size = centre.iter().map(|c| c.abs()).fold(diagonal, f64::max);
                let radius = (diagonal + size * 1e-6) as f32;
                Group { centre: centre.map(|c| c as f32), radius, error }
            }
        };
        let clusters = held.clusters().len();
        let levels = Levels::new(held, &[group], vec![0; clusters], vec![NO_GROUP; clusters])?;
        self.add_levels(mesh, coarse, levels)
    }

    /// Gives a mesh an impostor as one more of its levels: `held_by`, such as a box around it, goes
    /// through culling in its place where the error of `levels` is small enough, and a renderer
    /// draws `picture` there, which is its own affair and comes back as [`MeshLevels::impostor`].
    /// `cullet-mesh` has a picture from all around.
    ///
    /// [`Lod::impostors`] says whether it may be chosen. It goes as other levels do, and when the
    /// box of the mesh changes.
    ///
    /// # Errors
    /// As [`add_levels`](Self::add_levels).
    pub fn add_impostor(
        &mut self,
        mesh: MeshId,
        held_by: MeshId,
        levels: Levels,
        picture: Arc<dyn Any + Send + Sync>,
    ) -> Result<(), LevelsError> {
        self.add_levels(mesh, held_by, levels)?;
        if let Some(last) = self.levels[mesh as usize].last_mut() {
            last.impostor = Some(picture);
        }
        Ok(())
    }

    /// Takes the levels of a mesh away.
    pub fn clear_levels(&mut self, mesh: MeshId) {
        if let Some(levels) = self.levels.get_mut(mesh as usize) {
            self.level_count -= levels.len();
            levels.clear();
            self.change += 1;
            self.mesh_version += 1;
        }
    }

    /// Whether any mesh has levels.
    pub(crate) fn has_levels(&self) -> bool {
        self.level_count > 0
    }

    /// The levels of a mesh, in the order of their numbers, from 1.
    #[must_use]
    pub fn levels(&self, mesh: MeshId) -> &[MeshLevels] {
        self.levels.get(mesh as usize).map_or(&[], Vec::as_slice)
    }

    /// The number of the mesh that is drawn for a slot at a level of a
    /// [`DrawRange`](crate::draw::DrawRange): its own at level 0, and where there is no such level.
    ///
    /// # Panics
    /// If there is no such slot.
    #[must_use]
    pub fn mesh_id_at(&self, slot: u32, level: u32) -> MeshId {
        let own = self.mesh_id(slot);
        let levels = level.checked_sub(1).and_then(|at| self.levels(own).get(at as usize));
        levels.map_or(own, |levels| levels.mesh)
    }

    /// The mesh that is drawn for a slot at a level; see [`mesh_id_at`](Self::mesh_id_at).
    ///
    /// # Panics
    /// If there is no such slot.
    #[must_use]
    pub fn mesh_at(&self, slot: u32, level: u32) -> &Mesh {
        &self.meshes[self.mesh_id_at(slot, level) as usize]
    }

    /// Forgets levels that no longer fit the mesh that holds them, and impostors of a mesh that is
    /// no longer in their box.
    pub(super) fn drop_stale_levels(&mut self) {
        for (own, levels) in self.meshes.iter().zip(&mut self.levels) {
            levels.retain(|l| {
                let is_of_own = l.impostor.is_none() || l.bounds == own.bounds();
                is_of_own && l.levels.check(&self.meshes[l.mesh as usize]).is_ok()
            });
        }
        self.level_count = self.levels.iter().map(Vec::len).sum();
    }
}
