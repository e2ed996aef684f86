//! Meshes: checked on construction, cut into clusters by one permutation of their triangles.

mod clusters;
mod regions;
mod sides;
mod weld;

pub use clusters::{Clustering, MAX_CLUSTER_TRIANGLES, MAX_CLUSTER_VERTICES};
pub use regions::{Regions, connected_regions};
pub use weld::weld;

use alloc::string::String;
use alloc::vec;
use alloc::vec::Vec;

use thiserror::Error;

use crate::array::Each;
use crate::bounds::{Aabb, Boxes};
use crate::digits::{Digits, Point};
use crate::hierarchy::Nodes;
use crate::math;

/// Alpha mode of a part's material.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum Alpha {
    /// Ignored: the part hides what is behind it.
    #[default]
    Opaque,
    /// Cut out by a threshold: the part never occludes.
    Masked,
    /// Blended: the part never occludes.
    Blended,
}

/// A range of a mesh's triangles with one material.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Part {
    /// First triangle of the range.
    pub first_triangle: u32,
    /// How many triangles.
    pub triangle_count: u32,
    /// The caller's number for the material.
    pub material: u32,
    /// Whether both sides of its triangles are drawn.
    pub two_sided: bool,
    /// Its alpha mode.
    pub alpha: Alpha,
}

/// Input of a mesh: plain data, not yet checked.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshData {
    /// Vertex positions.
    pub positions: Vec<[f32; 3]>,
    /// Three indices a triangle.
    pub indices: Vec<u32>,
    /// Ranges of triangles, in order and without gap. Empty means one opaque part, which is
    /// one-sided, so that its back faces are culled, where the triangles are the closed surfaces of
    /// bodies, wound outward; else two-sided. [`Mesh::is_two_sided`] tells which.
    pub parts: Vec<Part>,
    /// How many polygons the triangles came from; 0 means that each triangle is a polygon.
    pub polygons: u32,
    /// Whether vertices may move later (skinned, morphed): then no triangle is degenerate for good.
    pub deformable: bool,
}

/// A few triangles near each other, drawn or culled together: contiguous in the mesh's order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Cluster {
    /// First triangle, in the mesh's order.
    pub first_triangle: u32,
    /// How many triangles, at most [`MAX_CLUSTER_TRIANGLES`].
    pub triangle_count: u32,
    /// The part that all its triangles belong to.
    pub part: u32,
}

impl Cluster {
    /// The range of its triangles, in the mesh's order.
    #[must_use]
    pub fn triangles(&self) -> core::ops::Range<u32> {
        self.first_triangle..self.first_triangle + self.triangle_count
    }
}

/// Clusters of one part that follow each other in the mesh's order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PartRun {
    pub(crate) part: u32,
    pub(crate) first_cluster: u32,
    pub(crate) cluster_count: u32,
}

impl PartRun {
    /// The range of its clusters.
    pub(crate) fn clusters(&self) -> core::ops::Range<u32> {
        self.first_cluster..self.first_cluster + self.cluster_count
    }
}

/// Why a mesh cannot be made.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum MeshError {
    /// A vertex with a NaN or infinite coordinate.
    #[error("vertex {vertex} is not finite: {}", Point(*position, Digits::Plain32))]
    NotFinite {
        /// Number of the vertex.
        vertex: usize,
        /// Where it is.
        position: [f32; 3],
    },
    /// An index beyond the vertices.
    #[error("index {at} is {index}, but there are {vertices} vertices")]
    Index {
        /// Position of the entry in the index list.
        at: usize,
        /// Its value.
        index: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// The number of indices is not a multiple of three.
    #[error("{0} indices do not make whole triangles")]
    NotTriangles(usize),
    /// More than fits the 32-bit numbers of a mesh.
    #[error("{count} {what} exceed the limit of {limit}")]
    TooMany {
        /// Kind of the items that are too many: vertices or triangles.
        what: &'static str,
        /// How many.
        count: usize,
        /// How many at the most.
        limit: usize,
    },
    /// Parts that do not cover the triangles in order.
    #[error("part {part} starts at triangle {first}, expected {expected} of {triangles}")]
    Parts {
        /// Number of the part.
        part: usize,
        /// Where it starts.
        first: u32,
        /// Where it should start.
        expected: u32,
        /// How many triangles there are.
        triangles: usize,
    },
    /// A clustering that is no permutation, or whose clusters break a limit or cross a part.
    #[error("clustering: {0}")]
    Clustering(String),
}

/// A triangle mesh: positions, triangles in cluster order, parts and clusters.
///
/// Triangles are permuted once, when the mesh is made;
/// [`original_triangle`](Self::original_triangle) leads back, and every triangle number that is
/// shown or drawn is the original one. Degenerate triangles (repeated indices, or an area that is
/// exactly zero, on a mesh that cannot deform) are kept at the end of the order, in no cluster:
/// nothing ever draws them.
#[derive(Clone, Debug)]
pub struct Mesh {
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
    original_triangle: Vec<u32>,
    parts: Vec<Part>,
    clusters: Vec<Cluster>,
    part_runs: Vec<PartRun>,
    cluster_boxes: Boxes,
    cluster_nodes: Nodes,
    bounds: Aabb,
    degenerate: u32,
    polygons: u32,
    deformable: bool,
    revision: u64,
}

impl Default for Mesh {
    /// A mesh without triangles.
    fn default() -> Self {
        let mut data = MeshData::default();
        complete_parts(&mut data);
        Self::assemble(data, Clustering { order: Vec::new(), clusters: Vec::new() })
    }
}

impl Mesh {
    /// A mesh with clusters of the simple kind: triangles in spatial order.
    ///
    /// # Errors
    /// If an index is out of range, a position is not finite, or a count does not fit.
    pub fn new(mut data: MeshData) -> Result<Self, MeshError> {
        check(&data)?;
        complete_parts(&mut data);
        let clustering = Clustering::of_checked(&data);
        Ok(Self::assemble(data, clustering))
    }

    /// A mesh with the clusters of the caller.
    ///
    /// # Errors
    /// As [`Mesh::new`], and if `clustering` does not hold every triangle that is not degenerate
    /// just once, in clusters within the limits that do not cross a part.
    pub fn with_clusters(mut data: MeshData, clustering: &Clustering) -> Result<Self, MeshError> {
        check(&data)?;
        complete_parts(&mut data);
        clustering.validate(&data)?;
        Ok(Self::assemble(data, clustering.clone()))
    }

    /// Both must have been checked. Takes what it can over instead of copying: the only new large
    /// allocation is the permuted index list, so that loading stays within thrice the geometry.
    fn assemble(data: MeshData, clustering: Clustering) -> Self {
        let MeshData { positions, indices, parts, polygons, deformable } = data;
        let Clustering { order: mut original_triangle, clusters } = clustering;
        let triangles = indices.len() / 3;
        let drawn = original_triangle.len();
        if drawn < triangles {
            let mut clustered = vec![false; triangles];
            original_triangle.iter().for_each(|&t| clustered[t as usize] = true);
            original_triangle.reserve_exact(triangles - drawn);
            original_triangle.extend((0..triangles as u32).filter(|&t| !clustered[t as usize]));
        }
        let mut permuted = Vec::with_capacity(indices.len());
        for &t in &original_triangle {
            permuted.extend_from_slice(&indices[t as usize * 3..][..3]);
        }
        drop(indices);
        let mut bounds = Aabb::EMPTY;
        let mut boxes = Vec::with_capacity(clusters.len());
        for c in &clusters {
            let corners =
                &permuted[c.first_triangle as usize * 3..][..c.triangle_count as usize * 3];
            let b = box_of(corners, &positions);
            bounds = bounds.union(&b);
            boxes.push(b);
        }
        let cluster_boxes = Boxes::from_slice(&boxes);
        Self {
            polygons: if polygons == 0 { triangles as u32 } else { polygons },
            degenerate: (triangles - drawn) as u32,
            part_runs: part_runs(&clusters),
            clusters,
            indices: permuted,
            positions,
            original_triangle,
            parts,
            cluster_nodes: Nodes::over(crate::Simd::best(), &cluster_boxes),
            cluster_boxes,
            bounds,
            deformable,
            revision: math::unique(),
        }
    }

    /// Vertex positions, as they were given.
    #[must_use]
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.positions
    }

    /// Three indices a triangle, in the mesh's order: clusters first, degenerate triangles last.
    #[must_use]
    pub fn indices(&self) -> &[u32] {
        &self.indices
    }

    /// How many triangles there are, degenerate ones included.
    #[must_use]
    pub fn triangle_count(&self) -> u32 {
        (self.indices.len() / 3) as u32
    }

    /// How many polygons the triangles came from.
    #[must_use]
    pub fn polygon_count(&self) -> u32 {
        self.polygons
    }

    /// How many triangles at the end of the order are degenerate and in no cluster.
    #[must_use]
    pub fn degenerate_count(&self) -> u32 {
        self.degenerate
    }

    /// The degenerate triangles, in the mesh's order: they follow the last cluster.
    pub(crate) fn degenerate_triangles(&self) -> core::ops::Range<u32> {
        let count = self.triangle_count();
        count - self.degenerate..count
    }

    /// The original number of each triangle of the mesh's order.
    #[must_use]
    pub fn original_triangle(&self) -> &[u32] {
        &self.original_triangle
    }

    /// Three indices a triangle, in the original order, which is that of the parts. O(triangles).
    #[must_use]
    pub fn original_indices(&self) -> Vec<u32> {
        let mut indices = vec![0; self.indices.len()];
        for (t, &original) in self.indices.chunks_exact(3).zip(&self.original_triangle) {
            indices[original as usize * 3..][..3].copy_from_slice(t);
        }
        indices
    }

    /// Input that the mesh was made of, its triangles in their original order: to make it again in
    /// another way. Copies all of it.
    #[must_use]
    pub fn to_data(&self) -> MeshData {
        MeshData {
            positions: self.positions.clone(),
            indices: self.original_indices(),
            parts: self.parts.clone(),
            polygons: self.polygons,
            deformable: self.deformable,
        }
    }

    /// The vertex indices of triangle `t` of the mesh's order.
    #[must_use]
    pub fn triangle(&self, t: u32) -> [u32; 3] {
        let i = t as usize * 3;
        [self.indices[i], self.indices[i + 1], self.indices[i + 2]]
    }

    /// The corners of triangle `t` of the mesh's order.
    #[must_use]
    pub fn corners(&self, t: u32) -> [[f32; 3]; 3] {
        self.triangle(t).each(|v| self.positions[v as usize])
    }

    /// Parts; their ranges are of original triangle numbers.
    #[must_use]
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// Clusters, in the mesh's order.
    #[must_use]
    pub fn clusters(&self) -> &[Cluster] {
        &self.clusters
    }

    /// Returns the number of clusters.
    #[must_use]
    pub fn cluster_count(&self) -> u32 {
        self.clusters.len() as u32
    }

    /// The clusters of each part, in the mesh's order: what is drawn at once. As many runs as
    /// parts, unless a clustering of the caller's mixes them.
    pub(crate) fn part_runs(&self) -> &[PartRun] {
        &self.part_runs
    }

    /// Range of [`indices`](Self::indices) of some clusters that follow each other: what to draw
    /// for a [`DrawRange`](crate::draw::DrawRange). Empty for no clusters.
    ///
    /// # Panics
    /// If there are not as many clusters.
    #[must_use]
    pub fn index_range(&self, clusters: core::ops::Range<u32>) -> core::ops::Range<u32> {
        match &self.clusters[clusters.start as usize..clusters.end as usize] {
            [] => 0..0,
            [one] => one.first_triangle * 3..one.triangles().end * 3,
            [first, .., last] => first.first_triangle * 3..last.triangles().end * 3,
        }
    }

    /// Some clusters that follow each other as runs of one part each: parts and clusters.
    pub(crate) fn runs_of_parts(
        &self,
        clusters: core::ops::Range<u32>,
    ) -> impl Iterator<Item = (u32, core::ops::Range<u32>)> {
        let core::ops::Range { start, end } = clusters;
        let first = self.part_runs.partition_point(|run| run.clusters().end <= start);
        let runs = self.part_runs[first..].iter().take_while(move |run| run.first_cluster < end);
        runs.map(move |run| (run.part, run.first_cluster.max(start)..run.clusters().end.min(end)))
    }

    /// The box of each cluster, made ready for batch tests.
    #[must_use]
    pub fn cluster_boxes(&self) -> &Boxes {
        &self.cluster_boxes
    }

    /// Nodes over the boxes of the clusters.
    #[must_use]
    pub fn cluster_nodes(&self) -> &Nodes {
        &self.cluster_nodes
    }

    /// The box around all triangles that are not degenerate; empty if there are none.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Whether vertices may move later.
    #[must_use]
    pub fn is_deformable(&self) -> bool {
        self.deformable
    }

    /// Whether no part has a side that is not drawn.
    #[must_use]
    pub fn is_two_sided(&self) -> bool {
        self.parts.iter().all(|part| part.two_sided)
    }

    /// Declares every part one-sided or two-sided.
    pub fn set_two_sided(&mut self, two_sided: bool) {
        if self.parts.iter().any(|p| p.two_sided != two_sided) {
            self.parts.iter_mut().for_each(|p| p.two_sided = two_sided);
            self.revision = math::unique();
        }
    }

    /// Number that two meshes share only if one is an unchanged copy of the other.
    pub(crate) fn revision(&self) -> u64 {
        self.revision
    }
}

fn part_runs(clusters: &[Cluster]) -> Vec<PartRun> {
    let mut first_cluster = 0;
    let run = |same: &[Cluster]| {
        let cluster_count = same.len() as u32;
        first_cluster += cluster_count;
        PartRun { part: same[0].part, first_cluster: first_cluster - cluster_count, cluster_count }
    };
    clusters.chunk_by(|a, b| a.part == b.part).map(run).collect()
}

/// The box around the vertices of a part of an index list.
fn box_of(indices: &[u32], positions: &[[f32; 3]]) -> Aabb {
    // Coordinates are finite, so plain comparisons do; they compile to one instruction each.
    let mut b = Aabb::EMPTY;
    for &v in indices {
        let p = positions[v as usize];
        for axis in 0..3 {
            b.min[axis] = if p[axis] < b.min[axis] { p[axis] } else { b.min[axis] };
            b.max[axis] = if p[axis] > b.max[axis] { p[axis] } else { b.max[axis] };
        }
    }
    b
}

/// Whether a triangle covers nothing: repeated indices, or an area that is exactly zero (found
/// without rounding, so a triangle that is merely thin is never one). NaN coordinates are not zero.
///
/// # Panics
/// If an index is not below the number of positions.
#[must_use]
pub fn is_degenerate(triangle: [u32; 3], positions: &[[f32; 3]]) -> bool {
    let [a, b, c] = triangle;
    a == b
        || b == c
        || c == a
        || crate::exact::is_collinear(&triangle.each(|v| positions[v as usize]))
}

/// Gives a mesh without parts one: opaque, and one-sided where it is a body.
fn complete_parts(data: &mut MeshData) {
    if data.parts.is_empty() {
        let is_body = !data.deformable && sides::encloses(&data.positions, &data.indices);
        data.parts.push(Part { two_sided: !is_body, ..whole(data.indices.len() / 3) });
    }
}

fn whole(triangles: usize) -> Part {
    Part { triangle_count: triangles as u32, two_sided: true, ..Part::default() }
}

/// Checks everything that later code relies on.
fn check(data: &MeshData) -> Result<(), MeshError> {
    // Triangle numbers and index positions are u32 all through.
    const LIMIT: usize = (u32::MAX / 3) as usize;
    let triangles = data.indices.len() / 3;
    if !data.indices.len().is_multiple_of(3) {
        return Err(MeshError::NotTriangles(data.indices.len()));
    }
    for (what, count) in [("vertices", data.positions.len()), ("triangles", triangles)] {
        if count > LIMIT {
            return Err(MeshError::TooMany { what, count, limit: LIMIT });
        }
    }
    if let Some(vertex) = data.positions.iter().position(|p| !p.iter().all(|v| v.is_finite())) {
        return Err(MeshError::NotFinite { vertex, position: data.positions[vertex] });
    }
    let vertices = data.positions.len();
    if let Some(at) = data.indices.iter().position(|&i| i as usize >= vertices) {
        return Err(MeshError::Index { at, index: data.indices[at], vertices });
    }
    let mut expected = 0u32;
    for (i, part) in data.parts.iter().enumerate() {
        let end = part.first_triangle as usize + part.triangle_count as usize;
        if part.first_triangle != expected || end > triangles {
            let first = part.first_triangle;
            return Err(MeshError::Parts { part: i, first, expected, triangles });
        }
        expected = end as u32;
    }
    if !data.parts.is_empty() && expected as usize != triangles {
        let part = data.parts.len();
        let (first, expected) = (expected, triangles as u32);
        return Err(MeshError::Parts { part, first, expected, triangles });
    }
    Ok(())
}
