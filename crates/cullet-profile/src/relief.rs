//! What a kind of culling gives back, as predicted and as found. Pure computation.

use serde::Serialize;

use super::elasticity::Elasticity;

/// What a stage of culling gives back of a frame, in percent of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Relief {
    /// The stage.
    pub stage: String,
    /// By the elasticities, and the share of each link's work that the stage takes away.
    pub predicted_percent: f64,
    /// By frames with and without it.
    pub measured_percent: f64,
}

/// Work that frames have of each link, in the order of [`Link::ALL`](super::link::Link::ALL), in any units: covered samples, hidden ones
/// too; triangles; bytes; seconds.
pub type Work = [f64; 4];

/// The share of a frame that goes if its work falls from `before` to `after`: Σ s (1 − after / before). Below 0 where work is added. A link
/// without work before counts nothing.
#[must_use]
pub fn predicted(elasticity: &[Elasticity; 4], before: &Work, after: &Work) -> f64 {
    let of = |((own, before), after): ((&Elasticity, &f64), &f64)| {
        if *before > 0.0 { own.value * (1.0 - after / before) } else { 0.0 }
    };
    elasticity.iter().zip(before).zip(after).map(of).sum()
}

/// The share of a frame that went, by its time before and after.
#[must_use]
pub fn measured(before_ms: f64, after_ms: f64) -> f64 {
    if before_ms > 0.0 { 1.0 - after_ms / before_ms } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(values: [f64; 4]) -> [Elasticity; 4] {
        values.map(|value| Elasticity { value, interval: [value; 2] })
    }

    #[test]
    fn what_a_link_loses_counts_as_much_as_the_frame_waits_for_it() {
        let s = of([0.6, 0.3, 0.0, 0.1]);
        let before = [100.0, 10.0, 5.0, 1.0];
        assert_eq!(predicted(&s, &before, &before), 0.0);
        assert!((predicted(&s, &before, &[50.0, 10.0, 0.0, 1.0]) - 0.3).abs() < 1e-12);
        // Culling costs the program something.
        assert!((predicted(&s, &before, &[100.0, 10.0, 5.0, 3.0]) + 0.2).abs() < 1e-12);
        assert_eq!(predicted(&s, &[0.0; 4], &[1.0; 4]), 0.0);
        assert_eq!(measured(10.0, 4.0), 0.6);
        assert_eq!(measured(0.0, 4.0), 0.0);
    }
}
