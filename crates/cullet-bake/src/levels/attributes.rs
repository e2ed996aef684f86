//! Attributes of vertices, and checks of what is simplified.

use cullet::mesh::MeshError;

use super::error::LevelsError;

/// The longest side of a mesh: squares of distances are single precision here and there.
pub const MAX_EXTENT: f64 = 1e18;

/// Attributes of vertices, as far as they keep vertices at one position apart: normals, colours,
/// texture coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VertexValues<'a> {
    /// `count` values a vertex, vertex by vertex; finite.
    pub values: &'a [f32],
    /// Number of values of each vertex.
    pub count: usize,
}

/// Checks positions and indices; the longest side of the box around the positions.
pub(super) fn checked_extent(positions: &[[f32; 3]], indices: &[u32]) -> Result<f64, LevelsError> {
    if !indices.len().is_multiple_of(3) {
        return Err(MeshError::NotTriangles(indices.len()).into());
    }
    let vertices = positions.len();
    // The simplifier keeps four bits beside a vertex's number.
    let limit = 1 << 28;
    if vertices >= limit {
        return Err(MeshError::TooMany { what: "vertices", count: vertices, limit }.into());
    }
    if let Some(at) = indices.iter().position(|&i| i as usize >= vertices) {
        return Err(MeshError::Index { at, index: indices[at], vertices }.into());
    }
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    let mut sum = 0.0_f32;
    for p in positions {
        for a in 0..3 {
            low[a] = if p[a] < low[a] { p[a] } else { low[a] };
            high[a] = if p[a] > high[a] { p[a] } else { high[a] };
            // NaN as soon as one value is not finite.
            sum += p[a] * 0.0;
        }
    }
    if sum.is_nan() {
        let vertex = positions.iter().position(|p| !p.iter().all(|v| v.is_finite())).unwrap_or(0);
        return Err(MeshError::NotFinite { vertex, position: positions[vertex] }.into());
    }
    let side = |a: usize| f64::from(high[a]) - f64::from(low[a]);
    let extent = if positions.is_empty() { 0.0 } else { side(0).max(side(1)).max(side(2)) };
    if extent > MAX_EXTENT {
        return Err(LevelsError::TooLarge { extent, limit: MAX_EXTENT });
    }
    Ok(extent)
}

pub(super) fn check_attributes(
    attributes: VertexValues<'_>,
    vertices: usize,
) -> Result<(), LevelsError> {
    let VertexValues { values, count } = attributes;
    same("attributes", values.len(), count * vertices)?;
    if let Some(at) = values.iter().position(|v| !v.is_finite()) {
        let (vertex, attribute) = (at / count, at % count);
        return Err(LevelsError::Attribute { vertex, attribute, value: values[at] });
    }
    Ok(())
}

fn same(what: &'static str, count: usize, expected: usize) -> Result<(), LevelsError> {
    if count == expected { Ok(()) } else { Err(LevelsError::Length { what, count, expected }) }
}
