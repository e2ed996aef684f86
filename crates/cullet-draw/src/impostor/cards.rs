//! An impostor as six cards that any viewer of glTF draws.

use cullet_mesh::Impostor;

use super::sheet::{part_color, texels};

/// A glTF of six cards that cross in the middle of a mesh, each with one frame of the impostor on
/// it: what lies nearest to the axes of the mesh. Less than the impostor is, for no viewer walks
/// along its rays: for looking at, and for places where cards do.
#[derive(Clone, Debug, PartialEq)]
pub struct ImpostorCards {
    /// The JSON of the glTF.
    pub gltf: String,
    /// Its buffer.
    pub bin: Vec<u8>,
    /// Its texture: all frames, colour and coverage, a PNG.
    pub png: Vec<u8>,
}

/// The cards of an impostor. The glTF names its buffer `NAME.bin` and its texture `NAME.png`;
/// `colors` are of the parts, in sRGB, and parts beyond them have one of their own.
#[must_use]
pub fn impostor_cards(impostor: &Impostor, name: &str, colors: &[[u8; 3]]) -> ImpostorCards {
    let grid = impostor.grid();
    let bounds = impostor.bounds();
    let frames = Impostor::frames(grid, &bounds, impostor.radius());
    let centre = bounds.center();
    let sides = [
        [1.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, -1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.0, 0.0, -1.0],
    ];
    let (mut positions, mut normals, mut places) = (Vec::new(), Vec::new(), Vec::new());
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for side in sides {
        let around = impostor.frames_around(side);
        let nearest = around.iter().max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |f| f.0);
        let frame = &frames[nearest as usize];
        let [right, up, towards] = frame.axes;
        for [x, y] in [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]] {
            let at =
                |a: usize| centre[a] + right[a] * frame.half[0] * x + up[a] * frame.half[1] * y;
            let p = [0, 1, 2].map(|a| at(a) as f32);
            for a in 0..3 {
                (low[a], high[a]) = (low[a].min(p[a]), high[a].max(p[a]));
            }
            positions.push(p);
            normals.push(towards.map(|v| v as f32));
            let place = |number: u32, v: f64| (f64::from(number) + 0.5 + 0.5 * v) / f64::from(grid);
            places.push([place(nearest % grid, x) as f32, place(nearest / grid, -y) as f32]);
        }
    }
    let indices = (0..6u32).flat_map(|card| [0, 1, 2, 0, 2, 3].map(|i| card * 4 + i));
    let mut bin: Vec<u8> = Vec::new();
    bin.extend(positions.as_flattened().iter().flat_map(|v| v.to_le_bytes()));
    bin.extend(normals.as_flattened().iter().flat_map(|v| v.to_le_bytes()));
    bin.extend(places.as_flattened().iter().flat_map(|v| v.to_le_bytes()));
    bin.extend(indices.flat_map(u32::to_le_bytes));
    let name: String = name.chars().filter(|c| !c.is_control() && !"\"\\".contains(*c)).collect();
    let gltf = format!(
        r#"{{
  "asset": {{ "version": "2.0", "generator": "cullet-draw {version}" }},
  "scene": 0,
  "scenes": [{{ "nodes": [0] }}],
  "nodes": [{{ "name": "{name}", "mesh": 0 }}],
  "meshes": [{{ "primitives": [{{
    "attributes": {{ "POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2 }}, "indices": 3, "material": 0
  }}] }}],
  "materials": [{{
    "alphaMode": "MASK", "alphaCutoff": 0.5,
    "pbrMetallicRoughness": {{
      "baseColorTexture": {{ "index": 0 }}, "metallicFactor": 0.0, "roughnessFactor": 0.9
    }}
  }}],
  "textures": [{{ "source": 0, "sampler": 0 }}],
  "samplers": [{{ "magFilter": 9729, "minFilter": 9729, "wrapS": 33071, "wrapT": 33071 }}],
  "images": [{{ "uri": "{name}.png" }}],
  "buffers": [{{ "uri": "{name}.bin", "byteLength": {bytes} }}],
  "bufferViews": [
    {{ "buffer": 0, "byteOffset": 0, "byteLength": 288, "target": 34962 }},
    {{ "buffer": 0, "byteOffset": 288, "byteLength": 288, "target": 34962 }},
    {{ "buffer": 0, "byteOffset": 576, "byteLength": 192, "target": 34962 }},
    {{ "buffer": 0, "byteOffset": 768, "byteLength": 144, "target": 34963 }}
  ],
  "accessors": [
    {{ "bufferView": 0, "componentType": 5126, "count": 24, "type": "VEC3", "min": {low:?}, "max": {high:?} }},
    {{ "bufferView": 1, "componentType": 5126, "count": 24, "type": "VEC3" }},
    {{ "bufferView": 2, "componentType": 5126, "count": 24, "type": "VEC2" }},
    {{ "bufferView": 3, "componentType": 5125, "count": 36, "type": "SCALAR" }}
  ]
}}
"#,
        version = env!("CARGO_PKG_VERSION"),
        bytes = bin.len(),
    );
    ImpostorCards { gltf, bin, png: texture(impostor, colors) }
}

/// Colours that are not multiplied by their coverage, for a viewer does that; what is not covered
/// has its neighbour's.
fn texture(impostor: &Impostor, colors: &[[u8; 3]]) -> Vec<u8> {
    let (side, texels) = texels(impostor);
    let rgba: Vec<u8> = texels
        .flat_map(|texel| {
            let [r, g, b] = part_color(&texel, colors);
            [r, g, b, (texel.coverage * 255.0).round() as u8]
        })
        .collect();
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, side as u32, side as u32);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    let written = encoder.write_header().and_then(|mut w| w.write_image_data(&rgba));
    // Memory has no error to give.
    debug_assert!(written.is_ok(), "{written:?}");
    bytes
}
