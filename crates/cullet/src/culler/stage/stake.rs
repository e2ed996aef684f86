//! Stakes: how much occlusion may cost, and how much it saves.
//!
//! Nobody knows before drawing what is hidden. So little is spent first, a share of what the frame
//! would cost to draw without; then some of what is left is tested, and as long as that shows that
//! much is hidden, a fifth of what it saves is spent on more. A frame in which nothing is hidden is
//! slower by the first share alone, and one that costs next to nothing to draw is left alone.

use crate::array::Each;
use crate::costs::Costs;
use crate::cull::occlusion::Occlusion;

/// Share of what is saved that is spent to save more.
const RETURN: f32 = 0.2;

/// How much may be spent, in microseconds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stake {
    /// At the most, whatever is saved.
    limit: f32,
    /// Before anything is known to be hidden.
    first: f32,
    /// Cost of drawing all that is left.
    draw: f32,
    /// Cost of testing all that is left.
    tests: f32,
}

impl Stake {
    /// Creates the stake of a frame in which `instances` are left, with about `triangles` triangles
    /// to draw. Looking for occluders takes `look_ns` nanoseconds, and testing takes `test_ns`.
    pub(super) fn new(
        settings: &Occlusion,
        costs: &Costs,
        [instances, triangles]: [f64; 2],
        [look_ns, test_ns]: [f64; 2],
    ) -> Self {
        let ns = costs.draw_ns * instances + costs.opaque_triangle_ns * triangles;
        let [draw, look, tests] = [ns, look_ns, test_ns].each(|ns| (ns * 1e-3) as f32);
        let first = settings.risk.map_or(f32::INFINITY, |risk| draw * risk - look);
        Self { limit: settings.budget, first, draw, tests }
    }

    /// Whether hiding such a share saves more than finding out what it is.
    pub(super) fn pays_for_tests(&self, hidden: f32) -> bool {
        !self.is_limited() || self.saved(hidden) > self.tests
    }

    /// Returns what hiding the share `hidden` saves, in microseconds.
    pub(super) fn saved(&self, hidden: f32) -> f32 {
        self.draw * hidden
    }

    /// Whether there is nothing to be gained.
    pub(super) fn is_nothing(&self) -> bool {
        self.first <= 0.0
    }

    /// Whether less may be spent than the budget.
    pub(super) fn is_limited(&self) -> bool {
        self.first < self.limit
    }

    /// Returns how many microseconds may be spent on drawing occluders where the share `hidden` is
    /// known to be hidden. It is no more than the limit, and 0 for a limit that is not above 0.
    pub(super) fn budget(&self, hidden: f32) -> f32 {
        // A limit of NaN is none to be spent.
        if self.limit > 0.0 {
            (self.first + self.draw * hidden * RETURN).min(self.limit)
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_spent_on_what_costs_nothing_and_more_where_more_is_saved() {
        let costs = Costs::default();
        let settings = Occlusion { risk: Some(0.025), budget: 500.0, ..Occlusion::default() };
        assert!(Stake::new(&settings, &costs, [10.0, 1e3], [5e3, 1e3]).is_nothing());
        let stake = Stake::new(&settings, &costs, [2e3, 2e5], [4e4, 2e4]);
        assert!(!stake.is_nothing() && stake.is_limited());
        // 4 ms to draw: 2.5 % of them, without what tests cost.
        assert!((60.0..100.1).contains(&stake.budget(0.0)), "{stake:?}");
        assert_eq!(stake.budget(0.25), stake.budget(0.0) + 200.0);
        assert_eq!(stake.budget(1.0), settings.budget);
        assert!(stake.pays_for_tests(0.25) && !stake.pays_for_tests(0.004));
        let always = Stake::new(&Occlusion::default(), &costs, [1.0, 100.0], [5e3, 1e3]);
        assert!(!always.is_nothing() && !always.is_limited());
        assert!(always.pays_for_tests(0.0));
        assert_eq!(always.budget(0.0), Occlusion::default().budget);
    }
}
