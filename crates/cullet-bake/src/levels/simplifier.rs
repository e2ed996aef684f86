//! Meshoptimizer's simplifier, partitioner and cluster builder behind checks: its assertions abort
//! the process, and without them it writes where it should not, so nothing unchecked reaches it.

use cullet::mesh::{MAX_CLUSTER_TRIANGLES, MAX_CLUSTER_VERTICES, MeshError};
use meshopt::{SimplifyOptions, VertexDataAdapter};

use super::error::LevelsError;

/// The longest side of a mesh: squares of distances are single precision here and there.
pub const MAX_EXTENT: f64 = 1e18;

/// How far to simplify.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// Stop at so many triangles. 0 leaves the error to decide.
    pub triangles: usize,
    /// Stop before the simplifier's own estimate of the error exceeds this, in units of the mesh.
    /// It is an estimate: the true deviation is often larger. Infinity leaves the number of
    /// triangles to decide.
    pub error: f32,
    /// Whether open borders stay as they are. Where not, they are simplified along themselves.
    pub lock_border: bool,
}

impl Default for Target {
    fn default() -> Self {
        Self { triangles: 0, error: f32::INFINITY, lock_border: false }
    }
}

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

/// A simplified index list.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Simplified {
    /// Three vertices a triangle, of those that were given.
    pub indices: Vec<u32>,
    /// The simplifier's own estimate of the error, in units of the mesh: *no bound*.
    pub error: f32,
}

/// Collapses edges until the target is reached, or nothing more can be collapsed. Vertices keep
/// their places and numbers. Those at the same position are joined by it; where several numbers
/// share a position, edges of attributes are kept along it.
///
/// `locks` is empty, or says for each vertex whether it must stay (and with it all at its
/// position).
///
/// No triangles, and triangles that all lie in one point, come back as they are, with an error of
/// 0. Deterministic; O(n log n).
///
/// # Errors
/// If an index is not below the number of positions, indices are not whole triangles, a position or
/// an attribute is not finite, the mesh extends over more than [`MAX_EXTENT`], or the target's
/// error is below 0 or NaN.
pub fn simplify(
    positions: &[[f32; 3]],
    indices: &[u32],
    locks: &[bool],
    attributes: Option<Attributes<'_>>,
    target: Target,
) -> Result<Simplified, LevelsError> {
    let extent = checked_extent(positions, indices)?;
    if !locks.is_empty() {
        same("locks", locks.len(), positions.len())?;
    }
    if target.error.is_nan() || target.error < 0.0 {
        let value = f64::from(target.error);
        return Err(LevelsError::Value { what: "error", value, allowed: "a number from 0" });
    }
    if let Some(attributes) = attributes {
        check_attributes(attributes, positions.len())?;
    }
    // Below the second limit the simplifier's scale to a unit box overflows.
    if indices.is_empty() || extent < f64::from(f32::MIN_POSITIVE) * 4.0 {
        return Ok(Simplified { indices: indices.to_vec(), error: 0.0 });
    }
    let bytes = meshopt::typed_to_bytes(positions);
    // Cannot fail: the bytes are whole positions.
    let Ok(vertices) = VertexDataAdapter::new(bytes, 12, 0) else {
        return Ok(Simplified { indices: indices.to_vec(), error: 0.0 });
    };
    // Always absolute: a share of the extent would be another number for each group of clusters.
    let mut options = SimplifyOptions::ErrorAbsolute;
    if target.lock_border {
        options |= SimplifyOptions::LockBorder;
    }
    let count = target.triangles.saturating_mul(3).min(indices.len());
    // Larger than any estimate, and its square in units of the extent does not matter: infinite is
    // as good.
    let most = target.error.min(f32::MAX);
    let mut error = 0.0;
    let none;
    let locks = if locks.is_empty() {
        none = vec![false; positions.len()];
        &none
    } else {
        locks
    };
    let indices = match attributes.filter(|a| !a.weights.is_empty()) {
        Some(a) => meshopt::simplify_with_attributes_and_locks(
            indices,
            &vertices,
            a.values,
            a.weights,
            size_of_val(a.weights),
            locks,
            count,
            most,
            options,
            Some(&mut error),
        ),
        None => meshopt::simplify_with_locks(
            indices,
            &vertices,
            locks,
            count,
            most,
            options,
            Some(&mut error),
        ),
    };
    Ok(Simplified { indices, error })
}

/// Groups of some `size` clusters (at most a third more) that share vertices, or are near each
/// other where none do: for each cluster its group, numbered from 0 in the order of their first
/// clusters. `indices` are the triangles of all clusters, one after the other, and `counts` how
/// many indices each has. Welded vertices must have one number.
///
/// # Errors
/// As [`simplify`]; if the counts do not sum up to the indices or one is 0; if `size` is 0.
pub fn partition(
    positions: &[[f32; 3]],
    indices: &[u32],
    counts: &[u32],
    size: usize,
) -> Result<Vec<u32>, LevelsError> {
    checked_extent(positions, indices)?;
    same("counts of indices", counts.iter().map(|&c| c as usize).sum(), indices.len())?;
    if let Some(&count) = counts.iter().find(|c| **c == 0 || **c % 3 != 0) {
        return Err(MeshError::NotTriangles(count as usize).into());
    }
    if size == 0 {
        return Err(LevelsError::Value { what: "size", value: 0.0, allowed: "1 or more" });
    }
    let mut groups = vec![0; counts.len()];
    if counts.len() < 2 {
        return Ok(groups);
    }
    if let Ok(vertices) = VertexDataAdapter::new(meshopt::typed_to_bytes(positions), 12, 0) {
        meshopt::partition_clusters_with_positions(&mut groups, indices, counts, &vertices, size);
    }
    // As it numbers them, a group's number is that of its place among groups by an inner list.
    let mut number = vec![u32::MAX; counts.len()];
    let mut next = 0;
    for group in &mut groups {
        let known = &mut number[*group as usize];
        if *known == u32::MAX {
            *known = next;
            next += 1;
        }
        *group = *known;
    }
    Ok(groups)
}

/// The limits of clusters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClusterSize {
    /// The most vertices, 3 to 64.
    pub vertices: usize,
    /// The fewest triangles, where a cluster might be larger but would extend too far: a multiple
    /// of 4.
    pub least: usize,
    /// The most triangles, 4 to 124: a multiple of 4.
    pub most: usize,
    /// How many times larger than expected a cluster must be to be ended before it is full; 0 for
    /// never.
    pub split_factor: f32,
}

/// Triangles cut into clusters: their indices, cluster by cluster (each triangle in its turn,
/// though it may begin with another corner), and how many triangles each cluster has.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Clusters {
    /// Three vertices a triangle.
    pub indices: Vec<u32>,
    /// Triangles of each cluster; never 0.
    pub counts: Vec<u32>,
}

/// Cuts triangles into clusters of neighbours. None make no cluster.
///
/// # Errors
/// As [`simplify`], and if a limit is out of range.
pub fn cut_into_clusters(
    positions: &[[f32; 3]],
    indices: &[u32],
    size: ClusterSize,
) -> Result<Clusters, LevelsError> {
    checked_extent(positions, indices)?;
    let in_range = (3..=MAX_CLUSTER_VERTICES).contains(&size.vertices)
        && (4..=MAX_CLUSTER_TRIANGLES).contains(&size.most)
        && (4..=size.most).contains(&size.least)
        && size.most.is_multiple_of(4)
        && size.least.is_multiple_of(4);
    if !in_range {
        let allowed = "multiples of 4 up to 124, and 3 to 64 vertices";
        return Err(LevelsError::Value { what: "cluster size", value: size.most as f64, allowed });
    }
    if !(0.0..=1e6).contains(&size.split_factor) {
        let value = f64::from(size.split_factor);
        return Err(LevelsError::Value { what: "split_factor", value, allowed: "0 to 1e6" });
    }
    let mut result = Clusters::default();
    if indices.is_empty() {
        return Ok(result);
    }
    let Ok(vertices) = VertexDataAdapter::new(meshopt::typed_to_bytes(positions), 12, 0) else {
        return Ok(result);
    };
    let made = meshopt::build_meshlets_flex(
        indices,
        &vertices,
        size.vertices,
        size.least,
        size.most,
        0.0,
        size.split_factor,
    );
    result.indices.reserve(indices.len());
    for meshlet in made.iter() {
        result.indices.extend(meshlet.triangles.iter().map(|&i| meshlet.vertices[i as usize]));
        result.counts.push((meshlet.triangles.len() / 3) as u32);
    }
    Ok(result)
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A flat square sheet of n × n quads.
    fn sheet(n: u32) -> (Vec<[f32; 3]>, Vec<u32>) {
        let side = n + 1;
        let positions =
            (0..side * side).map(|i| [(i % side) as f32, (i / side) as f32, 0.0]).collect();
        let quad = |q: u32| {
            let a = q / n * side + q % n;
            [a, a + 1, a + side + 1, a, a + side + 1, a + side]
        };
        (positions, (0..n * n).flat_map(quad).collect())
    }

    #[test]
    fn a_flat_sheet_needs_few_triangles_and_locks_are_kept() {
        let (positions, indices) = sheet(16);
        let to = |locks: &[bool], target| {
            simplify(&positions, &indices, locks, None, target).expect("valid")
        };
        let free = to(&[], Target { error: 1e-3, ..Target::default() });
        assert!(free.indices.len() <= 40 * 3, "{} of 512 triangles", free.indices.len() / 3);
        assert!(free.error <= 1e-3);
        let mut locks = vec![false; positions.len()];
        locks[40] = true;
        let kept = to(&locks, Target { error: 1e-3, ..Target::default() });
        assert!(kept.indices.contains(&40) && !free.indices.contains(&40));
        let border = to(&[], Target { error: 1e-3, lock_border: true, ..Target::default() });
        assert!((0..17).all(|v| border.indices.contains(&v)));
        let half = to(&[], Target { triangles: 256, ..Target::default() });
        assert!(half.indices.len() <= 256 * 3);
    }

    #[test]
    fn what_is_not_valid_is_refused() {
        let (mut positions, indices) = sheet(2);
        let run = |p: &[[f32; 3]], i: &[u32], locks: &[bool], error: f32| {
            simplify(p, i, locks, None, Target { error, ..Target::default() }).err()
        };
        assert_eq!(run(&positions, &indices, &[], 0.0), None);
        assert!(matches!(
            run(&positions, &indices[1..], &[], 0.0),
            Some(LevelsError::Mesh(MeshError::NotTriangles(_)))
        ));
        assert!(matches!(
            run(&positions[1..], &indices, &[], 0.0),
            Some(LevelsError::Mesh(MeshError::Index { .. }))
        ));
        assert!(matches!(
            run(&positions, &indices, &[true], 0.0),
            Some(LevelsError::Length { .. })
        ));
        for error in [-1.0, f32::NAN] {
            assert!(matches!(
                run(&positions, &indices, &[], error),
                Some(LevelsError::Value { .. })
            ));
        }
        positions[3] = [1e30, 0.0, 0.0];
        assert!(matches!(run(&positions, &indices, &[], 0.0), Some(LevelsError::TooLarge { .. })));
        positions[3] = [f32::NAN, 0.0, 0.0];
        let refused = run(&positions, &indices, &[], 0.0);
        assert!(matches!(refused, Some(LevelsError::Mesh(MeshError::NotFinite { vertex: 3, .. }))));
        assert!(partition(&positions[..3], &[0, 1, 2], &[2], 8).is_err());
        assert!(partition(&positions[..3], &[0, 1, 2], &[3], 0).is_err());
    }

    #[test]
    fn nothing_and_one_point_stay_as_they_are() {
        let none = simplify(&[], &[], &[], None, Target::default()).expect("valid");
        assert_eq!(none, Simplified::default());
        let indices: Vec<u32> = (0..300).collect();
        for far in [0.0, 1e-45, 1e-38] {
            let positions: Vec<[f32; 3]> =
                (0..300).map(|i| [if i == 7 { far } else { 0.0 }, 1.0, 2.0]).collect();
            let same = simplify(&positions, &indices, &[], None, Target::default());
            assert_eq!(same.map(|s| s.indices), Ok(indices.clone()));
        }
    }

    #[test]
    fn clusters_hold_each_triangle_once_and_groups_are_of_the_size() {
        let (positions, indices) = sheet(40);
        let size = ClusterSize { vertices: 64, least: 20, most: 64, split_factor: 2.0 };
        let clusters = cut_into_clusters(&positions, &indices, size).expect("valid");
        let sorted = |indices: &[u32]| {
            let mut all: Vec<_> = indices
                .chunks_exact(3)
                .map(|t| crate::corners::turned([t[0], t[1], t[2]]))
                .collect();
            all.sort_unstable();
            all
        };
        assert_eq!(sorted(&clusters.indices), sorted(&indices));
        assert!(clusters.counts.iter().all(|c| (1..=64).contains(c)));
        let counts: Vec<u32> = clusters.counts.iter().map(|c| c * 3).collect();
        let groups = partition(&positions, &clusters.indices, &counts, 8).expect("valid");
        let number = groups.iter().max().map_or(0, |g| *g as usize + 1);
        let mut members = vec![0; number];
        groups.iter().for_each(|&g| members[g as usize] += 1);
        assert!(members.iter().all(|m| (1..=10).contains(m)), "{members:?}");
        assert!(number * 6 <= counts.len() + 12, "{number} of {}", counts.len());
        let bad = ClusterSize { most: 63, ..size };
        assert!(cut_into_clusters(&positions, &indices, bad).is_err());
    }
}
