//! Convex occluders: drawn as one, by their silhouette.

mod draw;

use alloc::vec;
use alloc::vec::Vec;

use super::super::OcclusionError;
use super::super::raster::reach;
use super::numbers::Numbers;
use crate::array::{self, Each};
use crate::bounds::Aabb;
use crate::exact;
use crate::mesh::weld;
use crate::sort::sort;

/// An edge as the key of a map, in the order of its ends.
fn edge(a: u32, b: u32) -> u64 {
    u64::from(a) << 32 | u64::from(b)
}

/// Eight points, an array for each axis.
type Points = [[f32; 8]; 3];

/// A convex polyhedron, or a convex polygon that hides from both sides.
///
/// On the screen it is one outline, the edges between a face that is seen and one that is not; and
/// at each pixel it is as near as the farthest of the planes of the faces seen, since a line enters
/// a convex body at the last plane that it crosses inward.
#[derive(Clone, Debug, PartialEq)]
pub struct Convex {
    pub(super) vertices: Vec<[f32; 3]>,
    /// Loops of vertices, counter-clockwise seen from outside, one after the other.
    loops: Vec<u32>,
    /// Where the loop of each face begins; one more than there are faces.
    starts: Vec<u32>,
    /// Three corners of each face that lie well apart.
    spread: Vec<[u32; 3]>,
    /// Edges: from, to, the face that winds that way, the face that winds the other way.
    pub(super) edges: Vec<[u32; 4]>,
    /// The first eight vertices, the last one again where there are no more: all that most bodies
    /// have, and here since a body that is covered should not cost a look elsewhere. Then the
    /// others.
    points: Points,
    more: Vec<Points>,
    /// The largest absolute coordinate along each axis.
    reach: [f32; 3],
    bounds: Aabb,
}

impl Convex {
    /// The most vertices that a convex occluder has.
    pub(crate) const MAX_VERTICES: usize = 256;

    /// A box. One that is flat hides by its two largest sides; one without area hides nothing.
    ///
    /// # Errors
    /// [`OcclusionError::NotFinite`], and [`OcclusionError::Empty`] for an empty box.
    pub fn from_box(b: &Aabb) -> Result<Self, OcclusionError> {
        if b.is_empty() {
            return Err(OcclusionError::Empty);
        }
        let vertices = b.corners().to_vec();
        // Corner i has the upper x, y, z where bits 0, 1, 2 are set.
        let faces: [[u32; 4]; 6] =
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        Self::from_loops(vertices, &faces.each(|f| f.to_vec()))
    }

    /// A flat convex polygon, which hides from both sides. Its corners are taken to lie in one
    /// plane: what they stand out of it by must be made good by the caller, who shrinks or moves
    /// it.
    ///
    /// # Errors
    /// Where it has fewer than three corners, too many, or one that is not finite.
    pub fn from_polygon(corners: &[[f32; 3]]) -> Result<Self, OcclusionError> {
        let count = corners.len() as u32;
        if count < 3 {
            return Err(OcclusionError::Empty);
        }
        Self::from_loops(corners.to_vec(), &[(0..count).collect(), (0..count).rev().collect()])
    }

    /// A flat convex polygon that hides from its front alone, where its corners are
    /// counter-clockwise. As [`from_polygon`](Self::from_polygon) otherwise.
    ///
    /// # Errors
    /// As [`from_polygon`](Self::from_polygon).
    pub fn from_one_sided_polygon(corners: &[[f32; 3]]) -> Result<Self, OcclusionError> {
        let mut polygon = Self::from_polygon(corners)?;
        // The back stays, for the outline lies between it and the front, but has neither a plane
        // that could be seen nor corners that could be drawn.
        polygon.spread[1] = [polygon.spread[1][0]; 3];
        polygon.starts[2] = polygon.starts[1];
        polygon.loops.truncate(polygon.starts[1] as usize);
        Ok(polygon)
    }

    /// Whether it is a polygon that hides from both sides.
    pub(super) fn is_two_sided(&self) -> bool {
        self.face_count() == 2 && !self.face(1).is_empty()
    }

    /// The convex body that a triangle list is the surface of: exactly convex, closed and wound
    /// outward. `None` for any other list, and for one with too many corners.
    #[must_use]
    pub fn from_mesh(positions: &[[f32; 3]], indices: &[u32]) -> Option<Self> {
        // The positions may be those of much more.
        let uses = indices.iter().enumerate().rev();
        let first_use = Numbers::new(uses.map(|(at, &v)| (v.into(), at as u32)).collect());
        let mut used = Vec::new();
        let mut local: Vec<u32> = Vec::with_capacity(indices.len());
        for (&v, at) in indices.iter().zip(0..) {
            let first = first_use.get(v.into())?;
            if first < at {
                local.push(local[first as usize]);
            } else {
                local.push(used.len() as u32);
                used.push(*positions.get(v as usize)?);
            }
        }
        let (positions, first) = (&used, weld(&used));
        let triangles: Vec<[u32; 3]> =
            local.as_chunks::<3>().0.iter().map(|t| t.each(|v| first[v as usize])).collect();
        if triangles.len() < 4 {
            return None;
        }
        let corners = |t: usize| triangles[t].each(|v| positions[v as usize]);
        let sides = triangles
            .iter()
            .zip(0..)
            .flat_map(|(v, t)| [0, 1, 2].map(|k| (edge(v[k], v[(k + 1) % 3]), t)));
        let half_edges = Numbers::new(sides.collect());
        if half_edges.len() != triangles.len() * 3 {
            return None;
        }
        // Triangles in one plane are one face.
        let mut face = vec![usize::MAX; triangles.len()];
        let mut faces: Vec<Vec<usize>> = Vec::new();
        for seed in 0..triangles.len() {
            if face[seed] != usize::MAX {
                continue;
            }
            if exact::is_collinear(&corners(seed)) {
                return None;
            }
            let plane = corners(seed);
            let mut members = vec![seed];
            face[seed] = faces.len();
            let mut at = 0;
            while let Some(&t) = members.get(at) {
                at += 1;
                for k in 0..3 {
                    let (a, b) = (triangles[t][k], triangles[t][(k + 1) % 3]);
                    let other = half_edges.get(edge(b, a))? as usize;
                    let flat = triangles[other]
                        .iter()
                        .all(|&v| exact::side_sign(&plane, positions[v as usize]) == 0);
                    if flat && face[other] == usize::MAX {
                        face[other] = faces.len();
                        members.push(other);
                    }
                }
            }
            faces.push(members);
            if faces.len() > Self::MAX_VERTICES * 2 {
                return None;
            }
        }
        let mut used: Vec<u32> = triangles.iter().flatten().copied().collect();
        sort(&mut used);
        used.dedup();
        for members in &faces {
            let plane = corners(members[0]);
            if used.iter().any(|&v| exact::side_sign(&plane, positions[v as usize]) > 0) {
                return None;
            }
        }
        // A vertex where fewer than three faces meet lies within a face or an edge.
        let corners_of = triangles.iter().zip(&face);
        let around = corners_of.flat_map(|(v, &face)| v.map(|v| edge(v, face as u32)));
        let mut around: Vec<u64> = around.collect();
        sort(&mut around);
        around.dedup();
        let mut number = Vec::new();
        let mut vertices = Vec::new();
        for faces in around.chunk_by(|a, b| a >> 32 == b >> 32).filter(|faces| faces.len() >= 3) {
            number.push((faces[0] >> 32, vertices.len() as u32));
            vertices.push(positions[(faces[0] >> 32) as usize]);
        }
        let number = Numbers::new(number);
        let mut loops = Vec::with_capacity(faces.len());
        for members in &faces {
            let mut rim = Vec::new();
            let face_of = |a, b| Some(face[half_edges.get(edge(a, b))? as usize]);
            for &t in members {
                for k in 0..3 {
                    let (a, b) = (triangles[t][k], triangles[t][(k + 1) % 3]);
                    if face_of(b, a)? != face_of(a, b)? {
                        rim.push((a.into(), b));
                    }
                }
            }
            let rim = Numbers::new(rim);
            let start = rim.pairs().first()?.0;
            let (mut v, mut outline) = (start, Vec::new());
            for _ in 0..rim.len() {
                outline.extend(number.get(v));
                v = u64::from(rim.get(v)?);
            }
            if v != start {
                return None;
            }
            loops.push(outline);
        }
        Self::from_loops(vertices, &loops).ok()
    }

    /// From the loops of its faces, counter-clockwise seen from outside. Trusted to be convex.
    pub(super) fn from_loops(
        vertices: Vec<[f32; 3]>,
        loops: &[Vec<u32>],
    ) -> Result<Self, OcclusionError> {
        if let Some((vertex, &position)) =
            vertices.iter().enumerate().find(|(_, p)| !p.iter().all(|v| v.is_finite()))
        {
            return Err(OcclusionError::NotFinite { vertex, position });
        }
        if vertices.len() > Self::MAX_VERTICES {
            return Err(OcclusionError::TooManyVertices(vertices.len(), Self::MAX_VERTICES));
        }
        let sides = loops.iter().zip(0..).flat_map(|(corners, f)| {
            let ends = corners.iter().zip(corners.iter().cycle().skip(1));
            ends.map(move |(&a, &b)| (edge(a, b), f))
        });
        let half_edges = Numbers::new(sides.collect());
        // In the order of their ends.
        let edges: Vec<[u32; 4]> = half_edges
            .pairs()
            .iter()
            .map(|&(ends, f)| ((ends >> 32) as u32, ends as u32, f))
            .filter(|&(a, b, _)| a < b)
            .filter_map(|(a, b, f)| Some([a, b, f, half_edges.get(edge(b, a))?]))
            .collect();
        if edges.len() * 2 != half_edges.len() {
            return Err(OcclusionError::Open);
        }
        let spread = loops.iter().map(|corners| spread(&vertices, corners)).collect();
        let mut starts = vec![0];
        starts.extend(loops.iter().scan(0, |at, l| {
            *at += l.len() as u32;
            Some(*at)
        }));
        let bounds = vertices.iter().fold(Aabb::EMPTY, |b, &p| b.union(&Aabb { min: p, max: p }));
        let mut eights = vertices
            .chunks(8)
            .map(|c| [0, 1, 2].each(|axis| array::from_fn(|i| c[i.min(c.len() - 1)][axis])));
        let points = eights.next().ok_or(OcclusionError::Empty)?;
        let more = eights.collect();
        let reach = reach(&vertices);
        Ok(Self {
            vertices,
            loops: loops.concat(),
            starts,
            spread,
            edges,
            points,
            more,
            reach,
            bounds,
        })
    }

    /// Number of faces.
    pub(crate) fn face_count(&self) -> usize {
        self.spread.len()
    }

    /// The loop of a face, counter-clockwise seen from outside; empty for the back of a one-sided
    /// polygon.
    pub(super) fn face(&self, face: usize) -> &[u32] {
        &self.loops[self.starts[face] as usize..self.starts[face + 1] as usize]
    }

    /// Its box.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Returns the corners.
    #[must_use]
    pub fn vertices(&self) -> &[[f32; 3]] {
        &self.vertices
    }

    /// Returns each face: three of its corners that lie well apart, and all of them, both
    /// counter-clockwise seen from outside. A one-sided polygon has no back.
    pub fn faces(&self) -> impl Iterator<Item = ([u32; 3], &[u32])> {
        let all = (0..self.face_count()).map(|f| (self.spread[f], self.face(f)));
        all.filter(|(_, corners)| !corners.is_empty())
    }
}

/// Three corners of a loop that span a large triangle, in the loop's order.
fn spread(vertices: &[[f32; 3]], corners: &[u32]) -> [u32; 3] {
    let at = |k: usize| glam::DVec3::from(vertices[corners[k] as usize].each(f64::from));
    let area = |k: [usize; 3]| (at(k[1]) - at(k[0])).cross(at(k[2]) - at(k[0])).length_squared();
    let n = corners.len();
    let mut best = [0, n / 3, (2 * n).div_ceil(3).min(n - 1)];
    // Moving one corner at a time to where the triangle is largest soon stops.
    for _ in 0..4 {
        for j in 0..3 {
            for k in 0..n {
                let mut next = best;
                next[j] = k;
                if next.is_sorted() && area(next) > area(best) {
                    best = next;
                }
            }
        }
    }
    best.each(|k| corners[k])
}

#[cfg(test)]
mod tests {
    use crate::Simd;

    use super::*;
    use crate::cull::occlusion::{OcclusionBuffer, Visibility};
    use crate::transform::Transform;
    use crate::view::{Camera, Depth, Projection, View};

    /// Whether a box at the end of the line from the eye through the origin is hidden by a polygon.
    fn hides(polygon: &Convex, eye: [f64; 3]) -> bool {
        let projection =
            Projection::Perspective { fov_y_radians: 1.0, aspect: 1.0, near: 0.1, far: 100.0 };
        let view =
            View::new(&Camera::look_at(eye, [0.0; 3], projection), Depth::Reversed, [64, 64]);
        let mut buffer = OcclusionBuffer::new([64, 64]).unwrap();
        buffer.begin(&view.unwrap(), [0.0; 3]);
        polygon.draw(Simd::best(), &mut buffer, &Transform::IDENTITY);
        let at = eye.map(|v| -v as f32);
        let target = Aabb::new(at.map(|v| v - 0.2), at.map(|v| v + 0.2));
        buffer.test_box(&target) == Visibility::Hidden
    }

    #[test]
    fn a_one_sided_polygon_hides_from_its_front_alone() {
        let corners = [[-2.0, -2.0, 0.0], [2.0, -2.0, 0.0], [2.0, 2.0, 0.0], [-2.0, 2.0, 0.0]];
        let one = Convex::from_one_sided_polygon(&corners).unwrap();
        let both = Convex::from_polygon(&corners).unwrap();
        assert!(!one.is_two_sided() && both.is_two_sided());
        for (eye, from_front) in [([0.0, 0.3, 4.0], true), ([0.4, 0.0, -4.0], false)] {
            assert!(hides(&both, eye));
            assert_eq!(hides(&one, eye), from_front);
        }
    }

    #[test]
    fn so_it_does_where_the_near_plane_cuts_it() {
        // A floor from behind the eye to far away.
        let floor = [[-9.0, -1.0, 9.0], [9.0, -1.0, 9.0], [9.0, -1.0, -9.0], [-9.0, -1.0, -9.0]];
        let below = |polygon: &Convex| hides(polygon, [0.0, 2.0, 4.0]);
        assert!(below(&Convex::from_one_sided_polygon(&floor).unwrap()));
        let mut turned = floor;
        turned.reverse();
        assert!(!below(&Convex::from_one_sided_polygon(&turned).unwrap()));
        assert!(below(&Convex::from_polygon(&turned).unwrap()));
    }
}
