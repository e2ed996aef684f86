//! Sets of numbers as bits, 64 a word.

/// The numbers whose bits are set.
pub(crate) fn slots(words: &[u64]) -> impl Iterator<Item = u32> + '_ {
    words.iter().enumerate().flat_map(|(word, &bits)| slots_of(word, bits))
}

/// Returns the slots of one word.
pub(crate) fn slots_of(word: usize, mut bits: u64) -> impl Iterator<Item = u32> {
    std::iter::from_fn(move || {
        (bits != 0).then(|| {
            let bit = bits.trailing_zeros();
            bits &= bits - 1;
            word as u32 * 64 + bit
        })
    })
}
