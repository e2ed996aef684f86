//! Which occluders are worth drawing.

use std::cmp::Ordering;

use super::{Footprint, OcclusionBuffer, Shape};

/// How to find what is hidden.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct Occlusion {
    /// Pixels across the buffer; its height follows from the viewport. Never more than the viewport has. Half of the
    /// screen finds nearly as much as all of it, at a quarter of the cost; the answer is never wrong. Default 640.
    pub width: u32,
    /// What drawing occluders may cost, in microseconds of a cost model, not of a clock: so the same scene,
    /// view and budget give the same answer on every machine. 0 draws none. Half a millisecond finds most of
    /// what is hidden, even in a forest of a million things. Default 500.
    pub budget: f32,
}

impl Default for Occlusion {
    fn default() -> Self {
        Self { width: 640, budget: 500.0 }
    }
}

impl Occlusion {
    /// The size of the buffer for a viewport.
    #[must_use]
    pub fn size(&self, viewport: [u32; 2]) -> [u32; 2] {
        let [width, height] = viewport.map(|v| v.clamp(1, OcclusionBuffer::LIMIT));
        let columns = self.width.clamp(1, width);
        let rows = (u64::from(height) * u64::from(columns)).div_ceil(u64::from(width));
        [columns, (rows as u32).clamp(1, OcclusionBuffer::LIMIT)]
    }
}

/// A shape that may be drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Candidate {
    /// What may be behind it, in pixels.
    pub(crate) value: f32,
    /// How near it comes; infinite where it crosses the near plane.
    pub(crate) nearness: f32,
    pub(crate) slot: u32,
    pub(crate) shape: u32,
    /// Microseconds that drawing it is taken to cost.
    pub(crate) cost: f32,
    /// The pixels that it may touch; `None` where it crosses the near plane.
    pub(crate) footprint: Option<Footprint>,
}

impl Candidate {
    /// What may be behind it for what it costs.
    pub(crate) fn worth(&self) -> f32 {
        self.value / self.cost
    }

    /// The better one first; ties go by slot and shape.
    fn rank(&self, other: &Self) -> Ordering {
        let ties = || (self.slot, self.shape).cmp(&(other.slot, other.shape));
        other.worth().total_cmp(&self.worth()).then_with(ties)
    }
}

/// What drawing a shape costs.
///
/// Fitted to the fastest of eight draws of each of 13,700 shapes of the built-in forest, plant and city, at 640
/// pixels across: bodies of 21 to 114,000 pixels took 0.4 to 22 µs, patches 1.6 to 61 µs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Price {
    base: f32,
    per_pixel: f32,
}

impl Price {
    pub(super) fn of(shape: &Shape) -> Self {
        match shape {
            Shape::Convex(convex) => Self::of_convex(convex.edges.len()),
            Shape::Patch(patch) => Self::of_patch(patch.edges.len()),
        }
    }

    fn of_convex(edges: usize) -> Self {
        Self { base: 0.4 + 0.005 * edges as f32, per_pixel: 1e-4 }
    }

    fn of_patch(edges: usize) -> Self {
        // Triangles cost, those around it too, and there are two for three edges.
        Self { base: 1.0 + edges as f32 * 0.02, per_pixel: 2.4e-4 }
    }

    /// Of so many pixels, in microseconds. The root is for the outline.
    pub(crate) fn cost(self, pixels: f32) -> f32 {
        self.base + pixels.sqrt() * 0.03 + pixels * self.per_pixel
    }
}

/// The fewest edges of some shapes of each kind: none of them costs less than such a shape over as many pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Cheapest {
    convex: Option<usize>,
    patch: Option<usize>,
}

impl Cheapest {
    /// Of shapes that are not known.
    pub(crate) const ANY: Self = Self { convex: Some(0), patch: None };

    pub(super) fn of(shapes: &[Shape]) -> Self {
        let edges = |of: fn(&Shape) -> Option<usize>| shapes.iter().filter_map(of).min();
        Self {
            convex: edges(|s| match s {
                Shape::Convex(convex) => Some(convex.edges.len()),
                Shape::Patch(_) => None,
            }),
            patch: edges(|s| match s {
                Shape::Patch(patch) => Some(patch.edges.len()),
                Shape::Convex(_) => None,
            }),
        }
    }

    /// Of both.
    pub(crate) fn or(self, other: Self) -> Self {
        let least = |a: Option<usize>, b: Option<usize>| a.into_iter().chain(b).min();
        Self { convex: least(self.convex, other.convex), patch: least(self.patch, other.patch) }
    }

    /// No shape of at most such a value is worth more, where no pixel has more than `densest` of it. (Pixels
    /// rise faster than their cost, so that a smaller shape is worth less; the bound is raised by more than
    /// what rounding does to either.)
    pub(crate) fn worth(self, value: f32, densest: f32) -> f32 {
        let fewest = value / densest;
        let convex = self.convex.map_or(0.0, |edges| value / Price::of_convex(edges).cost(fewest));
        let patch = self.patch.map_or(0.0, |edges| value / Price::of_patch(edges).cost(fewest));
        convex.max(patch) * (1.0 + 1e-5)
    }

    /// What is of less value is worth less than `least_worth`: a little less than the least that is not, so
    /// that most can be refused without a root and a division.
    pub(crate) fn least_value(self, least_worth: f32, densest: f32) -> f32 {
        let (mut low, mut high) = (0.0, 1e12);
        // Half a step of a thousandth in 12 + 3 decades.
        while high > low * 1.001 + 1e-3 {
            let middle = (low + high) * 0.5;
            if self.worth(middle, densest) < least_worth {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    }
}

/// The candidates that cover most for their cost, as far as a budget goes.
///
/// The answer is that of sorting all by their worth and taking them until the budget is spent; but as soon as
/// what was found spends it, what is worth less than the first that cannot be paid for is refused, and need not
/// be looked at: better ones can but push it further back.
#[derive(Clone, Debug, Default)]
pub(crate) struct Choice {
    found: Vec<Candidate>,
    budget: f32,
    /// What is worth less is refused.
    least_worth: f32,
    /// The cost of what was found, and where it is looked through again.
    cost: f64,
    limit: f64,
    offered: u64,
    /// Not all that was found can be paid for.
    is_short: bool,
}

impl Choice {
    /// Forgets all, but for the memory.
    pub(crate) fn begin(&mut self, budget: f32) {
        self.found.clear();
        (self.budget, self.least_worth, self.offered) = (budget, 0.0, 0);
        (self.cost, self.limit) = (0.0, f64::from(budget));
        self.is_short = false;
    }

    /// What is worth less is refused.
    pub(crate) fn least_worth(&self) -> f32 {
        self.least_worth
    }

    /// Whether what is worth so much at most may be chosen.
    pub(crate) fn may_take(&self, worth: f32) -> bool {
        worth >= self.least_worth
    }

    pub(crate) fn offer(&mut self, candidate: Candidate) {
        self.offered += 1;
        if self.may_take(candidate.worth()) {
            self.found.push(candidate);
            self.cost += f64::from(candidate.cost);
            if self.cost > self.limit {
                self.spend();
                // Half more than what is left, so that sorting is paid for by what is new, and yet what is
                // refused is known soon.
                self.cost = self.found.iter().map(|c| f64::from(c.cost)).sum();
                self.limit = self.cost * 1.5;
            }
        }
    }

    /// How many were offered.
    pub(crate) fn offered(&self) -> u64 {
        self.offered
    }

    /// Whether more would have been [chosen](Self::chosen) for more, as far as it looked.
    pub(crate) fn is_short(&self) -> bool {
        self.is_short
    }

    /// Sorts, and drops what cannot be paid for.
    fn spend(&mut self) {
        self.found.sort_unstable_by(Candidate::rank);
        let (budget, mut spent) = (self.budget, 0.0);
        let count = self.found.iter().take_while(|c| {
            spent += c.cost;
            spent <= budget
        });
        let count = count.count();
        if let Some(first) = self.found.get(count) {
            self.least_worth = first.worth();
            self.is_short = true;
        }
        // The first that cannot be paid for stays: what follows is refused for its sake, whatever comes.
        self.found.truncate(count + 1);
    }

    /// The chosen ones, front to back.
    pub(crate) fn chosen(&mut self) -> &[Candidate] {
        // Where all can be paid for, with more to spare than the rounding of any sum, which are better is no matter.
        if !(self.found.len() < 100_000 && self.cost * 1.01 <= f64::from(self.budget)) {
            self.spend();
            let (budget, mut spent) = (self.budget, 0.0);
            self.found.retain(|c| {
                spent += c.cost;
                spent <= budget
            });
        }
        self.found.sort_unstable_by(|a, b| {
            b.nearness.total_cmp(&a.nearness).then((a.slot, a.shape).cmp(&(b.slot, b.shape)))
        });
        &self.found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_budget_buys_what_covers_most_and_order_does_not_matter() {
        let candidate = |slot: u32, value: f32, nearness: f32| Candidate {
            value,
            nearness,
            slot,
            shape: 0,
            cost: 1.0,
            footprint: None,
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
            list.into_iter().for_each(|c| choice.offer(c));
            choice.chosen().iter().map(|c| c.slot).collect::<Vec<_>>()
        };
        assert_eq!(slots(all.to_vec(), 3.0), [2, 3, 1]);
        assert_eq!(slots(all.iter().rev().copied().collect(), 3.0), [2, 3, 1]);
        assert_eq!(slots(all.to_vec(), 0.0), []);
        assert_eq!(slots(all.to_vec(), f32::NAN), []);
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
                .map(|slot| Candidate {
                    value: random(500) as f32,
                    nearness: 1.0,
                    slot,
                    shape: random(3),
                    cost: 0.2 + random(20) as f32 * 0.31,
                    footprint: None,
                })
                .collect();
            let mut sorted = all.clone();
            sorted.sort_by(Candidate::rank);
            let mut spent = 0.0;
            let expected = sorted.iter().take_while(|c| {
                spent += c.cost;
                spent <= budget
            });
            let mut expected: Vec<_> = expected.map(|c| c.slot).collect();
            expected.sort_unstable();
            let mut choice = Choice::default();
            choice.begin(budget);
            let mut refused = 0;
            for c in all {
                refused += usize::from(!choice.may_take(c.worth()));
                choice.offer(c);
            }
            assert_eq!(choice.chosen().iter().map(|c| c.slot).collect::<Vec<_>>(), expected);
            assert_eq!(refused > 1500, budget < 1000.0, "{refused} of {budget}");
        }
    }

    #[test]
    fn no_shape_is_worth_more_than_the_bound_of_larger_ones() {
        for edges in [0, 3, 12, 300] {
            for [convex, patch] in [[Some(edges), None], [None, Some(edges)]] {
                let bound = Cheapest { convex, patch };
                for pixels in (0..2000).map(|i| (i * i) as f32 * 0.37) {
                    let cost = match patch {
                        Some(edges) => Price::of_patch(edges + 2).cost(pixels),
                        None => Price::of_convex(edges + 2).cost(pixels),
                    };
                    for larger in [pixels, pixels + 1.0, pixels * 9.0] {
                        // A pixel has at most thrice the mean, and this shape has less.
                        for density in [1.0, 0.3, 3.0] {
                            let (worth, larger) = (pixels * density / cost, larger * density);
                            assert!(worth <= bound.or(Cheapest::ANY).worth(larger, 3.0));
                            assert!(worth <= bound.worth(larger, 3.0), "{pixels} of {edges}");
                        }
                    }
                }
            }
        }
        let of = Cheapest { convex: Some(12), patch: Some(90) };
        for least_worth in [0.0, 1e-3, 7.0, 900.0] {
            let least = of.least_value(least_worth, 3.0);
            assert!(least == 0.0 || of.worth(least, 3.0) < least_worth);
            assert!(of.worth(least * 1.01 + 0.01, 3.0) >= least_worth);
        }
        // What nothing is worth, a value without end is not.
        assert!(of.least_value(1e9, 3.0) > 1e11);
        assert_eq!(Cheapest::default().worth(1e6, 1.0), 0.0);
    }

    #[test]
    fn sizes_follow_the_viewport() {
        let of = |width| Occlusion { width, ..Occlusion::default() };
        assert_eq!(of(640).size([1280, 720]), [640, 360]);
        assert_eq!(of(640).size([320, 33]), [320, 33]);
        assert_eq!(of(0).size([1280, 720]), [1, 1]);
        assert_eq!(of(7).size([65536, 65536]), [7, 7]);
    }
}
