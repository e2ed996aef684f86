//! A triangle list as a surface: corners without degenerate triangles, edges, and shells.

use cullet::mesh::weld;
use glam::DVec3;

/// Triangles whose three corners differ.
pub(super) struct Surface<'a> {
    pub(super) positions: &'a [[f32; 3]],
    pub(super) corners: Vec<[u32; 3]>,
}

impl<'a> Surface<'a> {
    /// Builds the surface of a triangle list, with equal positions made one vertex.
    pub(super) fn welded(positions: &'a [[f32; 3]], indices: &[u32]) -> Self {
        let first = weld(positions);
        Self::build(positions, indices, |v| first.get(v as usize).copied())
    }

    /// Builds the surface of a triangle list and keeps its vertex numbering.
    pub(super) fn indexed(positions: &'a [[f32; 3]], indices: &[u32]) -> Self {
        Self::build(positions, indices, |v| ((v as usize) < positions.len()).then_some(v))
    }

    fn build(
        positions: &'a [[f32; 3]],
        indices: &[u32],
        vertex: impl Fn(u32) -> Option<u32>,
    ) -> Self {
        // Made at its full size: growing would hold the old and the new.
        let mut corners = Vec::with_capacity(indices.len() / 3);
        for i in indices.chunks_exact(3) {
            if let (Some(a), Some(b), Some(c)) = (vertex(i[0]), vertex(i[1]), vertex(i[2]))
                && a != b
                && b != c
                && c != a
            {
                corners.push([a, b, c]);
            }
        }
        Self { positions, corners }
    }

    pub(super) fn points(&self, triangle: usize) -> [[f32; 3]; 3] {
        self.corners[triangle].map(|v| self.positions[v as usize])
    }

    /// Six times the signed volume between a triangle and `about`.
    pub(super) fn volume6(&self, triangle: usize, about: DVec3) -> f64 {
        let [a, b, c] = self.points(triangle).map(|p| DVec3::from(p.map(f64::from)) - about);
        a.dot(b.cross(c))
    }
}

/// One use of an edge by a triangle.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(transparent)]
pub(super) struct HalfEdge(u64);

impl HalfEdge {
    fn new(high: u32, triangle: usize, falling: bool) -> Self {
        Self(u64::from(high) << 32 | (triangle as u64) << 1 | u64::from(falling))
    }

    /// The edge's higher vertex.
    fn high(self) -> u32 {
        (self.0 >> 32) as u32
    }

    pub(super) fn triangle(self) -> usize {
        (self.0 as u32 >> 1) as usize
    }

    /// Whether the triangle runs from the higher vertex to the lower.
    pub(super) fn falling(self) -> bool {
        self.0 & 1 == 1
    }
}

/// In how many passes the edges are visited at most: each goes over all triangles and holds its
/// share of their half edges, so that these are a quarter of what they would be. That keeps a mesh
/// and its edges within thrice its geometry.
const PASSES: usize = 4;
/// The fewest half edges that get a pass of their own: 1 MiB, which a processor's cache holds.
const LEAST_HALF_EDGES: usize = 1 << 17;

/// Calls `visit` with the uses of each edge. O(n) apart from a sort of the edges at each vertex:
/// half edges are dealt into buckets by their lower vertex, which hold six on average.
///
/// Besides the surface it takes 4 bytes a vertex and 6 a triangle (8 bytes for each of its half
/// edges, in four passes), and more only where one vertex has more than a quarter of all edges.
pub(super) fn for_each_edge(surface: &Surface<'_>, visit: impl FnMut(&[HalfEdge])) {
    let least = (surface.corners.len() * 3).div_ceil(PASSES);
    for_each_edge_within(surface, least.max(LEAST_HALF_EDGES), visit);
}

/// Calls `visit` with the uses of each edge. Holds no more than `limit` half edges at once, unless
/// a single vertex has more.
fn for_each_edge_within(surface: &Surface<'_>, limit: usize, mut visit: impl FnMut(&[HalfEdge])) {
    let half_edges = || {
        surface.corners.iter().enumerate().flat_map(|(t, &[a, b, c])| {
            [(a, b), (b, c), (c, a)].map(|(p, q)| (p.min(q), HalfEdge::new(p.max(q), t, p > q)))
        })
    };
    // Where the bucket of each vertex begins; once it is full, where it ends.
    let mut place = vec![0u32; surface.positions.len()];
    half_edges().for_each(|(low, _)| place[low as usize] += 1);
    let mut total = 0;
    for p in &mut place {
        let count = *p;
        *p = total;
        total += count;
    }
    // Made at its full size: growing would hold the old and the new.
    let mut buckets = Vec::with_capacity(limit.min(total as usize));
    let mut first = 0;
    let mut begin = 0;
    while begin < total {
        // Vertices from `first` on whose buckets fit, one at least.
        let fits = |&p: &u32| (p - begin) as usize <= limit;
        let fitting = place[first + 1..].partition_point(fits);
        let mut after = first + 1 + fitting;
        if after < place.len() || (total - begin) as usize > limit {
            // The last of them begins within the limit, but ends beyond it.
            after = (after - 1).max(first + 1);
        }
        let end = place.get(after).copied().unwrap_or(total);
        buckets.clear();
        buckets.resize((end - begin) as usize, HalfEdge(0));
        let vertices = first as u32..after as u32;
        for (low, half) in half_edges().filter(|(low, _)| vertices.contains(low)) {
            let at = &mut place[low as usize];
            buckets[(*at - begin) as usize] = half;
            *at += 1;
        }
        let mut rest = buckets.as_mut_slice();
        for &p in &place[first..after] {
            let (bucket, behind) = std::mem::take(&mut rest).split_at_mut((p - begin) as usize);
            bytemuck::cast_slice_mut::<_, u64>(bucket).sort_unstable();
            bucket.chunk_by(|a, b| a.high() == b.high()).for_each(&mut visit);
            (rest, begin) = (behind, p);
        }
        first = after;
    }
}

/// Sets of triangles joined by edges: a union-find.
pub(super) struct Shells {
    parents: Vec<u32>,
}

impl Shells {
    pub(super) fn new(triangles: usize) -> Self {
        Self { parents: (0..triangles as u32).collect() }
    }

    /// Returns the first triangle of the set of `t`.
    fn find(&mut self, t: usize) -> usize {
        let mut at = t;
        while self.parents[at] as usize != at {
            // Path halving: link to the grandparent.
            self.parents[at] = self.parents[self.parents[at] as usize];
            at = self.parents[at] as usize;
        }
        at
    }

    /// Joins the sets of two triangles.
    pub(super) fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.find(a), self.find(b));
        self.parents[a.max(b)] = a.min(b) as u32;
    }

    /// Returns the number of sets, and the set of each triangle, numbered in the order of first
    /// triangles.
    pub(super) fn number(&mut self) -> (usize, Vec<u32>) {
        let mut count = 0;
        let mut of = vec![0u32; self.parents.len()];
        for t in 0..of.len() {
            let root = self.find(t);
            // A root is the lowest triangle of its set, so it was numbered before.
            of[t] = if root == t { count } else { of[root] };
            count += u32::from(root == t);
        }
        (count as usize, of)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    /// Uses of each edge, by lower and higher vertex.
    fn edges_ref(indices: &[u32]) -> BTreeMap<(u32, u32), Vec<(usize, bool)>> {
        let mut edges: BTreeMap<_, Vec<_>> = BTreeMap::new();
        for (t, c) in indices.chunks_exact(3).enumerate() {
            for (p, q) in [(c[0], c[1]), (c[1], c[2]), (c[2], c[0])] {
                edges.entry((p.min(q), p.max(q))).or_default().push((t, p > q));
            }
        }
        edges
    }

    #[test]
    fn edges_are_the_same_in_any_number_of_passes() {
        // A fan around vertex 0, a strip, and vertices that nothing uses.
        let fan = (2..40).flat_map(|v| [0, v - 1, v]);
        let strip = (50..120).flat_map(|v| [v, v + 1, v + 2]);
        let indices: Vec<u32> = fan.chain(strip).collect();
        let positions: Vec<[f32; 3]> = (0..130).map(|v| [v as f32, 0.0, 0.0]).collect();
        let surface = Surface::indexed(&positions, &indices);
        let expected: Vec<_> = edges_ref(&indices).into_values().collect();
        for limit in [1, 2, 3, 7, 50, 100, 300, 10_000] {
            let mut found = Vec::new();
            for_each_edge_within(&surface, limit, |uses| {
                found.push(uses.iter().map(|u| (u.triangle(), u.falling())).collect::<Vec<_>>());
            });
            assert_eq!(found, expected, "limit {limit}");
        }
        for_each_edge(&Surface::indexed(&[], &[]), |_| panic!("no triangles, but an edge"));
    }

    #[test]
    fn triangles_without_three_different_corners_are_left_out() {
        let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0; 3]];
        let indices = [0, 0, 1, 0, 1, 2, 0, 1, 9, 0, 1, 3, 2, 1, 3, 1, 1, 1];
        let surface = Surface::welded(&positions, &indices);
        assert_eq!(surface.corners, [[0, 1, 2], [2, 1, 0]]);
    }
}
