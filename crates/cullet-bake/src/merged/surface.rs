//! Triangles of several instances in one space.

use std::collections::HashMap;

use cullet::Scene;
use cullet::lod::{LevelEye, Lod, PixelScale, Selection};
use cullet::mesh::Part;
use cullet::{MeshId, Simd};

/// Triangles, sorted by how they are drawn; equal positions of a part are one vertex.
#[derive(Clone, Debug, Default)]
pub(super) struct Surface {
    pub(super) positions: Vec<[f32; 3]>,
    pub(super) indices: Vec<u32>,
    /// As a mesh's, in one order for all surfaces of a group.
    pub(super) parts: Vec<Part>,
}

/// What is drawn of an instance: a mesh and some of its clusters.
pub(super) struct Piece {
    pub(super) slot: u32,
    mesh: MeshId,
    clusters: Vec<u32>,
    pub(super) triangles: u64,
}

impl Piece {
    /// All of an instance.
    pub(super) fn whole(scene: &Scene, slot: u32) -> Self {
        let mesh = scene.mesh_id(slot);
        Self::of(scene, slot, mesh, (0..scene.mesh(slot).clusters().len() as u32).collect())
    }

    fn of(scene: &Scene, slot: u32, mesh: MeshId, clusters: Vec<u32>) -> Self {
        let all = scene.meshes()[mesh as usize].clusters();
        let triangles = clusters.iter().map(|&c| u64::from(all[c as usize].triangle_count)).sum();
        Self { slot, mesh, clusters, triangles }
    }

    /// The fewest triangles of an instance that are off by no more than `bound`, in world units.
    pub(super) fn within(scene: &Scene, slot: u32, bound: f64) -> Self {
        let mut best = Self::whole(scene, slot);
        // A parallel view of a pixel a unit.
        let scale = PixelScale { eye: None, pixels: 1.0, near: 0.0 };
        let lod = Lod { pixels: bound, ..Lod::default() };
        let eye = LevelEye::new(&lod, &scale, scene.transform(slot), None);
        let mut selection = Selection::default();
        // An impostor has no surface to be merged.
        let all = scene.levels(scene.mesh_id(slot)).iter().filter(|l| l.impostor.is_none());
        for levels in all {
            if levels.levels.select(Simd::best(), &eye, &mut selection)
                && selection.triangle_count() < best.triangles
            {
                let clusters = selection.ranges().flatten().collect();
                best = Self::of(scene, slot, levels.mesh, clusters);
            }
        }
        best
    }
}

impl Surface {
    /// Puts pieces of instances into one space, around a point of the world. `kinds` are the parts by which they are sorted,
    /// as far as they are known; those that are not are added.
    pub(super) fn gather(
        scene: &Scene,
        pieces: impl Iterator<Item = Piece>,
        origin: [f64; 3],
        kinds: &mut Vec<Part>,
    ) -> Self {
        let mut corners: Vec<Vec<[f32; 3]>> = Vec::new();
        for piece in pieces {
            let mesh = &scene.meshes()[piece.mesh as usize];
            let transform = scene.transform(piece.slot);
            let m = transform.to_matrix();
            let place = |v: u32| -> [f32; 3] {
                let p = mesh.positions()[v as usize].map(f64::from);
                std::array::from_fn(|a| {
                    let world = m[a] * p[0] + m[4 + a] * p[1] + m[8 + a] * p[2] + m[12 + a];
                    (world - origin[a]) as f32
                })
            };
            let is_mirrored = transform.is_mirrored();
            for &cluster in &piece.clusters {
                let cluster = &mesh.clusters()[cluster as usize];
                let kind = kind_of(&mesh.parts()[cluster.part as usize], kinds);
                corners.resize_with(kinds.len().max(corners.len()), Vec::new);
                let range = cluster.triangles();
                let own = &mesh.indices()[range.start as usize * 3..range.end as usize * 3];
                for t in own.as_chunks::<3>().0 {
                    let [a, b, c] = t.map(place);
                    corners[kind].extend(if is_mirrored { [a, c, b] } else { [a, b, c] });
                }
            }
        }
        Self::of_corners(&corners, kinds)
    }

    /// Several surfaces of the same kinds of parts as one.
    pub(super) fn join<'a>(
        surfaces: impl Iterator<Item = (&'a Self, [f64; 3])>,
        kinds: &[Part],
    ) -> Self {
        let mut corners: Vec<Vec<[f32; 3]>> = vec![Vec::new(); kinds.len()];
        for (surface, moved) in surfaces {
            for part in &surface.parts {
                let Some(kind) = kinds.iter().position(|k| is_alike(k, part)) else { continue };
                let range = part.first_triangle as usize * 3..;
                for &v in &surface.indices[range][..part.triangle_count as usize * 3] {
                    let p = surface.positions[v as usize];
                    corners[kind]
                        .push(std::array::from_fn(|a| (f64::from(p[a]) + moved[a]) as f32));
                }
            }
        }
        Self::of_corners(&corners, kinds)
    }

    /// Of the corners of triangles, by the number of their part.
    fn of_corners(corners: &[Vec<[f32; 3]>], kinds: &[Part]) -> Self {
        let mut out = Self::default();
        for (kind, corners) in kinds.iter().zip(corners) {
            let first_triangle = (out.indices.len() / 3) as u32;
            let mut known: HashMap<[u32; 3], u32> = HashMap::with_capacity(corners.len() / 4);
            for t in corners.as_chunks::<3>().0 {
                let three = t.map(|p| {
                    // Adding 0 turns −0 into 0.
                    *known.entry(p.map(|v| (v + 0.0).to_bits())).or_insert_with(|| {
                        out.positions.push(p);
                        out.positions.len() as u32 - 1
                    })
                });
                let [a, b, c] = three;
                if a != b && b != c && c != a {
                    out.indices.extend(three);
                }
            }
            let triangle_count = (out.indices.len() / 3) as u32 - first_triangle;
            out.parts.push(Part { first_triangle, triangle_count, ..*kind });
        }
        out
    }

    pub(super) fn triangle_count(&self) -> u64 {
        (self.indices.len() / 3) as u64
    }

    /// Some of its triangles: those of a list of its vertices, which are sorted by part.
    pub(super) fn with_triangles(&self, indices: &[u32]) -> Self {
        let mut part_of = vec![0u32; self.positions.len()];
        for (number, part) in (0..).zip(&self.parts) {
            let range = part.first_triangle as usize * 3..;
            for &v in &self.indices[range][..part.triangle_count as usize * 3] {
                part_of[v as usize] = number;
            }
        }
        let mut corners: Vec<Vec<[f32; 3]>> = vec![Vec::new(); self.parts.len()];
        for t in indices.as_chunks::<3>().0 {
            // All corners are of one part.
            let own = &mut corners[part_of[t[0] as usize] as usize];
            own.extend(t.map(|v| self.positions[v as usize]));
        }
        Self::of_corners(&corners, &self.parts)
    }
}

/// The number of the kind that a part is of, which is added where it is new.
fn kind_of(part: &Part, kinds: &mut Vec<Part>) -> usize {
    match kinds.iter().position(|k| is_alike(k, part)) {
        Some(at) => at,
        None => {
            kinds.push(Part { first_triangle: 0, triangle_count: 0, ..*part });
            kinds.len() - 1
        }
    }
}

/// Whether parts are drawn alike.
fn is_alike(a: &Part, b: &Part) -> bool {
    (a.material, a.two_sided, a.alpha) == (b.material, b.two_sided, b.alpha)
}
