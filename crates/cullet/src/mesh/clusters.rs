//! Clusters of a mesh's triangles, and the simple generator: triangles in spatial order.

use alloc::format;
use alloc::string::String;
use alloc::vec;
use alloc::vec::Vec;

use super::{Cluster, MeshData, MeshError, is_degenerate};
use crate::array::{self, Each};
use crate::sort::{Sorter, of_f32, select_by, sort};

/// The most vertices that a cluster may use: the mesh-shader limit that vendors recommend.
pub const MAX_CLUSTER_VERTICES: usize = 64;
/// The most triangles in a cluster: 126 is the mesh-shader limit, 124 keeps their local indices in
/// a multiple of four bytes.
pub const MAX_CLUSTER_TRIANGLES: usize = 124;

/// A way to cut a mesh into clusters: an order of its triangles, and ranges of that order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Clustering {
    /// Original triangle numbers, cluster by cluster. Triangles left out are degenerate.
    pub order: Vec<u32>,
    /// Ranges of `order`, without gap.
    pub clusters: Vec<Cluster>,
}

impl Clustering {
    /// Triangles of each part split in two by the middle of their centres along the longest axis,
    /// until each half fits a cluster; within a cluster they keep their order. Degenerate triangles
    /// are left out, unless the mesh can deform. Deterministic; O(n log n).
    ///
    /// Cutting a space-filling curve where a cluster is full was tried and takes as long: along a
    /// Hilbert curve clusters are 7 to 16 % fewer, but their boxes have 1.5 to 2.3 times the
    /// surface, along a Morton curve 2.2 to 3.5 times (bunny, armadillo, buddha, a ball). On soups
    /// of many small components (Sponza) the curve makes a third fewer clusters.
    ///
    /// # Errors
    /// As [`Mesh::new`](super::Mesh::new).
    pub fn spatial(data: &MeshData) -> Result<Self, MeshError> {
        super::check(data)?;
        Ok(Self::of_checked(data))
    }

    /// Keeps the caller's order: runs of consecutive triangles of one part, each as long as a
    /// cluster may be. A mesh [with these clusters](super::Mesh::with_clusters) has the indices
    /// that it was given, so that a renderer draws from the index buffer that it has. Degenerate
    /// triangles keep their places and are drawn. O(n).
    ///
    /// Clusters are as compact as the order is: of indices sorted for a vertex cache they are about
    /// as good as [`spatial`](Self::spatial) ones, of a random order each is as large as the mesh,
    /// and culls nothing.
    ///
    /// # Errors
    /// As [`Mesh::new`](super::Mesh::new).
    pub fn in_order(data: &MeshData) -> Result<Self, MeshError> {
        super::check(data)?;
        let triangles = data.indices.len() / 3;
        let whole = [super::whole(triangles)];
        let parts = if data.parts.is_empty() { &whole } else { data.parts.as_slice() };
        let mut used_by = vec![0; data.positions.len()];
        let mut clusters: Vec<Cluster> = Vec::new();
        for (number, part) in (0..).zip(parts) {
            let mut vertices = usize::MAX;
            for t in part.first_triangle..part.first_triangle + part.triangle_count {
                let corners = &data.indices[t as usize * 3..][..3];
                let is_new = |used_by: &[u32], at: usize, stamp: usize| {
                    used_by[corners[at] as usize] != stamp as u32
                        && !corners[..at].contains(&corners[at])
                };
                let new = (0..3).filter(|&at| is_new(&used_by, at, clusters.len())).count();
                match clusters.last_mut() {
                    Some(open)
                        if vertices.saturating_add(new) <= MAX_CLUSTER_VERTICES
                            && (open.triangle_count as usize) < MAX_CLUSTER_TRIANGLES =>
                    {
                        open.triangle_count += 1;
                        vertices += new;
                    }
                    _ => {
                        clusters.push(Cluster {
                            first_triangle: t,
                            triangle_count: 1,
                            part: number,
                        });
                        vertices =
                            (0..3).filter(|&at| is_new(&used_by, at, clusters.len())).count();
                    }
                }
                corners.iter().for_each(|&v| used_by[v as usize] = clusters.len() as u32);
            }
        }
        Ok(Self { order: (0..triangles as u32).collect(), clusters })
    }

    pub(super) fn of_checked(data: &MeshData) -> Self {
        let whole = [super::whole(data.indices.len() / 3)];
        let parts = if data.parts.is_empty() { &whole } else { data.parts.as_slice() };
        let mut builder = Builder {
            data,
            result: Self {
                order: Vec::with_capacity(data.indices.len() / 3),
                clusters: Vec::new(),
            },
            used_by: vec![0; data.positions.len()],
            sorter: Sorter::default(),
            stamp: 0,
        };
        let largest = parts.iter().map(|p| p.triangle_count as usize).max();
        let mut centred = Vec::with_capacity(largest.unwrap_or_default());
        for (number, part) in parts.iter().enumerate() {
            centred.clear();
            for t in part.first_triangle..part.first_triangle + part.triangle_count {
                let corners = builder.triangle(t);
                if data.deformable || !is_degenerate(corners, &data.positions) {
                    let [a, b, c] = corners.each(|v| data.positions[v as usize]);
                    // Thirds are taken first: the sum of three large coordinates might overflow.
                    let centre = array::from_fn(|i| a[i] / 3.0 + b[i] / 3.0 + c[i] / 3.0);
                    centred.push((centre, t));
                }
            }
            builder.split(number as u32, &mut centred);
        }
        builder.result
    }

    /// Checks a clustering that came from elsewhere against the data it is for.
    pub(super) fn validate(&self, data: &MeshData) -> Result<(), MeshError> {
        let fail = |message: String| Err(MeshError::Clustering(message));
        let triangles = data.indices.len() / 3;
        let mut seen = vec![false; triangles];
        for &t in &self.order {
            match seen.get_mut(t as usize) {
                None => return fail(format!("triangle {t} of {triangles}")),
                Some(true) => return fail(format!("triangle {t} is there twice")),
                Some(seen) => *seen = true,
            }
        }
        let triangle = |t: u32| {
            let i = t as usize * 3;
            [data.indices[i], data.indices[i + 1], data.indices[i + 2]]
        };
        for t in (0..triangles as u32).filter(|&t| !seen[t as usize]) {
            if data.deformable || !is_degenerate(triangle(t), &data.positions) {
                return fail(format!("triangle {t} is left out but not degenerate"));
            }
        }
        let mut expected = 0;
        let mut vertices = Vec::new();
        for (i, c) in self.clusters.iter().enumerate() {
            let end = c.first_triangle as usize + c.triangle_count as usize;
            if c.first_triangle as usize != expected || end > self.order.len() {
                return fail(format!("cluster {i} starts at {}, not {expected}", c.first_triangle));
            }
            let Some(part) = data.parts.get(c.part as usize) else {
                return fail(format!("cluster {i} is of part {} of {}", c.part, data.parts.len()));
            };
            if c.triangle_count == 0 || c.triangle_count as usize > MAX_CLUSTER_TRIANGLES {
                return fail(format!(
                    "cluster {i} has {} triangles; 1 to {MAX_CLUSTER_TRIANGLES} are allowed",
                    c.triangle_count
                ));
            }
            vertices.clear();
            for &t in &self.order[expected..end] {
                if t < part.first_triangle || t >= part.first_triangle + part.triangle_count {
                    return fail(format!("cluster {i} has triangle {t}, not of part {}", c.part));
                }
                vertices.extend(triangle(t));
            }
            sort(&mut vertices);
            vertices.dedup();
            if vertices.len() > MAX_CLUSTER_VERTICES {
                return fail(format!(
                    "cluster {i} has {} vertices; {MAX_CLUSTER_VERTICES} are allowed",
                    vertices.len()
                ));
            }
            expected = end;
        }
        if expected != self.order.len() {
            return fail(format!("clusters end at {expected} of {}", self.order.len()));
        }
        Ok(())
    }
}

/// How many triangles a split aims at: a compact patch of a regular mesh has about half as many
/// vertices, and a ragged edge of twenty more. With 72 or 88 the test models end in more clusters.
const TARGET: usize = 80;

struct Builder<'a> {
    data: &'a MeshData,
    result: Clustering,
    /// The stamp of the range that last used a vertex.
    used_by: Vec<u32>,
    stamp: u32,
    sorter: Sorter,
}

impl Builder<'_> {
    fn triangle(&self, t: u32) -> [u32; 3] {
        let i = t as usize * 3;
        [self.data.indices[i], self.data.indices[i + 1], self.data.indices[i + 2]]
    }

    /// Makes clusters of some triangles of a part, given with their centres.
    fn split(&mut self, part: u32, range: &mut [([f32; 3], u32)]) {
        if self.close(part, range) {
            return;
        }
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for (c, _) in range.iter() {
            for a in 0..3 {
                low[a] = if c[a] < low[a] { c[a] } else { low[a] };
                high[a] = if c[a] > high[a] { c[a] } else { high[a] };
            }
        }
        let side = |a: usize| high[a] - low[a];
        let axis =
            if side(0) >= side(1).max(side(2)) { 0 } else { 1 + usize::from(side(2) > side(1)) };
        // At the middle, but so that both sides make whole clusters.
        let clusters = range.len().div_ceil(TARGET).max(2);
        let middle = clusters / 2 * range.len() / clusters;
        // Ties by number, so that the two halves are the same sets whatever the selection does
        // inside. In place: keys apart would take as much memory again as the centres.
        select_by(range, middle, &|&(c, t)| u64::from(of_f32(c[axis])) << 32 | u64::from(t));
        let (low, high) = range.split_at_mut(middle);
        self.split(part, low);
        self.split(part, high);
    }

    /// Makes a range one cluster, if it keeps the limits. An empty range makes none.
    fn close(&mut self, part: u32, range: &mut [([f32; 3], u32)]) -> bool {
        if range.len() > MAX_CLUSTER_TRIANGLES {
            return false;
        }
        self.stamp += 1;
        let mut vertices = 0;
        for &(_, t) in range.iter() {
            for v in self.triangle(t) {
                let user = &mut self.used_by[v as usize];
                vertices += usize::from(*user != self.stamp);
                *user = self.stamp;
            }
        }
        if vertices > MAX_CLUSTER_VERTICES {
            return false;
        }
        self.sorter.sort(range, |p| p.1.into());
        if !range.is_empty() {
            self.result.clusters.push(Cluster {
                first_triangle: self.result.order.len() as u32,
                triangle_count: range.len() as u32,
                part,
            });
        }
        self.result.order.extend(range.iter().map(|p| p.1));
        true
    }
}
