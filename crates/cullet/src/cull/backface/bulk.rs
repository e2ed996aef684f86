//! The forms of an answer, for every test of many things at once: a mask of what is culled, a count, or
//! the ascending list of what is kept.

use fearless_simd::{Level, Simd, dispatch};

use crate::cull::Indices;
use crate::cull::output::expand;

/// Things that are tested sixty-four at a time.
pub(super) trait Culled {
    /// How many there are.
    fn len(&self) -> usize;

    /// Words `first..` of the mask of what is culled, as many as `out` has; the bits beyond the last
    /// thing are 0.
    fn fill(&self, level: Level, first: usize, out: &mut [u64]);
}

/// Words at once: few enough to stay in the first cache, many enough to hide the calls.
const AT_ONCE: usize = 64;

/// Fills a mask of what is culled.
pub(super) fn cull(things: &impl Culled, level: Level, culled: &mut Vec<u64>) {
    // Every word is overwritten.
    culled.resize(things.len().div_ceil(64), 0);
    things.fill(level, 0, culled);
}

/// Counts what is culled.
pub(super) fn count(things: &impl Culled, level: Level) -> u64 {
    let mut count = 0;
    each(things, level, |_, words| {
        dispatch!(level, simd => count += ones(simd, words));
    });
    count
}

/// Lists what is kept.
pub(super) fn keep(things: &impl Culled, level: Level, kept: &mut Indices) {
    kept.fill(things.len().next_multiple_of(64), |out| {
        let mut len = 0;
        each(things, level, |first, words| {
            len += list(things, level, first, words, &mut out[len..]);
        });
        len
    });
}

/// Lists what is kept in those words whose bit in `wanted` is set; bits beyond the last word are ignored.
pub(super) fn keep_in(things: &impl Culled, level: Level, wanted: &[u64], kept: &mut Indices) {
    let room = wanted.iter().map(|w| w.count_ones() as usize * 64).sum();
    let words = things.len().div_ceil(64);
    kept.fill(room, |out| {
        let (mut len, mut block) = (0, [0; AT_ONCE]);
        for (i, &bits) in wanted.iter().enumerate() {
            let mut rest = bits;
            while rest != 0 {
                let start = rest.trailing_zeros();
                let run = (rest >> start).trailing_ones();
                rest &= !(u64::MAX >> (64 - run) << start);
                let first = i * 64 + start as usize;
                if first < words {
                    let block = &mut block[..(words - first).min(run as usize)];
                    things.fill(level, first, block);
                    len += list(things, level, first, block, &mut out[len..]);
                }
            }
        }
        len
    });
}

/// Writes the numbers of what words `first..` of the mask of what is culled keep.
fn list(
    things: &impl Culled,
    level: Level,
    first: usize,
    culled: &mut [u64],
    out: &mut [u32],
) -> usize {
    let last = things.len() - first * 64;
    for word in culled.iter_mut() {
        *word = !*word;
    }
    if let Some(end) = culled.get_mut(last / 64) {
        *end &= (1 << (last % 64)) - 1;
    }
    expand(level, culled, (first * 64) as u32, out)
}

fn each(things: &impl Culled, level: Level, mut take: impl FnMut(usize, &mut [u64])) {
    let mut block = [0; AT_ONCE];
    let words = things.len().div_ceil(64);
    for first in (0..words).step_by(AT_ONCE) {
        let block = &mut block[..(words - first).min(AT_ONCE)];
        things.fill(level, first, block);
        take(first, block);
    }
}

// Bits are counted under a level, for machines without SIMD have no instruction for it either.
#[inline(always)]
fn ones<S: Simd>(_: S, words: &[u64]) -> u64 {
    let mut count = 0;
    for word in words {
        count += u64::from(word.count_ones());
    }
    count
}
