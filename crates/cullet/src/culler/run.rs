//! Runs of clusters: what the stages after those of instances pass on.

use std::ops::Range;

use crate::mesh::{MAX_CLUSTER_TRIANGLES, Mesh};
use crate::scene::MeshId;

/// Consecutive clusters of one instance to which the frustum gave the same answer.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    pub(super) slot: u32,
    /// The mesh that they are of: of the instance, or of its levels.
    pub(super) mesh: MeshId,
    /// The level of detail, as a [`DrawRange`](crate::DrawRange) has it.
    pub(super) level: u32,
    pub(super) first_cluster: u32,
    pub(super) cluster_count: u32,
    /// No triangle of it needs an outcode.
    pub(super) inside: bool,
}

/// The fewest triangles of a mesh of which clusters are culled by themselves, as many as two clusters hold. Of less so
/// little goes that finding it costs more than drawing it.
const LEAST_PARTED: u32 = 2 * MAX_CLUSTER_TRIANGLES as u32;

/// Whether it pays to cull the clusters of a mesh by themselves.
pub(super) fn is_parted(mesh: &Mesh) -> bool {
    mesh.triangle_count() > LEAST_PARTED
}

/// The triangles of a run: clusters follow each other in the mesh's order.
pub(super) fn triangles_of(mesh: &Mesh, run: Run) -> Range<u32> {
    let clusters = &mesh.clusters()[run.first_cluster as usize..];
    let Some(first) = clusters.first() else { return 0..0 };
    let last = clusters[run.cluster_count as usize - 1];
    first.first_triangle..last.first_triangle + last.triangle_count
}
