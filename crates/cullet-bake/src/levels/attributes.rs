//! Attributes of vertices, and checks of what is simplified.

use cullet::mesh::MeshError;

use super::error::LevelsError;

/// The longest side of a mesh: squares of distances are single precision here and there.
pub const MAX_EXTENT: f64 = 1e18;

/// Attributes of vertices that the simplifier weighs against positions: normals, colours, texture
/// coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attributes<'a> {
    /// So many values a vertex as there are weights, vertex by vertex; finite.
    pub values: &'a [f32],
    /// Weight of a difference of 1 in each attribute, in units of the mesh's extent; at least 0, at
    /// most 32 of them.
    pub weights: &'a [f32],
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
    attributes: Attributes<'_>,
    vertices: usize,
) -> Result<(), LevelsError> {
    let Attributes { values, weights } = attributes;
    same("attributes", values.len(), weights.len() * vertices)?;
    if weights.len() > 32 {
        let value = weights.len() as f64;
        return Err(LevelsError::Value { what: "attributes", value, allowed: "at most 32" });
    }
    if let Some(weight) = weights.iter().find(|w| !(0.0..=f32::MAX).contains(*w)) {
        let value = f64::from(*weight);
        return Err(LevelsError::Value { what: "weights", value, allowed: "numbers from 0" });
    }
    if let Some(at) = values.iter().position(|v| !v.is_finite()) {
        let (vertex, attribute) = (at / weights.len(), at % weights.len());
        return Err(LevelsError::Attribute { vertex, attribute, value: values[at] });
    }
    Ok(())
}

fn same(what: &'static str, count: usize, expected: usize) -> Result<(), LevelsError> {
    if count == expected { Ok(()) } else { Err(LevelsError::Length { what, count, expected }) }
}

