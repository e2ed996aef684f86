//! Levels as meshes of their own that other programs draw: `MSFT_lod`, a list of nodes in the place
//! of one.
//!
//! Specification: <https://github.com/KhronosGroup/glTF/tree/main/extensions/2.0/Vendor/MSFT_lod>.

use std::borrow::Cow;
use std::collections::{HashMap, HashSet};

use cullet::lod::{Levels, NO_GROUP};
use cullet::{Mesh, MeshId};
use serde_json::json;

use super::object::{Object, list};
use crate::baked::{BakedMesh, LevelKind};
use crate::bytes::put_u32s;
use crate::{ErrorKind, Model, Warning};

const NAME: &str = "MSFT_lod";
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
const UNSIGNED_INT: u32 = 5125;

/// Rows of the screen on which levels are meant to be off by a pixel at the most.
const ROWS: f64 = 1080.0;

/// Members of a node that say where it stands, which each of its levels stands too.
const PLACE: [&str; 5] = ["name", "matrix", "translation", "rotation", "scale"];

/// Levels of a mesh of the file.
struct Lods {
    /// The new meshes, finest first.
    meshes: Vec<usize>,
    /// Share of the screen under which the next is drawn, for the mesh itself and each of them.
    coverage: Vec<f64>,
}

/// Adds the chains of a model's meshes as nodes. What cannot have them is told.
pub(super) fn add(
    model: &Model,
    root: &mut Object<'_>,
    bin: &mut Vec<u8>,
    warnings: &mut Vec<Warning>,
) -> Result<(), ErrorKind> {
    let mut warn = |item: String, message: &str| {
        warnings.push(Warning { item, message: format!("{NAME}: {message}") });
    };
    // Without a scene all nodes that nobody has for a child are drawn, and so would levels be.
    if root.get("scenes").is_none() {
        warn("scenes".to_owned(), "there are none, so no levels are added");
        return Ok(());
    }
    let mut meshes = list(root, "meshes")?;
    let mut views = list(root, "bufferViews")?;
    let mut accessors = list(root, "accessors")?;
    let counts: Vec<usize> = accessors.iter().map(|text| count_of(text)).collect();
    let mut nodes = list(root, "nodes")?;
    let places = places(root, &nodes)?;
    let mut made: HashMap<usize, Lods> = HashMap::new();
    let (mut shared, mut joined) = (0u64, 0u64);
    for one in model.baked.iter().flat_map(|baked| &baked.meshes) {
        let number = model.file_meshes.get(one.mesh as usize).map(|&n| n as usize);
        let base = &model.scene.meshes()[one.mesh as usize];
        let (Some(number), Some((held_by, levels))) = (number, chain(model, one)) else { continue };
        let drawn = !base.is_deformable() && places.free.iter().any(|&(_, mesh)| mesh == number);
        let Some(text) = meshes.get(number).filter(|_| drawn).cloned() else { continue };
        let source = Object::parse(&text, "mesh")?;
        let Some(blocks) = blocks(&source, &counts, base)? else {
            shared += 1;
            continue;
        };
        let Some(levels) = triangles(base, held_by, levels, &blocks) else {
            joined += 1;
            continue;
        };
        // Bytes of all levels lie together.
        bin.resize(bin.len().next_multiple_of(8), 0);
        let start = bin.len();
        let mut lods = Lods { meshes: Vec::new(), coverage: Vec::new() };
        for (k, level) in levels.iter().enumerate() {
            let mut mesh = Object::parse("{}", "mesh")?;
            let name = source.string("name").unwrap_or_else(|| format!("mesh {number}"));
            mesh.set("name", json!(format!("{name}, level {}", k + 1)).to_string());
            let mut primitives = Vec::new();
            for (block, indices) in blocks.iter().zip(&level.indices).filter(|(_, i)| !i.is_empty())
            {
                let mut primitive = Object::parse(&block.primitive, "primitive")?;
                primitive.remove("mode");
                primitive.change("extensions", &mut |all| {
                    all.remove("KHR_draco_mesh_compression");
                    Ok(())
                })?;
                primitive.set("indices", accessors.len().to_string());
                let accessor = json!({
                    "bufferView": views.len(), "byteOffset": bin.len() - start,
                    "componentType": UNSIGNED_INT, "count": indices.len(), "type": "SCALAR",
                });
                accessors.push(Cow::Owned(accessor.to_string()));
                put_u32s(bin, indices);
                primitives.push(Cow::Owned(primitive.to_text()));
            }
            mesh.set_list("primitives", &primitives);
            lods.meshes.push(meshes.len());
            meshes.push(Cow::Owned(mesh.to_text()));
            let most = lods.coverage.last().copied().unwrap_or(1.0);
            lods.coverage.push(coverage(base, level.error).min(most));
        }
        // The coarsest is drawn however small it is.
        lods.coverage.push(0.0);
        views.push(Cow::Owned(
            json!({ "buffer": 0, "byteOffset": start, "byteLength": bin.len() - start,
                    "target": ELEMENT_ARRAY_BUFFER })
            .to_string(),
        ));
        made.insert(number, lods);
    }
    for (at, mesh) in places.free {
        let Some(lods) = made.get(&mesh) else { continue };
        let text = nodes[at].clone();
        let mut node = Object::parse(&text, &format!("node {at}"))?;
        let ids: Vec<usize> = (nodes.len()..).take(lods.meshes.len()).collect();
        for &mesh in &lods.meshes {
            let mut level = Object::parse("{}", "node")?;
            for member in PLACE {
                if let Some(text) = node.get(member) {
                    level.set(member, text);
                }
            }
            level.set("mesh", mesh.to_string());
            nodes.push(Cow::Owned(level.to_text()));
        }
        node.set("extensions", json!({ NAME: { "ids": ids } }).to_string());
        if node.get("extras").is_none_or(|text| text.starts_with('{')) {
            node.change("extras", &mut |extras| {
                extras.set("MSFT_screencoverage", json!(lods.coverage).to_string());
                Ok(())
            })?;
        }
        nodes[at] = Cow::Owned(node.to_text());
    }
    let told = [
        (shared, "meshes", "share vertices with others, and have no levels"),
        (joined, "meshes", "have levels that join their primitives, which are not added"),
        (
            places.left,
            "nodes",
            "with children, a camera or extensions, or that move, have no levels",
        ),
    ];
    for (count, what, message) in told.into_iter().filter(|(count, ..)| *count > 0) {
        warn(format!("{count} {what}"), message);
    }
    if !made.is_empty() {
        root.set_list("meshes", &meshes);
        root.set_list("bufferViews", &views);
        root.set_list("accessors", &accessors);
        root.set_list("nodes", &nodes);
        let mut used = list(root, "extensionsUsed")?;
        let name = format!("\"{NAME}\"");
        if !used.iter().any(|own| *own == name) {
            used.push(Cow::Owned(name));
            root.set_list("extensionsUsed", &used);
        }
    }
    Ok(())
}

/// Where levels can be put.
struct Places {
    /// Nodes, and the mesh of each.
    free: Vec<(usize, usize)>,
    /// How many nodes draw a mesh, and cannot have levels.
    left: u64,
}

/// Returns the nodes that can take levels. A node with children or an animation cannot: children
/// would go with it, and an animation would not move its levels. Nodes that have a list keep
/// theirs.
fn places(root: &Object<'_>, nodes: &[Cow<'_, str>]) -> Result<Places, ErrorKind> {
    let moved = animated(root);
    let mut out = Places { free: Vec::new(), left: 0 };
    for (at, text) in nodes.iter().enumerate() {
        let node = Object::parse(text, &format!("node {at}"))?;
        let Some(mesh) = node.number("mesh") else { continue };
        let other = ["children", "camera", "skin", "weights", "extensions"];
        if !moved.contains(&at) && other.iter().all(|m| node.get(m).is_none()) {
            out.free.push((at, mesh));
        } else if !node.get("extensions").is_some_and(|text| text.contains(NAME)) {
            out.left += 1;
        }
    }
    Ok(out)
}

/// How many elements an accessor has.
fn count_of(text: &str) -> usize {
    Object::parse(text, "accessor").ok().and_then(|a| a.number("count")).unwrap_or(0)
}

/// The nodes that an animation moves.
fn animated(root: &Object<'_>) -> HashSet<usize> {
    let mut nodes = HashSet::new();
    for animation in list(root, "animations").unwrap_or_default() {
        let Ok(animation) = Object::parse(&animation, "animation") else { continue };
        for channel in list(&animation, "channels").unwrap_or_default() {
            let Ok(channel) = Object::parse(&channel, "channel") else { continue };
            let target = channel.get("target").and_then(|text| Object::parse(text, "target").ok());
            nodes.extend(target.and_then(|target| target.number("node")));
        }
    }
    nodes
}

/// The chain of a mesh.
fn chain<'m>(model: &'m Model, one: &BakedMesh) -> Option<(&'m Mesh, &'m Levels)> {
    let own = one.levels.iter().find(|l| l.kind == LevelKind::Chain)?;
    let held_by: MeshId = own.held_by;
    let of = model.scene.levels(one.mesh).iter().find(|of| of.mesh == held_by)?;
    Some((model.scene.meshes().get(held_by as usize)?, &of.levels))
}

/// A primitive of triangles, and the vertices of the mesh that it may name.
struct Block {
    primitive: String,
    first: u32,
    count: u32,
}

/// The primitives that have triangles; `None` where the vertices of the mesh are not theirs one
/// after another.
fn blocks(
    mesh: &Object<'_>,
    counts: &[usize],
    base: &Mesh,
) -> Result<Option<Vec<Block>>, ErrorKind> {
    let mut places: HashMap<[Option<usize>; 4], u32> = HashMap::new();
    let mut all = Vec::new();
    let mut end = 0usize;
    for text in list(mesh, "primitives")? {
        let item = Object::parse(&text, "primitive")?;
        let attributes = Object::parse(item.get("attributes").unwrap_or("{}"), "attributes")?;
        let names = ["POSITION", "NORMAL", "TEXCOORD_0", "COLOR_0"];
        let key = names.map(|name| attributes.number(name));
        let Some(&count) = key[0].and_then(|at| counts.get(at)) else { continue };
        let corners = match item.number("indices") {
            Some(at) => counts.get(at).copied().unwrap_or(0),
            None => count,
        };
        let modes = [4, 5, 6];
        if corners < 3 || !modes.contains(&item.number("mode").unwrap_or(4)) {
            continue;
        }
        let first = *places.entry(key).or_insert_with(|| {
            let first = end as u32;
            end = end.saturating_add(count);
            first
        });
        all.push(Block { primitive: text.into_owned(), first, count: count as u32 });
    }
    let fits = end == base.positions().len() && all.len() == base.parts().len();
    Ok(fits.then_some(all))
}

/// A level: the indices of each primitive, among its own vertices, and how far it is off.
struct Level {
    indices: Vec<Vec<u32>>,
    error: f32,
}

/// The levels of a chain but the finest; `None` where a triangle has a vertex that its primitive
/// has not.
fn triangles(base: &Mesh, held_by: &Mesh, levels: &Levels, blocks: &[Block]) -> Option<Vec<Level>> {
    // A vertex of another primitive may lie where one of this lies too.
    let mut own: Vec<Option<HashMap<[u32; 3], u32>>> = blocks.iter().map(|_| None).collect();
    let bits = |v: u32| base.positions()[v as usize].map(f32::to_bits);
    let mut all: Vec<Level> = Vec::new();
    for (cluster, &made_from) in held_by.clusters().iter().zip(levels.made_from()) {
        if made_from == NO_GROUP {
            continue;
        }
        // In a chain a group is a whole level, and what was made of it is the next.
        let at = made_from as usize;
        while all.len() <= at {
            let error = levels.group(all.len()).error;
            all.push(Level { indices: vec![Vec::new(); blocks.len()], error });
        }
        let part = cluster.part as usize;
        let Block { first, count, .. } = *blocks.get(part)?;
        let range = first..first + count;
        for t in cluster.triangles() {
            for v in held_by.triangle(t) {
                let v = match range.contains(&v) {
                    true => v,
                    false => *own[part]
                        .get_or_insert_with(|| range.clone().map(|v| (bits(v), v)).collect())
                        .get(&bits(v))?,
                };
                all[at].indices[part].push(v - first);
            }
        }
    }
    all.retain(|level| level.indices.iter().any(|i| !i.is_empty()));
    Some(all)
}

/// The share of the screen's area under which a level is off by less than a pixel: that of a square
/// as high as the mesh. Readers that take it for a share of the height draw the finer one longer.
fn coverage(base: &Mesh, error: f32) -> f64 {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in base.positions() {
        for a in 0..3 {
            (low[a], high[a]) = (low[a].min(p[a].into()), high[a].max(p[a].into()));
        }
    }
    let diameter = (0..3).map(|a| (high[a] - low[a]).powi(2)).sum::<f64>().sqrt();
    let share = diameter / (f64::from(error) * ROWS);
    if share.is_finite() { (share * share).min(1.0) } else { 1.0 }
}
