//! `cullet bench`: named workloads, their times, and how far from what the machine could do.
//!
//! A time says little on another machine; so each comes with the time that the same machine, in the
//! same run and at its best SIMD level, takes only to read the bytes that must be read. Every workload
//! checks its answer against the scalar oracle before it is timed.

mod backface;
mod cut;
mod frustum;
mod measure;
mod results;

pub(crate) use backface::bumpy_ball;
pub(crate) use frustum::{planes_that_see, random_boxes};
pub(crate) use results::{Machine, Measured, Results};

/// What to measure.
#[derive(Clone, Debug)]
pub(crate) struct BenchOptions {
    /// Only workloads whose name contains this.
    pub(crate) filter: Option<String>,
    /// Seconds for each workload and level; the fastest pass within them counts.
    pub(crate) seconds: f64,
    /// The sizes, in items.
    pub(crate) sizes: Vec<usize>,
}

impl Default for BenchOptions {
    fn default() -> Self {
        // 1e5 items stay in the second and third cache, 4e6 do not.
        Self { filter: None, seconds: 0.25, sizes: vec![100_000, 4_000_000] }
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
    cut::run(options, &mut take);
    Results { schema: 1, machine: Machine::here(), results }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_workload_of_a_small_run_checks_out() {
        let options = BenchOptions { filter: None, seconds: 0.0, sizes: vec![1000] };
        let results = run(&options);
        let levels = cullet::cull::frustum::batch::levels().len();
        // Frustum: two kinds, three shares. Back faces: four forms of triangles and six of clusters, with
        // three answers each, and the vertices. Cuts: six.
        assert_eq!(results.results.len(), (2 * 3 + (4 + 6) * 3) * levels + 1 + 6);
        for r in &results.results {
            assert!(r.checked, "{} at {}", r.name, r.level);
            assert!(r.ns_per_item > 0.0 && r.limit_ratio > 0.0, "{r:?}");
        }
        let json = serde_json::to_value(&results).expect("plain data");
        assert_eq!(json["schema"], 1);
        assert_eq!(json["results"][0]["name"], "frustum/spheres/1e3/5%");
    }

    #[test]
    fn a_filter_leaves_out_the_rest() {
        let filter = Some("boxes/1e3/30%".to_owned());
        let options = BenchOptions { filter, seconds: 0.0, sizes: vec![1000] };
        let mut seen = 0;
        let results = run_each(&options, &mut |_| seen += 1);
        assert!(results.results.iter().all(|r| r.name == "frustum/boxes/1e3/30%"));
        assert_eq!(seen, results.results.len());
        assert!(seen > 0);
    }
}
