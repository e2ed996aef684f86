//! Meshoptimizer's simplifier, as plain chains of levels are made with it.

use meshopt::{SimplifyOptions, VertexDataAdapter};

/// Collapses edges until so many triangles are left, or nothing more can be collapsed.
pub(super) fn simplify(
    positions: &[[f32; 3]],
    indices: &[u32],
    triangles: usize,
) -> Result<Vec<u32>, meshopt::Error> {
    let vertices = VertexDataAdapter::new(meshopt::typed_to_bytes(positions), 12, 0)?;
    let count = triangles.saturating_mul(3).min(indices.len());
    let options = SimplifyOptions::ErrorAbsolute;
    Ok(meshopt::simplify(indices, &vertices, count, f32::MAX, options, None))
}
