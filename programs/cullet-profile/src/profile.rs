//! Contents of a profile, for people and for programs.

use std::fmt::Write as _;

use serde::Serialize;

use super::elasticity::{Elasticity, limit};
use super::link::{Link, Way};
use super::measure::Times;
use super::relief::Relief;

/// Version of the JSON.
const SCHEMA: u32 = 1;

/// A profile of frames. As JSON it is what `--json` writes.
#[derive(Clone, Debug, Serialize)]
pub struct Profile {
    /// The version of this form.
    pub schema: u32,
    /// Name of the scene that was drawn.
    pub scene: String,
    /// The device.
    pub adapter: String,
    /// Whether the device is a program that runs on the processor.
    pub software: bool,
    /// The link that the frames wait for, or `mixed`.
    pub limit: String,
    /// Milliseconds a frame, by the median of the rounds.
    pub frame_ms: f64,
    /// How often each way was timed.
    pub rounds: usize,
    /// Elasticity of each link.
    pub elasticity: ByLink<f64>,
    /// Intervals of these.
    pub interval: ByLink<[f64; 2]>,
    /// Relief by each stage of culling.
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

impl<T: Copy> ByLink<T> {
    fn new([fill, transform, bus, cpu]: [T; 4]) -> Self {
        Self { fill, transform, bus, cpu }
    }

    /// Returns the value of one link.
    #[must_use]
    pub fn of(&self, link: Link) -> T {
        match link {
            Link::Fill => self.fill,
            Link::Transform => self.transform,
            Link::Bus => self.bus,
            Link::Cpu => self.cpu,
        }
    }
}

impl Profile {
    /// Builds the profile of what was measured of a scene on a device; relief is still to come.
    #[must_use]
    pub fn new(scene: &str, adapter: &wgpu::AdapterInfo, times: &Times) -> Self {
        let elasticity: [Elasticity; 4] = times.elasticities();
        let name = limit(&elasticity).map_or("mixed", Link::name);
        Self {
            schema: SCHEMA,
            scene: scene.to_owned(),
            adapter: adapter.name.clone(),
            software: adapter.device_type == wgpu::DeviceType::Cpu,
            limit: name.to_owned(),
            frame_ms: times.seconds(Way::Plain) * 1e3,
            rounds: times.rounds(),
            elasticity: ByLink::new(elasticity.map(|e| e.value)),
            interval: ByLink::new(elasticity.map(|e| e.interval)),
            relief: Vec::new(),
        }
    }

    /// Whether the frames wait for one link.
    #[must_use]
    pub fn is_named(&self) -> bool {
        self.limit != "mixed"
    }

    /// Returns the verdict in a sentence.
    #[must_use]
    pub fn verdict(&self) -> String {
        let mut out = if self.is_named() {
            format!("you are {} limited", self.limit)
        } else {
            "no link stands out".to_owned()
        };
        let best = self.relief.iter().filter(|r| r.stage != ALL);
        let best = best.max_by(|a, b| a.measured_percent.total_cmp(&b.measured_percent));
        // What is not told apart from nothing gives nothing.
        if let Some(best) = best.filter(|r| r.interval_percent[0] > 0.0) {
            let _ = write!(out, "; {} culling gives {:.1} times", best.stage, best.factor());
        }
        if let Some(all) = self.relief.iter().find(|r| r.stage == ALL) {
            let _ = write!(out, ", all of it {:.1} times", all.factor());
        }
        out
    }

    /// In words: the chain with a bar for each link, the link that is waited for, and what culling
    /// gives.
    #[must_use]
    pub fn to_text(&self) -> String {
        let mut out = String::new();
        let Self { scene, frame_ms, adapter, rounds, .. } = self;
        let _ = writeln!(out, "{scene}: {frame_ms:.2} ms a frame on {adapter}, {rounds} rounds\n");
        let _ =
            writeln!(out, "work doubled  frame takes longer by         (95 % of all draws lie in)");
        // As the work goes.
        for link in Link::ALL.into_iter().rev() {
            let value = self.elasticity.of(link);
            let bar = "█".repeat((value.clamp(0.0, 1.0) * 20.0).round() as usize);
            let [low, high] = self.interval.of(link).map(|v| v * 100.0);
            let percent = value * 100.0;
            let _ = writeln!(
                out,
                "  {:11} {percent:5.0} %  {bar:20}  {low:.0} to {high:.0} %",
                link.name()
            );
        }
        if !self.relief.is_empty() {
            let _ = writeln!(out, "\nculling       predicted    measured");
            for own in &self.relief {
                let Relief { stage, predicted_percent: p, measured_percent: m, .. } = own;
                let _ = writeln!(
                    out,
                    "  {stage:11} {p:6.0} %     {m:6.0} %   {:.2} times as fast",
                    own.factor()
                );
            }
        }
        let _ = writeln!(out, "\n{}", self.verdict());
        for line in self.cautions() {
            let _ = writeln!(out, "{line}");
        }
        out
    }

    /// Returns what cannot be measured here.
    #[must_use]
    pub fn cautions(&self) -> Vec<String> {
        let mut all = Vec::new();
        if self.software {
            all.push(
                "This device is a program on the processor: its bus is memory, and vertices, pixels and culling take time from each other."
                    .to_owned(),
            );
        }
        if !self.is_named() {
            all.push(
                "Frames wait for several links in turn, or for something that none of them is: the device's own set-up of a frame, say."
                    .to_owned(),
            );
        }
        all
    }
}

/// The name of all stages together.
pub(crate) const ALL: &str = "all";

#[cfg(test)]
mod tests {
    use super::*;

    fn relief(stage: &str, measured: f64) -> Relief {
        Relief {
            stage: stage.to_owned(),
            predicted_percent: measured,
            measured_percent: measured,
            interval_percent: [measured - 1.0, measured + 1.0],
        }
    }

    fn profile(limit: &str, relief: Vec<Relief>) -> Profile {
        Profile {
            schema: SCHEMA,
            scene: "city".to_owned(),
            adapter: "a device".to_owned(),
            software: false,
            limit: limit.to_owned(),
            frame_ms: 10.0,
            rounds: 30,
            elasticity: ByLink::new([0.8, 0.1, 0.0, 0.0]),
            interval: ByLink::new([[0.7, 0.9], [0.0, 0.2], [0.0, 0.1], [0.0, 0.1]]),
            relief,
        }
    }

    #[test]
    fn the_verdict_names_the_link_and_what_helps_most() {
        let some = vec![relief("frustum", 20.0), relief("occlusion", 44.4), relief(ALL, 50.0)];
        assert_eq!(
            profile("fill", some).verdict(),
            "you are fill limited; occlusion culling gives 1.8 times, all of it 2.0 times"
        );
        assert_eq!(profile("cpu", vec![]).verdict(), "you are cpu limited");
        let nothing = vec![relief("frustum", 0.5), relief(ALL, -25.0)];
        assert_eq!(profile("mixed", nothing).verdict(), "no link stands out, all of it 0.8 times");
    }

    #[test]
    fn programs_find_the_fields_that_are_promised() {
        let json = serde_json::to_value(profile("fill", vec![relief("frustum", 20.0)])).unwrap();
        assert_eq!(json["schema"], 1);
        assert_eq!(json["limit"], "fill");
        assert_eq!(json["elasticity"]["fill"], 0.8);
        assert_eq!(json["interval"]["cpu"], serde_json::json!([0.0, 0.1]));
        assert_eq!(json["relief"][0]["stage"], "frustum");
        assert_eq!(json["relief"][0]["predicted_percent"], 20.0);
        assert_eq!(json["relief"][0]["measured_percent"], 20.0);
        assert!(json["adapter"].is_string());
    }
}
