//! What a kind of culling gives back, as predicted and as found. Pure computation.

use serde::Serialize;

use super::elasticity::Elasticity;

/// What a kind of culling gives back of a frame, in percent of it; below 0 where it costs more than it saves.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Relief {
    /// The stage, or `all`.
    pub stage: String,
    /// By the elasticities, and the share of each link's work that it takes away.
    pub predicted_percent: f64,
    /// By frames with and without it.
    pub measured_percent: f64,
    /// Where the measured value lies in 95 of 100 draws of the rounds.
    pub interval_percent: [f64; 2],
}

impl Relief {
    /// Of a stage, from the work without and with it, and by how much of a frame it changed the time.
    #[must_use]
    pub fn new(
        stage: &str,
        elasticity: &[Elasticity; 4],
        (before, after): (&Work, &Work),
        change: &Elasticity,
    ) -> Self {
        let percent = |share: f64| share * 100.0;
        let [low, high] = change.interval;
        Self {
            stage: stage.to_owned(),
            predicted_percent: percent(predicted(elasticity, before, after)),
            measured_percent: percent(-change.value),
            interval_percent: [percent(-high), percent(-low)],
        }
    }

    /// By how many times frames are made faster, as measured.
    #[must_use]
    pub fn factor(&self) -> f64 {
        1.0 / (1.0 - self.measured_percent / 100.0).max(1e-3)
    }
}

/// Work that frames have of each link, in the order of [`Link::ALL`](super::Link::ALL): covered samples, hidden ones
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
    }

    #[test]
    fn what_goes_of_a_frame_is_how_many_times_faster_it_is() {
        let change = Elasticity { value: -0.5, interval: [-0.6, -0.4] };
        let found = Relief::new("frustum", &of([0.0; 4]), (&[1.0; 4], &[0.5; 4]), &change);
        assert_eq!(found.measured_percent, 50.0);
        assert_eq!(found.interval_percent, [40.0, 60.0]);
        assert_eq!(found.factor(), 2.0);
        assert_eq!(found.predicted_percent, 0.0);
    }
}
