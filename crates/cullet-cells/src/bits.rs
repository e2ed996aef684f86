//! Masks of one bit a slot, in words of sixty-four.

/// Returns the numbers of the bits that are set in `word`, ascending.
pub(crate) fn ones(word: u64) -> impl Iterator<Item = usize> {
    let mut left = word;
    core::iter::from_fn(move || {
        (left != 0).then(|| {
            let bit = left.trailing_zeros() as usize;
            left &= left - 1;
            bit
        })
    })
}

/// Returns the numbers of the bits that are set in `words`, ascending.
pub(crate) fn in_words(words: &[u64]) -> impl Iterator<Item = usize> + '_ {
    let words = words.iter().enumerate();
    words.flat_map(|(index, &word)| ones(word).map(move |bit| index * 64 + bit))
}

/// Returns one bit.
pub(crate) fn get(words: &[u64], bit: usize) -> bool {
    words[bit / 64] >> (bit % 64) & 1 == 1
}

/// Sets one bit to `value`.
pub(crate) fn set(words: &mut [u64], bit: usize, value: bool) {
    let word = &mut words[bit / 64];
    *word = *word & !(1 << (bit % 64)) | u64::from(value) << (bit % 64);
}
