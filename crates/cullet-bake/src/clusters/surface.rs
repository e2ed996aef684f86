//! The triangles of one part as a graph: which share an edge.

use std::ops::Range;

use cullet::bounds::Aabb;
use glam::DVec3;

/// Some triangles of a mesh, numbered from 0.
#[derive(Debug, Default)]
pub(super) struct PartSurface {
    /// The mesh's number of each triangle.
    pub(super) source: Vec<u32>,
    /// Its vertices, as the mesh numbers them: what the limit of vertices counts.
    pub(super) corners: Vec<[u32; 3]>,
    /// The box of each.
    pub(super) boxes: Vec<Aabb>,
    /// Triangles that share an edge: of triangle t, `links[starts[t]..starts[t + 1]]`.
    links: Vec<u32>,
    starts: Vec<u32>,
}

impl PartSurface {
    /// The triangles `source` of an index list. Edges are joined where the positions of their ends
    /// are equal, so that a seam of texture coordinates is no border. O(n log n).
    pub(super) fn new(
        positions: &[[f32; 3]],
        indices: &[u32],
        welded: &[u32],
        source: Vec<u32>,
    ) -> Self {
        let corners: Vec<[u32; 3]> =
            source.iter().map(|&t| std::array::from_fn(|k| indices[t as usize * 3 + k])).collect();
        let box_of = |c: &[u32; 3]| Aabb::from_points(&c.map(|v| positions[v as usize]));
        let boxes = corners.iter().map(box_of).collect();
        let (starts, links) = edges(&corners, welded);
        Self { source, corners, boxes, links, starts }
    }

    pub(super) fn len(&self) -> usize {
        self.source.len()
    }

    /// Triangles that share an edge with `t`.
    pub(super) fn neighbours(&self, t: u32) -> &[u32] {
        let range: Range<usize> =
            self.starts[t as usize] as usize..self.starts[t as usize + 1] as usize;
        &self.links[range]
    }
}

/// Neighbours of each triangle as ranges of one list. The triangles at an edge are linked in a row,
/// each to the next: at an edge of thousands of triangles, all pairs would be millions.
fn edges(corners: &[[u32; 3]], welded: &[u32]) -> (Vec<u32>, Vec<u32>) {
    let mut half: Vec<(u64, u32)> = Vec::with_capacity(corners.len() * 3);
    for (t, c) in corners.iter().enumerate() {
        let [a, b, c] = c.map(|v| welded[v as usize]);
        for (p, q) in [(a, b), (b, c), (c, a)] {
            if p != q {
                half.push((u64::from(p.min(q)) << 32 | u64::from(p.max(q)), t as u32));
            }
        }
    }
    half.sort_unstable();
    let mut pairs: Vec<(u32, u32)> = Vec::with_capacity(half.len());
    for two in half.windows(2) {
        if two[0].0 == two[1].0 && two[0].1 != two[1].1 {
            pairs.extend([(two[0].1, two[1].1), (two[1].1, two[0].1)]);
        }
    }
    pairs.sort_unstable();
    pairs.dedup();
    let mut starts = vec![0u32; corners.len() + 1];
    for &(t, _) in &pairs {
        starts[t as usize + 1] += 1;
    }
    for t in 0..corners.len() {
        starts[t + 1] += starts[t];
    }
    (starts, pairs.into_iter().map(|p| p.1).collect())
}

/// The planes of triangles, in units in which the mesh's sphere has radius 1 around the origin.
pub(super) struct Frame {
    centre: DVec3,
    radius: f64,
}

impl Frame {
    /// Around the corners of some triangles; a mesh of one point has radius 1.
    pub(super) fn around(positions: &[[f32; 3]], surfaces: &[PartSurface]) -> Self {
        let points = || {
            let corners = surfaces.iter().flat_map(|s| s.corners.as_flattened());
            corners.map(|&v| DVec3::from(positions[v as usize].map(f64::from)))
        };
        let (low, high) =
            points().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
        let centre = if low.is_finite() { (low + high) * 0.5 } else { DVec3::ZERO };
        let radius = points().map(|p| p.distance_squared(centre)).fold(0.0, f64::max).sqrt();
        Self { centre, radius: if radius > 0.0 { radius } else { 1.0 } }
    }

    pub(super) fn place(&self, p: [f32; 3]) -> DVec3 {
        (DVec3::from(p.map(f64::from)) - self.centre) / self.radius
    }

    /// Unit normal and offset of a triangle: n·x = d. A triangle without area has a normal of zero.
    pub(super) fn plane(&self, corners: [[f32; 3]; 3]) -> (DVec3, f64) {
        let [a, b, c] = corners.map(|p| self.place(p));
        let n = (b - a).cross(c - a).normalize_or_zero();
        (n, n.dot(a).min(n.dot(b)).min(n.dot(c)))
    }
}
