//! Rounds cut into units, and units that lie there laid end to end.

use std::ops::Range;

/// Cuts items into at most so many runs of nearly equal cost, in their order; none is empty. The most costly run is at most
/// an even share and one item above it. Where costs are zero or no numbers, runs of equal length.
#[must_use]
pub fn split(costs: &[f64], units: u32) -> Vec<Range<u32>> {
    let count = costs.len() as u32;
    let units = units.clamp(1, count.max(1));
    let sound = |c: f64| if c.is_finite() { c.max(0.0) } else { 0.0 };
    let all: f64 = costs.iter().map(|&c| sound(c)).sum();
    if all <= 0.0 || all.is_infinite() {
        let at = |k: u32| (u64::from(count) * u64::from(k) / u64::from(units)) as u32;
        return (0..units).map(|k| at(k)..at(k + 1)).filter(|r| !r.is_empty()).collect();
    }
    let mut runs = Vec::new();
    let (mut begin, mut sum) = (0, 0.0);
    for (end, &cost) in (1..).zip(costs) {
        sum += sound(cost);
        let made = runs.len() as u32;
        // What is past an even share is no part of the next.
        if made + 1 < units && sum >= all * f64::from(made + 1) / f64::from(units) {
            runs.push(begin..end);
            begin = end;
        }
    }
    if begin < count {
        runs.push(begin..count);
    }
    runs
}

/// Of units that may overlap those that are laid end to end from the first item on, the longest first; and, in order, what
/// is left between them.
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
    fn units_of_several_splits_are_laid_end_to_end() {
        assert_eq!(tile(vec![], 4), (vec![], vec![0..4]));
        assert_eq!(tile(vec![0..2, 2..4], 4), (vec![0..2, 2..4], vec![]));
        assert_eq!(tile(vec![1..3, 0..1, 0..2, 3..9], 4), (vec![0..2], vec![2..4]));
        assert_eq!(tile(vec![3..4, 1..2, 2..2], 5), (vec![1..2, 3..4], vec![0..1, 2..3, 4..5]));
    }
}
