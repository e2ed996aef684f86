//! Primitives decoded and joined into meshes, each with the vertices it uses.

use std::collections::HashMap;
use std::rc::Rc;

use cullet::MeshData;
use cullet::mesh::Part;

use super::accessor::{Accessors, Component};
use super::buffers::Buffers;
use super::materials::Surface;
use super::meshes::{Binding, Deform, MeshSource, Primitive, Topology, Vertices, user};
use super::notes::Notes;
use crate::{Attributes, ErrorKind, LoadOptions};

/// Turns meshes into data, one at a time, decoding each accessor once.
pub(super) struct Decoder<'a> {
    accessors: &'a Accessors,
    buffers: &'a Buffers<'a>,
    surfaces: &'a [Surface],
    options: &'a LoadOptions,
    /// Vertices that several meshes use.
    shared: HashMap<Vertices, Shared>,
    triangles: u64,
    /// Vertex count of all deformable meshes.
    vertices: u64,
    /// First vertex of each deformable primitive of the mesh last decoded.
    blocks: Vec<(u32, usize)>,
    /// Whether a primitive named no material.
    pub(super) used_default: bool,
}

/// The vertices that accessors hold.
#[derive(Debug, Default)]
struct Block {
    positions: Vec<[f32; 3]>,
    attributes: Attributes,
}

impl Block {
    /// Decodes them, and with `details` more than their positions; attributes that are not finite
    /// are left out with a note.
    ///
    /// # Errors
    /// If an accessor has another form than its attribute, or a position is not finite.
    fn read(
        accessors: &Accessors,
        buffers: &Buffers<'_>,
        vertices: &Vertices,
        details: bool,
        user: &str,
        notes: &mut Notes,
    ) -> Result<Self, ErrorKind> {
        let positions = positions(accessors, buffers, vertices.positions, user, notes)?;
        let mut attributes = Attributes::default();
        if !details {
            return Ok(Self { positions, attributes });
        }
        if let Some(i) = vertices.normals {
            attributes.normals = accessors.floats(i, buffers, &format!("{user}, NORMAL"))?;
        }
        if let Some(i) = vertices.uvs {
            attributes.uvs = accessors.floats(i, buffers, &format!("{user}, TEXCOORD_0"))?;
        }
        if let Some(i) = vertices.colors {
            let user = format!("{user}, COLOR_0");
            attributes.colors = if accessors.get(i, &user)?.is_vec3() {
                let opaque: Vec<[f32; 3]> = accessors.floats(i, buffers, &user)?;
                opaque.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect()
            } else {
                accessors.floats(i, buffers, &user)?
            };
        }
        let bad = attributes.mend();
        if bad > 0 {
            notes.push(
                user,
                format!("{bad} normals, texture coordinates or colours are not finite: left out"),
            );
        }
        // Counts were compared when the primitive was read.
        debug_assert!(attributes.normals.is_empty() || attributes.normals.len() == positions.len());
        Ok(Self { positions, attributes })
    }
}

#[derive(Default)]
struct Shared {
    /// The last mesh that was counted among those that use them.
    counted: Option<usize>,
    block: Option<Rc<Block>>,
    /// For each vertex: the last mesh that used it, by count, and its number there.
    place: Vec<(u32, u32)>,
    meshes_left: u32,
}

impl<'a> Decoder<'a> {
    /// A decoder for the meshes in `used`.
    pub(super) fn new(
        accessors: &'a Accessors,
        buffers: &'a Buffers<'a>,
        surfaces: &'a [Surface],
        options: &'a LoadOptions,
        used: impl Iterator<Item = &'a MeshSource>,
    ) -> Self {
        let mut shared: HashMap<Vertices, Shared> = HashMap::new();
        for (number, mesh) in used.enumerate() {
            // A mesh that deforms keeps its vertices in the order of the file, as its weights and
            // targets are.
            for p in mesh.primitives.iter().filter(|p| p.deform.is_rigid()) {
                let entry = shared.entry(p.vertices).or_default();
                if entry.counted != Some(number) {
                    entry.counted = Some(number);
                    entry.meshes_left += 1;
                }
            }
        }
        shared.retain(|_, shared| shared.meshes_left > 1);
        Self {
            accessors,
            buffers,
            surfaces,
            options,
            shared,
            triangles: 0,
            vertices: 0,
            blocks: Vec::new(),
            used_default: false,
        }
    }

    /// Decodes a mesh: one part for each primitive of triangles, in order. Vertices are those of
    /// the file, unless several meshes share them: then each gets those that it uses.
    ///
    /// # Errors
    /// If an index or a position is out of range, or a limit is passed; the error names mesh,
    /// primitive and vertex.
    pub(super) fn decode(
        &mut self,
        index: usize,
        mesh: &MeshSource,
        notes: &mut Notes,
    ) -> Result<(MeshData, Attributes), ErrorKind> {
        let mut data = MeshData::default();
        let mut attributes = Attributes::default();
        // Where vertices of this mesh alone begin.
        let mut bases: HashMap<(Vertices, &Deform), u32> = HashMap::new();
        let mut finished = Vec::new();
        self.blocks.clear();
        for (at, p) in mesh.primitives.iter().enumerate() {
            let user = user(index, &mesh.name, p.number);
            let count = self.accessors.get(p.vertices.positions, &user)?.count;
            let corners = match p.indices {
                Some(i) => self.accessors.get(i, &user)?.count,
                None => count,
            };
            let triangles = triangle_count(p.topology, corners);
            if p.topology == Topology::List && corners % 3 != 0 {
                notes.push(
                    &user,
                    format!("the last {} of {corners} indices make no triangle", corners % 3),
                );
            }
            self.grant(triangles)?;
            if triangles == 0 {
                notes.push(&user, format!("{corners} vertices make no triangle"));
                continue;
            }
            let fits = |n: usize| u32::try_from(n).is_ok();
            if !fits(data.positions.len().saturating_add(count)) {
                return Err(ErrorKind::OverLimit {
                    item: format!("vertices of mesh {index} `{}`", mesh.name),
                    count: (data.positions.len().saturating_add(count)) as u64,
                    limit: u32::MAX.into(),
                });
            }
            let list = self.corners(p, count, corners, &user)?;
            let first_triangle = (data.indices.len() / 3) as u32;
            let (accessors, buffers) = (self.accessors, self.buffers);
            let details = self.options.details;
            let read = |notes: &mut Notes| {
                Block::read(accessors, buffers, &p.vertices, details, &user, notes)
            };
            match self.shared.get_mut(&p.vertices).filter(|_| p.deform.is_rigid()) {
                Some(shared) => {
                    if shared.block.is_none() {
                        let decoded = read(notes)?;
                        shared.place = vec![(0, 0); decoded.positions.len()];
                        shared.block = Some(Rc::new(decoded));
                    }
                    let all = shared.block.clone().unwrap_or_default();
                    let list = list.unwrap_or_else(|| (0..corners as u32).collect());
                    let stamp = shared.meshes_left;
                    let place = &mut shared.place;
                    let vertices = &mut data.positions;
                    // Meshes count down from many to one, so each has a stamp of its own above 0.
                    each_corner(p.topology, &list, |v| {
                        let entry = &mut place[v as usize];
                        if entry.0 != stamp {
                            *entry = (stamp, vertices.len() as u32);
                            attributes.push(vertices.len(), &all.attributes, v as usize);
                            vertices.push(all.positions[v as usize]);
                        }
                        data.indices.push(entry.1);
                    });
                    if !finished.contains(&p.vertices) {
                        finished.push(p.vertices);
                    }
                }
                None => {
                    let base = match bases.get(&(p.vertices, &p.deform)) {
                        Some(&base) => base,
                        None => {
                            let decoded = read(notes)?;
                            let base = data.positions.len() as u32;
                            if base == 0 {
                                data.positions = decoded.positions;
                                attributes = decoded.attributes;
                            } else {
                                data.positions.extend(decoded.positions);
                                attributes.extend(base as usize, &decoded.attributes);
                            }
                            bases.insert((p.vertices, &p.deform), base);
                            if !p.deform.is_rigid() {
                                self.blocks.push((base, at));
                            }
                            base
                        }
                    };
                    match list {
                        // The usual mesh of one list: its indices are as the file has them.
                        Some(mut list)
                            if p.topology == Topology::List
                                && base == 0
                                && data.indices.is_empty() =>
                        {
                            list.truncate(triangles * 3);
                            data.indices = list;
                        }
                        list => {
                            let list = list.unwrap_or_else(|| (0..corners as u32).collect());
                            data.indices.reserve(triangles * 3);
                            each_corner(p.topology, &list, |v| data.indices.push(base + v));
                        }
                    }
                }
            }
            data.deformable |= !p.deform.is_rigid();
            data.parts.push(self.part(p, first_triangle, triangles as u32));
        }
        // Joined lists grew by doubling; what is kept should not.
        data.positions.shrink_to_fit();
        data.indices.shrink_to_fit();
        if data.deformable {
            // They turn with what deforms the mesh, which moves positions alone.
            attributes.normals = Vec::new();
        }
        attributes.complete(data.positions.len());
        for vertices in finished {
            if let Some(shared) = self.shared.get_mut(&vertices) {
                shared.meshes_left -= 1;
                if shared.meshes_left == 0 {
                    self.shared.remove(&vertices);
                }
            }
        }
        Ok((data, attributes))
    }

    /// Joints, weights and morph targets of the mesh that was decoded last, which has `vertices`
    /// vertices.
    ///
    /// # Errors
    /// If joints, weights or displacements are of another form or number than the vertices.
    pub(super) fn binding(
        &mut self,
        index: usize,
        mesh: &MeshSource,
        vertices: usize,
    ) -> Result<Binding, ErrorKind> {
        self.vertices = self.vertices.saturating_add((vertices * (1 + mesh.targets)) as u64);
        let (count, limit) = (self.vertices, self.options.max_triangles);
        if count > limit {
            let item = "vertices of deformed meshes, and of their morph targets".into();
            return Err(ErrorKind::OverLimit { item, count, limit });
        }
        let has_more = self.blocks.iter().any(|&(_, at)| mesh.primitives[at].deform.more.is_some());
        let rows = if has_more { 2 * vertices } else { vertices };
        let mut binding = Binding {
            joints: vec![[0; 4]; rows],
            weights: vec![[0.0; 4]; rows],
            targets: vec![vec![[0.0; 3]; vertices]; mesh.targets],
        };
        for &(base, at) in &self.blocks {
            let p = &mesh.primitives[at];
            let user = user(index, &mesh.name, p.number);
            let count = self.accessors.get(p.vertices.positions, &user)?.count;
            let place = base as usize..base as usize + count;
            let same = |found: usize, what: &str| match found == count {
                true => Ok(()),
                false => {
                    let message = format!("has {found} {what} for {count} vertices");
                    Err(ErrorKind::invalid(&user, message))
                }
            };
            let first = p.deform.joints.zip(p.deform.weights);
            for (set, pair) in [first, p.deform.more].into_iter().enumerate() {
                let Some((joints, weights)) = pair else { continue };
                let joints: Vec<[f32; 4]> = self.accessors.floats(joints, self.buffers, &user)?;
                let weights: Vec<[f32; 4]> = self.accessors.floats(weights, self.buffers, &user)?;
                same(joints.len(), "joints")?;
                same(weights.len(), "weights")?;
                let place = place.start + set * vertices..place.end + set * vertices;
                for (to, j) in binding.joints[place.clone()].iter_mut().zip(joints) {
                    *to = j.map(|j| j as u16);
                }
                binding.weights[place].copy_from_slice(&weights);
            }
            for (to, target) in binding.targets.iter_mut().zip(&p.deform.targets) {
                let Some(target) = *target else { continue };
                let target: Vec<[f32; 3]> = self.accessors.floats(target, self.buffers, &user)?;
                same(target.len(), "displacements")?;
                to[place.clone()].copy_from_slice(&target);
            }
        }
        normalise(&mut binding.weights, vertices);
        Ok(binding)
    }

    fn part(&mut self, p: &Primitive, first_triangle: u32, triangle_count: u32) -> Part {
        // The default material comes after those of the file.
        let material = p.material.unwrap_or(self.surfaces.len() - 1);
        self.used_default |= p.material.is_none();
        let surface = &self.surfaces[material];
        Part {
            first_triangle,
            triangle_count,
            material: material as u32,
            two_sided: self.options.two_sided.unwrap_or(surface.two_sided),
            alpha: surface.alpha,
        }
    }

    /// The index list of a primitive, its range checked; `None` if it has none.
    fn corners(
        &self,
        p: &Primitive,
        vertices: usize,
        corners: usize,
        user: &str,
    ) -> Result<Option<Vec<u32>>, ErrorKind> {
        let Some(accessor) = p.indices else { return Ok(None) };
        let list = self.accessors.indices(accessor, self.buffers, user)?;
        debug_assert_eq!(list.len(), corners);
        let greatest = list.iter().copied().max().unwrap_or(0);
        if (greatest as usize) < vertices {
            return Ok(Some(list));
        }
        let at = list.iter().position(|&i| i as usize >= vertices).unwrap_or_default();
        Err(ErrorKind::invalid(
            user,
            format!("index {at} is {}, but there are {vertices} vertices", list[at]),
        ))
    }

    fn grant(&mut self, triangles: usize) -> Result<(), ErrorKind> {
        self.triangles = self.triangles.saturating_add(triangles as u64);
        let limit = self.options.max_triangles;
        if self.triangles > limit {
            let item = "triangles of all meshes".into();
            return Err(ErrorKind::OverLimit { item, count: self.triangles, limit });
        }
        Ok(())
    }
}

/// Makes the weights of each vertex add to 1, as most programs do when they load; without any, the
/// first has all.
fn normalise(weights: &mut [[f32; 4]], vertices: usize) {
    for vertex in 0..vertices {
        let places = [vertex, vertex + vertices];
        let places = &places[..weights.len() / vertices];
        let sum: f32 = places.iter().flat_map(|&at| weights[at]).sum();
        for &at in places {
            weights[at] = match sum > 0.0 && sum.is_finite() {
                true => weights[at].map(|w| w / sum),
                false => [if at == vertex { 1.0 } else { 0.0 }, 0.0, 0.0, 0.0],
            };
        }
    }
}

fn triangle_count(topology: Topology, corners: usize) -> usize {
    match topology {
        Topology::List => corners / 3,
        Topology::Strip | Topology::Fan => corners.saturating_sub(2),
    }
}

/// Calls `corner` with the vertex of each corner of each triangle, in the order of the
/// specification: every second triangle of a strip is turned, and a fan's centre comes last.
pub(super) fn each_corner(topology: Topology, list: &[u32], mut corner: impl FnMut(u32)) {
    match topology {
        Topology::List => list[..list.len() / 3 * 3].iter().copied().for_each(corner),
        Topology::Strip => {
            for (i, w) in list.windows(3).enumerate() {
                let turned = i % 2;
                [w[0], w[1 + turned], w[2 - turned]].into_iter().for_each(&mut corner);
            }
        }
        Topology::Fan => {
            for w in list.windows(2).skip(1) {
                [w[0], w[1], list[0]].into_iter().for_each(&mut corner);
            }
        }
    }
}

/// Decodes positions, and holds them against the file's own bounds.
fn positions(
    accessors: &Accessors,
    buffers: &Buffers<'_>,
    index: usize,
    user: &str,
    notes: &mut Notes,
) -> Result<Vec<[f32; 3]>, ErrorKind> {
    let accessor = accessors.get(index, user)?;
    let decoded: Vec<[f32; 3]> = accessors.floats(index, buffers, user)?;
    if let Some(v) = decoded.iter().position(|p| !p.iter().all(|c| c.is_finite())) {
        return Err(ErrorKind::invalid(
            user,
            format!("vertex {v} is {:?} (accessor {index}); positions must be finite", decoded[v]),
        ));
    }
    let (Some(min), Some(max)) = (&accessor.min, &accessor.max) else {
        notes.push(format!("accessor {index}"), "is of positions, but declares no min and max");
        return Ok(decoded);
    };
    // Bounds of normalised integers are the integers.
    let plain = accessor.component == Component::F32 || !accessor.normalized;
    if plain && min.len() == 3 && max.len() == 3 {
        let outside = |p: &[f32; 3]| (0..3).any(|a| p[a] < min[a] as f32 || p[a] > max[a] as f32);
        let count = decoded.iter().filter(|p| outside(p)).count();
        if count > 0 {
            notes.push(
                format!("accessor {index}"),
                format!("{count} vertices lie outside its min and max: a program that trusts those will cull what is visible"),
            );
        }
    }
    Ok(decoded)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corners(topology: Topology, list: &[u32]) -> Vec<u32> {
        let mut out = Vec::new();
        each_corner(topology, list, |v| out.push(v));
        assert_eq!(out.len(), triangle_count(topology, list.len()) * 3);
        out
    }

    #[test]
    fn strips_and_fans_keep_their_winding() {
        assert_eq!(corners(Topology::Strip, &[0, 1, 2, 3, 4]), [0, 1, 2, 1, 3, 2, 2, 3, 4]);
        assert_eq!(corners(Topology::Fan, &[0, 1, 2, 3]), [1, 2, 0, 2, 3, 0]);
        assert_eq!(corners(Topology::List, &[2, 1, 0, 7]), [2, 1, 0]);
    }

    #[test]
    fn too_short_makes_nothing() {
        for topology in [Topology::List, Topology::Strip, Topology::Fan] {
            for list in [&[][..], &[0], &[0, 1]] {
                assert!(corners(topology, list).is_empty());
            }
        }
    }
}
