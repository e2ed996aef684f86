//! Bulk tests: many triangles or clusters against one eye, sixty-four at a time: the answer as a
//! mask of what is culled, a count, or the ascending list of what is kept.

use cullet::Simd;
use cullet::cull::Indices;
use cullet::cull::backface::{Facing, Planes8};
use cullet_mesh::{BackfaceMask, NormalMasks};

/// Words at once: few enough to stay in the first cache, many enough to hide the calls.
const AT_ONCE: usize = 64;

/// Triangles or clusters that are tested for back faces together, against an eye of type `E`.
pub trait Bulk<E: Copy> {
    /// How many there are.
    fn count_all(&self) -> usize;

    /// Fills words `first..` of the mask of what is culled, as many as `culled` has; bits beyond
    /// the last are 0. The same at every level.
    ///
    /// # Panics
    /// If the words reach beyond the last one's.
    fn cull_words(&self, simd: Simd, eye: E, first: usize, culled: &mut [u64]);

    /// Sets bit i of `culled` where i is culled; bits beyond the last are 0.
    fn cull(&self, simd: Simd, eye: E, culled: &mut Vec<u64>) {
        // Every word is overwritten.
        culled.resize(self.count_all().div_ceil(64), 0);
        self.cull_words(simd, eye, 0, culled);
    }

    /// How many are culled.
    fn count(&self, simd: Simd, eye: E) -> u64 {
        let mut count = 0;
        self.each(simd, eye, |_, words| {
            count += words.iter().map(|w| u64::from(w.count_ones())).sum::<u64>();
        });
        count
    }

    /// Lists what is *not* culled, ascending.
    fn keep(&self, simd: Simd, eye: E, kept: &mut Indices) {
        let len = self.count_all();
        kept.clear();
        self.each(simd, eye, |first, words| {
            append_kept(simd, len, first, words, kept);
        });
    }

    /// Lists what is *not* culled of those words whose bit in `wanted` is set, ascending: for
    /// clusters of 64 triangles of which only some want a test of each triangle. Bits beyond the
    /// last word are ignored.
    fn keep_in(&self, simd: Simd, eye: E, wanted: &[u64], kept: &mut Indices) {
        let (len, mut block) = (self.count_all(), [0; AT_ONCE]);
        kept.clear();
        for (i, &bits) in wanted.iter().enumerate() {
            let mut rest = bits;
            while rest != 0 {
                let start = rest.trailing_zeros();
                let run = (rest >> start).trailing_ones();
                rest &= !(u64::MAX >> (64 - run) << start);
                let first = i * 64 + start as usize;
                let words = len.div_ceil(64).saturating_sub(first).min(run as usize);
                self.cull_words(simd, eye, first, &mut block[..words]);
                append_kept(simd, len, first, &mut block[..words], kept);
            }
        }
    }

    /// Calls `take` with the masks of some words at a time, and the number of the first.
    fn each(&self, simd: Simd, eye: E, mut take: impl FnMut(usize, &mut [u64])) {
        let mut block = [0; AT_ONCE];
        let words = self.count_all().div_ceil(64);
        for first in (0..words).step_by(AT_ONCE) {
            let block = &mut block[..(words - first).min(AT_ONCE)];
            self.cull_words(simd, eye, first, block);
            take(first, block);
        }
    }
}

/// Appends the numbers of what words `first..` of the mask of what is culled of `len` keep.
fn append_kept(simd: Simd, len: usize, first: usize, culled: &mut [u64], kept: &mut Indices) {
    for word in culled.iter_mut() {
        *word = !*word;
    }
    if let Some(end) = (len / 64).checked_sub(first).and_then(|end| culled.get_mut(end)) {
        *end &= (1 << (len % 64)) - 1;
    }
    kept.append_ones(simd, culled, (first * 64) as u32);
}

impl Bulk<[f64; 4]> for Planes8 {
    fn count_all(&self) -> usize {
        self.len()
    }

    fn cull_words(&self, simd: Simd, eye: [f64; 4], first: usize, culled: &mut [u64]) {
        match self.eye(eye, Facing::Back, 0.0) {
            Some(eye) => Self::cull_words(self, simd, &eye, first, culled),
            None => culled.fill(0),
        }
    }
}

impl Bulk<&BackfaceMask> for NormalMasks {
    fn count_all(&self) -> usize {
        self.len()
    }

    fn cull_words(&self, simd: Simd, mask: &BackfaceMask, first: usize, culled: &mut [u64]) {
        Self::cull_words(self, simd, mask, first, culled);
    }
}
