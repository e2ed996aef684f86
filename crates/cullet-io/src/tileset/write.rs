//! A model as 3D Tiles 1.1: a tree of boxes, in which large instances stand high up and small ones far down.

use std::collections::BTreeMap;
use std::path::Path;

use cullet::{Instance, Scene};
use glam::DVec3;
use serde_json::{Value, json};

use super::json::TileSize;
use crate::baked::{Baked, BakedLevels, BakedMesh};
use crate::{Attributes, Model, SaveError, SaveErrorKind, save};

/// How a model is cut into tiles.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct WriteTiles {
    /// A tile is cut while it has more triangles than this, each instance counted. Default: 65,536.
    pub triangles: u64,
    /// Or more instances than this. Default: 4,096.
    pub instances: u32,
}

impl Default for WriteTiles {
    fn default() -> Self {
        Self { triangles: 1 << 16, instances: 4096 }
    }
}

/// What was written.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct TilesWritten {
    /// Tiles, and those of them that show something.
    pub tiles: [u32; 2],
    /// How often a tile is cut at the most.
    pub depth: u32,
    /// Of all files.
    pub bytes: u64,
}

/// Cuts end here: a box is a millionth of the whole.
const DEEPEST: u32 = 20;
/// An instance stays with the box that it is a larger part of than this, by their longest sides: it is seen from as far as
/// the whole is.
const LARGE: f64 = 0.25;

/// Writes a model as a tileset: `tileset.json` in a folder, which is made where it is not there, and a GLB for each tile that shows
/// something. Every instance is in one tile: in the smallest box of a tree that has its middle and is not small
/// beside it. Tiles add to those above them; a tile's geometric error is the diagonal of the largest instance below it. The
/// same model makes the same bytes. Meshes are written with each tile that draws them, with their levels and occluders where the model was baked;
/// impostors, merged groups, cells and motions are left out. `step` is called with the share that is written, and says whether to go on;
/// `None` where it did not.
///
/// # Errors
/// If a file cannot be written.
pub fn write_tiles(
    model: &Model,
    folder: &Path,
    options: &WriteTiles,
    mut step: impl FnMut(f64) -> bool,
) -> Result<Option<TilesWritten>, SaveError> {
    let fail = |error: std::io::Error| SaveError {
        path: folder.to_owned(),
        kind: SaveErrorKind::from(error),
    };
    std::fs::create_dir_all(folder.join("tiles")).map_err(fail)?;
    let scene = &model.scene;
    let items: Vec<Item> = scene.slots().filter_map(|slot| Item::of(scene, slot)).collect();
    let all = items.len().max(1) as f64;
    let cut = Cut { options };
    let root = cut.node(items, 0);
    let mut writer =
        Writer { model, folder, written: TilesWritten::default(), done: 0, all, step: &mut step };
    let Some(tile) = writer.node(&root, 0)? else { return Ok(None) };
    let error = root.error.max(root.diagonal());
    let tileset = json!({
        "asset": { "version": "1.1", "generator": concat!("cullet ", env!("CARGO_PKG_VERSION")) },
        "geometricError": error,
        "root": tile,
    });
    let text = serde_json::to_vec(&tileset).unwrap_or_default();
    writer.written.bytes += text.len() as u64;
    let written = writer.written;
    let path = folder.join("tileset.json");
    std::fs::write(&path, text).map_err(|e| SaveError { path, kind: SaveErrorKind::from(e) })?;
    Ok(Some(written))
}

/// An instance that draws something.
#[derive(Clone, Copy, Debug)]
struct Item {
    slot: u32,
    low: DVec3,
    high: DVec3,
    triangles: u64,
}

impl Item {
    fn of(scene: &Scene, slot: u32) -> Option<Self> {
        let bounds = scene.bounds(slot);
        let at = |v: [f32; 3]| DVec3::from(v.map(f64::from)) + DVec3::from(scene.origin());
        let (low, high) = (at(bounds.min), at(bounds.max));
        let triangles = scene.mesh(slot).triangle_count();
        let draws = triangles > 0 && low.is_finite() && high.is_finite();
        draws.then_some(Self { slot, low, high, triangles: triangles.into() })
    }

    fn middle(&self) -> DVec3 {
        (self.low + self.high) * 0.5
    }

    fn diagonal(&self) -> f64 {
        (self.high - self.low).length()
    }
}

/// A box of the tree.
#[derive(Debug)]
struct Node {
    /// Around all that is in it and below it.
    low: DVec3,
    high: DVec3,
    own: Vec<Item>,
    children: Vec<Self>,
    /// The largest diagonal below it.
    error: f64,
}

impl Node {
    fn diagonal(&self) -> f64 {
        let diagonal = (self.high - self.low).length();
        if diagonal.is_finite() { diagonal } else { 0.0 }
    }
}

struct Cut<'a> {
    options: &'a WriteTiles,
}

impl Cut<'_> {
    /// A node of some items. As deep as [`DEEPEST`].
    fn node(&self, items: Vec<Item>, depth: u32) -> Node {
        let low = items.iter().map(|i| i.low).reduce(DVec3::min).unwrap_or_default();
        let high = items.iter().map(|i| i.high).reduce(DVec3::max).unwrap_or_default();
        let triangles: u64 = items.iter().map(|i| i.triangles).sum();
        let is_small =
            triangles <= self.options.triangles && items.len() <= self.options.instances as usize;
        if is_small || depth == DEEPEST || items.len() == 1 {
            return Node { low, high, own: items, children: Vec::new(), error: 0.0 };
        }
        let size = high - low;
        let longest = size.max_element();
        let middle = (low + high) * 0.5;
        let (own, small): (Vec<Item>, Vec<Item>) =
            items.into_iter().partition(|i| (i.high - i.low).max_element() > longest * LARGE);
        // Flat boxes are cut along their long sides alone.
        let mut parts: BTreeMap<u8, Vec<Item>> = BTreeMap::new();
        for item in small {
            let at = item.middle();
            let side = |a: usize| u8::from(size[a] > longest * 0.5 && at[a] >= middle[a]) << a;
            parts.entry(side(0) | side(1) | side(2)).or_default().push(item);
        }
        let error = parts.values().flatten().map(Item::diagonal).fold(0.0, f64::max);
        let children = parts.into_values().map(|part| self.node(part, depth + 1)).collect();
        Node { low, high, own, children, error }
    }
}

struct Writer<'a> {
    model: &'a Model,
    folder: &'a Path,
    written: TilesWritten,
    done: usize,
    all: f64,
    step: &'a mut dyn FnMut(f64) -> bool,
}

impl Writer<'_> {
    /// Writes a node and all below it; its JSON.
    fn node(&mut self, node: &Node, depth: u32) -> Result<Option<Value>, SaveError> {
        let number = self.written.tiles[0];
        self.written.tiles[0] += 1;
        self.written.depth = self.written.depth.max(depth);
        let mut tile = json!({
            "boundingVolume": { "box": block(node) },
            "geometricError": node.error,
            "refine": "ADD",
        });
        let mut size = TileSize::default();
        if !node.own.is_empty() {
            self.written.tiles[1] += 1;
            let name = format!("tiles/{number}.glb");
            let part = part(self.model, &node.own);
            size = size_of(&part.scene);
            let path = self.folder.join(&name);
            save(&part, &path)?;
            let bytes = std::fs::metadata(&path).map_or(0, |m| m.len());
            self.written.bytes += bytes;
            tile["content"] = json!({ "uri": name });
        }
        tile["extras"] = json!({ "cullet": size });
        self.done += node.own.len();
        if !(self.step)(self.done as f64 / self.all) {
            return Ok(None);
        }
        let mut children = Vec::new();
        for child in &node.children {
            let Some(child) = self.node(child, depth + 1)? else { return Ok(None) };
            children.push(child);
        }
        if !children.is_empty() {
            tile["children"] = Value::Array(children);
        }
        Ok(Some(tile))
    }
}

/// A node's box as tiles have it, z-up: its middle and its half axes.
fn block(node: &Node) -> [f64; 12] {
    let (c, h) = ((node.low + node.high) * 0.5, (node.high - node.low) * 0.5);
    [c.x, -c.z, c.y, h.x, 0.0, 0.0, 0.0, h.z, 0.0, 0.0, 0.0, h.y]
}

/// Some instances of a model as a model.
fn part(model: &Model, items: &[Item]) -> Model {
    let from = &model.scene;
    let mut scene = Scene::new();
    let mut made =
        Model { name: model.name.clone(), materials: model.materials.clone(), ..Model::default() };
    let mut meshes: BTreeMap<u32, u32> = BTreeMap::new();
    let mut baked = Baked::default();
    for item in items {
        let mesh = from.mesh_id(item.slot);
        let own = *meshes.entry(mesh).or_insert_with(|| {
            made.mesh_names.push(model.mesh_names.get(mesh as usize).cloned().unwrap_or_default());
            let attributes = model.attributes.get(mesh as usize).cloned().unwrap_or_default();
            made.attributes.push(attributes);
            let own = scene.add_mesh(from.meshes()[mesh as usize].clone());
            let of = model.baked.iter().flat_map(|baked| &baked.meshes).find(|of| of.mesh == mesh);
            if let Some(of) = of {
                baked.meshes.push(with_levels(from, of, own, &mut scene));
                made.mesh_names.resize(scene.meshes().len(), String::new());
                made.attributes.resize(scene.meshes().len(), Attributes::default());
            }
            own
        });
        let instance = Instance {
            layers: from.layers(item.slot),
            flags: from.flags(item.slot),
            size_weight: from.size_weight(item.slot),
            ..Instance::new(own, *from.transform(item.slot))
        };
        // It is one that a scene had.
        if scene.add(instance).is_ok() {
            let name =
                from.handle(item.slot).map(|handle| model.instance_name(handle).into_owned());
            made.instance_names.push(name.unwrap_or_default());
        }
    }
    scene.commit();
    made.scene = scene;
    if let Some(whole) = model.baked.as_ref().filter(|_| !baked.meshes.is_empty()) {
        made.baked = Some(Baked { generator: whole.generator.clone(), ..baked });
    }
    made
}

/// Gives a mesh of another scene the levels that its own has; what is baked of it there.
fn with_levels(from: &Scene, of: &BakedMesh, own: u32, scene: &mut Scene) -> BakedMesh {
    let mut baked = BakedMesh { mesh: own, levels: Vec::new(), ..of.clone() };
    for levels in from.levels(of.mesh) {
        let Some(&kind) = of.levels.iter().find(|l| l.held_by == levels.mesh) else { continue };
        // Pictures would be written with each tile again.
        if levels.impostor.is_some() {
            continue;
        }
        let held_by = scene.add_mesh(from.meshes()[levels.mesh as usize].clone());
        if scene.add_levels(own, held_by, levels.levels.clone()).is_ok() {
            baked.levels.push(BakedLevels { held_by, ..kind });
        }
    }
    baked
}

fn size_of(scene: &Scene) -> TileSize {
    let meshes = scene.meshes();
    TileSize {
        instances: scene.instance_count(),
        vertices: meshes.iter().map(|m| m.positions().len() as u64).sum(),
        triangles: meshes.iter().map(|m| u64::from(m.triangle_count())).sum(),
    }
}
