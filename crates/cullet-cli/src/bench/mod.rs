//! `cullet bench`: named workloads, their times, and how far from what the machine could do.
//!
//! A time says little on another machine; so each comes with the time that the same machine, in the
//! same run and at its best SIMD level, takes only to read the bytes that must be read, or with that of
//! another way to the same answer. Every workload checks its answer before it is timed: against the scalar
//! oracle, or, with a hierarchy, against the flat sweep that was.

mod backface;
mod clip;
pub(crate) mod culler;
mod cut;
mod frustum;
mod hierarchy;
mod measure;
mod moving;
pub(crate) mod occlusion;
mod results;
mod shadow;
mod views;
mod world;

pub(crate) use backface::bumpy_ball;
pub(crate) use occlusion::{OcclusionArgs, run_scene};
pub(crate) use results::{Machine, Measured, Results, Yardstick};
pub(crate) use world::{planes_that_see, random_boxes};

/// What to measure.
#[derive(Clone, Debug)]
pub(crate) struct BenchOptions {
    /// Only workloads whose name contains this.
    pub(crate) filter: Option<String>,
    /// Seconds for each workload and level; the fastest pass within them counts.
    pub(crate) seconds: f64,
    /// The sizes, in items.
    pub(crate) sizes: Vec<usize>,
    /// The sizes of hierarchies, in boxes.
    pub(crate) tree_sizes: Vec<usize>,
    /// The largest size of a world whose boxes drift for a thousand frames.
    pub(crate) drift_size: usize,
}

impl BenchOptions {
    /// What the command line asks for.
    pub(crate) fn new(filter: Option<String>, large: bool) -> Self {
        let mut options = Self { filter, ..Self::default() };
        if large {
            options.tree_sizes.push(10_000_000);
            options.drift_size = 1_000_000;
        }
        options
    }

    /// Whether a workload is to run.
    fn wants(&self, name: &str) -> bool {
        self.filter.as_ref().is_none_or(|part| name.contains(part.as_str()))
    }
}

impl Default for BenchOptions {
    fn default() -> Self {
        // 1e5 items stay in the second and third cache, 4e6 do not.
        Self {
            filter: None,
            seconds: 0.25,
            sizes: vec![100_000, 4_000_000],
            tree_sizes: vec![100_000, 1_000_000],
            drift_size: 100_000,
        }
    }
}

/// Runs the workloads.
pub(crate) fn run(options: &BenchOptions) -> Results {
    run_each(options, &mut |_| {})
}

/// Runs the workloads and hands each result on as soon as it is there.
pub(crate) fn run_each(options: &BenchOptions, each: &mut dyn FnMut(&Measured)) -> Results {
    let mut results = Vec::new();
    let mut take = |measured| {
        each(&measured);
        results.push(measured);
    };
    frustum::run(options, &mut take);
    backface::run(options, &mut take);
    shadow::run(options, &mut take);
    hierarchy::run(options, &mut take);
    views::run(options, &mut take);
    moving::run(options, &mut take);
    clip::run(options, &mut take);
    cut::run(options, &mut take);
    let occlusion = occlusion::run(options, &mut take);
    Results { schema: 1, machine: Machine::here(), results, occlusion }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn small(filter: Option<String>) -> BenchOptions {
        let (sizes, tree_sizes) = (vec![1000], vec![1000]);
        BenchOptions { filter, seconds: 0.0, sizes, tree_sizes, drift_size: 1000 }
    }

    #[test]
    fn every_workload_of_a_small_run_checks_out() {
        let results = run(&small(None));
        let levels = cullet::cull::frustum::batch::levels().len();
        // Frustum: two kinds, three shares. Back faces: four forms of triangles and six of clusters, with
        // three answers each, and the vertices. A frame: three at each level, and four that have none.
        // Shadows: three lights.
        let flat = (2 * 3 + (4 + 6) * 3 + 3 + 3) * levels + 1 + 4;
        // Two layouts: four shares, a list at each level, ranges and sorted; three of views; eight of moves.
        let trees = 2 * (4 * (levels + 2) + 3 + 8);
        // Outcodes; sorting, three ways for lines, four for triangles, two places. Cuts: six.
        let clipping = levels + 1 + 3 + 4 + 2 + 6;
        // Three ways to draw, and the tests.
        let occlusion = 4 * levels;
        assert_eq!(results.results.len(), flat + trees + clipping + occlusion);
        for r in &results.results {
            assert!(r.checked, "{} at {}", r.name, r.level);
            assert!(r.ns_per_item > 0.0 && r.yardstick.ratio() > 0.0, "{r:?}");
        }
        let json = serde_json::to_value(&results).expect("plain data");
        assert_eq!(json["schema"], 1);
        assert_eq!(json["results"][0]["name"], "frustum/spheres/1e3/5%");
    }

    #[test]
    fn a_filter_leaves_out_the_rest() {
        let filter = Some("boxes/1e3/30%".to_owned());
        let options = small(filter);
        let mut seen = 0;
        let results = run_each(&options, &mut |_| seen += 1);
        assert!(results.results.iter().all(|r| r.name == "frustum/boxes/1e3/30%"));
        assert_eq!(seen, results.results.len());
        assert!(seen > 0);
    }
}
