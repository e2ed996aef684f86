//! Levels of detail of a scene's meshes.

use super::{MeshId, Scene};
use crate::lod::{Levels, LevelsError};
use crate::mesh::Mesh;

/// Levels of a mesh, and the mesh of the scene that holds their triangles.
#[derive(Clone, Debug)]
pub struct MeshLevels {
    /// The mesh with the clusters of all levels: one of the scene's, that needs no instance.
    pub mesh: MeshId,
    /// Its levels.
    pub levels: Levels,
}

impl Scene {
    /// Gives a mesh levels of detail, which are clusters of another mesh of the scene, in the same space:
    /// [`Culler::lod`](crate::Culler::lod) then draws those in place of the mesh's own. A mesh may have several, such as a
    /// chain of whole meshes and a hierarchy of clusters: of those the one with the fewest triangles is drawn.
    /// They are numbered from 1 in the order in which they were added, 0 being the mesh itself.
    ///
    /// Both meshes should have the same parts: sides and materials that are drawn are those of `held_by`. Levels go when
    /// [`edit_meshes`](Self::edit_meshes) gives the mesh that holds them another number of clusters.
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
            if mesh as usize >= meshes {
                return Err(LevelsError::NoMesh { mesh, meshes });
            }
        }
        levels.check(&self.meshes[held_by as usize])?;
        self.levels.resize_with(meshes, Vec::new);
        self.levels[mesh as usize].push(MeshLevels { mesh: held_by, levels });
        self.change += 1;
        Ok(())
    }

    /// Takes the levels of a mesh away.
    pub fn clear_levels(&mut self, mesh: MeshId) {
        if let Some(levels) = self.levels.get_mut(mesh as usize) {
            levels.clear();
            self.change += 1;
        }
    }

    /// Whether any mesh has levels.
    pub(crate) fn has_levels(&self) -> bool {
        self.levels.iter().any(|levels| !levels.is_empty())
    }

    /// The levels of a mesh, in the order of their numbers, from 1.
    #[must_use]
    pub fn levels(&self, mesh: MeshId) -> &[MeshLevels] {
        self.levels.get(mesh as usize).map_or(&[], Vec::as_slice)
    }

    /// The number of the mesh that is drawn for a slot at a level of a [`DrawRange`](crate::DrawRange): its own at level
    /// 0, and where there is no such level.
    #[must_use]
    pub fn mesh_id_at(&self, slot: u32, level: u32) -> MeshId {
        let own = self.mesh_id(slot);
        let levels = level.checked_sub(1).and_then(|at| self.levels(own).get(at as usize));
        levels.map_or(own, |levels| levels.mesh)
    }

    /// The mesh that is drawn for a slot at a level; see [`mesh_id_at`](Self::mesh_id_at).
    #[must_use]
    pub fn mesh_at(&self, slot: u32, level: u32) -> &Mesh {
        &self.meshes[self.mesh_id_at(slot, level) as usize]
    }

    /// Forgets levels that no longer fit the mesh that holds them.
    pub(super) fn drop_stale_levels(&mut self) {
        for levels in &mut self.levels {
            levels.retain(|l| l.levels.check(&self.meshes[l.mesh as usize]).is_ok());
        }
    }
}
