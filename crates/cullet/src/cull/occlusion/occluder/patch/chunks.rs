//! Chunks: facets that lie near one another, which become a patch when it is first needed.
//!
//! All triangles are gone through once: to pair consecutive ones, to put the facets in the order of
//! a curve through space, and for the vertices of each chunk. A vertex knows the last chunk that
//! has it, and that one the chunk before: enough to find the facets around a chunk among those of a
//! few others, when it is laid out. So what is never drawn is not laid out, and no facet is listed
//! by its vertices.

use alloc::vec::Vec;

use super::super::super::OcclusionError;
use super::super::super::raster::{Connected, MOST_VERTICES};
use super::curve::Curve;
use super::facet::Facet;
use super::layout::Layout;
use crate::bounds::Aabb;

/// The most facets of a chunk.
const MOST: usize = 128;

/// So many facets are enough for a chunk where the next one has no vertex of it: parts that lie
/// apart make a large box, but each patch costs something however small it is. With 8 a castle
/// takes 1.7 times as long, with 24 or 128 1.2 times.
const ENOUGH: usize = 48;

/// A chunk: its first facet, and the first of its nodes.
#[derive(Clone, Copy, Debug)]
struct Start {
    facet: usize,
    node: usize,
}

/// Facets in chunks.
#[derive(Clone, Debug)]
pub(crate) struct Chunks {
    triangles: Vec<[u32; 3]>,
    /// Facets as they come, and sorted.
    unsorted: Vec<Facet>,
    facets: Vec<Facet>,
    curve: Curve,
    /// One for each chunk, and the end.
    starts: Vec<Start>,
    /// A node is a vertex of a chunk. The first of all is none.
    vertices: Vec<u32>,
    /// For each node its chunk, and the node of the same vertex in the last chunk before that has
    /// it, or 0.
    links: Vec<[u32; 2]>,
    /// For each vertex the last node that it has, or 0.
    last: Vec<u32>,
    layout: Layout,
    /// For each vertex, and each chunk, when it was marked.
    vertex_marks: Vec<u32>,
    chunk_marks: Vec<u32>,
    mark: u32,
    around: Vec<u32>,
    rim: Vec<Facet>,
}

impl Default for Chunks {
    /// No triangle.
    fn default() -> Self {
        Self {
            triangles: Vec::new(),
            unsorted: Vec::new(),
            facets: Vec::new(),
            curve: Curve::default(),
            starts: Vec::new(),
            vertices: Vec::new(),
            links: Vec::new(),
            last: Vec::new(),
            layout: Layout::new(0),
            vertex_marks: Vec::new(),
            chunk_marks: Vec::new(),
            mark: 0,
            around: Vec::new(),
            rim: Vec::new(),
        }
    }
}

impl Chunks {
    /// How many there are.
    pub(crate) fn count(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Whether it has these triangles, of so many vertices.
    pub(crate) fn has(&self, vertices: usize, indices: &[u32]) -> bool {
        self.last.len() == vertices
            && self.triangles.as_flattened() == whole(indices).as_flattened()
    }

    /// Forgets all triangles.
    pub(crate) fn clear(&mut self) {
        self.triangles.clear();
        self.starts.clear();
        self.last.clear();
    }

    /// Takes other triangles; positions are finite. Only how well they can be drawn depends on
    /// where they are.
    ///
    /// # Errors
    /// If an index is out of range; then it has none.
    pub(crate) fn set(
        &mut self,
        positions: &[[f32; 3]],
        indices: &[u32],
    ) -> Result<(), OcclusionError> {
        self.clear();
        let vertices = positions.len();
        if indices.iter().fold(0, |most, &v| most.max(v)) as usize >= vertices
            && let Some(&index) = indices.iter().find(|&&v| v as usize >= vertices)
        {
            return Err(OcclusionError::Index(index, vertices));
        }
        self.triangles.extend_from_slice(whole(indices));
        self.unsorted.clear();
        pair(positions, &self.triangles, &mut self.unsorted);
        self.curve.sort(positions, &self.unsorted, &mut self.facets);
        self.last.resize(vertices, 0);
        self.layout.begin(vertices);
        if self.vertex_marks.len() < vertices {
            self.vertex_marks.resize(vertices, 0);
        }
        self.find_chunks();
        let count = self.count();
        if self.chunk_marks.len() < count {
            self.chunk_marks.resize(count, 0);
        }
        Ok(())
    }

    fn find_chunks(&mut self) {
        let (mut start, mut node) = (Start { facet: 0, node: 1 }, 1);
        self.starts.push(start);
        for (number, facet) in self.facets.iter().enumerate() {
            let count = number - start.facet;
            let is_apart =
                || facet.corners.iter().all(|&v| (self.last[v as usize] as usize) < start.node);
            if count == 0 || count == MOST || (count >= ENOUGH && is_apart()) {
                if count > 0 {
                    start = Start { facet: number, node };
                    self.starts.push(start);
                }
                let room = node + 4 * MOST;
                if self.vertices.len() < room {
                    self.vertices.resize(room * 2, 0);
                    self.links.resize(room * 2, [0; 2]);
                }
            }
            // Written in any case, since nobody can tell beforehand which vertices are new.
            let chunk = self.starts.len() as u32 - 1;
            for v in facet.corners {
                let last = self.last[v as usize];
                (self.vertices[node], self.links[node]) = (v, [chunk, last]);
                let is_new = (last as usize) < start.node;
                self.last[v as usize] = if is_new { node as u32 } else { last };
                node += usize::from(is_new);
            }
        }
        if self.facets.is_empty() {
            self.starts.clear();
        } else {
            self.starts.push(Start { facet: self.facets.len(), node });
        }
    }

    /// The vertices of a chunk, in no order.
    fn vertices(&self, chunk: usize) -> &[u32] {
        &self.vertices[self.starts[chunk].node..self.starts[chunk + 1].node]
    }

    fn facets(&self, chunk: usize) -> &[Facet] {
        &self.facets[self.starts[chunk].facet..self.starts[chunk + 1].facet]
    }

    /// The box of a chunk; positions are finite.
    pub(crate) fn bounds(&self, positions: &[[f32; 3]], chunk: usize) -> Aabb {
        let mut all = Aabb::EMPTY;
        for &v in self.vertices(chunk) {
            let p = positions[v as usize];
            for a in 0..3 {
                all.min[a] = if p[a] < all.min[a] { p[a] } else { all.min[a] };
                all.max[a] = if p[a] > all.max[a] { p[a] } else { all.max[a] };
            }
        }
        all
    }

    /// Lays out a chunk as a patch, but for where its vertices are.
    pub(crate) fn lay_out(
        &mut self,
        chunk: usize,
        two_sided: bool,
        to: &mut Connected,
        vertices: &mut Vec<u32>,
    ) {
        self.mark = self.mark.wrapping_add(1);
        if self.mark == 0 {
            self.vertex_marks.fill(0);
            self.chunk_marks.fill(0);
            self.mark = 1;
        }
        let mark = self.mark;
        self.chunk_marks[chunk] = mark;
        self.around.clear();
        for node in self.starts[chunk].node..self.starts[chunk + 1].node {
            let v = self.vertices[node] as usize;
            self.vertex_marks[v] = mark;
            let mut node = self.last[v] as usize;
            while node != 0 && self.around.len() < MOST_VERTICES {
                let [other, before] = self.links[node];
                if self.chunk_marks[other as usize] != mark {
                    self.chunk_marks[other as usize] = mark;
                    self.around.push(other);
                }
                node = before as usize;
            }
        }
        let mut rim = core::mem::take(&mut self.rim);
        rim.clear();
        for &other in &self.around {
            let touches =
                |f: &&Facet| f.corners.iter().any(|&v| self.vertex_marks[v as usize] == mark);
            rim.extend(self.facets(other as usize).iter().filter(touches));
            // More than are kept.
            if rim.len() > MOST_VERTICES {
                break;
            }
        }
        let Start { facet, .. } = self.starts[chunk];
        let own = &self.facets[facet..self.starts[chunk + 1].facet];
        self.layout.lay_out(own, &rim, two_sided, to);
        vertices.clear();
        vertices.extend_from_slice(self.layout.vertices());
        self.rim = rim;
    }
}

fn whole(indices: &[u32]) -> &[[u32; 3]] {
    indices.as_chunks().0
}

/// Facets of some triangles: a quad of two consecutive ones where they make a good one.
fn pair(positions: &[[f32; 3]], mut triangles: &[[u32; 3]], to: &mut Vec<Facet>) {
    while let [triangle, rest @ ..] = triangles {
        triangles = rest;
        let facet = Facet::triangle(*triangle);
        if !facet.is_whole() {
            continue;
        }
        let quad = rest.first().and_then(|next| facet.quad_with(*next));
        match quad.filter(|quad| quad.is_flat(positions)) {
            Some(quad) => {
                triangles = &rest[1..];
                to.push(quad);
            }
            None => to.push(facet),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid of cells, half of which are bent too much for quads, with a degenerate triangle and
    /// one more at some edge.
    fn grid(n: u32) -> (Vec<[f32; 3]>, Vec<u32>) {
        let at = |x: u32, y: u32| y * (n + 1) + x;
        let bend = |y: u32, x: u32| if y % 4 == 1 && x % 2 == 1 { 0.7 } else { 0.0 };
        let points = (0..=n).flat_map(|y| (0..=n).map(move |x| [x as f32, y as f32, bend(y, x)]));
        let cells = (0..n).flat_map(|y| (0..n).map(move |x| (x, y)));
        let indices = cells.flat_map(|(x, y)| {
            let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
            [a, b, c, a, c, d]
        });
        let odd = [3, 3, 4, 0, 1, n + 2];
        (points.collect(), indices.chain(odd).collect())
    }

    fn corners(facet: &Facet) -> Vec<[u32; 3]> {
        facet.triangles().collect()
    }

    #[test]
    fn chunks_have_each_triangle_once_and_all_that_share_a_vertex_with_them_around() {
        let (positions, indices) = grid(60);
        let mut chunks = Chunks::default();
        chunks.set(&positions, &indices).unwrap();
        assert!(
            chunks.has(positions.len(), &indices) && !chunks.has(positions.len(), &indices[3..])
        );
        let mut all: Vec<[u32; 3]> = chunks.facets.iter().flat_map(corners).collect();
        let mut expected: Vec<[u32; 3]> = whole(&indices).to_vec();
        expected.retain(|t| t[0] != t[1]);
        let sorted = |of: &mut Vec<[u32; 3]>| {
            // Each from its least corner on: a quad begins at its diagonal.
            for t in of.iter_mut() {
                let least = (0..3).fold(0, |k, i| if t[i] < t[k] { i } else { k });
                t.rotate_left(least);
            }
            of.sort_unstable();
        };
        sorted(&mut all);
        sorted(&mut expected);
        assert_eq!(all, expected);
        let quads = chunks.facets.iter().filter(|f| f.is_quad()).count();
        assert!(quads > 100 && quads * 2 < all.len() - 100, "{quads} quads");
        assert!(chunks.count() > 20);
        for chunk in 0..chunks.count() {
            let (mut mesh, mut vertices) = (Connected::default(), Vec::new());
            chunks.lay_out(chunk, false, &mut mesh, &mut vertices);
            let own = chunks.facets(chunk);
            assert!(own.len() <= MOST);
            let has = |f: &Facet| f.corners.iter().any(|v| chunks.vertices(chunk).contains(v));
            let expected = chunks.facets.iter().filter(|f| has(f)).count() - own.len();
            assert_eq!(chunks.rim.len(), expected, "around chunk {chunk}");
            mesh.place(&positions, &vertices);
            assert_eq!(mesh.bounds, chunks.bounds(&positions, chunk));
        }
    }

    #[test]
    fn no_triangle_and_none_that_is_whole_make_no_chunk() {
        let mut chunks = Chunks::default();
        chunks.set(&[], &[]).unwrap();
        assert_eq!(chunks.count(), 0);
        chunks.set(&[[0.0; 3]; 2], &[0, 1, 1, 0, 0, 0, 1]).unwrap();
        assert_eq!(chunks.count(), 0);
        assert!(chunks.set(&[[0.0; 3]; 2], &[0, 1, 2]).is_err());
        assert_eq!(chunks.count(), 0);
    }
}
