//! Triangles of several instances in one space.

use std::collections::HashMap;

use cullet::Scene;
use cullet::lod::{LevelEye, Lod, PixelScale, Selection};
use cullet::mesh::Part;
use cullet::{MeshId, Simd};

use super::MeshAttributes;

/// Texture coordinates, then a colour.
pub(super) type Values = [f32; 6];

/// Triangles, sorted by how they are drawn; equal positions of a part with equal attributes are one vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Surface {
    pub(super) positions: Vec<[f32; 3]>,
    /// Of each vertex; empty where none has any.
    pub(super) values: Vec<Values>,
    pub(super) indices: Vec<u32>,
    /// As a mesh's, in one order for all surfaces of a group.
    pub(super) parts: Vec<Part>,
}

/// A group whose levels are made.
#[derive(Debug, PartialEq)]
pub(super) struct Made {
    pub(super) origin: [f64; 3],
    pub(super) radius: f32,
    /// From fine to coarse, with what they were found to be off.
    pub(super) levels: Vec<(Surface, f32)>,
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

/// A corner of a triangle: its place, and the number of its attributes.
type Corner = ([f32; 3], u32);

/// Triangles as they are gathered, welded part by part.
struct Gathered {
    parts: Vec<GatheredPart>,
    /// Attributes that occur, each once; the first are none.
    values: Vec<Values>,
    number_of: HashMap<[u32; 6], u32>,
}

#[derive(Default)]
struct GatheredPart {
    known: HashMap<[u32; 4], u32>,
    vertices: Vec<Corner>,
    indices: Vec<u32>,
}

/// The bits of a number; adding 0 turns −0 into 0.
fn bits(v: f32) -> u32 {
    (v + 0.0).to_bits()
}

impl Gathered {
    fn new() -> Self {
        let number_of = HashMap::from([(Surface::NONE.map(bits), 0)]);
        Self { parts: Vec::new(), values: vec![Surface::NONE], number_of }
    }

    /// The number of attributes.
    fn number(&mut self, values: &Values) -> u32 {
        *self.number_of.entry(values.map(bits)).or_insert_with(|| {
            self.values.push(*values);
            self.values.len() as u32 - 1
        })
    }

    /// Adds a triangle to a part, unless corners of it are in one place.
    fn add(&mut self, part: usize, corners: [Corner; 3]) {
        if part >= self.parts.len() {
            self.parts.resize_with(part + 1, GatheredPart::default);
        }
        let own = &mut self.parts[part];
        let three = corners.map(|(p, values)| {
            let [x, y, z] = p.map(bits);
            *own.known.entry([x, y, z, values]).or_insert_with(|| {
                own.vertices.push((p, values));
                own.vertices.len() as u32 - 1
            })
        });
        let [a, b, c] = corners.map(|(p, _)| p.map(bits));
        if a != b && b != c && c != a {
            own.indices.extend(three);
        }
    }

    /// All of it, the parts in the order of `kinds`.
    fn finish(mut self, kinds: &[Part]) -> Surface {
        let mut out = Surface::default();
        self.parts.resize_with(kinds.len(), GatheredPart::default);
        let has_values = self.values.len() > 1;
        for (kind, own) in kinds.iter().zip(self.parts) {
            let first = out.positions.len() as u32;
            let first_triangle = (out.indices.len() / 3) as u32;
            out.positions.extend(own.vertices.iter().map(|v| v.0));
            if has_values {
                out.values.extend(own.vertices.iter().map(|v| self.values[v.1 as usize]));
            }
            out.indices.extend(own.indices.iter().map(|v| v + first));
            let triangle_count = (own.indices.len() / 3) as u32;
            out.parts.push(Part { first_triangle, triangle_count, ..*kind });
        }
        out
    }
}

impl Surface {
    /// Attributes of a vertex that has none, as in meshes of which only some parts have some.
    pub(super) const NONE: Values = [0.0, 0.0, 1.0, 1.0, 1.0, 1.0];

    /// Puts pieces of instances into one space, around a point of the world. `kinds` are the parts by which they are sorted,
    /// as far as they are known; those that are not are added. `attributes` are of the scene's meshes, by their numbers.
    pub(super) fn gather(
        scene: &Scene,
        attributes: &[MeshAttributes<'_>],
        pieces: impl Iterator<Item = Piece>,
        origin: [f64; 3],
        kinds: &mut Vec<Part>,
    ) -> Self {
        let mut out = Gathered::new();
        for piece in pieces {
            let mesh = &scene.meshes()[piece.mesh as usize];
            let own = attributes.get(scene.mesh_id(piece.slot) as usize);
            // Levels have the vertices of the mesh that they are of, and so its attributes.
            let own = own.and_then(|own| own.of_all(mesh.positions().len()));
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
                let range = cluster.triangles();
                let indices = &mesh.indices()[range.start as usize * 3..range.end as usize * 3];
                for t in indices.as_chunks::<3>().0 {
                    let [a, b, c] = t.map(|v| {
                        let values = own.map_or(0, |own| out.number(&own.values(v as usize)));
                        (place(v), values)
                    });
                    out.add(kind, if is_mirrored { [a, c, b] } else { [a, b, c] });
                }
            }
        }
        out.finish(kinds)
    }

    /// Several surfaces of the same kinds of parts as one.
    pub(super) fn join<'a>(
        surfaces: impl Iterator<Item = (&'a Self, [f64; 3])>,
        kinds: &[Part],
    ) -> Self {
        let mut out = Gathered::new();
        for (surface, moved) in surfaces {
            for part in &surface.parts {
                let Some(kind) = kinds.iter().position(|k| is_alike(k, part)) else { continue };
                let range = part.first_triangle as usize * 3..;
                let indices = &surface.indices[range][..part.triangle_count as usize * 3];
                for t in indices.as_chunks::<3>().0 {
                    let corners = t.map(|v| {
                        let (p, values) = surface.corner(v, &mut out);
                        let place = |a: usize| (f64::from(p[a]) + moved[a]) as f32;
                        ([place(0), place(1), place(2)], values)
                    });
                    out.add(kind, corners);
                }
            }
        }
        out.finish(kinds)
    }

    /// A vertex, as a corner of what is gathered.
    fn corner(&self, vertex: u32, to: &mut Gathered) -> Corner {
        let values = self.values.get(vertex as usize).map_or(0, |values| to.number(values));
        (self.positions[vertex as usize], values)
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
        let mut out = Gathered::new();
        for t in indices.as_chunks::<3>().0 {
            // All corners are of one part.
            let corners = t.map(|v| self.corner(v, &mut out));
            out.add(part_of[t[0] as usize] as usize, corners);
        }
        out.finish(&self.parts)
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
