//! Binary glTF 2.0.

use std::collections::HashMap;
use std::io::Write;

use cullet::mesh::{Alpha, Part};
use serde_json::{Value, json};

use super::nodes::{self, Written};
use super::{SaveErrorKind, attributes, baked, cameras, cells};
use crate::Model;
use crate::gltf::{BAKED, CELLS};

const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
/// Tables of what was baked begin at multiples of this, in the file as it lies.
const ALIGNMENT: usize = 64;
/// Bytes of the header and those of both chunks.
const HEADERS: usize = 28;

pub(super) fn write(model: &Model, out: &mut impl Write) -> Result<(), SaveErrorKind> {
    let scene = &model.scene;
    let mut used = vec![false; scene.meshes().len()];
    scene.slots().for_each(|s| used[scene.mesh_id(s) as usize] = true);
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
    let baked = baked::write(model, &number, &mut file, &mut meshes);
    let Written { mut nodes, mut roots, node_of } = nodes::write(model, &number);
    let cameras = cameras::write(model, &mut nodes, &mut roots);
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
        root["extensions"][BAKED] = baked;
    }
    let used = root.get("extensions").and_then(Value::as_object);
    if let Some(used) = used.map(|all| all.keys().cloned().collect::<Vec<_>>()) {
        root["extensionsUsed"] = json!(used);
    }
    let mut text = root.to_string().into_bytes();
    // Spaces before the binary chunk, so that tables that are aligned in it are so in the file.
    let multiple = if is_baked { ALIGNMENT } else { 4 };
    let before = HEADERS + text.len();
    text.resize(before.next_multiple_of(multiple) - HEADERS, b' ');
    let chunk = |len: usize| if len == 0 { 0 } else { 8 + len as u64 };
    let total = 12 + chunk(text.len()) + chunk(file.bin.len());
    let limit = u64::from(u32::MAX);
    if total > limit {
        return Err(SaveErrorKind::TooMany { what: "bytes", count: total, limit });
    }
    let word = |v: u64| (v as u32).to_le_bytes();
    out.write_all(b"glTF")?;
    out.write_all(&word(2))?;
    out.write_all(&word(total))?;
    for (kind, bytes) in [(b"JSON", &text), (b"BIN\0", &file.bin)] {
        if !bytes.is_empty() {
            out.write_all(&word(bytes.len() as u64))?;
            out.write_all(kind)?;
            out.write_all(bytes)?;
        }
    }
    Ok(())
}

/// The parts of the file that grow with each mesh. Everything in `bin` is of four bytes, so aligned.
#[derive(Default)]
pub(super) struct File {
    bin: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    materials: Vec<Value>,
    /// A material of the file is one of the model with the sides and the alpha of a part.
    by_part: HashMap<(u32, bool, Alpha), usize>,
}

impl File {
    fn primitives(&mut self, model: &Model, number: usize) -> Vec<Value> {
        let mesh = &model.scene.meshes()[number];
        if mesh.triangle_count() == 0 {
            return Vec::new();
        }
        let positions = mesh.positions();
        let start = self.bin.len();
        let (mut min, mut max) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for p in positions {
            for a in 0..3 {
                (min[a], max[a]) = (min[a].min(p[a]), max[a].max(p[a]));
                self.bin.extend_from_slice(&p[a].to_le_bytes());
            }
        }
        let view = self.view(start, ARRAY_BUFFER);
        let place = self.accessors.len();
        self.accessors.push(json!({
            "bufferView": view, "componentType": FLOAT, "count": positions.len(), "type": "VEC3",
            "min": min, "max": max,
        }));
        let mut named = json!({ "POSITION": place });
        let kept = attributes(model, number);
        if !kept.normals.is_empty() {
            named["NORMAL"] = self.vertices(&kept.unit_normals(mesh), "VEC3").into();
        }
        if !kept.uvs.is_empty() {
            named["TEXCOORD_0"] = self.vertices(&kept.uvs, "VEC2").into();
        }
        if !kept.colors.is_empty() {
            // Colours are shares of light; a file may have held others.
            let colors: Vec<_> = kept.colors.iter().map(|c| c.map(|v| v.clamp(0.0, 1.0))).collect();
            named["COLOR_0"] = self.vertices(&colors, "VEC4").into();
        }
        let indices = mesh.original_indices();
        let parts = mesh.parts().iter().filter(|p| p.triangle_count > 0);
        let primitives = parts.map(|part| {
            let start = self.bin.len();
            let first = part.first_triangle as usize * 3;
            let count = part.triangle_count as usize * 3;
            for i in &indices[first..first + count] {
                self.bin.extend_from_slice(&i.to_le_bytes());
            }
            let view = self.view(start, ELEMENT_ARRAY_BUFFER);
            self.accessors.push(json!({
                "bufferView": view, "componentType": UNSIGNED_INT, "count": count, "type": "SCALAR",
            }));
            json!({
                "attributes": named,
                "indices": self.accessors.len() - 1,
                "material": self.material(model, part),
            })
        });
        primitives.collect()
    }

    /// The accessor of something that every vertex has.
    fn vertices<const N: usize>(&mut self, values: &[[f32; N]], kind: &str) -> usize {
        let start = self.bin.len();
        self.bin.extend(values.as_flattened().iter().flat_map(|v| v.to_le_bytes()));
        let view = self.view(start, ARRAY_BUFFER);
        self.accessors.push(json!({
            "bufferView": view, "componentType": FLOAT, "count": values.len(), "type": kind,
        }));
        self.accessors.len() - 1
    }

    fn view(&mut self, start: usize, target: u32) -> usize {
        let length = self.bin.len() - start;
        self.views.push(
            json!({ "buffer": 0, "byteOffset": start, "byteLength": length, "target": target }),
        );
        self.views.len() - 1
    }

    /// The view of a table: aligned, and of no kind that a viewer draws.
    pub(super) fn table(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(ALIGNMENT), 0);
        let start = self.bin.len();
        self.bin.extend_from_slice(bytes);
        self.views.push(json!({ "buffer": 0, "byteOffset": start, "byteLength": bytes.len() }));
        self.views.len() - 1
    }

    fn material(&mut self, model: &Model, part: &Part) -> usize {
        let next = self.materials.len();
        let index =
            *self.by_part.entry((part.material, part.two_sided, part.alpha)).or_insert(next);
        if index == next {
            let given = model.materials.get(part.material as usize);
            let name = given.map_or("default", |m| m.name.as_str());
            // Colours are shares of light; a file may have held others.
            let color = given.map_or([1.0; 4], |m| m.color).map(|v| v.clamp(0.0, 1.0));
            let mode = match part.alpha {
                Alpha::Opaque => "OPAQUE",
                Alpha::Masked => "MASK",
                Alpha::Blended => "BLEND",
            };
            self.materials.push(json!({
                "name": name,
                "doubleSided": part.two_sided,
                "alphaMode": mode,
                "pbrMetallicRoughness": {
                    "baseColorFactor": color, "metallicFactor": 0.0, "roughnessFactor": 0.9,
                },
            }));
        }
        index
    }
}
