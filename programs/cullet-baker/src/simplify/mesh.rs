//! One mesh, and the attributes of its vertices.

use std::collections::HashMap;

use cullet::lod::{Group, LevelEye, NO_GROUP};
use cullet::mesh::{Part, weld};
use cullet::{Mesh, MeshData};
use cullet_bake::levels::{
    HierarchyOptions, LevelsError, VertexValues, Within, WithinOptions, build_hierarchy,
    simplify_within,
};
use cullet_draw::surface::Deviation;
use cullet_draw::surface::deviation;
use cullet_io::Attributes;

/// How a mesh is simplified.
#[derive(Clone, Copy, Debug)]
pub(super) struct Settings<'a> {
    /// How far it may be off.
    pub(super) goal: Goal<'a>,
    /// Whether attributes that differ count for nothing.
    pub(super) weld: bool,
    /// Points from which it is measured, each way.
    pub(super) samples: usize,
}

/// How far a mesh may be off.
#[derive(Clone, Copy, Debug)]
pub(super) enum Goal<'a> {
    /// So far in its own units, everywhere.
    Bound(f64),
    /// Error that all these eyes allow.
    Seen(&'a [LevelEye]),
}

/// Meshes of more triangles are cut from a hierarchy of clusters for an eye: in smaller ones little
/// of it is far from the rest.
const SMALL: usize = 5000;

/// A mesh of fewer triangles.
#[derive(Debug)]
pub(super) struct Simplified {
    /// The mesh; `None` where it stays as it is.
    pub(super) mesh: Option<Mesh>,
    pub(super) attributes: Attributes,
    /// How far it was found to be off while it was made, in its own units.
    pub(super) error: f32,
    /// The same from independent points.
    pub(super) deviation: Deviation,
    /// Positions at which attributes differ, and which are a seam for that.
    pub(super) split: u64,
}

/// Seed of the points that results are measured from.
const SEED: u64 = 0x1b0d_5eed;

/// Simplifies a mesh.
pub(super) fn simplify(
    mesh: &Mesh,
    attributes: Option<&Attributes>,
    settings: &Settings<'_>,
) -> Result<Simplified, LevelsError> {
    let data = mesh.to_data();
    let none = Attributes::default();
    let attributes = attributes.unwrap_or(&none);
    let kept = if settings.weld { &none } else { attributes };
    let (same, split) =
        if kept.is_empty() { (Vec::new(), 0) } else { same_vertices(&data.positions, kept) };
    let found = match settings.goal {
        Goal::Seen(eyes) if data.indices.len() / 3 > SMALL => cut_for(&data, kept, eyes)?,
        Goal::Seen(eyes) => {
            let bounds = mesh.bounds();
            let middle = bounds.center().map(|v| v as f32);
            let reach = bounds.half_extent().map(|v| v * v).iter().sum::<f64>().sqrt();
            let allowed = eyes.iter().map(|e| e.allowed(middle, reach as f32));
            within(&data, &same, f64::from(allowed.fold(f32::INFINITY, f32::min)))?
        }
        Goal::Bound(bound) => within(&data, &same, bound)?,
    };
    let fewer = found.indices.len() < data.indices.len() && !found.indices.is_empty();
    let result = if fewer { &found.indices } else { &data.indices };
    let deviation = deviation(
        (&data.positions, &data.indices),
        (&data.positions, result),
        settings.samples,
        SEED,
    );
    if !fewer {
        let attributes = attributes.clone();
        return Ok(Simplified { mesh: None, attributes, error: 0.0, deviation, split });
    }
    let mut used = Used::of(&found.indices, data.positions.len());
    let mut own = Attributes {
        normals: used.take(&attributes.normals),
        uvs: used.take(&attributes.uvs),
        colors: used.take(&attributes.colors),
    };
    if settings.weld {
        own.normals = Vec::new();
    }
    let parts: Vec<Part> = found.parts.into_iter().filter(|p| p.triangle_count > 0).collect();
    let small = MeshData {
        positions: used.take(&data.positions),
        indices: std::mem::take(&mut used.indices),
        parts,
        ..MeshData::default()
    };
    let mesh = Some(Mesh::new(small)?);
    Ok(Simplified { mesh, attributes: own, error: found.error, deviation, split })
}

/// The fewest triangles within a bound.
fn within(data: &MeshData, same: &[u32], bound: f64) -> Result<Within, LevelsError> {
    let mut options = WithinOptions::default();
    options.same = same;
    // What is larger than any mesh allows no more than that.
    simplify_within(data, bound.min(f64::from(f32::MAX)) as f32, &options)
}

/// The cut of a hierarchy of clusters for some eyes; its error is the largest of what is drawn.
fn cut_for(
    data: &MeshData,
    attributes: &Attributes,
    eyes: &[LevelEye],
) -> Result<Within, LevelsError> {
    let values = attributes.interleaved();
    let seams = VertexValues { values: &values, count: attributes.stride() };
    let seams = (!attributes.is_empty()).then_some(seams);
    let data = build_hierarchy(data, seams, &HierarchyOptions::default())?;
    let (mesh, levels) = data.into_levels()?;
    let over = |group: &Group| eyes.iter().any(|e| e.is_over(group));
    let mut of_parts = vec![Vec::new(); mesh.parts().len()];
    let mut error = 0.0_f32;
    let made_from = levels.made_from().iter().zip(mesh.clusters());
    let drawn = levels.select_where(over);
    for ((&from, cluster), _) in made_from.zip(drawn).filter(|c| c.1) {
        let corners = cluster.triangles().start as usize * 3..cluster.triangles().end as usize * 3;
        of_parts[cluster.part as usize].extend_from_slice(&mesh.indices()[corners]);
        if from != NO_GROUP {
            error = error.max(levels.group(from as usize).error);
        }
    }
    let mut first_triangle = 0;
    let parts = mesh.parts().iter().zip(&of_parts).map(|(part, of)| {
        let part = Part { first_triangle, triangle_count: (of.len() / 3) as u32, ..*part };
        first_triangle += part.triangle_count;
        part
    });
    let parts = parts.collect();
    Ok(Within { indices: of_parts.concat(), parts, error })
}

/// The vertices that triangles use, in the order of first use, and the triangles by their new
/// numbers.
#[derive(Debug)]
struct Used {
    vertices: Vec<u32>,
    indices: Vec<u32>,
}

impl Used {
    fn of(indices: &[u32], vertices: usize) -> Self {
        let mut number = vec![u32::MAX; vertices];
        let mut used = Vec::new();
        let indices = indices.iter().map(|&v| {
            let known = &mut number[v as usize];
            if *known == u32::MAX {
                *known = used.len() as u32;
                used.push(v);
            }
            *known
        });
        let indices = indices.collect();
        Self { vertices: used, indices }
    }

    /// Their values, of one for each vertex before; none of none.
    fn take<T: Copy>(&self, values: &[T]) -> Vec<T> {
        self.vertices.iter().filter_map(|&v| values.get(v as usize).copied()).collect()
    }
}

/// For each vertex the first one of the same position and attributes; and at how many positions
/// there are several.
fn same_vertices(positions: &[[f32; 3]], attributes: &Attributes) -> (Vec<u32>, u64) {
    let by_position = weld(positions);
    let (numbers, stride) = (attributes.interleaved(), attributes.stride());
    let key = |v: usize| -> Vec<u32> {
        let own = numbers.get(v * stride..(v + 1) * stride).unwrap_or(&[]);
        // Adding 0 turns −0 into 0.
        std::iter::once(by_position[v]).chain(own.iter().map(|n| (n + 0.0).to_bits())).collect()
    };
    let mut first: HashMap<Vec<u32>, u32> = HashMap::with_capacity(positions.len());
    let mut of_position = vec![0_u32; positions.len()];
    let same = (0..positions.len()).map(|v| {
        *first.entry(key(v)).or_insert_with(|| {
            of_position[by_position[v] as usize] += 1;
            v as u32
        })
    });
    let same = same.collect();
    (same, of_position.iter().filter(|&&n| n > 1).count() as u64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet_testkit::{meshes, soups};

    fn settings(bound: f64, weld: bool) -> Settings<'static> {
        Settings { goal: Goal::Bound(bound), weld, samples: 20_000 }
    }

    #[test]
    fn attributes_stay_with_their_vertices_and_seams_are_kept() {
        let (positions, indices) = soups::ball(24, 48);
        // The upper half has a colour of its own; between them is a seam.
        let middle = positions.len() as u32;
        let soup = soups::unshared(&(positions, indices));
        let mesh = meshes::one_sided(soup);
        let upper = |t: &[[f32; 3]]| t.iter().map(|p| p[1]).sum::<f32>() > 0.0;
        let colors: Vec<[f32; 4]> = mesh
            .positions()
            .chunks_exact(3)
            .flat_map(|t| [if upper(t) { [1.0, 0.0, 0.0, 1.0] } else { [0.0, 0.0, 1.0, 1.0] }; 3])
            .collect();
        let attributes = Attributes { colors, ..Attributes::default() };
        let made = simplify(&mesh, Some(&attributes), &settings(0.02, false)).expect("valid");
        let small = made.mesh.expect("fewer triangles");
        let (few, all) = (small.triangle_count(), mesh.triangle_count());
        assert!(few * 2 < all, "{few} of {all}");
        assert!(small.positions().len() < middle as usize);
        assert_eq!(made.split, 48, "the equator");
        assert_eq!(made.attributes.colors.len(), small.positions().len());
        assert_eq!(made.deviation.open_edges, [0, 0]);
        for (p, c) in small.positions().iter().zip(&made.attributes.colors) {
            let is_upper = c[0] == 1.0;
            assert!(p[1] == 0.0 || p[1].abs() < 1e-6 || (p[1] > 0.0) == is_upper, "{p:?} {c:?}");
        }
        // Both colours, in the same numbers of triangles.
        let of = |t: &[u32]| small_color(&made.attributes, t);
        let red = small.indices().chunks_exact(3).filter(|t| of(t)).count() as u32;
        assert!(red * 3 > small.triangle_count() && red * 3 < small.triangle_count() * 2);
        let welded = simplify(&mesh, Some(&attributes), &settings(0.02, true)).expect("valid");
        assert_eq!(welded.split, 0);
        let fewer = welded.mesh.expect("fewer triangles").triangle_count();
        assert!(fewer * 2 < all, "{fewer} of {all}");
    }

    /// Whether a triangle is red, which all of its corners say or none.
    fn small_color(attributes: &Attributes, t: &[u32]) -> bool {
        let red: Vec<bool> = t.iter().map(|&v| attributes.colors[v as usize][0] == 1.0).collect();
        assert!(red.iter().all(|r| *r == red[0]));
        red[0]
    }

    #[test]
    fn what_cannot_be_simplified_stays() {
        let mesh = meshes::tetrahedron();
        let made = simplify(&mesh, None, &settings(0.01, false)).expect("valid");
        assert!(made.mesh.is_none() && made.error == 0.0);
        assert!(made.deviation.max < 1e-6);
    }
}
