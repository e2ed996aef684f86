//! A triangle list as a surface: corners without degenerate triangles, edges, and shells.

use super::weld::weld;

/// Triangles whose three corners differ.
pub(super) struct Surface<'a> {
    pub(super) positions: &'a [[f32; 3]],
    pub(super) corners: Vec<[u32; 3]>,
    /// The triangle of the list that each one is.
    pub(super) source: Vec<u32>,
}

impl<'a> Surface<'a> {
    /// With equal positions made one vertex.
    pub(super) fn welded(positions: &'a [[f32; 3]], indices: &[u32]) -> Self {
        let first = weld(positions);
        Self::build(positions, indices, |v| first.get(v as usize).copied())
    }

    /// With vertices as they are numbered.
    pub(super) fn indexed(positions: &'a [[f32; 3]], indices: &[u32]) -> Self {
        Self::build(positions, indices, |v| ((v as usize) < positions.len()).then_some(v))
    }

    fn build(
        positions: &'a [[f32; 3]],
        indices: &[u32],
        vertex: impl Fn(u32) -> Option<u32>,
    ) -> Self {
        let triangles = indices.len() / 3;
        let (mut corners, mut source) =
            (Vec::with_capacity(triangles), Vec::with_capacity(triangles));
        for (t, i) in indices.chunks_exact(3).enumerate() {
            if let (Some(a), Some(b), Some(c)) = (vertex(i[0]), vertex(i[1]), vertex(i[2]))
                && a != b
                && b != c
                && c != a
            {
                corners.push([a, b, c]);
                source.push(t as u32);
            }
        }
        Self { positions, corners, source }
    }

    pub(super) fn points(&self, triangle: usize) -> [[f32; 3]; 3] {
        self.corners[triangle].map(|v| self.positions[v as usize])
    }

    /// Six times the signed volume between a triangle and `about`.
    pub(super) fn volume6(&self, triangle: usize, about: glam::DVec3) -> f64 {
        let [a, b, c] = self.points(triangle).map(|p| glam::DVec3::from(p.map(f64::from)) - about);
        a.dot(b.cross(c))
    }
}

/// One use of an edge by a triangle.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
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

/// Calls `visit` with the uses of each edge. O(n) apart from a sort of the edges at each vertex: half
/// edges are dealt into buckets by their lower vertex, which hold six on average.
pub(super) fn for_each_edge(surface: &Surface<'_>, mut visit: impl FnMut(&[HalfEdge])) {
    let half_edges = || {
        surface.corners.iter().enumerate().flat_map(|(t, &[a, b, c])| {
            [(a, b), (b, c), (c, a)].map(|(p, q)| (p.min(q), HalfEdge::new(p.max(q), t, p > q)))
        })
    };
    let mut end = vec![0u32; surface.positions.len()];
    half_edges().for_each(|(low, _)| end[low as usize] += 1);
    let mut total = 0;
    for e in &mut end {
        let count = *e;
        *e = total;
        total += count;
    }
    let mut buckets = vec![HalfEdge(0); total as usize];
    for (low, half) in half_edges() {
        let at = &mut end[low as usize];
        buckets[*at as usize] = half;
        *at += 1;
    }
    let mut rest = buckets.as_mut_slice();
    let mut start = 0;
    for &e in &end {
        let (bucket, after) = std::mem::take(&mut rest).split_at_mut((e - start) as usize);
        bucket.sort_unstable();
        bucket.chunk_by(|a, b| a.high() == b.high()).for_each(&mut visit);
        (rest, start) = (after, e);
    }
}

/// Sets of triangles joined by edges, with the parity of each: whether it must be turned over to run
/// like the first triangle of its set. A union-find whose links carry a bit.
pub(super) struct Shells {
    /// Parent and parity bit.
    links: Vec<u32>,
}

impl Shells {
    pub(super) fn new(triangles: usize) -> Self {
        Self { links: (0..triangles as u32).map(|t| t << 1).collect() }
    }

    /// The first triangle of the set of `t`, and the parity of `t` against it.
    pub(super) fn find(&mut self, t: usize) -> (usize, bool) {
        let (mut at, mut parity) = (t, 0);
        loop {
            let link = self.links[at];
            let parent = (link >> 1) as usize;
            if parent == at {
                return (at, parity == 1);
            }
            let above = self.links[parent];
            // Path halving: link to the grandparent, adding the parities of both steps.
            let step = (link ^ above) & 1;
            self.links[at] = above & !1 | step;
            parity ^= step;
            at = (above >> 1) as usize;
        }
    }

    /// Joins the sets of two triangles that do (`odd`) or do not run against each other. False where
    /// they were joined before with the other parity.
    pub(super) fn join(&mut self, a: usize, b: usize, odd: bool) -> bool {
        let ((a, pa), (b, pb)) = (self.find(a), self.find(b));
        let odd = odd ^ pa ^ pb;
        if a == b {
            return !odd;
        }
        self.links[a.max(b)] = (a.min(b) as u32) << 1 | u32::from(odd);
        true
    }

    /// The number of sets, and the set of each triangle, numbered in the order of first triangles.
    pub(super) fn number(&mut self) -> (usize, Vec<u32>) {
        let mut count = 0;
        let mut of = vec![0u32; self.links.len()];
        for t in 0..of.len() {
            let (root, _) = self.find(t);
            // A root is the lowest triangle of its set, so it was numbered before.
            of[t] = if root == t { count } else { of[root] };
            count += u32::from(root == t);
        }
        (count as usize, of)
    }
}
