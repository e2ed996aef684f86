//! Any bytes as a portal graph: an error or a graph whose leafs are in its cells, never a panic.
#![no_main]

use cullet_maps::load_prt_bytes;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(prt) = load_prt_bytes("fuzz.prt", bytes) {
        let cells = prt.graph.cell_count();
        assert!(prt.leaf_clusters.iter().all(|&c| c < cells));
        assert!(prt.graph.portals().iter().all(|p| p.cells.iter().all(|&c| c < cells)));
        assert!(prt.leaf_clusters.len() <= bytes.len());
    }
});
