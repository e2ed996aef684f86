//! Choice of the candidates that cover most for their cost, within a budget.

use alloc::vec::Vec;

use super::super::raster::ScreenBounds;
use crate::sort::{Sorter, of_f32, pair};

/// Candidate shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Candidate {
    /// Value for its cost, of pixels that may be behind it, of mean density.
    pub(crate) score: f32,
    /// How near it comes; infinite where it crosses the near plane.
    pub(crate) nearness: f32,
    pub(crate) slot: u32,
    pub(crate) shape: u32,
    /// Cost of drawing it, in microseconds of the model.
    pub(crate) cost: f32,
    /// The pixels that it may touch; `None` where it crosses the near plane.
    pub(crate) bounds: Option<ScreenBounds>,
}

impl Candidate {
    /// Key to sort by: the nearer one first; ties go by slot and shape.
    pub(crate) fn by_nearness(&self) -> u128 {
        u128::from(!of_f32(self.nearness)) << 64 | pair(self.slot, self.shape)
    }

    /// Key to sort by: the better one first; ties go by slot and shape.
    fn by_score(&self) -> u128 {
        u128::from(!of_f32(self.score)) << 64 | pair(self.slot, self.shape)
    }
}

/// The candidates that cover most for their cost, as far as a budget goes.
///
/// The answer is that of sorting all by their score and taking them until the budget is used up;
/// but as soon as what was found uses it up, what has a lower score than the first that is over the
/// budget is refused, and need not be looked at: better ones can but push it further back.
#[derive(Clone, Debug, Default)]
pub(crate) struct Choice {
    found: Vec<Candidate>,
    budget: f32,
    /// A lower score is refused.
    least_score: f32,
    /// The cost of what was found, and where it is looked through again.
    cost: f64,
    limit: f64,
    considered: u64,
    /// Not all that was found is within the budget.
    is_short: bool,
    sorter: Sorter,
}

impl Choice {
    /// Forgets all, but for the memory.
    pub(crate) fn begin(&mut self, budget: f32) {
        self.found.clear();
        (self.budget, self.least_score, self.considered) = (budget, 0.0, 0);
        (self.cost, self.limit) = (0.0, f64::from(budget));
        self.is_short = false;
    }

    /// A lower score is refused.
    pub(crate) fn least_score(&self) -> f32 {
        self.least_score
    }

    /// Whether what has at most such a score may be chosen.
    pub(crate) fn may_take(&self, score: f32) -> bool {
        score >= self.least_score
    }

    /// Takes note of a candidate.
    pub(crate) fn consider(&mut self, candidate: Candidate) {
        self.considered += 1;
        if self.may_take(candidate.score) {
            self.found.push(candidate);
            self.cost += f64::from(candidate.cost);
            if self.cost > self.limit {
                self.cut();
                // Half more than what is left, so that sorting is rare beside what is new, and yet
                // what is refused is known soon.
                self.cost = self.found.iter().map(|c| f64::from(c.cost)).sum();
                self.limit = self.cost * 1.5;
            }
        }
    }

    /// How many were considered.
    pub(crate) fn considered(&self) -> u64 {
        self.considered
    }

    /// Whether more would be [ranked](Self::ranked) with more to spend, as far as it looked.
    pub(crate) fn is_short(&self) -> bool {
        self.is_short
    }

    /// Sorts, and drops what is over the budget.
    fn cut(&mut self) {
        self.sorter.sort(&mut self.found, Candidate::by_score);
        let (budget, mut sum) = (self.budget, 0.0);
        let count = self.found.iter().take_while(|c| {
            sum += c.cost;
            sum <= budget
        });
        let count = count.count();
        if let Some(first) = self.found.get(count) {
            self.least_score = first.score;
            self.is_short = true;
        }
        // The first that is over the budget stays: what follows is refused for its sake, whatever
        // comes.
        self.found.truncate(count + 1);
    }

    /// Drops the candidates that are over the budget. Returns the others, the better one first.
    pub(crate) fn ranked(&mut self) -> &[Candidate] {
        self.cut();
        let (budget, mut sum) = (self.budget, 0.0);
        self.found.retain(|c| {
            sum += c.cost;
            sum <= budget
        });
        &self.found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_budget_goes_to_what_covers_most_and_order_does_not_matter() {
        let candidate = |slot: u32, value: f32, nearness: f32| Candidate {
            score: value,
            nearness,
            slot,
            shape: 0,
            cost: 1.0,
            bounds: None,
        };
        let all = [
            candidate(0, 10.0, 0.1),
            candidate(1, 500.0, 0.2),
            candidate(2, 500.0, f32::INFINITY),
            candidate(3, 90.0, 0.9),
        ];
        let slots = |list: Vec<Candidate>, budget| {
            let mut choice = Choice::default();
            choice.begin(budget);
            list.into_iter().for_each(|c| choice.consider(c));
            choice.ranked().iter().map(|c| c.slot).collect::<Vec<_>>()
        };
        assert_eq!(slots(all.to_vec(), 3.0), [1, 2, 3]);
        assert_eq!(slots(all.iter().rev().copied().collect(), 3.0), [1, 2, 3]);
        assert!(slots(all.to_vec(), 0.0).is_empty());
        assert!(slots(all.to_vec(), f32::NAN).is_empty());
        assert_eq!(slots(all.to_vec(), 1e9).len(), 4);
    }

    #[test]
    fn what_is_refused_on_the_way_would_not_have_been_chosen() {
        let mut state = 1_u32;
        let mut random = |below: u32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) % below
        };
        for budget in [0.5, 3.0, 40.0, 400.0, 1e5] {
            let all: Vec<_> = (0..3000)
                .map(|slot| {
                    let (value, shape) = (random(500) as f32, random(3));
                    let cost = 0.2 + random(20) as f32 * 0.31;
                    Candidate {
                        score: value / cost,
                        nearness: 1.0,
                        slot,
                        shape,
                        cost,
                        bounds: None,
                    }
                })
                .collect();
            let mut sorted = all.clone();
            sorted.sort_by(|a, b| {
                b.score.total_cmp(&a.score).then((a.slot, a.shape).cmp(&(b.slot, b.shape)))
            });
            let mut sum = 0.0;
            let expected = sorted.iter().take_while(|c| {
                sum += c.cost;
                sum <= budget
            });
            let expected: Vec<_> = expected.map(|c| c.slot).collect();
            let mut choice = Choice::default();
            choice.begin(budget);
            let mut refused = 0;
            for c in all {
                refused += usize::from(!choice.may_take(c.score));
                choice.consider(c);
            }
            assert_eq!(choice.ranked().iter().map(|c| c.slot).collect::<Vec<_>>(), expected);
            assert_eq!(refused > 1500, budget < 1000.0, "{refused} of {budget}");
        }
    }
}
