//! The prepared forms made from a [`Mesh`], which knows which of its triangles are one-sided.
//!
//! The forms over slices take the caller's word for that. These refuse a mesh that is two-sided
//! throughout, with the defect that keeps it from being a solid, and never cull two-sided parts of
//! another. Triangles are in the mesh's order, as [`Mesh::indices`] has them.

use super::cluster::{BatchBound, ClusterBounds, ClusterPlanes};
use super::{MaskGrid, NormalMask, NormalMasks, Planes8, Planes16, Planes32};
use crate::mesh::{Cluster, Mesh, TwoSided};

/// The corners of a triangle that no eye is behind.
const NEVER: [[f32; 3]; 3] = [[0.0; 3]; 3];

macro_rules! planes_of_mesh {
    ($($planes:ty),*) => {$(
        impl $planes {
            /// The planes of a mesh's triangles, in its order; triangles of two-sided parts are never
            /// culled.
            ///
            /// # Errors
            /// If every part is two-sided.
            pub fn of_mesh(mesh: &Mesh) -> Result<Self, TwoSided> {
                mesh.require_one_sided()?;
                let mut planes = Self::new(mesh.positions(), mesh.indices());
                two_sided(mesh).for_each(|t| planes.set(t, NEVER));
                Ok(planes)
            }
        }
    )*};
}
planes_of_mesh!(Planes8, Planes16, Planes32);

impl MaskGrid {
    /// The classes of a mesh's triangles, in its order; `masks` is overwritten. Triangles of two-sided
    /// parts are never culled.
    ///
    /// # Errors
    /// If every part is two-sided; `masks` is then as it was.
    pub fn encode_mesh(&self, mesh: &Mesh, masks: &mut NormalMasks) -> Result<(), TwoSided> {
        mesh.require_one_sided()?;
        self.encode_triangles(mesh.positions(), mesh.indices(), masks);
        two_sided(mesh).for_each(|t| masks.set(t, NormalMask::NEVER));
        Ok(())
    }
}

impl<B: BatchBound> ClusterBounds<B> {
    /// The bounds of a mesh's clusters, in its order; those of two-sided parts are never culled. Some
    /// 50 µs a cluster for elliptic cones.
    ///
    /// # Errors
    /// If every part is two-sided.
    pub fn of_mesh(mesh: &Mesh) -> Result<Self, TwoSided> {
        mesh.require_one_sided()?;
        let fit = |c: &Cluster| {
            if mesh.parts()[c.part as usize].two_sided {
                return None;
            }
            let range = c.first_triangle..c.first_triangle + c.triangle_count;
            B::fit(&ClusterPlanes::new(range.map(|t| mesh.corners(t))))
        };
        Ok(mesh.clusters().iter().map(fit).collect())
    }
}

/// The triangles of two-sided parts, but for degenerate ones, which have no plane anyway.
fn two_sided(mesh: &Mesh) -> impl Iterator<Item = usize> {
    let clusters = mesh.clusters().iter().filter(|c| mesh.parts()[c.part as usize].two_sided);
    clusters.flat_map(|c| {
        let first = c.first_triangle as usize;
        first..first + c.triangle_count as usize
    })
}
