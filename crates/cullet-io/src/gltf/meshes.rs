//! Meshes and their primitives: read, and all that they refer to checked.

use super::accessor::{Accessor, Accessors};
use super::extensions;
use super::json::{self, Integer, MeshItem, PrimitiveItem, Root};
use super::notes::Notes;
use super::uri::shorten;
use crate::ErrorKind;

/// How vertices make triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Topology {
    List,
    Strip,
    Fan,
}

/// A primitive of triangles, its references checked.
#[derive(Debug)]
pub(super) struct Primitive {
    /// Its number in the mesh.
    pub(super) number: usize,
    pub(super) vertices: Vertices,
    pub(super) indices: Option<usize>,
    pub(super) material: Option<usize>,
    pub(super) topology: Topology,
    pub(super) deform: Deform,
}

/// The accessors of what its vertices are, also where only positions are kept: what the vertices of
/// a mesh are numbered by must not depend on that, or levels that were baked with all of them would
/// not fit a mesh that was loaded with few.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Vertices {
    pub(super) positions: usize,
    pub(super) normals: Option<usize>,
    pub(super) uvs: Option<usize>,
    pub(super) colors: Option<usize>,
}

/// The accessors that move the vertices of a primitive; none where it is rigid.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Deform {
    pub(super) joints: Option<usize>,
    pub(super) weights: Option<usize>,
    /// Joints and weights beside the first four of each vertex.
    pub(super) more: Option<(usize, usize)>,
    /// For each morph target its displacements, if it has any.
    pub(super) targets: Vec<Option<usize>>,
}

impl Deform {
    pub(super) fn is_rigid(&self) -> bool {
        self.joints.is_none() && self.targets.is_empty()
    }
}

/// Joints, weights and morph targets of a mesh, vertex by vertex.
#[derive(Debug, Default)]
pub(super) struct Binding {
    /// Joints and weights, four for each vertex, then perhaps four more for each; those without any
    /// are moved by the first joint alone.
    pub(super) joints: Vec<[u16; 4]>,
    pub(super) weights: Vec<[f32; 4]>,
    /// For each morph target the displacement of every vertex.
    pub(super) targets: Vec<Vec<[f32; 3]>>,
}

/// A mesh, not yet decoded.
#[derive(Debug)]
pub(super) struct MeshSource {
    pub(super) name: String,
    pub(super) primitives: Vec<Primitive>,
    /// Whether primitives have joints.
    pub(super) has_joints: bool,
    /// Whether primitives have more joints a vertex than eight.
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
        for (m, raw) in json::all(&root.meshes).iter().enumerate() {
            let item: MeshItem<'_> = json::item(*raw, "mesh", m)?;
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
                weights: item.weights.iter().map(|&w| w as f32).collect(),
            };
            for (p, item) in item.primitives.iter().enumerate() {
                let user = user(m, &source.name, p);
                source.has_joints |= item.attributes.get("JOINTS_0").is_some();
                source.has_more_joints |= item.attributes.get("JOINTS_2").is_some();
                let read = primitive(item, p, &user, accessors, materials, &mut named, notes)?;
                source.primitives.extend(read);
            }
            all.push(source);
        }
        Ok(Self { all, named })
    }
}

/// Name of a primitive in errors.
pub(super) fn user(mesh: usize, name: &str, primitive: usize) -> String {
    format!("mesh {mesh} `{name}`, primitive {primitive}")
}

/// Checks a primitive; `None` if it has nothing to draw.
fn primitive(
    item: &PrimitiveItem<'_>,
    number: usize,
    user: &str,
    accessors: &Accessors,
    materials: usize,
    named: &mut [bool],
    notes: &mut Notes,
) -> Result<Option<Primitive>, ErrorKind> {
    let wrong = |message: String| Err(ErrorKind::invalid(user, message));
    for (name, to) in std::iter::once(&item.attributes).chain(&item.targets).flat_map(|all| &all.0)
    {
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
    let Some(positions) = item.attributes.get("POSITION").map(Integer::index) else {
        notes.push(user, "has no POSITION and is skipped");
        return Ok(None);
    };
    let count = accessors.get(positions, user)?.count;
    for (name, to) in &item.attributes.0 {
        let other = accessors.find(to.index()).map(|a| a.count);
        if let Some(other) = other.filter(|&c| c != count) {
            let name = shorten(name);
            return wrong(format!("{name} has {other} elements, but POSITION has {count}"));
        }
    }
    if item.draco.is_some() {
        // Accessors with views of their own are the fallback for readers without Draco.
        let has_bytes = |i: usize| accessors.find(i).is_some_and(Accessor::has_bytes);
        let fallback = has_bytes(positions) && item.indices.is_none_or(|i| has_bytes(i.index()));
        if !fallback {
            return Err(ErrorKind::Unsupported(extensions::draco()));
        }
    }
    let attribute = |name: &str| item.attributes.get(name).map(Integer::index);
    Ok(Some(Primitive {
        number,
        vertices: Vertices {
            positions,
            normals: attribute("NORMAL"),
            uvs: attribute("TEXCOORD_0"),
            colors: attribute("COLOR_0"),
        },
        indices: item.indices.map(Integer::index),
        material,
        topology,
        deform: Deform {
            joints: attribute("JOINTS_0"),
            weights: attribute("WEIGHTS_0"),
            more: attribute("JOINTS_1").zip(attribute("WEIGHTS_1")),
            targets: item.targets.iter().map(|t| t.get("POSITION").map(Integer::index)).collect(),
        },
    }))
}
