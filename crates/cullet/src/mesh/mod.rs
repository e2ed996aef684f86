//! Meshes: checked on construction, cut into clusters by one permutation of their triangles.

mod clusters;
mod topology;

pub use clusters::{Clustering, MAX_CLUSTER_TRIANGLES, MAX_CLUSTER_VERTICES};
pub use topology::{NotSolid, Topology};

use thiserror::Error;

use crate::bounds::{Aabb, Boxes};

/// What the alpha of a part's material does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
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
pub struct Part {
    /// First triangle of the range.
    pub first_triangle: u32,
    /// How many triangles.
    pub triangle_count: u32,
    /// The caller's number for the material.
    pub material: u32,
    /// Whether both sides of its triangles are drawn.
    pub two_sided: bool,
    /// What its alpha does.
    pub alpha: Alpha,
}

/// What a mesh is made from: plain data, not yet checked.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshData {
    /// Vertex positions.
    pub positions: Vec<[f32; 3]>,
    /// Three indices a triangle.
    pub indices: Vec<u32>,
    /// Ranges of triangles, in order and without gap; empty means one opaque, two-sided part.
    pub parts: Vec<Part>,
    /// How many polygons the triangles came from; 0 means that each triangle is a polygon.
    pub polygons: u32,
    /// Whether vertices may move later (skinned, morphed): then no triangle is degenerate for good.
    pub deformable: bool,
}

/// A few triangles near each other, drawn or culled together: contiguous in the mesh's order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cluster {
    /// First triangle, in the mesh's order.
    pub first_triangle: u32,
    /// How many triangles, at most [`MAX_CLUSTER_TRIANGLES`].
    pub triangle_count: u32,
    /// The part that all its triangles belong to.
    pub part: u32,
}

/// A level of detail: a range of the mesh's clusters. Level 0 is the mesh as it was given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Level {
    /// First cluster.
    pub first_cluster: u32,
    /// How many clusters.
    pub cluster_count: u32,
}

/// Why a mesh cannot be made.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum MeshError {
    /// A vertex with a NaN or infinite coordinate.
    #[error("vertex {vertex} is not finite: {position:?}")]
    NotFinite {
        /// Which vertex.
        vertex: usize,
        /// Where it is.
        position: [f32; 3],
    },
    /// An index beyond the vertices.
    #[error("index {at} is {index}, but there are {vertices} vertices")]
    Index {
        /// Which entry of the index list.
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
        /// Of what.
        what: &'static str,
        /// How many.
        count: usize,
        /// How many at the most.
        limit: usize,
    },
    /// Parts that do not cover the triangles in order.
    #[error("part {part} starts at triangle {first}, expected {expected} of {triangles}")]
    Parts {
        /// Which part.
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

/// A triangle mesh: positions, triangles in cluster order, parts, clusters and levels.
///
/// Triangles are permuted once, when the mesh is made; [`original_triangle`](Self::original_triangle)
/// leads back, and every triangle number that is shown or drawn is the original one. Degenerate
/// triangles (repeated indices, or an area that is exactly zero in f64, on a mesh that cannot deform)
/// are kept at the end of the order, in no cluster: nothing ever draws them.
#[derive(Clone, Debug)]
pub struct Mesh {
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
    original_triangle: Vec<u32>,
    parts: Vec<Part>,
    clusters: Vec<Cluster>,
    cluster_boxes: Boxes,
    levels: Vec<Level>,
    bounds: Aabb,
    degenerate: u32,
    polygons: u32,
    deformable: bool,
}

impl Mesh {
    /// A mesh with clusters of the simple kind: triangles in spatial order.
    ///
    /// # Errors
    /// If an index is out of range, a position is not finite, or a count does not fit.
    pub fn new(data: MeshData) -> Result<Self, MeshError> {
        let data = check(data)?;
        let clustering = Clustering::spatial(&data);
        Self::assemble(data, &clustering)
    }

    /// A mesh with the clusters of the caller.
    ///
    /// # Errors
    /// As [`Mesh::new`], and if `clustering` does not hold every triangle that is not degenerate just
    /// once, in clusters within the limits that do not cross a part.
    pub fn with_clusters(data: MeshData, clustering: &Clustering) -> Result<Self, MeshError> {
        let data = check(data)?;
        clustering.validate(&data)?;
        Self::assemble(data, clustering)
    }

    fn assemble(data: MeshData, clustering: &Clustering) -> Result<Self, MeshError> {
        let MeshData { positions, indices, parts, polygons, deformable } = data;
        let triangle = |t: u32| {
            let i = t as usize * 3;
            [indices[i], indices[i + 1], indices[i + 2]]
        };
        let triangles = indices.len() / 3;
        let mut original_triangle = clustering.order.clone();
        let drawn = original_triangle.len();
        if drawn < triangles {
            let mut clustered = vec![false; triangles];
            clustering.order.iter().for_each(|&t| clustered[t as usize] = true);
            original_triangle.extend((0..triangles as u32).filter(|&t| !clustered[t as usize]));
        }
        let permuted: Vec<u32> = original_triangle.iter().flat_map(|&t| triangle(t)).collect();
        let mut cluster_boxes = Boxes::new();
        let mut bounds = Aabb::EMPTY;
        for c in &clustering.clusters {
            let first = c.first_triangle as usize * 3;
            let mut b = Aabb::EMPTY;
            for &v in &permuted[first..first + c.triangle_count as usize * 3] {
                let p = positions[v as usize];
                b = b.union(&Aabb::new(p, p));
            }
            cluster_boxes.push(&b);
            bounds = bounds.union(&b);
        }
        let levels =
            vec![Level { first_cluster: 0, cluster_count: clustering.clusters.len() as u32 }];
        Ok(Self {
            polygons: if polygons == 0 { triangles as u32 } else { polygons },
            degenerate: (triangles - drawn) as u32,
            clusters: clustering.clusters.clone(),
            indices: permuted,
            positions,
            original_triangle,
            parts,
            cluster_boxes,
            levels,
            bounds,
            deformable,
        })
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

    /// The original number of each triangle of the mesh's order.
    #[must_use]
    pub fn original_triangle(&self) -> &[u32] {
        &self.original_triangle
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
        self.triangle(t).map(|v| self.positions[v as usize])
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

    /// The box of each cluster, made ready for batch tests.
    #[must_use]
    pub fn cluster_boxes(&self) -> &Boxes {
        &self.cluster_boxes
    }

    /// Levels of detail, finest first.
    #[must_use]
    pub fn levels(&self) -> &[Level] {
        &self.levels
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

    /// What the welded surface is like; see [`Topology`]. Costs a sort of the edges, so keep the answer.
    #[must_use]
    pub fn topology(&self) -> Topology {
        Topology::of(&self.positions, &self.indices)
    }

    /// Whether this is a solid in the sense of the project, or the first reason why it is not:
    /// closed, manifold, consistently wound outward, of non-zero volume, and opaque in every part.
    ///
    /// # Errors
    /// The reason.
    pub fn solid(&self) -> Result<(), NotSolid> {
        if let Some(part) = self.parts.iter().position(|p| p.alpha != Alpha::Opaque) {
            return Err(NotSolid::NotOpaque { part: part as u32 });
        }
        self.topology().solid()
    }

    /// Declares every part one-sided or two-sided.
    pub fn set_two_sided(&mut self, two_sided: bool) {
        self.parts.iter_mut().for_each(|p| p.two_sided = two_sided);
    }
}

/// Whether a triangle covers nothing: repeated indices, or an area that is exactly zero in f64.
#[must_use]
pub fn is_degenerate(triangle: [u32; 3], positions: &[[f32; 3]]) -> bool {
    let [a, b, c] = triangle;
    if a == b || b == c || c == a {
        return true;
    }
    let [a, b, c] = [a, b, c].map(|v| glam::DVec3::from(positions[v as usize].map(f64::from)));
    (b - a).cross(c - a) == glam::DVec3::ZERO
}

/// Checks the data and completes its parts.
fn check(mut data: MeshData) -> Result<MeshData, MeshError> {
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
    if data.parts.is_empty() {
        data.parts.push(Part {
            triangle_count: triangles as u32,
            two_sided: true,
            ..Part::default()
        });
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
    if expected as usize != triangles {
        let part = data.parts.len();
        return Err(MeshError::Parts {
            part,
            first: expected,
            expected: triangles as u32,
            triangles,
        });
    }
    Ok(data)
}
