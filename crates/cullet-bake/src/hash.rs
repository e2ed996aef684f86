//! Hashes of bytes, of words and of graphs.

use cullet::cell::CellGraph;

/// The golden ratio, as a step that meets all words.
const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

/// A hash that grows word by word.
pub(crate) struct Sum(u64);

impl Sum {
    /// Of something of a length that tells it from what only begins like it.
    pub(crate) fn new(length: u64) -> Self {
        Self(STEP ^ length)
    }

    #[inline]
    pub(crate) fn add(&mut self, word: u64) {
        self.0 = mix(self.0 ^ word).wrapping_add(STEP);
    }

    /// How many words there are, and then each.
    #[cfg(feature = "meshopt")]
    pub(crate) fn add_all(&mut self, words: impl ExactSizeIterator<Item = u64>) {
        self.add(words.len() as u64);
        words.for_each(|word| self.add(word));
    }

    pub(crate) fn end(self) -> u64 {
        mix(self.0)
    }
}

/// Hash of bytes, the same on every machine: no secret, but no accident keeps it.
#[must_use]
pub fn hash(bytes: &[u8]) -> u64 {
    let mut sum = Sum::new(bytes.len() as u64);
    for chunk in bytes.chunks(8) {
        let mut word = [0; 8];
        word[..chunk.len()].copy_from_slice(chunk);
        sum.add(u64::from_le_bytes(word));
    }
    sum.end()
}

/// Steele, Lea and Flood, *Fast Splittable Pseudorandom Number Generators*, 2014.
#[inline]
pub(crate) fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Hash of a graph.
pub(crate) fn hash_of(graph: &CellGraph) -> u64 {
    let mut bytes = graph.cell_count().to_le_bytes().to_vec();
    for portal in graph.portals() {
        portal.cells.iter().for_each(|c| bytes.extend(c.to_le_bytes()));
        bytes.extend((portal.polygon.len() as u32).to_le_bytes());
        portal.polygon.iter().flatten().for_each(|v| bytes.extend(v.to_le_bytes()));
    }
    hash(&bytes)
}
