//! Meshes: primitives decoded and joined, each with the vertices it uses.

use std::collections::HashMap;
use std::rc::Rc;

use cullet::MeshData;
use cullet::mesh::Part;

use super::accessor::{Accessor, Accessors, Component};
use super::buffers::Buffers;
use super::extensions;
use super::json::{self, Integer, MeshItem, PrimitiveItem, Root};
use super::materials::Surface;
use super::notes::Notes;
use super::uri::shorten;
use crate::{ErrorKind, LoadOptions};

/// How vertices make triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Topology {
    List,
    Strip,
    Fan,
}

/// A primitive of triangles, its references checked.
#[derive(Debug)]
struct Primitive {
    /// Its number in the mesh.
    number: usize,
    positions: usize,
    indices: Option<usize>,
    material: Option<usize>,
    topology: Topology,
    deform: Deform,
}

/// The accessors that move the vertices of a primitive; none where it is rigid.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
struct Deform {
    joints: Option<usize>,
    weights: Option<usize>,
    /// For each morph target its displacements, if it has any.
    targets: Vec<Option<usize>>,
}

impl Deform {
    fn is_rigid(&self) -> bool {
        self.joints.is_none() && self.targets.is_empty()
    }
}

/// What moves the vertices of a mesh, vertex by vertex.
#[derive(Debug, Default)]
pub(super) struct Binding {
    /// Joints and weights; those without any are moved by the first joint alone.
    pub(super) joints: Vec<[u16; 4]>,
    pub(super) weights: Vec<[f32; 4]>,
    /// For each morph target the displacement of every vertex.
    pub(super) targets: Vec<Vec<[f32; 3]>>,
}

/// A mesh, not yet decoded.
#[derive(Debug)]
pub(super) struct MeshSource {
    pub(super) name: String,
    primitives: Vec<Primitive>,
    /// Whether primitives have joints.
    pub(super) has_joints: bool,
    /// Whether primitives have more joints a vertex than four.
    pub(super) has_more_joints: bool,
    /// How many morph targets there are.
    pub(super) targets: usize,
    /// The weights of the targets; those left out are 0.
    pub(super) weights: Vec<f32>,
}

impl MeshSource {
    /// Whether it has triangles to draw.
    pub(super) fn is_drawn(&self) -> bool {
        !self.primitives.is_empty()
    }
}

/// All meshes of a document.
#[derive(Debug)]
pub(super) struct Meshes {
    pub(super) all: Vec<MeshSource>,
    /// The accessors that anything of a mesh names.
    pub(super) named: Vec<bool>,
}

impl Meshes {
    /// Reads all meshes, and checks what they refer to.
    ///
    /// # Errors
    /// If a reference leads nowhere, or attributes contradict each other, or data are packed.
    pub(super) fn read(
        root: &Root<'_>,
        accessors: &Accessors,
        materials: usize,
        notes: &mut Notes,
    ) -> Result<Self, ErrorKind> {
        let mut named = vec![false; accessors.len()];
        let mut all = Vec::new();
        for (m, raw) in root.meshes.iter().flatten().enumerate() {
            let item: MeshItem<'_> = json::item(raw, "mesh", m)?;
            let name = match item.name.as_deref() {
                Some(name) if !name.is_empty() => shorten(name),
                _ => format!("mesh {m}"),
            };
            if item.primitives.is_empty() {
                notes.push(&name, "has no primitives");
            }
            let mut source = MeshSource {
                name,
                primitives: Vec::new(),
                has_joints: false,
                has_more_joints: false,
                targets: item.primitives.iter().map(|p| p.targets.len()).max().unwrap_or(0),
                weights: item.weights.iter().map(|w| w.0 as f32).collect(),
            };
            for (p, item) in item.primitives.iter().enumerate() {
                let user = user(m, &source.name, p);
                source.has_joints |= item.attributes.contains_key("JOINTS_0");
                source.has_more_joints |= item.attributes.contains_key("JOINTS_1");
                source
                    .primitives
                    .extend(primitive(item, p, &user, accessors, materials, &mut named, notes)?);
            }
            all.push(source);
        }
        Ok(Self { all, named })
    }
}

/// What errors call a primitive.
fn user(mesh: usize, name: &str, primitive: usize) -> String {
    format!("mesh {mesh} `{name}`, primitive {primitive}")
}

/// Checks a primitive; `None` if it has nothing to draw.
fn primitive(
    item: &PrimitiveItem,
    number: usize,
    user: &str,
    accessors: &Accessors,
    materials: usize,
    named: &mut [bool],
    notes: &mut Notes,
) -> Result<Option<Primitive>, ErrorKind> {
    let wrong = |message: String| Err(ErrorKind::invalid(user, message));
    let targets = item.targets.iter().flatten();
    for (name, to) in item.attributes.iter().chain(targets) {
        let Some(named) = named.get_mut(to.index()) else {
            let count = accessors.len();
            return wrong(format!("{} is accessor {} of {count}", shorten(name), to.0));
        };
        *named = true;
    }
    if let Some(indices) = item.indices {
        match named.get_mut(indices.index()) {
            Some(named) => *named = true,
            None => {
                return wrong(format!("indices are accessor {} of {}", indices.0, accessors.len()));
            }
        }
    }
    let material = item.material.map(Integer::index);
    if let Some(m) = material.filter(|&m| m >= materials) {
        return wrong(format!("names material {m} of {materials}"));
    }
    let topology = match item.mode.map_or(4, |m| m.0) {
        4 => Topology::List,
        5 => Topology::Strip,
        6 => Topology::Fan,
        0 => {
            notes.push(user, "is of points, which are skipped");
            return Ok(None);
        }
        1..=3 => {
            notes.push(user, "is of lines, which are skipped");
            return Ok(None);
        }
        mode => return wrong(format!("mode {mode} is not known; there are 0 to 6")),
    };
    let Some(positions) = item.attributes.get("POSITION").map(|i| i.index()) else {
        notes.push(user, "has no POSITION and is skipped");
        return Ok(None);
    };
    let count = accessors.get(positions, user)?.count;
    for (name, to) in &item.attributes {
        let other = accessors.find(to.index()).map(|a| a.count);
        if let Some(other) = other.filter(|&c| c != count) {
            let name = shorten(name);
            return wrong(format!("{name} has {other} elements, but POSITION has {count}"));
        }
    }
    if item.extensions.draco.is_some() {
        // Accessors with views of their own are the fallback for who cannot read Draco.
        let has_bytes = |i: usize| accessors.find(i).is_some_and(Accessor::has_bytes);
        let fallback = has_bytes(positions) && item.indices.is_none_or(|i| has_bytes(i.index()));
        if !fallback {
            return Err(ErrorKind::Unsupported(extensions::draco()));
        }
    }
    Ok(Some(Primitive {
        number,
        positions,
        indices: item.indices.map(Integer::index),
        material,
        topology,
        deform: Deform {
            joints: item.attributes.get("JOINTS_0").map(|i| i.index()),
            weights: item.attributes.get("WEIGHTS_0").map(|i| i.index()),
            targets: item.targets.iter().map(|t| t.get("POSITION").map(|i| i.index())).collect(),
        },
    }))
}

/// Turns meshes into data, one at a time, decoding each accessor once.
pub(super) struct Decoder<'a> {
    accessors: &'a Accessors,
    buffers: &'a Buffers<'a>,
    surfaces: &'a [Surface],
    options: &'a LoadOptions,
    /// Vertex accessors that several meshes use.
    shared: HashMap<usize, Shared>,
    triangles: u64,
    /// Of deformable meshes.
    vertices: u64,
    /// Of the mesh last decoded: where the vertices of a deformable primitive begin.
    blocks: Vec<(u32, usize)>,
    /// Whether a primitive named no material.
    pub(super) used_default: bool,
}

struct Shared {
    positions: Option<Rc<Vec<[f32; 3]>>>,
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
        // How many meshes use a vertex accessor, and the last that was counted.
        let mut users: HashMap<usize, (u32, usize)> = HashMap::new();
        for (number, mesh) in used.enumerate() {
            // What deforms keeps its vertices in the order of the file, beside what moves them.
            for p in mesh.primitives.iter().filter(|p| p.deform.is_rigid()) {
                let entry = users.entry(p.positions).or_insert((0, usize::MAX));
                if entry.1 != number {
                    *entry = (entry.0 + 1, number);
                }
            }
        }
        let shared = users
            .into_iter()
            .filter(|(_, (meshes, _))| *meshes > 1)
            .map(|(accessor, (meshes, _))| {
                (accessor, Shared { positions: None, place: Vec::new(), meshes_left: meshes })
            })
            .collect();
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

    /// Decodes a mesh: one part for each primitive of triangles, in order. Vertices are those of the
    /// file, unless several meshes share them: then each gets those that it uses.
    ///
    /// # Errors
    /// If an index or a position is out of range, or a limit is passed; the error names mesh,
    /// primitive and vertex.
    pub(super) fn decode(
        &mut self,
        index: usize,
        mesh: &MeshSource,
        notes: &mut Notes,
    ) -> Result<MeshData, ErrorKind> {
        let mut data = MeshData::default();
        // Where the vertices of an accessor of this mesh alone begin.
        let mut bases: HashMap<(usize, &Deform), u32> = HashMap::new();
        let mut finished = Vec::new();
        self.blocks.clear();
        for (at, p) in mesh.primitives.iter().enumerate() {
            let user = user(index, &mesh.name, p.number);
            let count = self.accessors.get(p.positions, &user)?.count;
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
            match self.shared.get_mut(&p.positions).filter(|_| p.deform.is_rigid()) {
                Some(shared) => {
                    if shared.positions.is_none() {
                        let decoded =
                            positions(self.accessors, self.buffers, p.positions, &user, notes)?;
                        shared.place = vec![(0, 0); decoded.len()];
                        shared.positions = Some(Rc::new(decoded));
                    }
                    let all = shared.positions.clone().unwrap_or_default();
                    let list = list.unwrap_or_else(|| (0..corners as u32).collect());
                    let stamp = shared.meshes_left;
                    let place = &mut shared.place;
                    let vertices = &mut data.positions;
                    // Meshes count down from many to one, so each has a stamp of its own above 0.
                    each_corner(p.topology, &list, |v| {
                        let entry = &mut place[v as usize];
                        if entry.0 != stamp {
                            *entry = (stamp, vertices.len() as u32);
                            vertices.push(all[v as usize]);
                        }
                        data.indices.push(entry.1);
                    });
                    if !finished.contains(&p.positions) {
                        finished.push(p.positions);
                    }
                }
                None => {
                    let base = match bases.get(&(p.positions, &p.deform)) {
                        Some(&base) => base,
                        None => {
                            let decoded =
                                positions(self.accessors, self.buffers, p.positions, &user, notes)?;
                            let base = data.positions.len() as u32;
                            if base == 0 {
                                data.positions = decoded;
                            } else {
                                data.positions.extend(decoded);
                            }
                            bases.insert((p.positions, &p.deform), base);
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
        for accessor in finished {
            if let Some(shared) = self.shared.get_mut(&accessor) {
                shared.meshes_left -= 1;
                if shared.meshes_left == 0 {
                    self.shared.remove(&accessor);
                }
            }
        }
        Ok(data)
    }

    /// What moves the vertices of the mesh that was decoded last, of which there are `vertices`.
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
        let mut binding = Binding {
            joints: vec![[0; 4]; vertices],
            weights: vec![[1.0, 0.0, 0.0, 0.0]; vertices],
            targets: vec![vec![[0.0; 3]; vertices]; mesh.targets],
        };
        for &(base, at) in &self.blocks {
            let p = &mesh.primitives[at];
            let user = user(index, &mesh.name, p.number);
            let count = self.accessors.get(p.positions, &user)?.count;
            let place = base as usize..base as usize + count;
            let same = |found: usize, what: &str| match found == count {
                true => Ok(()),
                false => {
                    let message = format!("has {found} {what} for {count} vertices");
                    Err(ErrorKind::invalid(&user, message))
                }
            };
            if let (Some(joints), Some(weights)) = (p.deform.joints, p.deform.weights) {
                let joints: Vec<[f32; 4]> = self.accessors.floats(joints, self.buffers, &user)?;
                let weights: Vec<[f32; 4]> = self.accessors.floats(weights, self.buffers, &user)?;
                same(joints.len(), "joints")?;
                same(weights.len(), "weights")?;
                for (to, j) in binding.joints[place.clone()].iter_mut().zip(joints) {
                    *to = j.map(|j| j as u16);
                }
                for (to, w) in binding.weights[place.clone()].iter_mut().zip(weights) {
                    *to = normalised(w);
                }
            }
            for (to, target) in binding.targets.iter_mut().zip(&p.deform.targets) {
                let Some(target) = *target else { continue };
                let target: Vec<[f32; 3]> = self.accessors.floats(target, self.buffers, &user)?;
                same(target.len(), "displacements")?;
                to[place.clone()].copy_from_slice(&target);
            }
        }
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

/// Weights that add to 1, as most programs make them when they load; without any, the first has all.
fn normalised(w: [f32; 4]) -> [f32; 4] {
    let sum: f32 = w.iter().sum();
    match sum > 0.0 && sum.is_finite() {
        true => w.map(|v| v / sum),
        false => [1.0, 0.0, 0.0, 0.0],
    }
}

fn triangle_count(topology: Topology, corners: usize) -> usize {
    match topology {
        Topology::List => corners / 3,
        Topology::Strip | Topology::Fan => corners.saturating_sub(2),
    }
}

/// Calls `corner` with the vertex of each corner of each triangle, in the order of the specification:
/// every second triangle of a strip is turned, and a fan's centre comes last.
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
