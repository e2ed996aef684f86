//! Clusters by meshoptimizer, to compare with.

use cullet::MeshData;
use cullet::mesh::{Cluster, Clustering};
use meshopt::VertexDataAdapter;

use super::{ClusterError, checked_parts, drawn};
use crate::corners::turned;

/// Clusters as meshoptimizer's `meshopt_buildMeshlets` makes them, part by part, in the form that
/// [`Mesh::with_clusters`](cullet::Mesh::with_clusters) takes. Degenerate triangles are left out as
/// in [`build`](super::build).
///
/// `max_vertices` is 3 to 64 and `max_triangles` 4 to 124, rounded down to a multiple of 4 as
/// meshoptimizer requires; `cone_weight` is 0 to 1, more for clusters that are culled more often.
///
/// # Errors
/// If the mesh is invalid or a limit out of range.
pub fn build_meshopt(
    data: &MeshData,
    max_vertices: u32,
    max_triangles: u32,
    cone_weight: f32,
) -> Result<Clustering, ClusterError> {
    for (what, value, least, most) in
        [("max_vertices", max_vertices, 3, 64), ("max_triangles", max_triangles, 4, 124)]
    {
        if !(least..=most).contains(&value) {
            return Err(ClusterError::Count { what, value, least, most });
        }
    }
    if !(0.0..=1.0).contains(&cone_weight) {
        let value = f64::from(cone_weight);
        let allowed = "a number from 0 to 1";
        return Err(ClusterError::Value { what: "cone_weight", value, allowed });
    }
    let parts = checked_parts(data)?;
    let bytes = meshopt::typed_to_bytes(&data.positions);
    let mut result = Clustering::default();
    for (number, part) in parts.iter().enumerate() {
        let all = part.first_triangle..part.first_triangle + part.triangle_count;
        let mut triangles: Vec<([u32; 3], u32)> = drawn(data, all)
            .into_iter()
            .map(|t| (turned(std::array::from_fn(|k| data.indices[t as usize * 3 + k])), t))
            .collect();
        if triangles.is_empty() {
            continue;
        }
        let indices: Vec<u32> = triangles.iter().flat_map(|t| t.0).collect();
        // Cannot fail: the bytes are whole positions.
        let Ok(vertices) = VertexDataAdapter::new(bytes, 12, 0) else { continue };
        let made = meshopt::build_meshlets(
            &indices,
            &vertices,
            max_vertices as usize,
            max_triangles as usize & !3,
            cone_weight,
        );
        // Meshlets name vertices, not triangles. Each triangle is found by its corners, and of
        // equal ones each is taken once, last first.
        triangles.sort_unstable();
        let mut free: Vec<u32> = Vec::with_capacity(triangles.len());
        let mut left = vec![0usize; triangles.len()];
        for run in triangles.chunk_by(|a, b| a.0 == b.0) {
            left[free.len()] = run.len();
            free.extend(run.iter().map(|t| t.1));
        }
        for meshlet in made.iter() {
            let first_triangle = result.order.len() as u32;
            for t in meshlet.triangles.chunks_exact(3) {
                let corners = turned([t[0], t[1], t[2]].map(|i| meshlet.vertices[i as usize]));
                let run = triangles.partition_point(|p| p.0 < corners);
                left[run] -= 1;
                result.order.push(free[run + left[run]]);
            }
            let triangle_count = result.order.len() as u32 - first_triangle;
            result.clusters.push(Cluster { first_triangle, triangle_count, part: number as u32 });
        }
    }
    Ok(result)
}
