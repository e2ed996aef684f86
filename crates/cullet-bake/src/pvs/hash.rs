//! Hashes of bytes and graphs.

use cullet::cell::CellGraph;

/// Hash of bytes, the same on every machine: no secret, but no accident keeps it.
pub(crate) fn hash(bytes: &[u8]) -> u64 {
    let mut state = 0x9e37_79b9_7f4a_7c15 ^ bytes.len() as u64;
    for chunk in bytes.chunks(8) {
        let mut word = [0; 8];
        word[..chunk.len()].copy_from_slice(chunk);
        state = mix(state ^ u64::from_le_bytes(word)).wrapping_add(0x9e37_79b9_7f4a_7c15);
    }
    mix(state)
}

/// Steele, Lea and Flood, *Fast Splittable Pseudorandom Number Generators*, 2014.
#[inline]
pub(crate) fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Hash of a graph.
pub(super) fn hash_of(graph: &CellGraph) -> u64 {
    let mut bytes = graph.cell_count().to_le_bytes().to_vec();
    for portal in graph.portals() {
        portal.cells.iter().for_each(|c| bytes.extend(c.to_le_bytes()));
        bytes.extend((portal.polygon.len() as u32).to_le_bytes());
        portal.polygon.iter().flatten().for_each(|v| bytes.extend(v.to_le_bytes()));
    }
    hash(&bytes)
}
