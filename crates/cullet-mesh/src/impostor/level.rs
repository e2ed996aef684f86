//! An impostor among the levels of a scene's mesh.

use std::sync::Arc;

use cullet::lod::{Levels, LevelsError, NO_GROUP};
use cullet::mesh::{Alpha, Part};
use cullet::scene::MeshLevels;
use cullet::{Mesh, MeshData, MeshId, Scene};

use super::atlas::{Impostor, ImpostorError};
use super::frame::box_triangles;

impl Impostor {
    /// Gives a mesh of a scene this impostor, as one more of its levels: the box around it, which
    /// goes through culling in its place where the impostor's error is small enough, and no
    /// triangle count is smaller. Returns the number of the box among the meshes; a renderer draws
    /// there what [`at`](Self::at) has.
    ///
    /// The eye is never within the box where it is drawn, for then the error is over any threshold.
    ///
    /// # Errors
    /// If the mesh is not there, may move, is not opaque, or is not of the parts or in the box that
    /// the impostor is of.
    pub fn add_to(self, scene: &mut Scene, mesh: MeshId) -> Result<MeshId, ImpostorError> {
        let meshes = scene.meshes().len();
        let no_mesh = LevelsError::NoMesh { mesh, meshes };
        let of = scene.meshes().get(mesh as usize).ok_or(no_mesh)?;
        let not = |why| Err(ImpostorError::Mesh { why });
        if of.is_deformable() {
            return not("may move");
        }
        if of.parts().iter().any(|p| p.alpha != Alpha::Opaque) {
            return not("is not opaque");
        }
        if of.bounds() != self.bounds() {
            return not("is not in the box of the impostor");
        }
        self.check(of.parts().len())?;
        let (positions, indices) = box_triangles(&self.bounds());
        // From both sides, so that no rule about sides drops what the impostor has to show.
        let part = Part { triangle_count: 12, two_sided: true, ..Part::default() };
        let data = MeshData { positions, indices, parts: vec![part], ..MeshData::default() };
        let Ok(held) = Mesh::new(data) else { return not("is too large or too small for a box") };
        let clusters = held.clusters().len();
        let (from, by) = (vec![0; clusters], vec![NO_GROUP; clusters]);
        let levels = Levels::new(&held, &[self.group()], from, by)?;
        let held_by = scene.add_mesh(held);
        scene.add_impostor(mesh, held_by, levels, Arc::new(self))?;
        Ok(held_by)
    }

    /// The impostor that is drawn in place of the triangles of some levels, where they have one.
    #[must_use]
    pub fn of(levels: &MeshLevels) -> Option<&Self> {
        levels.impostor.as_ref()?.downcast_ref()
    }

    /// The impostor that is drawn for a slot at a level, where that is one.
    ///
    /// # Panics
    /// If there is no such slot.
    #[must_use]
    pub fn at(scene: &Scene, slot: u32, level: u32) -> Option<&Self> {
        let levels = scene.levels(scene.mesh_id(slot));
        Self::of(levels.get((level as usize).checked_sub(1)?)?)
    }
}
