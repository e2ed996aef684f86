//! Clusters by meshoptimizer, to compare with.

use cullet::MeshData;
use cullet::mesh::{Cluster, Clustering, is_degenerate};
use meshopt::VertexDataAdapter;

/// The vertices that a meshlet may have.
const MOST_VERTICES: usize = 64;

/// Clusters as `meshopt_buildMeshlets` makes them, part by part; triangles without area are in none.
/// `most` triangles each, a multiple of 4 from 4 to 124; `cone_weight` is 0 to 1, more for clusters
/// that are culled more often.
pub(super) fn meshlets(
    data: &MeshData,
    most: usize,
    cone_weight: f32,
) -> Result<Clustering, meshopt::Error> {
    let vertices = VertexDataAdapter::new(meshopt::typed_to_bytes(&data.positions), 12, 0)?;
    let all = data.indices.as_chunks::<3>().0;
    let mut result = Clustering::default();
    for (part, of) in (0..).zip(&data.parts) {
        let mut triangles: Vec<([u32; 3], u32)> = (of.first_triangle..)
            .take(of.triangle_count as usize)
            .map(|t| (turned(all[t as usize]), t))
            .filter(|(corners, _)| !is_degenerate(*corners, &data.positions))
            .collect();
        if triangles.is_empty() {
            continue;
        }
        let indices: Vec<u32> = triangles.iter().flat_map(|t| t.0).collect();
        let made = meshopt::build_meshlets(&indices, &vertices, MOST_VERTICES, most, cone_weight);
        // Meshlets name vertices, not triangles. Each triangle is found by its corners, and of
        // equal ones each is taken once, last first.
        triangles.sort_unstable();
        let mut left = vec![0usize; triangles.len()];
        let mut first = 0;
        for run in triangles.chunk_by(|a, b| a.0 == b.0) {
            left[first] = run.len();
            first += run.len();
        }
        for meshlet in made.iter() {
            let first_triangle = result.order.len() as u32;
            for t in meshlet.triangles.as_chunks::<3>().0 {
                let corners = turned(t.map(|i| meshlet.vertices[i as usize]));
                let run = triangles.partition_point(|p| p.0 < corners);
                left[run] -= 1;
                result.order.push(triangles[run + left[run]].1);
            }
            let triangle_count = result.order.len() as u32 - first_triangle;
            result.clusters.push(Cluster { first_triangle, triangle_count, part });
        }
    }
    Ok(result)
}

/// The same triangle with its least corner first, in the same turn.
fn turned(mut corners: [u32; 3]) -> [u32; 3] {
    let least = (0..3).min_by_key(|&k| corners[k]).unwrap_or(0);
    corners.rotate_left(least);
    corners
}
