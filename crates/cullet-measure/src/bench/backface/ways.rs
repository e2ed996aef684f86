//! Ways to test all triangles or clusters, under one trait.

use cullet::Level;
use cullet::cull::Indices;
use cullet::cull::backface::{
    BackfaceMask, NormalMasks, Planes8, Planes16, count_masked, cull_masked, cull_masked_ref,
    keep_unmasked,
};
use cullet_methods::Planes32;
use cullet_methods::cluster::{Bound, ClusterBounds};

use super::ball::EYE;

/// One way to test all triangles or clusters: answers as mask, count and list.
pub(super) trait Test {
    fn mask(&self, level: Level, culled: &mut Vec<u64>);
    fn count(&self, level: Level) -> u64;
    fn keep(&self, level: Level, kept: &mut Indices);
    fn oracle(&self) -> Vec<u64>;
}

macro_rules! planes {
    ($($planes:ty),*) => {$(
        impl Test for $planes {
            fn mask(&self, level: Level, culled: &mut Vec<u64>) {
                self.cull(level, EYE, culled);
            }
            fn count(&self, level: Level) -> u64 {
                self.count(level, EYE)
            }
            fn keep(&self, level: Level, kept: &mut Indices) {
                self.keep(level, EYE, kept);
            }
            fn oracle(&self) -> Vec<u64> {
                self.cull_ref(EYE)
            }
        }
    )*};
}
planes!(Planes8, Planes16, Planes32);

impl Test for (NormalMasks, BackfaceMask) {
    fn mask(&self, level: Level, culled: &mut Vec<u64>) {
        cull_masked(level, &self.0, &self.1, culled);
    }
    fn count(&self, level: Level) -> u64 {
        count_masked(level, &self.0, &self.1)
    }
    fn keep(&self, level: Level, kept: &mut Indices) {
        keep_unmasked(level, &self.0, &self.1, kept);
    }
    fn oracle(&self) -> Vec<u64> {
        cull_masked_ref(&self.0, &self.1)
    }
}

impl<B: Bound> Test for (ClusterBounds<B>, Vec<Option<B>>) {
    fn mask(&self, level: Level, culled: &mut Vec<u64>) {
        self.0.cull(level, EYE, culled);
    }
    fn count(&self, level: Level) -> u64 {
        self.0.count(level, EYE)
    }
    fn keep(&self, level: Level, kept: &mut Indices) {
        self.0.keep(level, EYE, kept);
    }
    fn oracle(&self) -> Vec<u64> {
        let mut culled = vec![0; self.1.len().div_ceil(64)];
        for (i, bound) in self.1.iter().enumerate() {
            let behind = bound.as_ref().is_some_and(|b| b.is_behind(EYE));
            culled[i / 64] |= u64::from(behind) << (i % 64);
        }
        culled
    }
}
