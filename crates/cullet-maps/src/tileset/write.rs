//! A model as 3D Tiles 1.1.

use std::path::Path;

use super::cut::{Item, Node, cut};
use super::globe::{self, Globe};
use super::json::TileSize;
use super::options::{TileInput, TileStandIn, TilesWritten, WriteTiles};
use super::part::part;
use super::sight::{self, Numbered};
use cullet::{Instance, Scene, Transform};
use cullet_io::{Model, Motion, SaveError, SaveErrorKind, Saved, Warning, save};

/// Writes a model as a tileset: `tileset.json` in a folder, which is made where it is not there,
/// and a GLB for each tile that shows something. Every instance is in one tile: in the smallest box
/// of a tree that has its middle and is not small beside it. Tiles add to those above them; a
/// tile's geometric error is the diagonal of the largest instance below it. The same model makes
/// the same bytes. Meshes are written with each tile that draws them, with their levels and
/// occluders where the model was baked; impostors, cells, cameras and motions are left out, which
/// the [notes](TilesWritten::notes) of the result say. `step` is called with the share that is
/// written, and says whether to go on; `None` where it did not.
///
/// # Errors
/// If a file cannot be written.
pub fn write_tiles(
    model: &Model,
    folder: &Path,
    options: &WriteTiles,
    step: impl FnMut(f64) -> bool,
) -> Result<Option<TilesWritten>, SaveError> {
    write_tiles_with(model, folder, options, &TileInput::default(), step)
}

/// Writes tiles like [`write_tiles`], with stand-ins and visible sets.
///
/// With a maker of stand-ins, tiles replace those above them. An instance is in one of the finest
/// tiles, in full; each tile that is not one of those shows a stand-in of all instances below it,
/// and its geometric error is that of the stand-in, never below one of a tile below it. Instances
/// that are large beside their box are a tile of their own there. A stand-in of nothing is left
/// out, and the error is the diagonal of the largest instance below.
///
/// With a [place on the globe](WriteTiles::place) tiles have horizon occlusion points, for the boxes
/// of their instances and of the tiles below them. Ground may go below the ellipsoid as far as the
/// lowest instance does.
///
/// Visible sets are written as `sight.bin`, named by the tileset's root: for each cell a row of
/// bits, one for each tile.
///
/// # Errors
/// If a file cannot be written.
pub fn write_tiles_with(
    model: &Model,
    folder: &Path,
    options: &WriteTiles,
    input: &TileInput<'_>,
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
    let globe = options.place.map(|place| Globe::new(place, &items));
    let root = cut(items, options, input.stand_in.is_some());
    let mut writer = Writer {
        model,
        folder,
        input,
        globe,
        written: TilesWritten { notes: left_out(model), ..TilesWritten::default() },
        numbered: Numbered::default(),
        done: 0,
        all,
        step: &mut step,
    };
    let Some(Tile { json, error }) = writer.node(&root, 0, 0)? else { return Ok(None) };
    if let Some(sets) = &input.sets {
        writer.write(sight::FILE, &sight::to_bytes(sets, &writer.numbered))?;
        writer.written.cells = sets.sets.cell_count();
    }
    let version = env!("CARGO_PKG_VERSION");
    let used = match writer.written.horizon_points {
        0 => String::new(),
        _ => format!(r#""extensionsUsed":["{}"],"#, globe::EXTENSION),
    };
    let tileset = format!(
        r#"{{"asset":{{"generator":"cullet {version}","version":"1.1"}},{used}"geometricError":{:?},"root":{json}}}"#,
        error.max(root.diagonal())
    );
    writer.write("tileset.json", tileset.as_bytes())?;
    Ok(Some(writer.written))
}

struct Writer<'a> {
    model: &'a Model,
    folder: &'a Path,
    input: &'a TileInput<'a>,
    globe: Option<Globe>,
    written: TilesWritten,
    numbered: Numbered,
    done: usize,
    all: f64,
    step: &'a mut dyn FnMut(f64) -> bool,
}

/// A tile that is written.
struct Tile {
    json: String,
    error: f64,
}

impl Writer<'_> {
    /// Writes a node, the one below the tile `above`, and all below it; `None` where it is not to
    /// go on.
    fn node(&mut self, node: &Node, above: u32, depth: u32) -> Result<Option<Tile>, SaveError> {
        let number = self.written.tiles[0];
        self.written.tiles[0] += 1;
        self.written.depth = self.written.depth.max(depth);
        self.number(node, above, number);
        let mut size = None;
        if !node.own.is_empty() {
            let (own, saved) = self.content(&part(self.model, &node.own), number)?;
            size = Some(own);
            self.written.instances += saved.instances;
            self.written.triangles += saved.triangles;
        }
        self.done += node.own.len();
        if !(self.step)(self.done as f64 / self.all) {
            return Ok(None);
        }
        let (mut children, mut error) = (Vec::new(), 0.0_f64);
        for child in &node.children {
            let Some(child) = self.node(child, number, depth + 1)? else { return Ok(None) };
            error = error.max(child.error);
            children.push(child.json);
        }
        let stand_in = self.input.stand_in.filter(|_| !children.is_empty());
        let stand_in = stand_in.and_then(|of| {
            let mut slots = Vec::new();
            node.add_slots(&mut slots);
            of(&slots, error)
        });
        match stand_in {
            Some(stand_in) => {
                error = error.max(stand_in.error);
                self.written.stand_ins += 1;
                self.written.stand_in_triangles += u64::from(stand_in.mesh.triangle_count());
                self.written.stand_in_error = self.written.stand_in_error.max(error);
                size = Some(self.content(&alone(self.model, stand_in), number)?.0);
            }
            None => error = error.max(node.error),
        }
        // Stand-ins may reach beyond the boxes of what they stand for, here and in tiles below.
        let off = if self.input.stand_in.is_some() && !children.is_empty() { error } else { 0.0 };
        let refine = if self.input.stand_in.is_some() { "REPLACE" } else { "ADD" };
        let mut json = format!(
            r#"{{"boundingVolume":{{"box":{:?}}},"refine":"{refine}","geometricError":{error:?}"#,
            block(node)
        );
        if !children.is_empty() {
            json += &format!(r#","children":[{}]"#, children.join(","));
        }
        if size.is_some() {
            json += &format!(r#","content":{{"uri":"tiles/{number}.glb"}}"#);
        }
        json += &self.on_globe(node, number, off);
        let TileSize { instances, vertices, triangles } = size.unwrap_or_default();
        json += &format!(
            r#","extras":{{"cullet":{{"instances":{instances},"vertices":{vertices},"triangles":{triangles}"#
        );
        if self.globe.is_some() && number == 0 {
            json += r#","placed":true"#;
        }
        if self.input.sets.is_some() {
            json += &format!(r#","number":{number}"#);
            if number == 0 {
                json += &format!(r#","cells":"{}""#, sight::FILE);
            }
        }
        json += "}}}";
        Ok(Some(Tile { json, error }))
    }

    /// The part of a tile's JSON that places it on the globe: the transform of the root, and the
    /// horizon occlusion point of a tile whose meshes are off by `error`.
    fn on_globe(&mut self, node: &Node, number: u32, error: f64) -> String {
        let Some(globe) = &self.globe else { return String::new() };
        let mut json = String::new();
        if number == 0 {
            json += &format!(r#","transform":{:?}"#, globe.transform());
        }
        if let Some(point) = globe.point(node, error) {
            self.written.horizon_points += 1;
            let name = globe::EXTENSION;
            json += &format!(r#","extensions":{{"{name}":{{"horizonOcclusionPoint":{point:?}}}}}"#);
        }
        json
    }

    /// Notes where instances are, for the rows of visible sets.
    fn number(&mut self, node: &Node, above: u32, number: u32) {
        if self.input.sets.is_none() {
            return;
        }
        self.numbered.above.push(above);
        let scene = &self.model.scene;
        let handles = node.own.iter().filter_map(|item| scene.handle(item.slot));
        self.numbered.instances.extend(handles.map(|handle| (handle.index, number)));
    }

    /// Writes what a tile shows; what that takes.
    fn content(&mut self, model: &Model, number: u32) -> Result<(TileSize, Saved), SaveError> {
        let path = self.folder.join(format!("tiles/{number}.glb"));
        let saved = save(model, &path)?;
        self.written.tiles[1] += 1;
        self.written.bytes += std::fs::metadata(&path).map_or(0, |m| m.len());
        Ok((size_of(&model.scene), saved))
    }

    /// Writes a file beside the tiles.
    fn write(&mut self, name: &str, bytes: &[u8]) -> Result<(), SaveError> {
        let path = self.folder.join(name);
        self.written.bytes += bytes.len() as u64;
        std::fs::write(&path, bytes).map_err(|e| SaveError { path, kind: SaveErrorKind::from(e) })
    }
}

/// Notes about everything of a model that tiles do not have, and why.
fn left_out(model: &Model) -> Vec<Warning> {
    let scene = &model.scene;
    let mut notes = Vec::new();
    let mut note = |item: String, message: String| notes.push(Warning { item, message });
    let of = |is: &dyn Fn(u32) -> bool| -> Vec<u32> { scene.slots().filter(|&s| is(s)).collect() };
    let no_place = of(&|slot| !scene.transform(slot).is_finite());
    let empty =
        of(&|slot| scene.transform(slot).is_finite() && scene.mesh(slot).triangle_count() == 0);
    for (slots, defect) in
        [(no_place, "transforms that are not finite"), (empty, "meshes without triangles")]
    {
        let names = slots.iter().take(3).filter_map(|&slot| scene.handle(slot));
        let names: Vec<String> = names.map(|h| format!("\"{}\"", model.instance_name(h))).collect();
        let (count, names) = (slots.len(), names.join(", "));
        let more = if count > 3 { ", ..." } else { "" };
        if count > 0 {
            note(format!("instances with {defect}"), format!("{count} left out: {names}{more}"));
        }
    }
    let has_pictures = |mesh| scene.levels(mesh).iter().any(|of| of.impostor.is_some());
    let lost = [
        (model.textures > 0, "textures (not read)"),
        (model.motion.as_ref().is_some_and(Motion::moves), "motions (it is written as it stands)"),
        (!model.cameras.is_empty(), "cameras"),
        (!model.views.is_empty(), "views that are matrices"),
        (!model.cells.cells.is_empty(), "cells and portals"),
        ((0..scene.meshes().len() as u32).any(has_pictures), "impostors"),
    ];
    let lost: Vec<&str> = lost.iter().filter(|l| l.0).map(|l| l.1).collect();
    if !lost.is_empty() {
        note("model".to_owned(), format!("left out: {}", lost.join(", ")));
    }
    notes
}

/// A stand-in as a model.
fn alone(model: &Model, stand_in: TileStandIn) -> Model {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(stand_in.mesh);
    // Its mesh is there, and where it stands is finite, as what it stands for is.
    let _ = scene.add(Instance::new(mesh, Transform::from_translation(stand_in.origin)));
    scene.commit(&cullet::Culler::default());
    Model {
        name: model.name.clone(),
        scene,
        mesh_names: vec!["stand-in".to_owned()],
        attributes: vec![stand_in.attributes],
        instance_names: vec!["stand-in".to_owned()],
        materials: model.materials.clone(),
        ..Model::default()
    }
}

/// A node's box as tiles have it, z-up: its middle and its half axes.
fn block(node: &Node) -> [f64; 12] {
    let (c, h) = ((node.low + node.high) * 0.5, (node.high - node.low) * 0.5);
    [c.x, -c.z, c.y, h.x, 0.0, 0.0, 0.0, h.z, 0.0, 0.0, 0.0, h.y]
}

fn size_of(scene: &Scene) -> TileSize {
    let meshes = scene.meshes();
    TileSize {
        instances: scene.instance_count(),
        vertices: meshes.iter().map(|m| m.positions().len() as u64).sum(),
        triangles: meshes.iter().map(|m| u64::from(m.triangle_count())).sum(),
    }
}
