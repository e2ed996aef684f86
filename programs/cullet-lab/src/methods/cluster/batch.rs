//! Many clusters against one eye, with SIMD.
//!
//! Bounds are kept in blocks of sixteen, a row for each number, and tested as many at a time as a
//! vector is wide. The arithmetic is that of [`Bound::is_behind`], product by product, so the
//! answers are the same at every level.

use cullet::cull::backface::ClusterEye;
use fearless_simd::{Simd, dispatch, prelude::*};

use super::lanes::Lanes;
use super::{Batch, Bound};
use crate::methods::bulk::Bulk;

/// The bounds of many clusters: answers as a mask, a count or a list.
#[derive(Clone, Debug)]
pub struct ClusterBounds<B: Bound> {
    batch: B::Batch,
}

impl<B: Bound> Default for ClusterBounds<B> {
    fn default() -> Self {
        Self { batch: B::Batch::default() }
    }
}

impl<B: Bound> FromIterator<Option<B>> for ClusterBounds<B> {
    /// Clusters without a bound are never culled.
    fn from_iter<I: IntoIterator<Item = Option<B>>>(bounds: I) -> Self {
        let mut all = Self::default();
        bounds.into_iter().for_each(|b| all.push(b));
        all
    }
}

impl<B: Bound> ClusterBounds<B> {
    /// Adds a cluster; `None` is one that is never culled.
    pub fn push(&mut self, bound: Option<B>) {
        self.batch.push(bound);
    }

    /// How many clusters there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.batch.len()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.batch.is_empty()
    }

    /// Bits of 64 clusters.
    pub(super) fn word(&self, simd: cullet::Simd, word: usize, eye: &ClusterEye) -> u64 {
        let mut out = [0];
        self.batch.cull_words(simd, eye, word, &mut out);
        out[0]
    }
}

/// An eye that is none (see [`ClusterEye::new`]) culls nothing.
impl<B: Bound> Bulk<[f64; 4]> for ClusterBounds<B> {
    fn count_all(&self) -> usize {
        self.len()
    }

    fn cull_words(&self, simd: cullet::Simd, eye: [f64; 4], first: usize, culled: &mut [u64]) {
        match ClusterEye::new(eye) {
            Some(eye) => self.batch.cull_words(simd, &eye, first, culled),
            None => culled.fill(0),
        }
    }
}

/// Blocks of sixteen bounds each: the batch of every bound that has no better.
#[derive(Clone, Debug)]
pub struct Blocks<B: Lanes> {
    blocks: Vec<B::Block>,
    len: usize,
}

/// Blocks a word of 64 bits.
const BLOCKS: usize = 4;

impl<B: Lanes> Default for Blocks<B> {
    fn default() -> Self {
        Self { blocks: Vec::new(), len: 0 }
    }
}

impl<B: Lanes> Batch<B> for Blocks<B> {
    fn push(&mut self, bound: Option<B>) {
        if self.len.is_multiple_of(16 * BLOCKS) {
            self.blocks.extend([B::NOTHING; BLOCKS]);
        }
        if let Some(bound) = bound {
            bound.set_lane(&mut self.blocks[self.len / 16], self.len % 16);
        }
        self.len += 1;
    }

    fn len(&self) -> usize {
        self.len
    }

    fn cull_words(&self, simd: cullet::Simd, eye: &ClusterEye, first: usize, culled: &mut [u64]) {
        let blocks = &self.blocks[first * BLOCKS..(first + culled.len()) * BLOCKS];
        dispatch!(simd.level(), simd => words::<_, B>(simd, blocks, eye, culled));
    }
}

#[inline(always)]
fn words<S: Simd, B: Lanes>(simd: S, blocks: &[B::Block], eye: &ClusterEye, out: &mut [u64]) {
    for (blocks, out) in blocks.as_chunks::<BLOCKS>().0.iter().zip(out) {
        *out = 0;
        for (i, block) in blocks.iter().enumerate() {
            for start in (0..16).step_by(S::f32s::LEN) {
                *out |= B::test_lanes(simd, block, start, eye) << (i * 16 + start);
            }
        }
    }
}
