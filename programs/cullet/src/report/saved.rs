//! Milliseconds: what the triangles that culling takes would have cost to draw.

use std::path::PathBuf;

use clap::Args;
use cullet::mesh::Alpha;
use cullet::{Scene, Stage, funnel::Unit};
use cullet_command::console::Console;
use cullet_command::console::digits;
use cullet_command::exit::Failure;
use cullet_command::measured_costs::MeasuredCosts;
use cullet_command::parse;
use cullet_command::stored_costs::Stored;
use serde::Serialize;

use crate::record::Summary;

/// Where prices come from.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Costs")]
pub(crate) struct CostArgs {
    /// Costs that `cullet calibrate --out` wrote [default: those that `cullet calibrate` kept]
    #[arg(long, value_name = "FILE", conflicts_with = "triangle_ns")]
    pub(crate) costs: Option<PathBuf>,
    /// Cost of a triangle in your renderer, in nanoseconds
    #[arg(long, value_name = "NS", value_parser = parse::nanoseconds)]
    pub(crate) triangle_ns: Option<f64>,
}

/// Costs of triangles of a scene.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TriangleCosts {
    origin: Origin,
    /// A triangle that the renderer would have rejected itself.
    rejected_ns: f64,
    /// A triangle that it would have drawn, in the scene's mix of materials.
    drawn_ns: f64,
}

/// Who says so.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Origin {
    /// `--triangle-ns`, in nanoseconds.
    Given(f64),
    /// A file of costs.
    File { path: PathBuf, stored: Box<Stored> },
}

/// `costs` in `report.json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct CostsRecord {
    /// The file, or `--triangle-ns`.
    pub(crate) source: String,
    /// The day it was measured.
    pub(crate) date: Option<String>,
    /// Where it was measured.
    pub(crate) machine: Option<String>,
    /// A triangle that the renderer would have rejected itself, in nanoseconds.
    pub(crate) rejected_triangle_ns: f64,
    /// A triangle that it would have drawn, in the scene's mix of materials.
    pub(crate) drawn_triangle_ns: f64,
    /// Estimated saving by culling, in an average view, for a renderer that takes up every
    /// triangle, in milliseconds.
    pub(crate) saved_ms_per_view: f64,
    /// That over the triangles that culling takes, in nanoseconds; null where it takes none.
    pub(crate) saved_ns_per_triangle: Option<f64>,
    /// Estimated cost of the tests in bulk in an average view; null where only a triangle's cost is
    /// known.
    pub(crate) tests_ms_per_view: Option<f64>,
    /// All of this in a sentence for people.
    pub(crate) assumption: String,
}

impl Origin {
    /// The prices that the command line names, else those that are kept, if any are. A file that
    /// the user names must be sound; one that is only kept is passed over with a warning.
    pub(crate) fn find(args: &CostArgs, console: &Console) -> Result<Option<Self>, Failure> {
        if let Some(ns) = args.triangle_ns {
            return Ok(Some(Self::Given(ns)));
        }
        let found = Stored::find(args.costs.as_deref(), console, "no milliseconds")?;
        Ok(found.map(|(path, stored)| Self::File { path, stored: Box::new(stored) }))
    }
}

impl TriangleCosts {
    /// The prices of a scene's triangles.
    pub(crate) fn new(origin: Origin, scene: &Scene) -> Self {
        let [rejected_ns, drawn_ns] = match &origin {
            Origin::Given(ns) => [*ns; 2],
            Origin::File { stored, .. } => {
                let costs = stored.costs();
                [costs.rejected_triangle_ns, mean_drawn_ns(&costs, scene)]
            }
        };
        Self { origin, rejected_ns, drawn_ns }
    }

    /// Cost of a drawn triangle, in nanoseconds: the mean over the scene's materials.
    pub(crate) fn drawn_ns(&self) -> f64 {
        self.drawn_ns
    }

    /// Costs and savings over the views of a summary.
    pub(crate) fn record(&self, summary: &Summary) -> CostsRecord {
        let views = summary.views.max(1) as f64;
        let saved: f64 = summary.removed.iter().map(|(s, n)| self.cost_of(*s) * *n as f64).sum();
        let culled: u64 = summary.removed.values().sum();
        let (source, stored) = match &self.origin {
            Origin::Given(_) => ("--triangle-ns".to_owned(), None),
            Origin::File { path, stored } => (path.display().to_string(), Some(stored)),
        };
        let tests = stored.map(|s| tests_ns(&s.costs(), summary) / views * 1e-6);
        CostsRecord {
            source,
            date: stored.map(|s| s.date.clone()),
            machine: stored.map(|s| s.machine.clone()),
            rejected_triangle_ns: self.rejected_ns,
            drawn_triangle_ns: self.drawn_ns,
            saved_ms_per_view: saved / views * 1e-6,
            saved_ns_per_triangle: (culled > 0).then(|| saved / culled as f64),
            tests_ms_per_view: tests,
            assumption: self.assumption(tests),
        }
    }

    /// Cost that a triangle would have had if a stage had not culled it. A triangle that is outside
    /// the view, faces away or has no area fills no pixel in any renderer, so only its setup is
    /// saved.
    fn cost_of(&self, stage: Stage) -> f64 {
        match stage {
            Stage::Frustum | Stage::Backface | Stage::Degenerate => self.rejected_ns,
            // The renderer skips other layers too, with all of an instance at once.
            Stage::Layer => 0.0,
            Stage::Pvs | Stage::Portal | Stage::Detail | Stage::Lod | Stage::Occlusion => {
                self.drawn_ns
            }
        }
    }

    fn assumption(&self, tests_ms: Option<f64>) -> String {
        let [rejected, drawn] = [self.rejected_ns, self.drawn_ns].map(digits);
        let Origin::File { stored, .. } = &self.origin else {
            return format!(
                "Milliseconds are estimated, not timed, at {drawn} ns per triangle, as --triangle-ns says."
            );
        };
        let machine = match stored.is_of_here() {
            true => "this machine".to_owned(),
            false => format!("another machine ({})", stored.machine),
        };
        let tests = tests_ms.map_or_else(String::new, |t| {
            format!(" The tests in bulk would cost {} of it.", about(t))
        });
        format!(
            "Milliseconds are estimated, not timed, for a renderer that takes up every triangle: {rejected} ns for \
             one outside the view or facing away, which it rejects, and r = {drawn} ns for any other, as \
             measured with {} on {}, on {machine}. A renderer that skips whole instances by itself gains less; \
             a GPU's r is another, and --triangle-ns takes it.{tests}",
            stored.renderer, stored.date
        )
    }
}

impl CostsRecord {
    /// Whether culling saves anything by these costs.
    pub(crate) fn saves(&self) -> bool {
        self.saved_ns_per_triangle.is_some_and(|ns| ns > 0.0)
    }

    /// The end of the headline, with its condition; empty where nothing is saved.
    pub(crate) fn headline(&self) -> String {
        match self.saved_ns_per_triangle {
            Some(ns) if self.saves() => format!(
                // No figure is parted from its unit at the end of a line.
                " At {}\u{a0}ns per triangle, culling saves {} per view.",
                digits(ns),
                about(self.saved_ms_per_view).replace(" ms", "\u{a0}ms")
            ),
            _ => String::new(),
        }
    }
}

/// The line that stands in place of the assumption where nothing is known.
pub(crate) const UNKNOWN: &str = "`cullet calibrate` measures what a triangle costs on this machine; reports \
                                  then say how many milliseconds culling saves.";

/// The cost of a drawn triangle, the mean over all instances; that of an opaque one where there is
/// none.
fn mean_drawn_ns(costs: &MeasuredCosts, scene: &Scene) -> f64 {
    let (mut ns, mut triangles) = (0.0, 0u64);
    for slot in scene.slots() {
        let transparent = scene.flags(slot).transparent;
        for part in scene.mesh(slot).parts() {
            let alpha = if transparent { Alpha::Blended } else { part.alpha };
            ns += costs.drawn_ns(alpha) * f64::from(part.triangle_count);
            triangles += u64::from(part.triangle_count);
        }
    }
    if triangles == 0 { costs.opaque_triangle_ns } else { ns / triangles as f64 }
}

/// The tests of all views, were each made in bulk.
fn tests_ns(costs: &MeasuredCosts, summary: &Summary) -> f64 {
    let cost = |stage: Stage, unit: Unit| match (stage, unit) {
        (Stage::Frustum, Unit::Instances) => costs.object_test_ns,
        (_, Unit::Clusters) => costs.cluster_test_ns,
        (Stage::Backface, Unit::Triangles) => costs.triangle_test_ns,
        _ => 0.0,
    };
    summary.stages.iter().map(|s| cost(s.stage, s.unit) * s.entered as f64).sum()
}

/// `about 12 ms`
fn about(ms: f64) -> String {
    match ms {
        0.0 => "0 ms".into(),
        // A bound is no estimate.
        ms if ms < 0.001 => "under 0.001 ms".into(),
        ms => format!("about {} ms", digits(ms)),
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use cullet::mesh::Part;
    use cullet::{Instance, Mesh, MeshData, Transform};
    use cullet_command::stored_costs::Spread;

    use super::*;
    use crate::record::StageRecord;

    fn summary(removed: &[(Stage, u64)]) -> Summary {
        let stage = |stage, unit, entered| StageRecord {
            stage,
            unit,
            entered,
            left: 0,
            instances: [0; 2],
            clusters: [0; 2],
            triangles: [0; 2],
            ms: None,
        };
        Summary {
            views: 2,
            removed: removed.iter().copied().collect::<BTreeMap<_, _>>(),
            stages: vec![
                stage(Stage::Frustum, Unit::Instances, 1_000_000),
                stage(Stage::Frustum, Unit::Clusters, 2_000_000),
                stage(Stage::Backface, Unit::Triangles, 4_000_000),
                stage(Stage::Degenerate, Unit::Triangles, 9),
            ],
            ..Summary::of(&[])
        }
    }

    /// The headline with ordinary spaces.
    fn plain(record: &CostsRecord) -> String {
        record.headline().replace('\u{a0}', " ")
    }

    /// Costs of 1 ns, 2 ns and so on.
    fn file() -> Origin {
        let spread = |i: usize| {
            let ns = (i + 1) as f64;
            Spread { ns, low: ns - 2.0, high: ns * 1.1 }
        };
        let stored = Box::new(Stored::now(std::array::from_fn(spread), 3));
        Origin::File { path: "c.json".into(), stored }
    }

    /// One triangle of each class.
    fn scene() -> Scene {
        let classes = [Alpha::Opaque, Alpha::Masked, Alpha::Blended];
        let part = |(first, alpha)| Part {
            first_triangle: first,
            triangle_count: 1,
            alpha,
            ..Part::default()
        };
        let mut scene = Scene::new();
        let data = MeshData {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            indices: [0, 1, 2].repeat(3),
            parts: (0..).zip(classes).map(part).collect(),
            ..MeshData::default()
        };
        let mesh = scene.add_mesh(Mesh::new(data).unwrap());
        scene.add(Instance::new(mesh, Transform::IDENTITY)).unwrap();
        scene.commit(&cullet::Culler::default());
        scene
    }

    #[test]
    fn each_stage_spares_what_its_triangles_would_have_cost() {
        // 4 ns rejected; 5, 6 and 7 ns drawn, by class.
        let triangle_costs = TriangleCosts::new(file(), &scene());
        assert_eq!((triangle_costs.rejected_ns, triangle_costs.drawn_ns), (4.0, 6.0));
        let removed = [
            (Stage::Frustum, 1_000_000),
            (Stage::Backface, 2_000_000),
            (Stage::Detail, 3_000_000),
            (Stage::Layer, 9),
        ];
        let record = triangle_costs.record(&summary(&removed));
        // (3e6 × 4 + 3e6 × 6) / 2 views
        assert_eq!(record.saved_ms_per_view, 15.0);
        // (1e6 × 1 + 2e6 × 2 + 4e6 × 3) / 2 views
        assert_eq!(record.tests_ms_per_view, Some(8.5));
        assert_eq!(record.saved_ns_per_triangle, Some(30e6 / 6_000_009.0));
        assert_eq!(plain(&record), " At 5.0 ns per triangle, culling saves about 15 ms per view.");
        for part in [
            "4.0 ns for one outside",
            "r = 6.0 ns for any other",
            "this machine",
            "about 8.5 ms of it",
        ] {
            assert!(record.assumption.contains(part), "{part}: {}", record.assumption);
        }
    }

    #[test]
    fn a_price_from_the_command_line_is_the_price_of_all() {
        let triangle_costs = TriangleCosts::new(Origin::Given(2.5), &scene());
        let record = triangle_costs
            .record(&summary(&[(Stage::Frustum, 1_000_000), (Stage::Occlusion, 1_000_000)]));
        assert_eq!((record.saved_ms_per_view, record.tests_ms_per_view), (2.5, None));
        assert!(record.assumption.contains("2.5 ns per triangle"), "{}", record.assumption);
        assert_eq!(plain(&record), " At 2.5 ns per triangle, culling saves about 2.5 ms per view.");
    }

    #[test]
    fn a_scene_of_nothing_has_a_price_and_saves_nothing() {
        let triangle_costs = TriangleCosts::new(file(), &Scene::new());
        assert_eq!(triangle_costs.drawn_ns, 5.0);
        let record = triangle_costs.record(&Summary::of(&[]));
        assert_eq!((record.saved_ms_per_view, record.saved_ns_per_triangle), (0.0, None));
        assert_eq!(record.headline(), "");
    }

    #[test]
    fn milliseconds_never_round_to_none_and_a_bound_is_not_about() {
        assert_eq!(about(0.0), "0 ms");
        assert_eq!(about(1e-9), "under 0.001 ms");
        assert_eq!(about(0.0234), "about 0.023 ms");
        assert_eq!(about(1234.5), "about 1234 ms");
    }
}
