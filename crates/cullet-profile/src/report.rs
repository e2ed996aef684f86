//! What a profile says, for people and for programs.

use std::fmt::Write as _;

use serde::Serialize;

use super::elasticity::limit;
use super::link::Link;
use super::measure::Measured;
use super::relief::Relief;

/// A profile of a frame. As JSON it is what `--json` writes.
#[derive(Clone, Debug, Serialize)]
pub struct Profile {
    /// The version of this form.
    pub schema: u32,
    /// The device.
    pub adapter: String,
    /// The link that the frame waits for, or `mixed`.
    pub limit: String,
    /// Milliseconds a frame.
    pub frame_ms: f64,
    /// By link.
    pub elasticity: ByLink<f64>,
    /// Intervals of these.
    pub interval: ByLink<[f64; 2]>,
    /// By stage of culling.
    pub relief: Vec<Relief>,
}

/// Something of each link.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[allow(missing_docs, reason = "named as the links are")]
pub struct ByLink<T> {
    pub fill: T,
    pub transform: T,
    pub bus: T,
    pub cpu: T,
}

impl<T> ByLink<T> {
    fn new([fill, transform, bus, cpu]: [T; 4]) -> Self {
        Self { fill, transform, bus, cpu }
    }
}

impl Profile {
    /// Of what was measured on a device.
    #[must_use]
    pub fn new(adapter: String, found: &Measured, relief: Vec<Relief>) -> Self {
        let name = limit(&found.elasticity).map_or("mixed", Link::name);
        Self {
            schema: 1,
            adapter,
            limit: name.to_owned(),
            frame_ms: found.frame_ms,
            elasticity: ByLink::new(found.elasticity.map(|e| e.value)),
            interval: ByLink::new(found.elasticity.map(|e| e.interval)),
            relief,
        }
    }

    /// In words: the chain with a bar for each link, the link that is waited for, and what culling gives.
    #[must_use]
    pub fn to_text(&self, is_software: bool) -> String {
        let mut out = String::new();
        let ByLink { fill, transform, bus, cpu } = self.elasticity;
        let values = [fill, transform, bus, cpu];
        let intervals =
            [self.interval.fill, self.interval.transform, self.interval.bus, self.interval.cpu];
        let _ = writeln!(out, "{:.2} ms a frame on {}", self.frame_ms, self.adapter);
        // As the work goes.
        for at in [3, 2, 1, 0] {
            let bar = "█".repeat((values[at].clamp(0.0, 1.0) * 20.0).round() as usize);
            let [low, high] = intervals[at];
            let name = Link::ALL[at].name();
            let _ =
                writeln!(out, "  {name:9} {bar:20} {:5.2}  ({low:.2} to {high:.2})", values[at]);
        }
        let _ = match self.limit.as_str() {
            "mixed" => writeln!(
                out,
                "no link stands out: the frame waits for several, or for something else"
            ),
            name => writeln!(out, "the frame waits for: {name}"),
        };
        if is_software {
            let _ = writeln!(
                out,
                "this device is a program: it computes vertices and pixels on the processor, and its bus is memory"
            );
        }
        for own in &self.relief {
            let factor = 1.0 / (1.0 - own.measured_percent / 100.0).max(0.01);
            let _ = writeln!(
                out,
                "  {:12} {:5.1} % less predicted, {:5.1} % measured: {factor:.2} times as fast",
                own.stage, own.predicted_percent, own.measured_percent
            );
        }
        out
    }
}
