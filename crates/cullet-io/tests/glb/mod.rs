//! GLBs made by tests.

use serde_json::{Value, json};

/// A GLB under construction.
pub(crate) struct Glb {
    pub(crate) json: Value,
    bin: Vec<u8>,
}

impl Glb {
    pub(crate) fn new() -> Self {
        let json = json!({
            "asset": {"version": "2.0"}, "accessors": [], "bufferViews": [], "meshes": [], "nodes": [],
            "animations": [], "skins": [],
        });
        Self { json, bin: Vec::new() }
    }

    pub(crate) fn push(&mut self, array: &str, item: Value) -> usize {
        let items = self.json[array].as_array_mut().unwrap();
        items.push(item);
        items.len() - 1
    }

    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let view = json!({"buffer": 0, "byteOffset": self.bin.len(), "byteLength": bytes.len()});
        self.bin.extend(bytes);
        self.push("bufferViews", view)
    }

    pub(crate) fn accessor(
        &mut self,
        bytes: &[u8],
        component: u32,
        kind: &str,
        count: usize,
    ) -> usize {
        let view = self.view(bytes);
        self.push(
            "accessors",
            json!({"bufferView": view, "componentType": component, "type": kind, "count": count}),
        )
    }

    pub(crate) fn floats<const N: usize>(&mut self, kind: &str, v: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = v.as_flattened().iter().flat_map(|f| f.to_le_bytes()).collect();
        self.accessor(&bytes, 5126, kind, v.len())
    }

    pub(crate) fn indices(&mut self, v: &[u16]) -> usize {
        let bytes: Vec<u8> = v.iter().flat_map(|i| i.to_le_bytes()).collect();
        self.accessor(&bytes, 5123, "SCALAR", v.len())
    }

    pub(crate) fn finish(mut self) -> Vec<u8> {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        if self.json["buffers"].is_null() {
            self.json["buffers"] = json!([{"byteLength": self.bin.len()}]);
        }
        for array in ["animations", "skins"] {
            if self.json[array].as_array().is_some_and(Vec::is_empty) {
                self.json.as_object_mut().unwrap().remove(array);
            }
        }
        let mut text = self.json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut out = b"glTF\x02\0\0\0".to_vec();
        out.extend((20 + text.len() as u32 + 8 + self.bin.len() as u32).to_le_bytes());
        out.extend((text.len() as u32).to_le_bytes());
        out.extend(b"JSON");
        out.extend(&text);
        out.extend((self.bin.len() as u32).to_le_bytes());
        out.extend(b"BIN\0");
        out.extend(&self.bin);
        out
    }
}
