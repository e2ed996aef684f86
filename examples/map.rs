//! A Quake map: where players start, what is seen from there, its cells and portals, and other visibility written into it.

use cullet_maps::bsp::{Bsp, ClusterRows, clusters_of_leafs, with_visibility};

/// A room in two leafs, one of water.
const SMALL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fuzz/seeds/bsp/quake");

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).unwrap_or_else(|| SMALL.to_owned());
    let bytes = std::fs::read(&path)?;
    let map = Bsp::parse(&bytes)?;
    println!("{}: {}, {} leafs", path, map.version().name(), map.leafs().len());
    for start in map.starts() {
        let seen = map.leafs_seen_from(map.leaf_at(start.origin)).len();
        println!("{} at {:?}: {seen} leafs seen", start.class, start.origin);
    }
    println!("{} lamps", map.lamps().len());

    let graph = map.cells()?;
    println!("{} cells, {} portals", graph.cell_count(), graph.portals().len());

    // Each cell sees itself and its neighbours: what a baker finds takes the place of this.
    let length = (graph.cell_count() as usize).div_ceil(8);
    let mut rows = vec![0; length * graph.cell_count() as usize];
    let mut set =
        |from: u32, to: u32| rows[from as usize * length + to as usize / 8] |= 1 << (to % 8);
    (0..graph.cell_count()).for_each(|cell| set(cell, cell));
    for portal in graph.portals() {
        let [a, b] = portal.cells;
        set(a, b);
        set(b, a);
    }
    let of_leaf = clusters_of_leafs(&map);
    let rows = ClusterRows { clusters: graph.cell_count(), of_leaf: &of_leaf, rows: &rows };
    let written = with_visibility(&bytes, &rows)?;
    println!("{} bytes with these rows, {} before", written.len(), bytes.len());
    Ok(())
}
