//! The largest of many distances: their maximum, and the one that only a stated share exceeds.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// The largest of a known number of distances, of which a share may exceed the error that is
/// stated.
///
/// Distances up to the [`quantile`](Self::quantile) so far need not be known: they change neither
/// that, nor [`max`](Self::max), nor [`error`](Self::error). So a search may stop at the first
/// triangle that is not farther. Memory and time for as many distances as may exceed it, not for
/// all.
///
/// ```
/// use cullet_draw::surface::LargestDistances;
///
/// let mut largest = LargestDistances::new(1000, 0.001, 0.0);
/// (0..1000).for_each(|i| largest.push(i as f32));
/// assert_eq!((largest.quantile(), largest.max(), largest.error()), (998.0, 999.0, 998.0));
/// ```
#[derive(Clone, Debug)]
pub struct LargestDistances {
    /// Bits of distances that are not negative order as the distances do.
    kept: BinaryHeap<Reverse<u32>>,
    keep: usize,
    floor: f32,
    max: f32,
}

impl LargestDistances {
    /// For so many distances, of which a share (0 up to 1; 0.001 is usual) may exceed the quantile.
    /// Nothing is stated below the `floor`, such as the error of the level before.
    #[must_use]
    pub fn new(count: usize, share: f64, floor: f32) -> Self {
        let over = (count as f64 * share.clamp(0.0, 1.0)) as usize;
        // NaN is no floor either.
        let floor = floor.max(0.0);
        Self { kept: BinaryHeap::new(), keep: over.saturating_add(1), floor, max: 0.0 }
    }

    /// Takes a distance; one that is negative or NaN counts as 0.
    #[inline]
    pub fn push(&mut self, distance: f32) {
        let distance = distance.max(0.0);
        self.max = self.max.max(distance);
        let bits = Reverse(distance.to_bits());
        if self.kept.len() < self.keep {
            self.kept.push(bits);
        } else if let Some(mut least) = self.kept.peek_mut()
            && bits < *least
        {
            *least = bits;
        }
    }

    /// The largest distance but for the share that may exceed it, at least the floor. Where fewer
    /// distances came than may exceed it, that is the floor.
    #[must_use]
    #[inline]
    pub fn quantile(&self) -> f32 {
        let full = self.kept.len() >= self.keep;
        let least = self.kept.peek().filter(|_| full).map_or(0.0, |bits| f32::from_bits(bits.0));
        least.max(self.floor)
    }

    /// The largest distance of all; 0 where none came.
    #[must_use]
    #[inline]
    pub fn max(&self) -> f32 {
        self.max
    }

    /// Returns the error to state: at most the share of distances exceeds it, and none is more than
    /// twice as large.
    #[must_use]
    #[inline]
    pub fn error(&self) -> f32 {
        self.quantile().max(self.max * 0.5)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet_testkit::{Rng, cases};

    #[test]
    fn the_error_is_that_of_a_sorted_list_and_what_is_below_it_does_not_matter() {
        let mut rng = Rng(7);
        for case in 0..cases(300) {
            let count = rng.index(4000) + 1;
            let share = [0.0, 0.001, 0.01, 0.3][rng.index(4)];
            let floor = if rng.chance(0.5) { 0.0 } else { rng.range(0.0, 1.2) as f32 };
            // Some far outside of the rest, some equal.
            let mut distances: Vec<f32> = (0..count)
                .map(|_| {
                    let d = (rng.unit() * 100.0).round() / 100.0;
                    (if rng.chance(0.002) { d * 5.0 } else { d }) as f32
                })
                .collect();
            let mut all = LargestDistances::new(count, share, floor);
            let mut few = all.clone();
            for &d in &distances {
                all.push(d);
                if d > few.error() {
                    few.push(d);
                }
            }
            distances.sort_unstable_by(f32::total_cmp);
            let max = distances[count - 1];
            let over = (count as f64 * share) as usize;
            let quantile = distances[count - 1 - over].max(floor);
            assert_eq!((all.quantile(), all.max()), (quantile, max), "case {case}");
            assert_eq!(all.error(), quantile.max(max / 2.0), "case {case}");
            assert_eq!(few.error(), all.error(), "case {case}");
            assert!(distances.iter().filter(|&&d| d > all.error()).count() <= over);
        }
    }

    #[test]
    fn invalid_distances_count_as_none() {
        let mut largest = LargestDistances::new(3, f64::NAN, f32::NAN);
        [f32::NAN, -1.0, 0.25].into_iter().for_each(|d| largest.push(d));
        assert_eq!((largest.quantile(), largest.max(), largest.error()), (0.25, 0.25, 0.25));
        let none = LargestDistances::new(0, 0.5, 0.5);
        assert_eq!((none.quantile(), none.max(), none.error()), (0.5, 0.0, 0.5));
    }
}
