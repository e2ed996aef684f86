//! Sums of bytes, by which damage is told, and hashes of what baked files are of.

use cullet_cells::cell::CellGraph;

use crate::bytes::{put_f64s, put_u32s};

/// The golden ratio, as a step that meets all words.
const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

/// Hash of bytes, the same on every machine: no secret, but no accident keeps it. It is that of
/// every baked file.
#[must_use]
pub fn hash(bytes: &[u8]) -> u64 {
    let mut sum = Sum::new(bytes.len() as u64);
    let (words, rest) = bytes.as_chunks::<8>();
    words.iter().for_each(|&word| sum.add(u64::from_le_bytes(word)));
    if !rest.is_empty() {
        let mut word = [0; 8];
        word[..rest.len()].copy_from_slice(rest);
        sum.add(u64::from_le_bytes(word));
    }
    sum.end()
}

/// A hash that grows word by word.
#[derive(Clone, Copy, Debug)]
pub struct Sum(u64);

impl Sum {
    /// The sum of something of a length, which tells it from what only begins like it.
    #[must_use]
    pub fn new(length: u64) -> Self {
        Self(STEP ^ length)
    }

    /// Adds a word.
    #[inline]
    pub fn add(&mut self, word: u64) {
        self.0 = mix(self.0 ^ word).wrapping_add(STEP);
    }

    /// Adds the number of words, and then each.
    pub fn add_all(&mut self, words: impl ExactSizeIterator<Item = u64>) {
        self.add(words.len() as u64);
        words.for_each(|word| self.add(word));
    }

    /// The hash.
    #[must_use]
    pub fn end(self) -> u64 {
        mix(self.0)
    }
}

/// The sum of a table of chunks: number of the mesh, bytes and sum of each.
pub(crate) fn root_sum(chunks: &[[u64; 3]]) -> u64 {
    let mut sum = Sum::new(chunks.len() as u64);
    chunks.as_flattened().iter().for_each(|&word| sum.add(word));
    sum.end()
}

/// Mixes the bits of a word: Steele, Lea and Flood, *Fast Splittable Pseudorandom Number
/// Generators*, 2014.
#[inline]
#[must_use]
pub fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Hash of a graph of cells, the same on every machine.
#[must_use]
pub fn graph_hash(graph: &CellGraph) -> u64 {
    let mut bytes = graph.cell_count().to_le_bytes().to_vec();
    for portal in graph.portals() {
        put_u32s(&mut bytes, &portal.cells);
        put_u32s(&mut bytes, &[portal.polygon.len() as u32]);
        put_f64s(&mut bytes, portal.polygon.as_flattened());
    }
    hash(&bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_and_the_length_count() {
        let bytes: Vec<u8> = (0..40).collect();
        let mut seen = vec![hash(&bytes)];
        for at in 0..bytes.len() {
            let mut odd = bytes.clone();
            odd[at] ^= 1;
            seen.extend([hash(&odd), hash(&bytes[..at])]);
        }
        // Zeros at the end fill a word up, and still count.
        seen.push(hash(&[&bytes[..], &[0]].concat()));
        let all = seen.len();
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), all);
    }
}
