//! The choice: which clusters of a mesh's levels are drawn for an eye.

use alloc::vec::Vec;
use core::ops::Range;

use crate::simd::dispatch_256;
use fearless_simd::f32x8;
use fearless_simd::prelude::*;

use super::{Group, LevelEye, Levels, NO_GROUP};
use crate::bits;
use crate::simd::Simd;
use crate::sort::sort;

/// Groups a vector.
const WIDTH: usize = 8;

/// Least number of groups for a walk that asks one by one. With fewer groups a sweep over all is
/// quicker.
const LEAST_TO_WALK: usize = 256;
/// A walk that has visited this part of all groups gives up: it was worth little, and the sweep is
/// worth it.
const SHARE_TO_WALK: usize = 16;

/// Clusters that were chosen, and the memory to choose again.
#[derive(Clone, Debug, Default)]
pub struct Selection {
    /// One bit a group: it is over the threshold.
    over: Vec<u64>,
    /// One bit a group: it has been visited. As long as the largest levels that were chosen from.
    visited: Vec<u64>,
    /// The groups that have been visited.
    seen: Vec<u32>,
    /// One bit a cluster: it is drawn. As long as the largest levels that were chosen from.
    chosen: Vec<u64>,
    /// The words of `chosen` that are not zero.
    words: Vec<u32>,
    /// How many words of `chosen` the levels have that were chosen from last.
    word_count: usize,
    pending: Vec<u32>,
    triangles: u64,
    clusters: u32,
}

impl Selection {
    /// One bit a cluster: it is drawn.
    #[must_use]
    pub fn clusters(&self) -> &[u64] {
        &self.chosen[..self.word_count]
    }

    /// Forgets what was chosen, and makes room for so many groups and clusters. O(what was chosen).
    fn clear(&mut self, groups: usize, clusters: usize) {
        self.seen.drain(..).for_each(|group| self.visited[group as usize / 64] = 0);
        self.words.drain(..).for_each(|word| self.chosen[word as usize] = 0);
        (self.triangles, self.clusters) = (0, 0);
        self.word_count = clusters.div_ceil(64);
        self.visited.resize(self.visited.len().max(groups.div_ceil(64)), 0);
        self.chosen.resize(self.chosen.len().max(self.word_count), 0);
        self.pending.clear();
    }

    /// How many clusters are drawn.
    #[must_use]
    pub fn cluster_count(&self) -> u32 {
        self.clusters
    }

    /// How many triangles they have.
    #[must_use]
    pub fn triangle_count(&self) -> u64 {
        self.triangles
    }

    /// Ranges of clusters that follow each other, ascending.
    pub fn ranges(&self) -> impl Iterator<Item = Range<u32>> + '_ {
        // Words between those that are not zero part the ranges.
        let runs = self.words.chunk_by(|a, b| a + 1 == *b);
        runs.flat_map(move |words| {
            let (mut at, end) = (words[0] * 64, (words[words.len() - 1] + 1) * 64);
            core::iter::from_fn(move || {
                let first = bits::next(&self.chosen, at, end, true);
                at = bits::next(&self.chosen, first, end, false);
                (first < at).then_some(first..at)
            })
        })
    }
}

impl Levels {
    /// Chooses the clusters that are drawn for an eye: those whose group they were made from is not
    /// over the threshold, and that in which they were simplified is.
    ///
    /// Whether all of it is there: the finest clusters may be left out of the levels, as those of a
    /// chain are that the mesh itself is the finest of; `false` where some of them would be drawn,
    /// so that the mesh is to be drawn instead. Then nothing is chosen.
    ///
    /// Visits the groups from the coarsest down and goes no deeper than what is drawn: O(n log n)
    /// of what is drawn, and of what was drawn the last time. Where that is much of what there is,
    /// a sweep over all groups finds out first which are over the threshold, in a fraction of a
    /// nanosecond each. Allocates while `selection` grows.
    pub fn select(&self, simd: Simd, eye: &LevelEye, selection: &mut Selection) -> bool {
        let groups = self.group_count();
        if groups >= LEAST_TO_WALK {
            let over = |levels: &Self, group: u32| eye.is_over(&levels.group(group as usize));
            if let Some(all) = self.walk(over, groups / SHARE_TO_WALK, selection) {
                return all;
            }
        }
        let mut bits = core::mem::take(&mut selection.over);
        self.sweep(simd, eye, &mut bits);
        let over = |_: &Self, group: u32| bits::get(&bits, group as usize);
        let all = self.walk(over, usize::MAX, selection);
        selection.over = bits;
        all.unwrap_or(false)
    }

    /// Chooses from the coarsest groups down; whether all is there, or nothing where more groups
    /// would have to be visited than `most`.
    #[inline(always)]
    fn walk(
        &self,
        over: impl Fn(&Self, u32) -> bool,
        most: usize,
        selection: &mut Selection,
    ) -> Option<bool> {
        let (groups, all) = (self.group_count(), self.made_from.len());
        selection.clear(groups, all);
        let Selection { visited, seen, chosen, words, pending, .. } = selection;
        let (mut triangles, mut clusters) = (0, 0);
        // The list after the last group's: what no group simplified.
        pending.push(groups as u32);
        let mut left = most;
        while let Some(group) = pending.pop() {
            left = left.checked_sub(1)?;
            for &cluster in self.inputs_of(group as usize) {
                let finer = self.made_from[cluster as usize];
                if finer != NO_GROUP && over(self, finer) {
                    if self.inputs_of(finer as usize).is_empty() {
                        selection.clear(groups, all);
                        return Some(false);
                    }
                    let (word, bit) = (finer as usize / 64, 1 << (finer % 64));
                    if visited[word] & bit == 0 {
                        visited[word] |= bit;
                        seen.push(finer);
                        pending.push(finer);
                    }
                } else {
                    let word = &mut chosen[cluster as usize / 64];
                    if *word == 0 {
                        words.push(cluster / 64);
                    }
                    *word |= 1 << (cluster % 64);
                    triangles += u64::from(self.triangles[cluster as usize]);
                    clusters += 1;
                }
            }
        }
        sort(words);
        (selection.triangles, selection.clusters) = (triangles, clusters);
        Some(true)
    }

    /// Chooses clusters by the rule alone, slow and obvious: returns one flag a cluster. It is
    /// drawn where the groups are over the threshold that `over` says, as for several eyes at once,
    /// and [`select`](Self::select) chooses the same for one. `over` must say so of each group that
    /// was made from one of which it does. Flags are also set where clusters that would be drawn
    /// are missing from the levels; `select` then chooses nothing.
    #[must_use]
    pub fn select_where(&self, over: impl Fn(&Group) -> bool) -> Vec<bool> {
        let over: Vec<bool> = (0..self.group_count()).map(|g| over(&self.group(g))).collect();
        let is_over = |g: u32, none: bool| if g == NO_GROUP { none } else { over[g as usize] };
        let pairs = self.made_from.iter().zip(self.replaced_by());
        pairs.map(|(&from, &by)| !is_over(from, false) && is_over(by, true)).collect()
    }

    /// One bit a group: it is over the threshold.
    fn sweep(&self, simd: Simd, eye: &LevelEye, over: &mut Vec<u64>) {
        over.clear();
        over.resize(self.group_count().div_ceil(64), 0);
        dispatch_256!(simd, simd => sweep_with(simd, &self.rows, eye, over));
        for group in self.group_count() / WIDTH * WIDTH..self.group_count() {
            if eye.is_over(&self.group(group)) {
                over[group / 64] |= 1 << (group % 64);
            }
        }
    }
}

/// The sweep over whole vectors of groups, by the arithmetic of [`LevelEye::is_over`].
#[inline(always)]
fn sweep_with<S: fearless_simd::Simd>(
    simd: S,
    [x, y, z, radius, error]: &[Vec<f32>; 5],
    eye: &LevelEye,
    over: &mut [u64],
) {
    // No closures: one that is not inlined has none of the level's instructions.
    let ex = f32x8::splat(simd, eye.eye[0]);
    let ey = f32x8::splat(simd, eye.eye[1]);
    let ez = f32x8::splat(simd, eye.eye[2]);
    let (reach, ball) = (f32x8::splat(simd, eye.reach), f32x8::splat(simd, eye.ball));
    let nearest = f32x8::splat(simd, eye.nearest);
    for at in (0..x.len() / WIDTH * WIDTH).step_by(WIDTH) {
        let own = at..at + WIDTH;
        let e = f32x8::from_slice(simd, &error[own.clone()]);
        let dx = f32x8::from_slice(simd, &x[own.clone()]) - ex;
        let dy = f32x8::from_slice(simd, &y[own.clone()]) - ey;
        let dz = f32x8::from_slice(simd, &z[own.clone()]) - ez;
        let far = (e * reach + f32x8::from_slice(simd, &radius[own])) + ball;
        let away = (dx * dx + dy * dy) + dz * dz;
        // Not beyond: also where a number is NaN, as 0 times infinity is.
        let within = !away.simd_gt(far * far);
        let bits = (within & e.simd_gt(nearest)).to_bitmask();
        over[at / 64] |= bits << (at % 64);
    }
}
