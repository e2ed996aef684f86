//! Triangles of several instances in one space: what stand-ins and merged groups are made of.

use std::collections::HashMap;

use cullet::Scene;
use cullet::lod::{LevelEye, Lod, NO_GROUP, PixelScale, Selection};
use cullet::mesh::Part;
use cullet::{MeshId, Simd, scene::MeshLevels};

/// Texture coordinates, then a colour.
pub(crate) type Values = [f32; 6];

/// Triangles, sorted by how they are drawn; equal positions of a part with equal attributes are one
/// vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Surface {
    pub(crate) positions: Vec<[f32; 3]>,
    /// Attributes of each vertex; empty where none has any.
    pub(crate) values: Vec<Values>,
    pub(crate) indices: Vec<u32>,
    /// Parts like those of a mesh, in one order for all surfaces of a group.
    pub(crate) parts: Vec<Part>,
}

/// The part of an instance that is drawn: a mesh and some of its clusters.
pub(crate) struct Piece {
    pub(crate) slot: u32,
    mesh: MeshId,
    clusters: Vec<u32>,
    pub(crate) triangles: u64,
    /// How far it is off, in world units: as its levels state.
    pub(crate) error: f64,
}

impl Piece {
    /// All of an instance.
    pub(crate) fn whole(scene: &Scene, slot: u32) -> Self {
        let (mesh, clusters) = (scene.mesh_id(slot), scene.mesh(slot).clusters());
        let triangles = clusters.iter().map(|c| u64::from(c.triangle_count)).sum();
        let clusters = (0..clusters.len() as u32).collect();
        Self { slot, mesh, clusters, triangles, error: 0.0 }
    }

    /// The fewest triangles of an instance that are off by no more than `bound`, in world units.
    pub(crate) fn within(scene: &Scene, slot: u32, bound: f64) -> Self {
        let whole = Self::whole(scene, slot);
        let of_levels = Self::of_levels(scene, slot, bound);
        of_levels.filter(|piece| piece.triangles < whole.triangles).unwrap_or(whole)
    }

    /// Returns the same as [`within`](Self::within), from its levels alone: `None` where they have
    /// nothing within the bound, or there are none.
    pub(crate) fn of_levels(scene: &Scene, slot: u32, bound: f64) -> Option<Self> {
        // A parallel view of a pixel a unit.
        let scale = PixelScale { eye: None, pixels: 1.0, near: 0.0 };
        let lod = Lod::default().with_pixels(bound);
        let eye = LevelEye::new(&lod, &scale, scene.transform(slot), None);
        let mut selection = Selection::default();
        let mut best: Option<Self> = None;
        // An impostor has no surface to be merged.
        let all = scene.levels(scene.mesh_id(slot)).iter().filter(|l| l.impostor.is_none());
        for MeshLevels { mesh, levels, .. } in all {
            let fewest = best.as_ref().map_or(u64::MAX, |best| best.triangles);
            if levels.select(Simd::best(), &eye, &mut selection)
                && selection.triangle_count() < fewest
            {
                let clusters: Vec<u32> = selection.ranges().flatten().collect();
                let made_from = clusters.iter().map(|&c| levels.made_from()[c as usize]);
                let errors =
                    made_from.filter(|&g| g != NO_GROUP).map(|g| levels.group(g as usize).error);
                // The error that is as large as the bound, in units of the mesh, is the eye's.
                let share = f64::from(errors.fold(0.0, f32::max)) / f64::from(eye.nearest);
                best = Some(Self {
                    slot,
                    mesh: *mesh,
                    clusters,
                    triangles: selection.triangle_count(),
                    error: bound * share.clamp(0.0, 1.0),
                });
            }
        }
        best
    }
}

/// Texture coordinates and colours of a mesh's vertices, each list one for each vertex or empty.
#[derive(Clone, Copy, Debug, Default)]
pub struct MeshAttributes<'a> {
    /// Texture coordinates.
    pub uvs: &'a [[f32; 2]],
    /// Linear colours and alpha.
    pub colors: &'a [[f32; 4]],
}

impl MeshAttributes<'_> {
    /// The lists that have as many entries as there are vertices; `None` where neither has.
    fn of_all(self, vertices: usize) -> Option<Self> {
        let uvs = if self.uvs.len() == vertices { self.uvs } else { &[] };
        let colors = if self.colors.len() == vertices { self.colors } else { &[] };
        (vertices > 0 && !(uvs.is_empty() && colors.is_empty())).then_some(Self { uvs, colors })
    }

    /// Returns the attributes of a vertex; a missing one is zero, a missing colour white.
    fn values(&self, vertex: usize) -> [f32; 6] {
        let [u, v] = self.uvs.get(vertex).copied().unwrap_or_default();
        let [r, g, b, a] = self.colors.get(vertex).copied().unwrap_or([1.0; 4]);
        [u, v, r, g, b, a]
    }
}

/// A corner of a triangle: its place, and the number of its attributes.
pub(crate) type Corner = ([f32; 3], u32);

/// Triangles as they are gathered, welded part by part.
pub(crate) struct Gathered {
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
    pub(crate) fn new() -> Self {
        let number_of = HashMap::from([(Surface::NONE.map(bits), 0)]);
        Self { parts: Vec::new(), values: vec![Surface::NONE], number_of }
    }

    /// The number of attributes.
    pub(crate) fn number(&mut self, values: &Values) -> u32 {
        *self.number_of.entry(values.map(bits)).or_insert_with(|| {
            self.values.push(*values);
            self.values.len() as u32 - 1
        })
    }

    /// Adds a triangle to a part, unless corners of it are in one place.
    pub(crate) fn add(&mut self, part: usize, corners: [Corner; 3]) {
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
    pub(crate) fn finish(mut self, kinds: &[Part]) -> Surface {
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
    pub(crate) const NONE: Values = [0.0, 0.0, 1.0, 1.0, 1.0, 1.0];

    /// Puts pieces of instances into one space, around a point of the world. `kinds` are the parts
    /// by which they are sorted, as far as they are known; those that are not are added.
    /// `attributes` are of the scene's meshes, by their numbers.
    pub(crate) fn gather(
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
pub(crate) fn is_alike(a: &Part, b: &Part) -> bool {
    (a.material, a.two_sided, a.alpha) == (b.material, b.two_sided, b.alpha)
}
