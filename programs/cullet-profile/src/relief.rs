//! Gain of a kind of culling, as predicted and as found. Pure computation.

use serde::Serialize;

use super::elasticity::Elasticity;
use super::link::Way;
use super::measure::Times;

/// Gain of a kind of culling, in percent of a frame; below 0 where it costs more than it saves.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Relief {
    /// The stage, or `all`.
    pub stage: String,
    /// Percent predicted from the elasticities, and from the share of each link's work that it
    /// takes away.
    pub predicted_percent: f64,
    /// Percent measured by frames with and without it.
    pub measured_percent: f64,
    /// Where the measured value lies in 95 of 100 draws of the rounds.
    pub interval_percent: [f64; 2],
}

impl Relief {
    /// Computes the relief of a stage from what frames wait for without it, the work without and
    /// with it, and the relative change of a frame's time.
    #[must_use]
    pub fn new(
        stage: &str,
        waits: &Waits,
        (before, after): (&Work, &Work),
        change: &Elasticity,
    ) -> Self {
        let percent = |share: f64| share * 100.0;
        let [low, high] = change.interval;
        Self {
            stage: stage.to_owned(),
            predicted_percent: percent(predicted(waits, before, after)),
            measured_percent: percent(-change.value),
            interval_percent: [percent(-high), percent(-low)],
        }
    }

    /// Returns the measured factor by which frames become faster.
    #[must_use]
    pub fn factor(&self) -> f64 {
        1.0 / (1.0 - self.measured_percent / 100.0).max(1e-3)
    }
}

/// Work of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Work {
    /// Covered samples, hidden ones too: work of [`Link::Fill`](super::Link::Fill).
    pub samples: f64,
    /// Triangles that reach the screen, for which a device sets up where their edges run: work of
    /// the transform, as those that follow are.
    pub on_screen: f64,
    /// Triangles that are drawn, each with its vertices.
    pub triangles: f64,
    /// Bytes that are uploaded.
    pub bytes: f64,
    /// Seconds of the program, to cull and to record.
    pub seconds: f64,
}

impl Work {
    /// The sum of two.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            samples: self.samples + other.samples,
            on_screen: self.on_screen + other.on_screen,
            triangles: self.triangles + other.triangles,
            bytes: self.bytes + other.bytes,
            seconds: self.seconds + other.seconds,
        }
    }

    /// So many times as much.
    #[must_use]
    pub fn times(&self, by: f64) -> Self {
        Self {
            samples: self.samples * by,
            on_screen: self.on_screen * by,
            triangles: self.triangles * by,
            bytes: self.bytes * by,
            seconds: self.seconds * by,
        }
    }
}

/// How long frames take, and how much they wait for each kind of work.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Waits {
    /// Seconds a frame.
    pub seconds: f64,
    /// The elasticity of filling.
    pub fill: f64,
    /// Share of setting up triangles that reach the screen.
    pub set_up: f64,
    /// Share of transforming vertices, without the set-up.
    pub vertices: f64,
    /// Share of uploads.
    pub bus: f64,
    /// Share of the program.
    pub cpu: f64,
}

impl Waits {
    /// Returns the waits as measured.
    #[must_use]
    pub fn of(times: &Times) -> Self {
        let [fill, transform, bus, cpu] = times.elasticities().map(|e| e.value);
        let transform = transform.max(0.0);
        let set_up = times.set_up().value.clamp(0.0, transform);
        let seconds = times.seconds(Way::Plain);
        Self { seconds, fill, set_up, vertices: transform - set_up, bus, cpu }
    }
}

/// The share of a frame that goes if its work falls from `before` to `after`: Σ s (1 − after /
/// before). Below 0 where work is added. Work that was none before counts nothing.
///
/// Elasticities are taken as at least 0, and that of the program as no more than its share of the
/// frame: what it does more of by many times would turn the error of a small one into a large one.
/// Where they come to more than a whole frame, as where a triangle that is drawn again takes some
/// of the time that its pixels take, they are shares of their sum.
#[must_use]
pub fn predicted(waits: &Waits, before: &Work, after: &Work) -> f64 {
    let Waits { seconds, fill, set_up, vertices, bus, cpu } = *waits;
    let own = if seconds > 0.0 { before.seconds / seconds } else { 0.0 };
    let links = [
        (fill, before.samples, after.samples),
        (set_up, before.on_screen, after.on_screen),
        (vertices, before.triangles, after.triangles),
        (bus, before.bytes, after.bytes),
        (cpu.min(own), before.seconds, after.seconds),
    ];
    let links = links.map(|(wait, before, after)| (wait.clamp(0.0, 1.0), before, after));
    let sum: f64 = links.iter().map(|(wait, ..)| wait).sum();
    let falls = |(wait, before, after): (f64, f64, f64)| {
        if before > 0.0 { wait * (1.0 - after / before) } else { 0.0 }
    };
    links.into_iter().map(falls).sum::<f64>() / sum.max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const WAITS: Waits =
        Waits { seconds: 8.0, fill: 0.6, set_up: 0.2, vertices: 0.1, bus: 0.0, cpu: 0.1 };
    const BEFORE: Work =
        Work { samples: 100.0, on_screen: 6.0, triangles: 10.0, bytes: 5.0, seconds: 1.0 };

    #[test]
    fn what_a_link_loses_counts_as_much_as_the_frame_waits_for_it() {
        let falls = |after: Work| predicted(&WAITS, &BEFORE, &after);
        assert_eq!(falls(BEFORE), 0.0);
        assert!((falls(Work { samples: 50.0, bytes: 0.0, ..BEFORE }) - 0.3).abs() < 1e-12);
        assert!((falls(Work { triangles: 5.0, ..BEFORE }) - 0.05).abs() < 1e-12);
        assert!((falls(Work { on_screen: 3.0, ..BEFORE }) - 0.1).abs() < 1e-12);
        // Culling costs the program something.
        assert!((falls(Work { seconds: 3.0, ..BEFORE }) + 0.2).abs() < 1e-12);
        assert_eq!(predicted(&WAITS, &Work::default(), &BEFORE), 0.0);
    }

    #[test]
    fn no_more_than_all_of_a_frame_can_go() {
        let waits = Waits { fill: 0.9, set_up: 0.7, vertices: 0.4, ..WAITS };
        let nothing = Work { seconds: BEFORE.seconds, ..Work::default() };
        let goes = predicted(&waits, &BEFORE, &nothing);
        assert!(0.9 < goes && goes <= 1.0, "{goes}");
    }

    #[test]
    fn the_error_of_a_small_elasticity_is_not_made_large() {
        let before = Work { seconds: 1e-3, ..BEFORE };
        let after = Work { seconds: 1.0, ..BEFORE };
        let cost = |cpu: f64| {
            predicted(&Waits { seconds: 10.0, cpu, ..Waits::default() }, &before, &after)
        };
        // A second more of ten at the most.
        assert!((cost(0.05) + 0.0999).abs() < 1e-9, "{}", cost(0.05));
        assert_eq!(cost(-0.05), 0.0);
    }

    #[test]
    fn what_goes_of_a_frame_is_how_many_times_faster_it_is() {
        let change = Elasticity { value: -0.5, interval: [-0.6, -0.4] };
        let found = Relief::new("frustum", &Waits::default(), (&BEFORE, &BEFORE), &change);
        assert_eq!(found.measured_percent, 50.0);
        assert_eq!(found.interval_percent, [40.0, 60.0]);
        assert_eq!(found.factor(), 2.0);
        assert_eq!(found.predicted_percent, 0.0);
    }
}
