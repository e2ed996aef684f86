//! Facets: triangles of a surface, and pairs of them that make a convex quad.

use alloc::vec;
use alloc::vec::Vec;

use crate::array::Each;
#[cfg(not(feature = "std"))]
use crate::math::Float as _;
use crate::sort::{Sorter, of_f64, pair, sort_above};
use glam::{DVec3, Vec3};

/// The cosine of the angle between the normals of two triangles below which they make no quad.
const FLAT: f64 = 0.995;

/// The least sine of a corner of a quad: one that is nearly straight is convex on the screen in few
/// views.
const LEAST_CORNER: f64 = 0.02;

/// No facet.
pub(super) const NONE: u32 = u32::MAX;

/// A facet: three vertices, or four of a quad whose diagonal runs from the first to the third.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Facet {
    /// Vertex indices of the facet. A triangle repeats its third vertex.
    pub(super) corners: [u32; 4],
}

impl Facet {
    pub(super) fn triangle([a, b, c]: [u32; 3]) -> Self {
        Self { corners: [a, b, c, c] }
    }

    pub(super) fn corners(&self) -> &[u32] {
        &self.corners[..if self.is_quad() { 4 } else { 3 }]
    }

    pub(super) fn is_quad(&self) -> bool {
        self.corners[2] != self.corners[3]
    }

    /// Whether a triangle's corners differ; and those of a quad.
    pub(super) fn is_whole(&self) -> bool {
        let corners = self.corners();
        (0..corners.len()).all(|i| (0..i).all(|k| corners[i] != corners[k]))
    }

    fn sides(&self) -> impl Iterator<Item = [u32; 2]> + '_ {
        let corners = self.corners();
        (0..corners.len()).map(|k| [corners[k], corners[(k + 1) % corners.len()]])
    }

    /// The quad of a triangle and another one that shares an edge with it; where they share two,
    /// the first.
    pub(super) fn quad_with(&self, other: [u32; 3]) -> Option<Self> {
        let [a, b, c, _] = self.corners;
        for [from, to, top] in [[c, a, b], [b, c, a], [a, b, c]] {
            for k in 0..3 {
                let bottom = other[(k + 2) % 3];
                if other[k] == to && other[(k + 1) % 3] == from {
                    let quad = Self { corners: [from, bottom, to, top] };
                    return quad.is_whole().then_some(quad);
                }
            }
        }
        None
    }

    /// Whether the triangles of a quad are nearly flat together, and it is convex. Roughly, in f32:
    /// it is drawn right in any case, but worse and at more cost where not.
    pub(super) fn is_flat(&self, positions: &[[f32; 3]]) -> bool {
        let [a, b, c, d] = self.corners.each(|v| Vec3::from(positions[v as usize]));
        let (u, v, w) = (b - a, c - a, d - a);
        let (n, m) = (u.cross(v), v.cross(w));
        let (along, size) = (n.dot(m), n.length_squared() * m.length_squared());
        // The corners at the ends of the diagonal; the others are corners of triangles.
        let (x, y) = (d - c, b - c);
        let corner = |from: Vec3, to: Vec3| {
            let sine = from.cross(to).dot(n);
            let least = LEAST_CORNER as f32;
            let all = from.length_squared() * to.length_squared() * n.length_squared();
            sine > 0.0 && sine * sine > least * least * all
        };
        let flat = (FLAT * FLAT) as f32;
        along > 0.0 && along * along > flat * size && corner(u, w) && corner(x, y)
    }

    /// Its triangles.
    pub(super) fn triangles(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        let corners = self.corners();
        (2..corners.len()).map(|k| [corners[0], corners[k - 1], corners[k]])
    }
}

/// An edge, and the facets on its sides: the first runs along it from the first vertex, where there
/// are two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Edge {
    pub(super) vertices: [u32; 2],
    pub(super) facets: [u32; 2],
}

/// Edges of facets, ascending by vertices: half-edges of one direction matched with those of the
/// other, in the order of the facets; what is left over is an edge with one facet. So of three
/// facets at an edge one has it open, and of two that wind differently both.
pub(super) fn edges(facets: &[Facet]) -> Vec<Edge> {
    // Least vertex and the other; direction and facet.
    let mut halves: Vec<u128> = Vec::with_capacity(facets.len() * 4);
    for (number, facet) in (0_u32..).zip(facets) {
        halves.extend(
            facet
                .sides()
                .map(|[a, b]| pair(a.min(b), a.max(b)) << 64 | pair(u32::from(a > b), number)),
        );
    }
    // They are in the order of the facets.
    sort_above(&mut halves, &mut Vec::new());
    let mut edges = Vec::with_capacity(halves.len() / 2);
    for same in halves.chunk_by(|p, q| p >> 64 == q >> 64) {
        let vertices = [(same[0] >> 96) as u32, (same[0] >> 64) as u32];
        let (along, against) = same.split_at(same.partition_point(|h| (h >> 32) as u32 == 0));
        for k in 0..along.len().max(against.len()) {
            let facet = |of: &[u128]| of.get(k).map_or(NONE, |&h| h as u32);
            let facets = match [facet(along), facet(against)] {
                [NONE, g] => [g, NONE],
                both => both,
            };
            edges.push(Edge { vertices, facets });
        }
    }
    edges
}

fn place(positions: &[[f32; 3]], vertex: u32) -> DVec3 {
    DVec3::from(positions[vertex as usize].each(f64::from))
}

/// The normal of a triangle, as long as twice its area.
pub(super) fn normal(positions: &[[f32; 3]], [a, b, c]: [u32; 3]) -> DVec3 {
    let at = place(positions, a);
    (place(positions, b) - at).cross(place(positions, c) - at)
}

/// The quad of two triangles over the edge that they share; `None` where both have the same three
/// vertices.
fn quad(first: &Facet, second: &Facet, edge: [u32; 2]) -> Option<Facet> {
    let apex = |facet: &Facet| (0..3).find(|&k| !edge.contains(&facet.corners[k]));
    let (i, j) = (apex(first)?, apex(second)?);
    let (top, bottom) = (first.corners[i], second.corners[j]);
    let [a, b] = [first.corners[(i + 1) % 3], first.corners[(i + 2) % 3]];
    // In the order of the first: top, a, bottom, b. The shared edge, from a to b, is the diagonal.
    (top != bottom).then_some(Facet { corners: [a, bottom, b, top] })
}

/// Pairs triangles to quads where they are nearly flat together and convex, the flattest and
/// squarest first.
pub(super) fn paired(positions: &[[f32; 3]], triangles: Vec<Facet>) -> Vec<Facet> {
    let normals: Vec<DVec3> = triangles
        .iter()
        .map(|t| t.triangles().map(|t| normal(positions, t)).sum::<DVec3>().normalize_or_zero())
        .collect();
    let mut candidates: Vec<(f64, Facet, [u32; 2])> = Vec::new();
    for Edge { vertices, facets } in edges(&triangles) {
        if facets[1] == NONE {
            continue;
        }
        let [f, g] = facets.each(|f| f as usize);
        let flatness = normals[f].dot(normals[g]);
        if flatness < FLAT {
            continue;
        }
        let Some(quad) = quad(&triangles[f], &triangles[g], vertices) else { continue };
        let up = normals[f] + normals[g];
        let at = quad.corners.each(|v| place(positions, v));
        let corner = |k: usize| {
            let (u, v) = (at[(k + 1) % 4] - at[k], at[(k + 2) % 4] - at[(k + 1) % 4]);
            u.cross(v).dot(up) / (u.length_squared() * v.length_squared()).sqrt()
        };
        let least = (0..4).map(corner).fold(f64::INFINITY, f64::min);
        if least > LEAST_CORNER {
            candidates.push(((flatness * 1e4).floor() + least, quad, facets));
        }
    }
    let mut sorter = Sorter::default();
    sorter.sort(&mut candidates, |&(_, _, [f, g])| pair(f, g));
    sorter.sort(&mut candidates, |&(score, ..)| (!of_f64(score)).into());
    let mut used = vec![false; triangles.len()];
    let mut facets = Vec::with_capacity(triangles.len());
    for (_, quad, of) in candidates {
        if of.iter().all(|&f| !used[f as usize]) {
            of.iter().for_each(|&f| used[f as usize] = true);
            facets.push(quad);
        }
    }
    facets.extend((0..).zip(triangles).filter(|(t, _): &(usize, _)| !used[*t]).map(|(_, t)| t));
    facets
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_triangles_at_an_edge_leave_one_open() {
        let facets = [[0, 1, 2], [1, 0, 3], [0, 1, 4]].each(Facet::triangle);
        let at: Vec<_> = edges(&facets).into_iter().filter(|e| e.vertices == [0, 1]).collect();
        assert_eq!(at.iter().map(|e| e.facets).collect::<Vec<_>>(), [[0, 1], [2, NONE]]);
        let facets = [[0, 1, 2], [0, 1, 3]].each(Facet::triangle);
        let open = edges(&facets).into_iter().filter(|e| e.facets[1] == NONE).count();
        assert_eq!(open, 6, "two that wind differently have none in common");
    }

    #[test]
    fn a_bent_pair_stays_two_triangles_and_a_flat_one_is_a_quad() {
        let mut positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.5], [0.0, 1.0, 0.0]];
        let pair = || [[0, 1, 2], [0, 2, 3]].each(Facet::triangle).to_vec();
        assert_eq!(paired(&positions, pair()).len(), 2);
        positions[2][2] = 0.0;
        let flat = paired(&positions, pair());
        assert_eq!(flat.len(), 1);
        let [a, _, c, _] = flat[0].corners;
        assert_eq!([a.min(c), a.max(c)], [0, 2], "the diagonal");
        // One corner of the two reaches in.
        positions[1] = [0.6, 0.7, 0.0];
        assert_eq!(paired(&positions, pair()).len(), 2);
    }
}
