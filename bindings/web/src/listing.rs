//! Numbers in ascending order, from a walk that goes in the order of space.

use alloc::vec::Vec;

use cullet::Simd;
use cullet::cull::Indices;

/// Sorts numbers by a bit each. Its memory is kept from call to call.
#[derive(Debug, Default)]
pub(crate) struct Ascending {
    words: Vec<u64>,
    list: Indices,
}

impl Ascending {
    /// Lists the numbers, all below `len`. O(numbers + len / 64).
    pub(crate) fn fill(&mut self, simd: Simd, len: usize, numbers: impl Iterator<Item = u32>) {
        self.words.clear();
        self.words.resize(len.div_ceil(64), 0);
        for number in numbers {
            self.words[number as usize / 64] |= 1 << (number % 64);
        }
        self.list.clear();
        self.list.append_ones(simd, &self.words, 0);
    }

    /// The numbers, ascending.
    pub(crate) fn list(&self) -> &[u32] {
        &self.list
    }
}
