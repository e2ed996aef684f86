//! Classes of boxes of like size, for an order in which each class has its own nodes.

use alloc::vec;
use alloc::vec::Vec;

use crate::bounds::Aabb;
use crate::sort::sort;

/// Bins of an octave of sizes, as powers of two: the bits of the mantissa that tell them apart.
const FINE: u32 = 2;
/// Bins of all sizes that f32 has.
const BINS: usize = 1 << (8 + FINE);
/// Least number of bins between the means of two classes: fourfold sizes. Below that a class
/// has not much that the other has not.
const APART: u64 = 2 << FINE;
/// No class has fewer boxes: those below a node of 4,096.
const LEAST: u64 = 4096;
/// Nor a smaller share of all of them: nodes that are few cost walks more than they gain.
const SHARE: u64 = 64;
/// The most classes there are.
const MOST: usize = 4;

/// How many boxes have which longest side.
#[derive(Clone, Debug)]
pub(super) struct Counts {
    bins: Vec<u32>,
    len: u64,
}

impl Default for Counts {
    fn default() -> Self {
        Self { bins: vec![0; BINS], len: 0 }
    }
}

impl Counts {
    #[inline(always)]
    pub(super) fn add(&mut self, b: &Aabb) {
        if let Some(bin) = bin_of(b) {
            self.bins[bin as usize] += 1;
            self.len += 1;
        }
    }
}

/// Classes of sizes: a box is in the class of its longest side.
#[derive(Clone, Debug, Default)]
pub(super) struct Classes {
    /// The first bin of each class but the lowest, ascending.
    firsts: [u32; MOST - 1],
    /// How many of `firsts` there are.
    count: usize,
}

impl Classes {
    /// Finds the classes of the boxes that were counted.
    pub(super) fn of(Counts { bins: counts, len }: &Counts) -> Self {
        let mut found = Self::default();
        let least = LEAST.max(len / SHARE);
        // Each part is split once more, where it falls into two.
        let mut parts = [0..BINS, 0..0, 0..0, 0..0];
        let mut at = 0;
        while at <= found.count && found.count < MOST - 1 {
            let part = parts[at].clone();
            let Some(first) = split(&counts[part.clone()], least) else {
                at += 1;
                continue;
            };
            let first = part.start + first;
            found.count += 1;
            parts[found.count] = first..part.end;
            parts[at] = part.start..first;
        }
        for (first, part) in found.firsts.iter_mut().zip(&parts[1..=found.count]) {
            *first = part.start as u32;
        }
        sort(&mut found.firsts[..found.count]);
        found
    }

    /// Bits at the top of a key that tell the classes apart.
    pub(super) fn bits(&self) -> usize {
        (self.count + 1).next_power_of_two().ilog2() as usize
    }

    /// Returns the top of the key of a box: its class.
    #[inline(always)]
    pub(super) fn key(&self, b: &Aabb) -> u32 {
        if self.count == 0 {
            return 0;
        }
        let bin = bin_of(b).unwrap_or(0);
        let class = self.firsts[..self.count].iter().fold(0, |n, &f| n + u32::from(bin >= f));
        class << (32 - self.bits() as u32)
    }
}

/// The bin of the longest side of a box; `None` where it is nowhere.
#[inline(always)]
fn bin_of(b: &Aabb) -> Option<u32> {
    let longest = (0..3).fold(0.0_f32, |most, a| most.max(b.max[a] - b.min[a]));
    let somewhere = (0..3).fold(true, |all, a| all & (b.min[a] <= b.max[a]));
    somewhere.then_some(longest.to_bits() >> (23 - FINE))
}

/// Returns where some bins fall into two classes: the split after which the bins differ least from
/// the means of their classes (Otsu, *A Threshold Selection Method from Gray-Level Histograms*,
/// 1979), if those are [`APART`] and none is below `least`.
fn split(counts: &[u32], least: u64) -> Option<usize> {
    let of = |bins: core::ops::Range<usize>| {
        bins.fold((0_u64, 0_u64), |(n, sum), bin| {
            let own = u64::from(counts[bin]);
            (n + own, sum + own * bin as u64)
        })
    };
    let (all, all_sum) = of(0..counts.len());
    let (mut below, mut below_sum) = (0, 0);
    let mut best: Option<(u128, usize)> = None;
    for (bin, &own) in counts.iter().enumerate() {
        let above = all - below;
        if own > 0 && below >= least && above >= least {
            // The variance between the two, as a fraction whose denominator is common to all
            // splits but for n·m: d² n m, with d the difference of the means.
            let (n, m) = (u128::from(below), u128::from(above));
            let cross = (u128::from(all_sum - below_sum) * n).abs_diff(u128::from(below_sum) * m);
            let is_apart = cross >= n * m * u128::from(APART);
            let between = cross / n * (cross / m);
            if is_apart && best.is_none_or(|(most, _)| between > most) {
                best = Some((between, bin));
            }
        }
        below += u64::from(own);
        below_sum += u64::from(own) * bin as u64;
    }
    best.map(|(_, bin)| bin)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box with these sides.
    fn of_size(size: f32) -> Aabb {
        Aabb::new([3.0; 3], [3.0 + size, 3.5, 3.0])
    }

    fn classes(sizes: &[f32]) -> Classes {
        let mut counts = Counts::default();
        sizes.iter().for_each(|&size| counts.add(&of_size(size)));
        Classes::of(&counts)
    }

    #[test]
    fn sizes_of_two_kinds_are_two_classes() {
        // Grass of about one, and trees of about ten.
        let sizes: Vec<_> = (0..40_000)
            .map(|i| {
                let v = 0.8 + (i * 7919 % 1000) as f32 * 4e-4;
                if i % 5 == 0 { 10.0 * v } else { v }
            })
            .collect();
        let two = classes(&sizes);
        assert_eq!((two.count, two.bits()), (1, 1));
        for &size in &sizes {
            assert_eq!(two.key(&of_size(size)) >> 31, u32::from(size > 4.0), "{size}");
        }
        // What is nowhere is in the lowest; it comes last by its key in any case.
        assert_eq!(two.key(&Aabb::EMPTY), 0);
    }

    #[test]
    fn sizes_that_are_alike_and_few_boxes_stay_one_class() {
        let even: Vec<_> = (0..40_000).map(|i| 1.0 + (i * 7919 % 1000) as f32 * 2e-3).collect();
        assert_eq!(classes(&even).count, 0);
        let few: Vec<_> = (0..8000).map(|i| if i % 2 == 0 { 1.0 } else { 90.0 }).collect();
        assert_eq!(classes(&few).count, 0);
        // Large ones that are too few for nodes of their own.
        let rare: Vec<_> = (0..40_000).map(|i| if i % 100 == 0 { 90.0 } else { 1.0 }).collect();
        assert_eq!(classes(&rare).count, 0);
        assert_eq!(classes(&[]).count, 0);
    }

    #[test]
    fn there_are_no_more_than_four_classes_and_every_size_is_in_one() {
        let sizes: Vec<_> = (0..70_000).map(|i| 10.0_f32.powi(i % 7 - 3)).collect();
        let four = classes(&sizes);
        assert_eq!((four.count, four.bits()), (3, 2));
        let mut before = 0;
        for power in -3..4 {
            let class = four.key(&of_size(10.0_f32.powi(power))) >> 30;
            assert!(class == before || class == before + 1, "{power}");
            before = class;
        }
        assert_eq!(before, 3);
    }
}
