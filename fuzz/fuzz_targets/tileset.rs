//! Any bytes as a tileset, with a tile beside it, and as its visible sets: an error or a model, never a panic.
#![no_main]

use cullet_io::LoadOptions;
use cullet_io::baked::hash;
use cullet_maps::TileSight;
use cullet_maps::load_bytes_with;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    // What follows the JSON's last brace is the tile, so that one input tries both.
    let end = bytes.iter().rposition(|&b| b == b'}').map_or(0, |at| at + 1);
    let (json, tile) = bytes.split_at(end);
    let beside = ["a.glb", "b.b3dm", "c.i3dm", "d.cmpt"].map(|n| (n.to_owned(), tile.to_vec()));
    let options = LoadOptions { max_triangles: 100_000, ..LoadOptions::default() };
    if let Ok(model) = load_bytes_with("fuzz.json", json, &beside, &options) {
        assert!(model.scene.triangle_count() <= 100_000 || model.scene.instance_count() > 1);
    }
    // With the right sum, so that what is behind it is tried.
    let sets = [b"CLTSIGHT", &hash(bytes).to_le_bytes()[..], bytes].concat();
    if let Ok(sight) = TileSight::from_bytes(&sets) {
        for number in [0, 1, 63, 64, 4097, u32::MAX] {
            let _ = (0..sight.cell_count().min(9)).any(|cell| sight.sees(cell, number));
        }
        let _ = sight.cell_of([0.5; 3]);
    }
});
