//! Meshes made ready to be simplified: welded, with the points by which results are measured.

use cullet::MeshData;
use cullet::mesh::{Clustering, MeshError, Part, weld};

use super::error::LevelsError;
use cullet_draw::surface::SurfaceTree;
use cullet_draw::surface::{SurfacePoint, inner_points, surface_points};

/// Seeds of the points that are measured while levels are made: others than
/// [`deviation`](super::deviation) is given.
const SEED: u64 = 0x6c65_7665_6c73;

/// A mesh, welded, in the form that is simplified and measured.
///
/// Equal positions are one vertex, or as the caller says. A vertex that several parts use is one
/// for each, so that the simplifier keeps the line between parts on both sides and simplifies it
/// along itself. Triangles without area in indices are left out.
#[derive(Debug)]
pub(crate) struct Original {
    pub(crate) positions: Vec<[f32; 3]>,
    /// For each vertex the first at its position.
    pub(crate) place: Vec<u32>,
    pub(crate) indices: Vec<u32>,
    /// The vertex of the mesh that each is.
    pub(crate) vertex: Vec<u32>,
    /// The part that each vertex is of.
    pub(crate) part: Vec<u32>,
    pub(crate) parts: Vec<Part>,
    pub(crate) tree: SurfaceTree,
    /// Points of the surface besides its vertices.
    pub(crate) points: Vec<SurfacePoint>,
}

/// How many points confirm a result of so many triangles of the original. With four a triangle
/// fandisk was off by 1.24 of its bound between them.
fn confirming(triangles: usize) -> usize {
    (5000 + 16 * triangles).min((4 * triangles).max(1_000_000))
}

impl Original {
    /// Prepares a mesh. `same` says for each vertex which vertex it is the same as, in position and
    /// all else that matters; where it is empty, that is the position.
    pub(crate) fn new(data: &MeshData, same: &[u32]) -> Result<Self, LevelsError> {
        let parts = checked(data)?;
        let vertices = data.positions.len();
        if !same.is_empty() {
            let what = "numbers of equal vertices";
            if same.len() != vertices {
                return Err(LevelsError::Length { what, count: same.len(), expected: vertices });
            }
            if let Some(at) = same.iter().position(|&v| v as usize >= vertices) {
                return Err(MeshError::Index { at, index: same[at], vertices }.into());
            }
        }
        let by_position = weld(&data.positions);
        let same = if same.is_empty() { &by_position } else { same };
        let mut original = Self {
            positions: Vec::new(),
            place: Vec::new(),
            indices: Vec::with_capacity(data.indices.len()),
            vertex: Vec::new(),
            part: Vec::new(),
            parts,
            tree: SurfaceTree::new(&[], &[]),
            points: Vec::new(),
        };
        // For each vertex of the mesh the last one made of it, and of which part.
        let mut made = vec![[u32::MAX; 2]; vertices];
        for (number, part) in original.parts.iter().enumerate() {
            let range = part.first_triangle as usize * 3..;
            for corners in data.indices[range].chunks_exact(3).take(part.triangle_count as usize) {
                let [a, b, c] = [0, 1, 2].map(|k| by_position[corners[k] as usize]);
                if a == b || b == c || c == a {
                    continue;
                }
                for &corner in corners {
                    let vertex = same[corner as usize];
                    let known = &mut made[vertex as usize];
                    if known[1] != number as u32 {
                        *known = [original.vertex.len() as u32, number as u32];
                        original.vertex.push(vertex);
                        original.part.push(number as u32);
                        original.positions.push(data.positions[corner as usize]);
                    }
                    original.indices.push(known[0]);
                }
            }
        }
        original.place = weld(&original.positions);
        original.tree = SurfaceTree::new(&original.positions, &original.indices);
        original.take_points();
        Ok(original)
    }

    /// A point of each triangle, and as many spread by area, so that neither small nor large
    /// triangles are missed.
    fn take_points(&mut self) {
        let triangles = self.indices.len() / 3;
        self.points = surface_points(&self.positions, &self.indices, triangles, SEED);
        for t in 0..triangles as u32 {
            let inner = inner_points(self.corners(&self.indices, t), SEED, t, 1);
            self.points.extend(inner.map(|point| SurfacePoint { point, triangle: t }));
        }
    }

    pub(crate) fn triangle_count(&self) -> usize {
        self.indices.len() / 3
    }

    /// The corners of a triangle of a list of these vertices.
    pub(crate) fn corners(&self, indices: &[u32], t: u32) -> [[f32; 3]; 3] {
        let at = t as usize * 3;
        [0, 1, 2].map(|k| self.positions[indices[at + k] as usize])
    }

    /// Points of a simplified surface from which the way back is measured: some of each triangle,
    /// and as many spread by area as the original has.
    pub(crate) fn points_back(&self, indices: &[u32]) -> Vec<SurfacePoint> {
        const EACH: u32 = 4;
        let mut points = surface_points(&self.positions, indices, self.triangle_count(), SEED + 1);
        for t in 0..(indices.len() / 3) as u32 {
            let inner = inner_points(self.corners(indices, t), SEED + 1, t, EACH);
            points.extend(inner.map(|point| SurfacePoint { point, triangle: t }));
        }
        points
    }

    /// Many more points of the original, or of a simplified surface, by which a result is confirmed
    /// that has passed the others. They are made when they are needed, for they need much memory.
    pub(crate) fn confirming_points(&self, indices: &[u32]) -> Vec<SurfacePoint> {
        let count = confirming(self.triangle_count());
        surface_points(&self.positions, indices, count, SEED + 2)
    }
}

/// Checks a mesh; its parts, or the one that it is.
fn checked(data: &MeshData) -> Result<Vec<Part>, LevelsError> {
    // The simple clustering checks all that a mesh is checked for.
    Clustering::spatial(data)?;
    if !data.parts.is_empty() {
        return Ok(data.parts.clone());
    }
    let triangle_count = (data.indices.len() / 3) as u32;
    Ok(vec![Part { triangle_count, two_sided: true, ..Part::default() }])
}
