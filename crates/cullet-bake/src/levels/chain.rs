//! Chains of levels: the whole mesh again and again, each time of fewer triangles, with errors that
//! are measured.

use cullet::MeshData;
use cullet::mesh::{Cluster, Clustering, Part};

use super::data::{Group, LevelsData, NO_GROUP};
use super::error::LevelsError;
use super::original::Original;
use super::within::{Within, WithinOptions, check};

/// Options that decide the levels of a chain.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ChainOptions<'a> {
    /// How each level is made.
    pub within: WithinOptions<'a>,
    /// The bound of the first level, in bounding radii; above 0. Default 0.0005.
    pub first: f32,
    /// The bound of the last level before the sheets, in bounding radii. Default 0.25.
    pub last: f32,
    /// Factor by which the bound grows from level to level; above 1. Default 1.6.
    pub growth: f32,
    /// How many of the triangles of the level before one may have at the most; others are not kept.
    /// Above 0, below 1. Default 0.7.
    pub keep: f32,
}

impl Default for ChainOptions<'_> {
    fn default() -> Self {
        Self { within: WithinOptions::default(), first: 0.0005, last: 0.25, growth: 1.6, keep: 0.7 }
    }
}

impl ChainOptions<'_> {
    fn check(&self) -> Result<(), LevelsError> {
        let refused = |what, value: f32, allowed| {
            Err(LevelsError::Value { what, value: f64::from(value), allowed })
        };
        if !(self.first > 0.0 && self.first.is_finite()) {
            return refused("first", self.first, "a number of radii above 0");
        }
        if !(self.last > 0.0 && self.last.is_finite()) {
            return refused("last", self.last, "a number of radii above 0");
        }
        if !(self.growth >= 1.01 && self.growth.is_finite()) {
            return refused("growth", self.growth, "a number from 1.01");
        }
        if !(self.keep > 0.0 && self.keep < 1.0) {
            return refused("keep", self.keep, "a share above 0 and below 1");
        }
        check(0.0, &self.within)
    }
}

/// A chain of levels of a mesh, each made from the one before, within a bound of the original that
/// grows from level to level, as [`simplify_within`](super::simplify_within) does. The error of a
/// level is what was measured, and at least that of the level before. The last two are of a sheet of two triangles
/// and of one for each part, twice where it is one-sided. A mesh that cannot be simplified has the
/// one level that it is.
///
/// Each level but the original is one group, whose sphere is around the whole mesh. Vertices keep
/// their numbers. The same on every run and on every target.
///
/// # Errors
/// If the mesh is invalid or extends too far, or an option is out of range.
pub fn build_chain(data: &MeshData, options: &ChainOptions<'_>) -> Result<LevelsData, LevelsError> {
    options.check()?;
    let original = Original::new(data, options.within.same)?;
    let (centre, radius) = sphere(&original.positions);
    let mut levels: Vec<Within> = Vec::new();
    let mut last = original.carrying();
    let mut triangles = original.triangle_count();
    let mut error = 0.0_f32;
    let mut share = options.first;
    while radius > 0.0 && triangles > 1 && share <= options.last {
        let most = (triangles as f64 * f64::from(options.keep)) as usize + 1;
        let bound = share * radius;
        if let Some(found) = original.fewest_within(&mut last, bound, most, &options.within) {
            error = error.max(found.error);
            triangles = found.indices.len() / 3;
            levels.push(original.as_given(&found.indices, error));
            if triangles == 0 {
                // All of it is smaller than the bound; nothing follows nothing.
                levels.pop();
                break;
            }
        }
        share *= options.growth;
    }
    // A sheet of two triangles, then of one.
    for corners in [2, 1] {
        let most = (triangles as f64 * f64::from(options.keep)) as usize;
        if radius > 0.0
            && let Some(found) = original.sheets(corners)
            && found.indices.len() / 3 <= most
            && found.error.is_finite()
        {
            error = error.max(found.error);
            triangles = found.indices.len() / 3;
            levels.push(original.as_given(&found.indices, error));
        }
    }
    chain_of(data, &original.parts, &levels, centre, radius)
}

/// The middle of the box around points, and the distance of the farthest from it, rounded up.
fn sphere(points: &[[f32; 3]]) -> ([f32; 3], f32) {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for p in points {
        for a in 0..3 {
            low[a] = low[a].min(p[a]);
            high[a] = high[a].max(p[a]);
        }
    }
    if points.is_empty() {
        return ([0.0; 3], 0.0);
    }
    let centre: [f32; 3] = std::array::from_fn(|a| low[a] * 0.5 + high[a] * 0.5);
    let squared = |p: &[f32; 3]| {
        (0..3).map(|a| (f64::from(p[a]) - f64::from(centre[a])).powi(2)).sum::<f64>()
    };
    let radius = points.iter().map(squared).fold(0.0, f64::max).sqrt();
    let rounded = radius as f32;
    (centre, if f64::from(rounded) < radius { rounded.next_up() } else { rounded })
}

/// Puts the triangles of the levels behind those of the mesh, part by part, each level cut into
/// clusters. A mesh without triangles is no level.
pub(crate) fn chain_of(
    data: &MeshData,
    parts: &[Part],
    levels: &[Within],
    centre: [f32; 3],
    radius: f32,
) -> Result<LevelsData, LevelsError> {
    let mut out = LevelsData {
        mesh: MeshData {
            positions: data.positions.clone(),
            polygons: data.polygons,
            deformable: data.deformable,
            ..MeshData::default()
        },
        groups: levels.iter().map(|l| Group { centre, radius, error: l.error }).collect(),
        ..LevelsData::default()
    };
    let mut cut = vec![Clustering::spatial(data)?];
    for level in levels {
        cut.push(Clustering::spatial(&MeshData {
            positions: data.positions.clone(),
            indices: level.indices.clone(),
            parts: level.parts.clone(),
            deformable: data.deformable,
            ..MeshData::default()
        })?);
    }
    for number in 0..parts.len() {
        let first_triangle = (out.mesh.indices.len() / 3) as u32;
        for (level, clustering) in cut.iter().enumerate() {
            let (indices, part) = match level {
                0 => (&data.indices, parts[number]),
                _ => (&levels[level - 1].indices, levels[level - 1].parts[number]),
            };
            let from = part.first_triangle as usize * 3;
            // From a triangle's number in its level to that in the mesh of all.
            let offset = (out.mesh.indices.len() / 3) as u32;
            out.mesh
                .indices
                .extend_from_slice(&indices[from..from + part.triangle_count as usize * 3]);
            for cluster in clustering.clusters.iter().filter(|c| c.part as usize == number) {
                let range = cluster.triangles();
                let of = &clustering.order[range.start as usize..range.end as usize];
                let first = out.clustering.order.len() as u32;
                let moved = of.iter().map(|t| t - part.first_triangle + offset);
                out.clustering.order.extend(moved);
                out.clustering.clusters.push(Cluster { first_triangle: first, ..*cluster });
                let group =
                    |level: usize| if level < levels.len() { level as u32 } else { NO_GROUP };
                out.replaced_by.push(group(level));
                out.made_from.push(if level == 0 { NO_GROUP } else { group(level - 1) });
            }
        }
        let triangle_count = (out.mesh.indices.len() / 3) as u32 - first_triangle;
        out.mesh.parts.push(Part { first_triangle, triangle_count, ..parts[number] });
    }
    Ok(out)
}
