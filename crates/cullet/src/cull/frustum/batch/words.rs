//! Blocks of sixteen items, four to a word of the answer: how a batch is gone through, whatever is
//! tested.

use bytemuck::Zeroable;
use fearless_simd::prelude::*;

/// Blocks to a word of the answer.
pub(super) const BLOCKS: usize = 4;

/// The valid bits of word `index` of a batch of `len` items.
#[inline(always)]
pub(super) fn valid(len: usize, index: usize) -> u64 {
    match len.saturating_sub(index * 64) {
        0 => 0,
        left if left >= 64 => u64::MAX,
        left => (1 << left) - 1,
    }
}

/// Splits words `first..` of a mask into those whose sixty-four items are all there, with their
/// blocks, and the rest, with their numbers.
#[inline(always)]
pub(super) fn parts<'a, T>(
    blocks: &'a [T],
    len: usize,
    first: usize,
    words: &'a mut [u64],
) -> (
    impl Iterator<Item = (&'a [T; BLOCKS], &'a mut u64)>,
    impl Iterator<Item = (usize, &'a mut u64)>,
) {
    let whole = (len / 64).clamp(first, first + words.len());
    let (now, later) = words.split_at_mut(whole - first);
    let chunks = &blocks.as_chunks::<BLOCKS>().0;
    (chunks[first.min(chunks.len())..].iter().zip(now), (whole..).zip(later))
}

/// The blocks of a word that the batch does not fill.
#[cold]
pub(super) fn padded<T: Copy + Zeroable>(blocks: &[T], index: usize) -> [T; BLOCKS] {
    let mut chunk = [T::zeroed(); BLOCKS];
    let rest = blocks.get(index * BLOCKS..).unwrap_or_default();
    for (to, from) in chunk.iter_mut().zip(rest) {
        *to = *from;
    }
    chunk
}

#[inline(always)]
pub(super) fn bits<S: Simd>(v: S::f32s) -> S::i32s {
    v.bitcast()
}

#[inline(always)]
pub(in crate::cull::frustum) fn load<S: Simd>(simd: S, row: &[f32; 16], at: usize) -> S::f32s {
    S::f32s::from_slice(simd, &row[at..at + S::f32s::LEN])
}
