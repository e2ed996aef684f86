//! Any bytes as a map of Quake or Quake 3: an error, or a model and a map whose rows are the same after writing them and
//! reading again.
#![no_main]

use cullet_io::LoadOptions;
use cullet_maps::bsp::{Bsp, ClusterRows, clusters_of_leafs, with_visibility};
use cullet_maps::load_bytes;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let _ = load_bytes("fuzz.bsp", bytes, &LoadOptions::default());
    let Ok(map) = Bsp::parse(bytes) else { return };
    let _ = map.cells();
    for start in map.starts() {
        let _ = map.leafs_seen_from(map.leaf_at(start.origin));
    }
    let mut rows = Vec::new();
    let row = |map: &Bsp, cell: u32, rows: &mut Vec<u8>| {
        let start = rows.len();
        map.cell_row_into(cell, rows);
        // Each must see itself.
        rows[start + cell as usize / 8] |= 1 << (cell % 8);
    };
    (0..map.cell_count()).for_each(|cell| row(&map, cell, &mut rows));
    let of_leaf = clusters_of_leafs(&map);
    let given = ClusterRows { clusters: map.cell_count(), of_leaf: &of_leaf, rows: &rows };
    // Lumps may overlap, and a cluster of Quake 3 may have no leaf.
    let Ok(written) = with_visibility(bytes, &given) else { return };
    let again = Bsp::parse(&written).expect("what was written can be read");
    let mut read = Vec::new();
    (0..again.cell_count()).for_each(|cell| row(&again, cell, &mut read));
    assert_eq!(rows, read);
});
