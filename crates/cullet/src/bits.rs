//! Masks of one bit per item, in words of sixty-four.

use core::ops::Range;

/// The numbers of the bits that are set in a word, ascending.
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

/// The numbers of the bits that are set in words, ascending.
pub(crate) fn in_words(words: &[u64]) -> impl Iterator<Item = usize> + '_ {
    let words = words.iter().enumerate();
    words.flat_map(|(index, &word)| ones(word).map(move |bit| index * 64 + bit))
}

/// Runs of set bits of a word, ascending.
pub(crate) fn runs(word: u64) -> impl Iterator<Item = Range<usize>> {
    let mut left = word;
    core::iter::from_fn(move || {
        (left != 0).then(|| {
            let start = left.trailing_zeros();
            let end = start + (left >> start).trailing_ones();
            left = left.checked_shr(end).unwrap_or(0).checked_shl(end).unwrap_or(0);
            start as usize..end as usize
        })
    })
}

/// The words of a range of bits, each with its bits.
pub(crate) fn words_of(range: Range<usize>) -> impl Iterator<Item = (usize, u64)> {
    let words = if range.is_empty() { 0..0 } else { range.start / 64..range.end.div_ceil(64) };
    words.map(move |word| {
        let from = range.start.saturating_sub(word * 64);
        let to = (range.end - word * 64).min(64);
        (word, u64::MAX << from & u64::MAX >> (64 - to))
    })
}

/// One bit.
pub(crate) fn get(words: &[u64], bit: usize) -> bool {
    words[bit / 64] >> (bit % 64) & 1 == 1
}

/// Sets one bit to a value.
pub(crate) fn set(words: &mut [u64], bit: usize, value: bool) {
    let word = &mut words[bit / 64];
    *word = *word & !(1 << (bit % 64)) | u64::from(value) << (bit % 64);
}

/// The first of `from..end` whose bit is `set`, or `end`.
pub(crate) fn next(words: &[u64], from: u32, end: u32, set: bool) -> u32 {
    let mut at = from;
    while at < end {
        let word = words.get(at as usize / 64).copied().unwrap_or(0);
        let word = (if set { word } else { !word }) >> (at % 64);
        if word != 0 {
            return (at + word.trailing_zeros()).min(end);
        }
        at = (at / 64 + 1) * 64;
    }
    end
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_and_runs_agree() {
        for range in [0..0, 0..1, 3..64, 0..64, 63..65, 5..200, 64..128, 127..128] {
            let mut words = [0; 4];
            words_of(range.clone()).for_each(|(w, bits)| words[w] |= bits);
            let mut one_by_one = [0; 4];
            range.clone().for_each(|bit| set(&mut one_by_one, bit, true));
            assert_eq!(words, one_by_one, "{range:?}");
            let found: Vec<_> = (0..4).flat_map(|w| runs(words[w]).map(move |r| (w, r))).collect();
            let bits: Vec<_> =
                found.into_iter().flat_map(|(w, r)| r.map(move |b| w * 64 + b)).collect();
            let by_ones: Vec<_> =
                (0..4).flat_map(|w| ones(words[w]).map(move |b| w * 64 + b)).collect();
            assert!(bits.iter().copied().eq(range.clone()) && by_ones.iter().copied().eq(range));
        }
        assert!(runs(0b1011_0001).eq([0..1, 4..6, 7..8]));
    }
}
