//! What a kind of culling gives back, as predicted and as found. Pure computation.

use serde::Serialize;

use super::elasticity::Elasticity;
use super::link::Link;

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
    /// Of a stage, from the elasticities and seconds of frames without it, the work without and with it, and by how much of a frame it changed the time.
    #[must_use]
    pub fn new(
        stage: &str,
        (elasticity, seconds): (&[Elasticity; 4], f64),
        (before, after): (&Work, &Work),
        change: &Elasticity,
    ) -> Self {
        let percent = |share: f64| share * 100.0;
        let [low, high] = change.interval;
        Self {
            stage: stage.to_owned(),
            predicted_percent: percent(predicted(elasticity, seconds, before, after)),
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

/// The share of a frame of so many `seconds` that goes if its work falls from `before` to `after`: Σ s (1 − after / before). Below 0 where
/// work is added. A link without work before counts nothing.
///
/// Elasticities are taken as at least 0, and that of the program as no more than its share of the frame: what it does more of by many times
/// would turn the error of a small one into a large one.
#[must_use]
pub fn predicted(elasticity: &[Elasticity; 4], seconds: f64, before: &Work, after: &Work) -> f64 {
    let cpu = Link::Cpu as usize;
    let most = |link: usize| match link {
        _ if link != cpu => 1.0,
        _ if seconds > 0.0 => (before[cpu] / seconds).min(1.0),
        _ => 0.0,
    };
    let of = |link: usize| {
        let own = elasticity[link].value.clamp(0.0, most(link));
        if before[link] > 0.0 { own * (1.0 - after[link] / before[link]) } else { 0.0 }
    };
    (0..before.len()).map(of).sum()
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
        let falls = |to: [f64; 4]| predicted(&s, 8.0, &before, &to);
        assert_eq!(falls(before), 0.0);
        assert!((falls([50.0, 10.0, 0.0, 1.0]) - 0.3).abs() < 1e-12);
        // Culling costs the program something.
        assert!((falls([100.0, 10.0, 5.0, 3.0]) + 0.2).abs() < 1e-12);
        assert_eq!(predicted(&s, 8.0, &[0.0; 4], &[1.0; 4]), 0.0);
    }

    #[test]
    fn the_error_of_a_small_elasticity_is_not_made_large() {
        let before = [1.0, 1.0, 1.0, 1e-3];
        let after = [1.0, 1.0, 1.0, 1.0];
        let cost = |s: f64| predicted(&of([0.0, 0.0, 0.0, s]), 10.0, &before, &after);
        // A second more of ten at the most.
        assert!((cost(0.05) + 0.0999).abs() < 1e-9, "{}", cost(0.05));
        assert_eq!(cost(-0.05), 0.0);
    }

    #[test]
    fn what_goes_of_a_frame_is_how_many_times_faster_it_is() {
        let change = Elasticity { value: -0.5, interval: [-0.6, -0.4] };
        let found = Relief::new("frustum", (&of([0.0; 4]), 1.0), (&[1.0; 4], &[0.5; 4]), &change);
        assert_eq!(found.measured_percent, 50.0);
        assert_eq!(found.interval_percent, [40.0, 60.0]);
        assert_eq!(found.factor(), 2.0);
        assert_eq!(found.predicted_percent, 0.0);
    }
}
