//! glTF 2.0 and GLB.
//!
//! The JSON is read by types of our own and every reference, range and count is checked here before
//! it is used: a general reader either refuses files for things that have no bearing on geometry,
//! or trusts what it must not.

mod accessor;
mod animation;
mod baked;
mod baked_items;
mod buffers;
mod cameras;
mod cells;
mod decode;
mod extensions;
mod glb;
mod impostor;
mod instances;
mod json;
mod mapped;
mod mapped_groups;
mod mapped_tables;
mod materials;
mod meshes;
mod meshopt;
mod nodes;
mod notes;
mod rig;
#[cfg(not(target_family = "wasm"))]
mod size;
mod stand_ins;
pub(crate) mod uri;

#[cfg(test)]
mod tests;

use std::ops::Range;
use std::path::{Path, PathBuf};

use cullet::{Mesh, MeshData, Scene};

use crate::beside::Beside;
use crate::blocks::Source;
use crate::model::{Motion, MotionKind};
use crate::motion::Deformed;
use crate::pose::stand;
use crate::{Attributes, CameraNode, ErrorKind, LoadOptions, Material, Model, NodeTree, Unread};
use instances::Placement;
use notes::Notes;

pub(crate) use baked_items::NAME as BAKED;
pub(crate) use cells::{NAME as CELLS, error as cells_error};
pub(crate) use glb::parts;
pub(crate) use mapped::{ListError, Listed, list};
pub use mapped::{ListedImpostor, ListedLevels, ListedMesh, ListedTable};
pub use mapped_groups::ListedGroup;
#[cfg(not(target_family = "wasm"))]
pub use size::{Counts, counts};
pub(crate) use uri::read as read_uri;
pub use uri::{UriSource, read_in as read_uri_in};

/// Loads a glTF or GLB from the bytes of its file; its other files are `beside`.
///
/// The scene that the file chooses is loaded (else its first, else every root node): one mesh for
/// each mesh that a node draws, one instance for each drawing. Points and lines are skipped with a
/// warning. Skinned and morphed meshes come as the file stores them, each node's its own mesh: its
/// joints where their nodes are, whatever the skinned node's own transform, and its targets under
/// their default weights; the model's motion poses them at a time. Vertices keep their order, except that meshes which share a
/// vertex accessor get only the vertices that they use.
///
/// Costs O(size of the file + instances); at its peak takes the file's bytes and once the decoded
/// geometry, then the geometry and what [`Mesh::new`] needs for one mesh.
///
/// # Errors
/// If the file is invalid, needs an extension that is not read, or passes a limit of `options`.
pub fn load(
    path: &Path,
    bytes: Vec<u8>,
    options: &LoadOptions,
    beside: Beside<'_>,
) -> Result<Model, ErrorKind> {
    check_header(path, &bytes)?;
    let decoded = decode(&bytes, beside, options, true)?;
    // Freed before meshes are made: the peak is the greater of the two halves, not their sum.
    drop(bytes);
    let mut model = decoded.into_model()?;
    model.name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok(model)
}

/// Loads the glTF of a tile like [`load`]. Returns with the model the centre that `CESIUM_RTC`
/// moves it by, zero where there is none: in the axes of the tile, so that it comes after the turn
/// of the up axis.
///
/// # Errors
/// As [`load`].
pub fn load_tile(
    path: &Path,
    bytes: Vec<u8>,
    options: &LoadOptions,
    beside: Beside<'_>,
) -> Result<(Model, [f64; 3]), ErrorKind> {
    check_header(path, &bytes)?;
    let decoded = decode(&bytes, beside, options, false)?;
    drop(bytes);
    let centre = decoded.centre;
    let mut model = decoded.into_model()?;
    model.name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok((model, centre))
}

/// A file named `.glb` must begin as one.
fn check_header(path: &Path, bytes: &[u8]) -> Result<(), ErrorKind> {
    let named_glb = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("glb"));
    if named_glb && !bytes.starts_with(b"glTF") {
        let found = bytes.get(..4).unwrap_or(bytes).escape_ascii();
        let message = format!("starts with \"{found}\", expected \"glTF\"");
        return Err(ErrorKind::invalid("GLB header", message));
    }
    Ok(())
}

/// The first bytes of a glTF or GLB, and where in them its JSON is. Of a GLB what follows that is
/// not read.
fn json_of(source: &Source<'_>) -> Result<(Vec<u8>, Range<usize>), ErrorKind> {
    let head = source.head(glb::HEAD)?;
    let size = usize::try_from(source.size()).unwrap_or(usize::MAX);
    let json = match glb::json_at(&head) {
        Some(json) if json.end <= size => json,
        Some(json) => {
            let message = format!("declares {} bytes: more than the file has", json.len());
            return Err(ErrorKind::invalid("GLB chunk 0", message));
        }
        None => 0..size,
    };
    Ok((source.head(json.end)?, json))
}

/// The files that the buffers of a glTF or GLB name. Of a GLB only the JSON is read.
///
/// # Errors
/// If there is no JSON to be read. What is wrong with a buffer is left to who loads the model.
pub(crate) fn named(path: &Path, source: &Source<'_>) -> Result<Vec<PathBuf>, ErrorKind> {
    check_header(path, &source.head(glb::HEAD)?)?;
    let (bytes, json) = json_of(source)?;
    let root = json::parse(bytes.get(json).unwrap_or_default())?;
    Ok(buffers::files(&root))
}

/// A document that was decoded, free of the file's bytes.
struct Decoded {
    /// The centre of `CESIUM_RTC`.
    centre: [f64; 3],
    unread: Vec<Unread>,
    meshes: Vec<(String, MeshData)>,
    /// One entry per mesh; empty unless the options request details.
    attributes: Vec<Attributes>,
    /// Their numbers are those of `meshes`.
    placements: Vec<Placement>,
    names: Vec<String>,
    node_tree: NodeTree,
    materials: Vec<Material>,
    textures: u32,
    cameras: Vec<CameraNode>,
    plan: rig::Plan,
    nodes: nodes::Nodes,
    /// Instances that move or deform, by their place in `placements`.
    followers: Vec<rig::Placed>,
    deformed: Vec<Deformed>,
    cells: cells::Cells,
    baked: Option<baked::Found>,
    /// The number of each mesh in the file.
    numbers: Vec<u32>,
    notes: Notes,
}

/// Decodes a document. `moved` says whether the centre of `CESIUM_RTC`, in the axes of the file, is
/// in the place of its nodes.
fn decode(
    bytes: &[u8],
    beside: Beside<'_>,
    options: &LoadOptions,
    moved: bool,
) -> Result<Decoded, ErrorKind> {
    let mut notes = Notes::default();
    let container = glb::open(bytes, &mut notes)?;
    let root = json::parse(&bytes[container.json])?;
    extensions::check(&root.extensions_required)?;
    let centre = extensions::centre(&root)?;
    empty_arrays(&root, &mut notes);
    let count = |items: &json::Items<'_>| items.as_ref().map_or(0, Vec::len);

    let buffers = buffers::Buffers::read(&root, bytes, container.bin, container.is_glb, beside)?;
    let accessors = accessor::Accessors::read(&root, &buffers)?;
    let mut surfaces = materials::read(&root, &mut notes)?;
    let meshes = meshes::Meshes::read(&root, &accessors, surfaces.len(), &mut notes)?;
    let counts = nodes::Counts {
        meshes: meshes.all.len(),
        cameras: count(&root.cameras),
        skins: count(&root.skins),
    };
    let base = nodes::base(options.up.unwrap_or_default(), if moved { centre } else { [0.0; 3] });
    let nodes = nodes::Nodes::read(&root, &counts, base, &mut notes)?;
    check_unused(&root, &accessors, &buffers, &meshes, &nodes)?;
    let cells = cells::Cells::read(&root, &nodes.base(), nodes.all.len())?;

    let plan = rig::Plan::read(&root, &nodes, &meshes, &accessors, &buffers, &mut notes)?;
    let mut placed =
        instances::place(&nodes, &meshes, &accessors, &buffers, &plan, options, &mut notes)?;
    let cameras = cameras::read(&root, &nodes, &placed.cameras, &plan.clips, &mut notes)?;

    surfaces.push(materials::default());
    let drawn = placed.meshes.iter().map(|&m| &meshes.all[m as usize]);
    let mut decoder = decode::Decoder::new(&accessors, &buffers, &surfaces, options, drawn);
    let mut data = Vec::with_capacity(placed.meshes.len());
    let mut attributes = Vec::new();
    let mut owners = vec![None; placed.meshes.len()];
    placed.deformed.iter().for_each(|&(node, mesh)| owners[mesh as usize] = Some(node));
    let mut deformed = Vec::new();
    for (number, &m) in placed.meshes.iter().enumerate() {
        let source = &meshes.all[m as usize];
        let (mesh, kept) = decoder.decode(m as usize, source, &mut notes)?;
        if options.details {
            attributes.push(kept);
        }
        if let Some(index) = owners[number] {
            let node = &nodes.all[index as usize];
            let name = nodes.name(index);
            let mut left = |e: String| {
                notes.push(&name, format!("cannot be posed, and stays as it is stored: {e}"));
            };
            match decoder.binding(m as usize, source, mesh.positions.len()) {
                Ok(binding) => {
                    let mesh = (number as u32, &mesh);
                    match plan.deformed((index, node), mesh, &source.weights, binding) {
                        Ok(d) => deformed.push(d),
                        Err(e) => left(e.to_string()),
                    }
                }
                Err(e @ ErrorKind::OverLimit { .. }) => return Err(e),
                Err(e) => left(e.to_string()),
            }
            if node.skin.is_some() && source.has_more_joints {
                notes.push(&name, "has more than eight joints a vertex: the first eight move it");
            }
        }
        data.push((source.name.clone(), mesh));
    }
    let baked = match options.levels {
        true => baked::read(&root, &buffers, &placed.meshes, &data, options.details, &mut notes),
        false => None,
    };
    let baked = match options.impostors {
        true => baked,
        false => baked.map(baked::Found::without_impostors),
    };
    let used_default = decoder.used_default;
    let mut materials: Vec<Material> = surfaces.into_iter().map(|s| s.material).collect();
    if !used_default {
        materials.pop();
    }
    let unread = extensions::unread(&root, plan.pointer.as_deref());
    if placed.placements.is_empty() {
        let unread: Vec<&str> =
            unread.iter().filter(|u| u.may_draw).map(|u| u.name.as_str()).collect();
        notes.push(
            "scene",
            match unread.is_empty() {
                true => "draws nothing".to_owned(),
                false => format!("draws nothing but what {} may draw", unread.join(", ")),
            },
        );
    }
    unread.iter().for_each(|u| notes.push("not read", format!("{}, {}", u.name, u.meaning)));
    Ok(Decoded {
        centre,
        unread,
        meshes: data,
        attributes,
        placements: std::mem::take(&mut placed.placements),
        names: placed.names,
        node_tree: nodes.tree(placed.nodes, options.details),
        materials,
        textures: count(&root.textures) as u32,
        cameras,
        plan,
        nodes,
        followers: placed.followers,
        deformed,
        cells,
        baked,
        numbers: placed.meshes,
        notes,
    })
}

impl Decoded {
    fn into_model(mut self) -> Result<Model, ErrorKind> {
        let mut scene = Scene::new();
        let mut mesh_names = Vec::with_capacity(self.meshes.len());
        for (name, data) in self.meshes {
            let mesh = Mesh::new(data)
                .map_err(|e| ErrorKind::invalid(format!("mesh `{name}`"), e.to_string()))?;
            scene.add_mesh(mesh);
            mesh_names.push(name);
        }
        let mut handles = Vec::new();
        for (i, placement) in self.placements.iter().enumerate() {
            let handle = scene
                .add(placement.instance())
                .map_err(|e| ErrorKind::invalid("scene", e.to_string()))?;
            if let Some(&node) = self.node_tree.node_of_instance.get(i) {
                self.cells.drawn(node, handle);
            }
            // In step with `followers`, so that millions that stand need no list.
            if self.followers.get(handles.len()).is_some_and(|f| f.placement as usize == i) {
                handles.push(handle);
            }
        }
        let rig = self.plan.rig(&self.nodes, &self.followers, self.deformed, &handles);
        let mut model = Model {
            scene,
            mesh_names,
            attributes: self.attributes,
            instance_names: self.names,
            node_tree: self.node_tree,
            materials: self.materials,
            textures: self.textures,
            cameras: self.cameras,
            file_meshes: self.numbers,
            unread: self.unread,
            ..Model::default()
        };
        let nowhere =
            stand(&rig, &mut model).map_err(|e| ErrorKind::invalid("scene", e.to_string()))?;
        nowhere.into_iter().for_each(|w| self.notes.push(w.item, w.message));
        model.motion = rig.moves().then_some(Motion { kind: MotionKind::Rig(rig) });
        model.scene.sort();
        model.baked = self.baked.map(|found| {
            let Model { scene, mesh_names, attributes, .. } = &mut model;
            found.give(scene, mesh_names, attributes, &mut self.notes)
        });
        model.warnings = self.notes.into_warnings();
        self.cells.give(&mut model);
        Ok(model)
    }
}

/// The specification forbids empty arrays, but many programs write them, and they change nothing.
fn empty_arrays(root: &json::Root<'_>, notes: &mut Notes) {
    let arrays = [
        ("scenes", &root.scenes),
        ("nodes", &root.nodes),
        ("meshes", &root.meshes),
        ("accessors", &root.accessors),
        ("bufferViews", &root.buffer_views),
        ("buffers", &root.buffers),
    ];
    for (name, items) in arrays {
        if items.as_ref().is_some_and(Vec::is_empty) {
            notes.push(name, "is an empty array, which glTF forbids");
        }
    }
}

/// Floats that nobody names might be positions for somebody: as in positions, NaN is an error
/// there. Those of other attributes and of animations are theirs to judge.
fn check_unused(
    root: &json::Root<'_>,
    accessors: &accessor::Accessors,
    buffers: &buffers::Buffers<'_>,
    meshes: &meshes::Meshes,
    nodes: &nodes::Nodes,
) -> Result<(), ErrorKind> {
    // Skins and animations name accessors too, and neither is read here.
    if root.skins.is_some() || root.animations.is_some() {
        return Ok(());
    }
    let mut named = meshes.named.clone();
    for instancing in nodes.all.iter().filter_map(|n| n.instancing.as_deref()) {
        for index in instancing.accessors() {
            if let Some(named) = named.get_mut(index) {
                *named = true;
            }
        }
    }
    for (i, _) in named.iter().enumerate().filter(|(_, named)| !**named) {
        if let Some(element) = accessors.first_not_finite(i, buffers) {
            let message = format!("element {element} is not finite");
            return Err(ErrorKind::invalid(format!("accessor {i}"), message));
        }
    }
    Ok(())
}
