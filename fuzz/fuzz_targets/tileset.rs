//! Any bytes as a tileset, with a tile beside it: an error or a model, never a panic.
#![no_main]

use cullet_io::{LoadOptions, load_bytes_with};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    // What follows the JSON's last brace is the tile, so that one input tries both.
    let end = bytes.iter().rposition(|&b| b == b'}').map_or(0, |at| at + 1);
    let (json, tile) = bytes.split_at(end);
    let beside = [("a.glb".to_owned(), tile.to_vec()), ("b.b3dm".to_owned(), tile.to_vec())];
    let options = LoadOptions { max_triangles: 100_000, ..LoadOptions::default() };
    if let Ok(model) = load_bytes_with("fuzz.json", json, &beside, &options) {
        assert!(model.scene.triangle_count() <= 100_000 || model.scene.instance_count() > 1);
    }
});
