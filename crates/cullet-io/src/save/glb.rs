//! Binary glTF 2.0.

use std::io::Write;

use serde_json::{Value, json};

use super::buffer::{ALIGNMENT, File};
use super::nodes::{self, Nodes};
use super::{SaveErrorKind, Written, baked, cameras, cells};
use crate::gltf::{BAKED, CELLS};

/// Bytes of the header and those of both chunks.
const HEADERS: usize = 28;

pub(super) fn write(all: &mut Written<'_>, out: &mut impl Write) -> Result<(), SaveErrorKind> {
    let (model, scene) = (all.model, &all.model.scene);
    let mut used = vec![false; scene.meshes().len()];
    all.slots.iter().for_each(|&s| used[scene.mesh_id(s) as usize] = true);
    let mut file = File::default();
    let mut number = vec![None; used.len()];
    let mut meshes = Vec::new();
    for m in (0..used.len()).filter(|&m| used[m]) {
        let primitives = file.primitives(model, m);
        // A mesh without triangles is forbidden.
        if primitives.is_empty() {
            continue;
        }
        number[m] = Some(meshes.len());
        let name = model.mesh_names.get(m).map_or("", String::as_str);
        meshes.push(json!({ "name": name, "primitives": primitives }));
    }
    let baked = baked::write(model, &number, &mut file);
    for (at, object) in baked.iter().flat_map(|baked| &baked.meshes) {
        meshes[*at]["extensions"] = json!({ BAKED: object });
    }
    let Nodes { mut nodes, mut roots, node_of } = nodes::write(model, &all.slots, &number);
    let cameras = cameras::write(model, &mut nodes, &mut roots);
    if cameras.len() < model.cameras.len() {
        all.saved.say(
            format!("{} cameras", model.cameras.len() - cameras.len()),
            "left out, for glTF has no such projection, or they stand nowhere",
        );
    }
    let mut root = json!({
        "asset": { "version": "2.0", "generator": "cullet" },
        "scene": 0,
        "scenes": [{ "nodes": roots }],
    });
    // Empty arrays are forbidden.
    if nodes.is_empty() {
        root["scenes"] = json!([{}]);
    } else {
        root["nodes"] = json!(nodes);
    }
    if !cameras.is_empty() {
        root["cameras"] = json!(cameras);
    }
    if !meshes.is_empty() {
        root["meshes"] = json!(meshes);
        root["materials"] = json!(file.materials);
        root["accessors"] = json!(file.accessors);
        root["bufferViews"] = json!(file.views);
        root["buffers"] = json!([{ "byteLength": file.bin.len() }]);
    }
    if !model.cells.cells.is_empty() {
        root["extensions"][CELLS] = cells::extension(&model.cells, &node_of);
    }
    let is_baked = baked.is_some();
    if let Some(baked) = baked {
        root["extensions"][BAKED] = baked.root;
    }
    let used = root.get("extensions").and_then(Value::as_object);
    if let Some(used) = used.map(|all| all.keys().cloned().collect::<Vec<_>>()) {
        root["extensionsUsed"] = json!(used);
    }
    let alignment = if is_baked { ALIGNMENT } else { 4 };
    container(root.to_string().into_bytes(), &file.bin, &[], alignment, out)
}

/// Writes a GLB of its JSON, its binary buffer, which begins at a multiple of `alignment`, and
/// other chunks as they are.
///
/// # Errors
/// If it cannot be written, or is larger than the format allows.
pub(super) fn container(
    mut text: Vec<u8>,
    bin: &[u8],
    others: &[u8],
    alignment: usize,
    out: &mut impl Write,
) -> Result<(), SaveErrorKind> {
    // Spaces before the binary chunk, so that tables that are aligned in it are so in the file.
    let before = HEADERS + text.len();
    text.resize(before.next_multiple_of(alignment) - HEADERS, b' ');
    let zeros = bin.len().next_multiple_of(4) - bin.len();
    let chunk = |len: usize| if len == 0 { 0 } else { 8 + len as u64 };
    let total = 12 + chunk(text.len()) + chunk(bin.len() + zeros) + others.len() as u64;
    let limit = u64::from(u32::MAX);
    if total > limit {
        return Err(SaveErrorKind::TooMany { what: "bytes", count: total, limit });
    }
    let word = |v: u64| (v as u32).to_le_bytes();
    out.write_all(b"glTF")?;
    out.write_all(&word(2))?;
    out.write_all(&word(total))?;
    for (kind, bytes, zeros) in [(b"JSON", &text[..], 0), (b"BIN\0", bin, zeros)] {
        if !bytes.is_empty() {
            out.write_all(&word((bytes.len() + zeros) as u64))?;
            out.write_all(kind)?;
            out.write_all(bytes)?;
            out.write_all(&[0; 4][..zeros])?;
        }
    }
    out.write_all(others)?;
    Ok(())
}
