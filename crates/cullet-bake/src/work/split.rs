//! Rounds cut into units, and units that lie there laid end to end.

use std::ops::Range;

/// How much more of a round the first unit of [`taper`] has than the last.
const TAPER: f64 = 8.0;

/// Cuts items into at most so many runs of nearly equal cost, in their order; none is empty. The
/// most costly run is at most an even share and one item above it. Where costs are zero or no
/// numbers, runs of equal length.
#[must_use]
pub fn split(costs: &[f64], units: u32) -> Vec<Range<u32>> {
    cut(costs, units, |k, units| k / units)
}

/// Splits like [`split`], but the first run costs eight times as much as the last, and those
/// between less and less: workers that take the next run as they end one then wait only briefly for
/// the last, and the runs stay few.
///
/// After T. H. Tzen and L. M. Ni, *Trapezoid self-scheduling*, 1993.
#[must_use]
pub fn taper(costs: &[f64], units: u32) -> Vec<Range<u32>> {
    // Run k of n has a size of 1 + (TAPER - 1) (1 - k / (n - 1)); this is the sum of those before.
    let before = |k: f64, last: f64| k + (TAPER - 1.0) * (k - k * (k - 1.0) / (2.0 * last));
    cut(costs, units, |k, units| {
        let last = (units - 1.0).max(1.0);
        before(k, last) / before(units, last)
    })
}

/// Cuts items into at most so many runs; `until` says which share of the cost lies in the first so
/// many of all.
fn cut(costs: &[f64], units: u32, until: impl Fn(f64, f64) -> f64) -> Vec<Range<u32>> {
    let count = costs.len() as u32;
    let units = units.clamp(1, count.max(1));
    let until = |runs: u32| until(f64::from(runs), f64::from(units));
    let sound = |c: f64| if c.is_finite() { c.max(0.0) } else { 0.0 };
    let all: f64 = costs.iter().map(|&c| sound(c)).sum();
    if all <= 0.0 || all.is_infinite() {
        let at = |k: u32| (u64::from(count) * u64::from(k) / u64::from(units)) as u32;
        return (0..units).map(|k| at(k)..at(k + 1)).filter(|r| !r.is_empty()).collect();
    }
    let mut runs = Vec::new();
    let (mut begin, mut sum, mut before) = (0, 0.0, 0.0);
    for (end, &cost) in (1..).zip(costs) {
        sum += sound(cost);
        let left = units - runs.len() as u32 - 1;
        // What is past its share is no part of the next; and where no more items are left than
        // runs, each has one of its own.
        let is_full = sum >= all * until(units - left) || (sum > before && count - end <= left);
        if left > 0 && is_full {
            runs.push(begin..end);
            (begin, before) = (end, sum);
        }
    }
    if begin < count {
        runs.push(begin..count);
    }
    runs
}

/// The numbers of a list in the order in which a share of it is worked on: its own first, then
/// those of others from the other end, for the others come from this one.
pub(super) fn own_first(own: Range<usize>, count: usize) -> impl Iterator<Item = usize> {
    own.clone().chain((own.end..count).chain(0..own.start).rev())
}

/// The numbers of items that cost so much, in the order in which share `[i, n]` of them is worked
/// on, with i from 0: its own, as [`split`] cuts them, the most costly first; then, unless
/// `only_own`, those of the others, for what they have not done by then.
#[must_use]
pub fn order_of_share(costs: &[f64], [share, shares]: [u32; 2], only_own: bool) -> Vec<usize> {
    let own = split(costs, shares).get(share as usize).cloned().unwrap_or_default();
    let own = own.start as usize..own.end as usize;
    let own_count = own.len();
    let most = if only_own { own_count } else { costs.len() };
    let mut order: Vec<usize> = own_first(own, costs.len()).take(most).collect();
    order[..own_count].sort_by(|&a, &b| costs[b].total_cmp(&costs[a]));
    order
}

/// Returns, from units that may overlap, those that are laid end to end from the first item on, the
/// longest first; and, in order, what is left between them.
#[must_use]
pub fn tile(mut have: Vec<Range<u32>>, count: u32) -> (Vec<Range<u32>>, Vec<Range<u32>>) {
    have.retain(|r| r.start < r.end && r.end <= count);
    have.sort_by_key(|r| (r.start, std::cmp::Reverse(r.end)));
    let (mut tiles, mut gaps) = (Vec::new(), Vec::new());
    let mut at = 0;
    for unit in have {
        if unit.start < at {
            continue;
        }
        if unit.start > at {
            gaps.push(at..unit.start);
        }
        at = unit.end;
        tiles.push(unit);
    }
    if at < count {
        gaps.push(at..count);
    }
    (tiles, gaps)
}

#[cfg(test)]
#[expect(clippy::single_range_in_vec_init, reason = "lists of ranges, some of one")]
mod tests {
    use super::*;

    #[test]
    fn runs_are_even_and_leave_nothing_out() {
        let costs: Vec<f64> = (0..1000).map(|k| f64::from(k * k % 97)).collect();
        let all: f64 = costs.iter().sum();
        for units in [1, 2, 7, 64, 999, 5000] {
            let runs = split(&costs, units);
            assert!(runs.len() <= units as usize);
            assert_eq!(runs.first().map(|r| r.start), Some(0));
            assert_eq!(runs.last().map(|r| r.end), Some(1000));
            assert!(runs.windows(2).all(|w| w[0].end == w[1].start));
            for run in runs {
                let cost: f64 = costs[run.start as usize..run.end as usize].iter().sum();
                assert!(!run.is_empty() && cost <= all / f64::from(units) + 96.0);
            }
        }
    }

    #[test]
    fn runs_become_smaller_and_leave_nothing_out() {
        let costs = vec![0.5; 10_000];
        for units in [1, 2, 8, 100] {
            let runs = taper(&costs, units);
            assert_eq!(runs.len(), units as usize);
            assert_eq!((runs[0].start, runs[runs.len() - 1].end), (0, 10_000));
            assert!(runs.windows(2).all(|w| w[0].end == w[1].start));
            assert!(runs.windows(2).all(|w| w[0].len() + 1 >= w[1].len()), "{units}: {runs:?}");
            if units > 1 {
                let (first, last) = (runs[0].len() as f64, runs[runs.len() - 1].len() as f64);
                assert!((7.0..9.0).contains(&(first / last)), "{units}: {first} {last}");
            }
        }
        assert_eq!(taper(&[], 3), []);
        assert_eq!(taper(&[1.0, 1.0], 9), [0..1, 1..2]);
        // One that costs all is by itself.
        assert_eq!(taper(&[0.0, 9.0, 0.0], 3), [0..2, 2..3]);
    }

    #[test]
    fn runs_of_nothing_known_are_of_equal_length() {
        for cost in [0.0, f64::NAN, f64::INFINITY, -3.0] {
            assert_eq!(split(&[cost; 6], 3), [0..2, 2..4, 4..6]);
        }
        assert_eq!(split(&[], 3), []);
        assert_eq!(split(&[1.0], 3), [0..1]);
        // One that costs all is by itself, and what follows is not lost.
        assert_eq!(split(&[0.0, 9.0, 0.0], 3), [0..2, 2..3]);
    }

    #[test]
    fn a_share_begins_with_its_own_and_meets_the_others() {
        let order = |own, count| own_first(own, count).collect::<Vec<_>>();
        assert_eq!(order(2..4, 6), [2, 3, 1, 0, 5, 4]);
        assert_eq!(order(0..0, 3), [2, 1, 0]);
        assert_eq!(order(0..3, 3), [0, 1, 2]);
        assert!(order(0..0, 0).is_empty());
        let costs = [1.0, 1.0, 1.0, 2.0, 1.0];
        assert_eq!(order_of_share(&costs, [1, 2], false), [3, 4, 2, 1, 0]);
        assert_eq!(order_of_share(&costs, [0, 2], true), [0, 1, 2]);
        assert_eq!(order_of_share(&costs, [0, 1], true), [3, 0, 1, 2, 4]);
        // More shares than items: some have none of their own.
        assert!(order_of_share(&[1.0], [5, 9], true).is_empty());
        assert_eq!(order_of_share(&[1.0], [5, 9], false), [0]);
    }

    #[test]
    fn units_of_several_splits_are_laid_end_to_end() {
        assert_eq!(tile(vec![], 4), (vec![], vec![0..4]));
        assert_eq!(tile(vec![0..2, 2..4], 4), (vec![0..2, 2..4], vec![]));
        assert_eq!(tile(vec![1..3, 0..1, 0..2, 3..9], 4), (vec![0..2], vec![2..4]));
        assert_eq!(tile(vec![3..4, 1..2, 2..2], 5), (vec![1..2, 3..4], vec![0..1, 2..3, 4..5]));
    }
}
