//! Forms of an answer, for every test of many things at once: a mask of what is culled, a count, or the
//! ascending list of what is kept. `fill` writes words of that mask, from a word on; bits beyond the last
//! thing are 0.

use cullet::Level;
use cullet::cull::Indices;

/// Words at once: few enough to stay in the first cache, many enough to hide the calls.
const AT_ONCE: usize = 64;

/// Fills a mask of what is culled of `len` things.
pub(crate) fn cull(len: usize, culled: &mut Vec<u64>, fill: impl FnOnce(usize, &mut [u64])) {
    // Every word is overwritten.
    culled.resize(len.div_ceil(64), 0);
    fill(0, culled);
}

/// Counts what is culled.
pub(crate) fn count(len: usize, fill: impl FnMut(usize, &mut [u64])) -> u64 {
    let mut count = 0;
    each(len, fill, |_, words| {
        count += words.iter().map(|w| u64::from(w.count_ones())).sum::<u64>();
    });
    count
}

/// Lists what is kept.
pub(crate) fn keep(
    len: usize,
    level: Level,
    kept: &mut Indices,
    fill: impl FnMut(usize, &mut [u64]),
) {
    kept.clear();
    each(len, fill, |first, words| {
        for word in words.iter_mut() {
            *word = !*word;
        }
        if let Some(end) = words.get_mut(len / 64 - first) {
            *end &= (1 << (len % 64)) - 1;
        }
        kept.append_ones(level, words, (first * 64) as u32);
    });
}

fn each(
    len: usize,
    mut fill: impl FnMut(usize, &mut [u64]),
    mut take: impl FnMut(usize, &mut [u64]),
) {
    let mut block = [0; AT_ONCE];
    let words = len.div_ceil(64);
    for first in (0..words).step_by(AT_ONCE) {
        let block = &mut block[..(words - first).min(AT_ONCE)];
        fill(first, block);
        take(first, block);
    }
}
