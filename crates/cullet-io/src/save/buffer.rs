//! The buffer of a GLB, and what refers to it.

use std::collections::HashMap;

use cullet::mesh::{Alpha, Part};
use serde_json::{Value, json};

use super::attributes;
use crate::Model;
use crate::bytes::{put_f32s, put_u32s};

const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
pub(super) use crate::baked::TABLE_ALIGNMENT as ALIGNMENT;

/// The parts of the file that grow with each mesh. Everything in `bin` is of four bytes, so
/// aligned.
#[derive(Default)]
pub(super) struct File {
    pub(super) bin: Vec<u8>,
    pub(super) views: Vec<Value>,
    /// How many views the file has before these.
    first_view: usize,
    pub(super) accessors: Vec<Value>,
    pub(super) materials: Vec<Value>,
    /// A material of the file is one of the model with the sides and the alpha of a part.
    by_part: HashMap<(u32, bool, Alpha), usize>,
}

impl File {
    /// Returns an empty addition to a file that has a buffer and some views.
    pub(super) fn behind(bin: Vec<u8>, first_view: usize) -> Self {
        Self { bin, first_view, ..Self::default() }
    }

    /// The primitives of a mesh: one for each part with triangles.
    pub(super) fn primitives(&mut self, model: &Model, number: usize) -> Vec<Value> {
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
            }
        }
        put_f32s(&mut self.bin, positions.as_flattened());
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
            put_u32s(&mut self.bin, &indices[first..first + count]);
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
        put_f32s(&mut self.bin, values.as_flattened());
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
        self.view_count() - 1
    }

    /// How many views the file has by now.
    pub(super) fn view_count(&self) -> usize {
        self.first_view + self.views.len()
    }

    /// The view of a table: aligned, and of no kind that a viewer draws.
    pub(super) fn table(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(ALIGNMENT), 0);
        let start = self.bin.len();
        self.bin.extend_from_slice(bytes);
        self.views.push(json!({ "buffer": 0, "byteOffset": start, "byteLength": bytes.len() }));
        self.view_count() - 1
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
