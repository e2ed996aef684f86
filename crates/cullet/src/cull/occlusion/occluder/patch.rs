//! Occluders that are any triangles: patches of a surface, with the edges that their triangles share.

use std::collections::HashMap;
use std::ops::Range;

use super::super::OcclusionError;
use super::super::raster::{Band, Connected, TRIANGLES, is_whole, reach};
use crate::Simd;
use crate::bounds::Aabb;
use crate::mesh::weld;
use crate::transform::Transform;

/// A few neighbouring triangles of a surface, drawn as one.
///
/// Its own triangles cover what lies wholly within one of them. Pixels on the edges between them are covered by what
/// meets there, for which the triangles around the patch are kept too, so that no crack runs along
/// the seam between two patches of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Patch {
    pub(super) mesh: Connected,
    vertex_count: usize,
    own: usize,
}

impl Patch {
    /// Cuts a surface into patches: `patches` are ranges of its triangles, of at most 65,536 each; a few hundred
    /// are best. Positions that are equal are one vertex. `two_sided` triangles hide from both sides.
    ///
    /// An edge of more than two triangles, or of two that wind differently, counts as an open one. Triangles with
    /// two equal corners are left out.
    ///
    /// # Errors
    /// If an index is out of range, a position is not finite, or a range is none of triangles of the list.
    pub fn cut(
        positions: &[[f32; 3]],
        indices: &[u32],
        patches: &[Range<u32>],
        two_sided: bool,
    ) -> Result<Vec<Self>, OcclusionError> {
        if let Some(&index) = indices.iter().find(|&&v| v as usize >= positions.len()) {
            return Err(OcclusionError::Index(index, positions.len()));
        }
        if let Some((vertex, &position)) =
            positions.iter().enumerate().find(|(_, p)| !p.iter().all(|v| v.is_finite()))
        {
            return Err(OcclusionError::NotFinite { vertex, position });
        }
        let count = indices.len() / 3;
        if let Some(range) = patches.iter().find(|r| r.start > r.end || r.end as usize > count) {
            return Err(OcclusionError::Range { start: range.start, end: range.end, count });
        }
        let first = weld(positions);
        let triangles: Vec<[u32; 3]> = indices
            .chunks_exact(3)
            .map(|t| [t[0], t[1], t[2]].map(|v| first[v as usize]))
            .collect();
        let all = Adjacency::new(positions, &triangles, two_sided);
        Ok(patches.iter().map(|range| all.patch(range.clone())).collect())
    }

    /// Draws what lies in a band of it. Nothing where a number is not finite, and before
    /// [`OcclusionBuffer::begin`](super::super::OcclusionBuffer::begin).
    pub fn draw(&self, level: Simd, band: &mut Band<'_>, transform: &Transform) {
        band.draw_connected(level, &self.mesh, transform);
    }

    /// How many triangles are its own.
    #[cfg(feature = "serde")]
    pub(super) fn triangle_count(&self) -> usize {
        self.own
    }

    /// The box around its own triangles.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.mesh.bounds
    }

    /// Its vertices, those of the triangles around it included.
    #[cfg(feature = "serde")]
    pub(super) fn vertices(&self) -> impl ExactSizeIterator<Item = [f32; 3]> {
        let [x, y, z] = &self.mesh.places;
        (0..self.vertex_count).map(|v| [x[v], y[v], z[v]])
    }
}

/// A whole surface: its triangles, and those around each vertex.
pub(super) struct Adjacency<'a> {
    positions: &'a [[f32; 3]],
    triangles: &'a [[u32; 3]],
    two_sided: bool,
    /// The triangles around each vertex, one vertex after the other.
    around: Vec<u32>,
    starts: Vec<u32>,
}

impl<'a> Adjacency<'a> {
    pub(super) fn new(
        positions: &'a [[f32; 3]],
        triangles: &'a [[u32; 3]],
        two_sided: bool,
    ) -> Self {
        let mut starts = vec![0_u32; positions.len() + 1];
        for t in triangles.iter().filter(|t| is_whole(t)) {
            t.iter().for_each(|&v| starts[v as usize + 1] += 1);
        }
        for v in 0..positions.len() {
            starts[v + 1] += starts[v];
        }
        let mut next = starts.clone();
        let mut around = vec![0; starts[positions.len()] as usize];
        for (number, t) in triangles.iter().enumerate().filter(|(_, t)| is_whole(t)) {
            for &v in t {
                around[next[v as usize] as usize] = number as u32;
                next[v as usize] += 1;
            }
        }
        Self { positions, triangles, two_sided, around, starts }
    }

    fn around(&self, v: u32) -> &[u32] {
        &self.around[self.starts[v as usize] as usize..self.starts[v as usize + 1] as usize]
    }

    pub(super) fn patch(&self, range: Range<u32>) -> Patch {
        let own: Vec<u32> = range.filter(|&t| is_whole(&self.triangles[t as usize])).collect();
        let mut members = own.clone();
        let mut rim: Vec<u32> = own
            .iter()
            .flat_map(|&t| self.triangles[t as usize])
            .flat_map(|v| self.around(v).iter().copied())
            .collect();
        rim.sort_unstable();
        rim.dedup();
        rim.retain(|t| own.binary_search(t).is_err());
        members.extend(rim);
        let mut number = HashMap::new();
        let mut vertices = Vec::new();
        let triangles: Vec<[u32; 3]> = members
            .iter()
            .map(|&t| {
                self.triangles[t as usize].map(|v| {
                    *number.entry(v).or_insert_with(|| {
                        vertices.push(self.positions[v as usize]);
                        vertices.len() as u32 - 1
                    })
                })
            })
            .collect();
        let bounds = own
            .iter()
            .flat_map(|&t| self.triangles[t as usize])
            .map(|v| self.positions[v as usize])
            .fold(Aabb::EMPTY, |b, p| b.union(&Aabb { min: p, max: p }));
        let padded = vertices.len().next_multiple_of(TRIANGLES);
        let axis = |a: usize| {
            let mut places: Vec<f32> = vertices.iter().map(|p| p[a]).collect();
            places.resize(padded, places.last().copied().unwrap_or_default());
            places
        };
        let (own_triangles, around) = triangles.split_at(own.len());
        let own_vertices = own_triangles.iter().flatten().map(|v| v + 1).max();
        let own_groups = own_triangles.len().div_ceil(TRIANGLES);
        let groups =
            own_triangles.chunks(TRIANGLES).chain(around.chunks(TRIANGLES)).map(lanes).collect();
        let shift = own_groups * TRIANGLES - own.len();
        let number = |t: usize| if t < own.len() { t } else { t + shift } as u32;
        let mesh = Connected {
            edges: edges(triangles.iter().enumerate().map(|(t, v)| (number(t), *v))),
            reach: reach(&vertices),
            places: [0, 1, 2].map(axis),
            own_vertices: own_vertices.unwrap_or_default() as usize,
            groups,
            own_groups,
            two_sided: self.two_sided,
            bounds,
        };
        Patch { mesh, vertex_count: vertices.len(), own: own.len() }
    }
}

/// The first corners of up to eight triangles, the second, and the third.
fn lanes(triangles: &[[u32; 3]]) -> [[u32; TRIANGLES]; 3] {
    let mut lanes = [[triangles[0][0]; TRIANGLES]; 3];
    for (lane, t) in triangles.iter().enumerate() {
        for (corner, v) in lanes.iter_mut().zip(t) {
            corner[lane] = *v;
        }
    }
    lanes
}

/// Edges of some triangles. An edge that is not shared by just two that wind alike is given once for
/// each of its triangles, as an open one.
fn edges(triangles: impl ExactSizeIterator<Item = (u32, [u32; 3])>) -> Vec<[u32; 4]> {
    let mut half: Vec<[u32; 4]> = Vec::with_capacity(triangles.len() * 3);
    for (t, v) in triangles {
        for k in 0..3 {
            let (a, b) = (v[k], v[(k + 1) % 3]);
            half.push([a.min(b), a.max(b), u32::from(a > b), t]);
        }
    }
    half.sort_unstable();
    let mut edges = Vec::with_capacity(half.len() / 2 + 1);
    for group in half.chunk_by(|a, b| a[..2] == b[..2]) {
        match group {
            [p, q] if p[2] != q[2] => edges.push([p[0], p[1], p[3], q[3]]),
            _ => edges.extend(group.iter().map(|h| [h[0], h[1], h[3], Connected::NONE])),
        }
    }
    edges
}
