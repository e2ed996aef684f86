//! Runs of clusters: what the stages after those of instances pass on.

use core::ops::Range;

use crate::mesh::Mesh;
use crate::scene::MeshId;
pub(super) use crate::scene::is_parted;

/// Consecutive clusters of one instance to which the frustum gave the same answer.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    pub(super) slot: u32,
    /// The mesh that they are of: of the instance, or of its levels.
    pub(super) mesh: MeshId,
    /// The level of detail, as a [`DrawRange`](crate::draw::DrawRange) has it.
    pub(super) level: u32,
    pub(super) first_cluster: u32,
    pub(super) cluster_count: u32,
    /// No triangle of it needs an outcode.
    pub(super) inside: bool,
}

/// The triangles of a run: clusters follow each other in the mesh's order.
pub(super) fn triangles_of(mesh: &Mesh, run: Run) -> Range<u32> {
    let clusters = &mesh.clusters()[run.first_cluster as usize..];
    let Some(first) = clusters.first() else { return 0..0 };
    let last = clusters[run.cluster_count as usize - 1];
    first.first_triangle..last.first_triangle + last.triangle_count
}
