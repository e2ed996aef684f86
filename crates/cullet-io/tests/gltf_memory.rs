//! Loading a large GLB takes little more than its geometry, and not long.

use std::time::Instant;

use cullet::prepared::Preparation;
use cullet_io::{LoadOptions, load};
use cullet_testkit::memory::{Counting, peak_of};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// A GLB of a wavy square of 2·n² triangles, with normals and texture coordinates that are of no use here.
fn terrain(n: u32) -> Vec<u8> {
    let side = n + 1;
    let vertices = (side * side) as usize;
    let triangles = (n * n * 2) as usize;
    let mut bin = Vec::new();
    for i in 0..side * side {
        let (x, z) = ((i % side) as f32, (i / side) as f32);
        let y = (x * 0.1).sin() * (z * 0.07).cos() * 5.0;
        [x, y, z].iter().for_each(|v| bin.extend(v.to_le_bytes()));
    }
    bin.resize(bin.len() + vertices * 20, 0);
    for v in (0..n).flat_map(|z| (0..n).map(move |x| z * side + x)) {
        [v, v + side, v + 1, v + 1, v + side, v + side + 1]
            .iter()
            .for_each(|i| bin.extend(i.to_le_bytes()));
    }
    let (points, rest) = (vertices * 12, vertices * 20);
    let json = serde_json::json!({
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": bin.len()}],
        "bufferViews": [
            {"buffer": 0, "byteLength": points},
            {"buffer": 0, "byteOffset": points, "byteLength": vertices * 12},
            {"buffer": 0, "byteOffset": points + vertices * 12, "byteLength": vertices * 8},
            {"buffer": 0, "byteOffset": points + rest, "byteLength": triangles * 12},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": vertices,
             "min": [0, -5, 0], "max": [n, 5, n]},
            {"bufferView": 1, "componentType": 5126, "type": "VEC3", "count": vertices},
            {"bufferView": 2, "componentType": 5126, "type": "VEC2", "count": vertices},
            {"bufferView": 3, "componentType": 5125, "type": "SCALAR", "count": triangles * 3},
        ],
        "meshes": [{"primitives": [{
            "attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}, "indices": 3}]}],
        "nodes": [{"mesh": 0}],
    });
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut out = b"glTF\x02\0\0\0".to_vec();
    out.extend((28 + text.len() as u32 + bin.len() as u32).to_le_bytes());
    out.extend((text.len() as u32).to_le_bytes());
    out.extend(b"JSON");
    out.extend(&text);
    out.extend((bin.len() as u32).to_le_bytes());
    out.extend(b"BIN\0");
    out.extend(&bin);
    out
}

/// Data prepared for culling would come on top of what a file takes.
fn unprepared() -> LoadOptions {
    LoadOptions { prepare: Preparation::NONE, ..LoadOptions::default() }
}

#[test]
fn a_million_triangles_take_at_most_three_times_their_geometry() {
    let n = 708;
    let file = std::env::temp_dir().join(format!("cullet-terrain-{}.glb", std::process::id()));
    std::fs::write(&file, terrain(n)).unwrap();
    let start = Instant::now();
    let (model, peak) = peak_of(|| load(&file, &unprepared()));
    let elapsed = start.elapsed();
    std::fs::remove_file(&file).unwrap();
    let model = model.unwrap();
    let mesh = &model.scene.meshes()[0];
    assert_eq!(mesh.triangle_count(), n * n * 2);
    assert_eq!(model.warnings, []);
    let geometry = size_of_val(mesh.positions()) + size_of_val(mesh.indices());
    let ratio = peak as f64 / geometry as f64;
    println!("{} triangles in {elapsed:?}, peak {ratio:.2} times {geometry} bytes", n * n * 2);
    assert!(ratio <= 3.0, "the peak is {peak} bytes, {ratio:.2} times the geometry");
}
