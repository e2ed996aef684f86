//! Options of the benchmarks: workloads, sizes and times.

/// Workloads, sizes and times.
#[derive(Clone, Debug)]
pub struct BenchOptions {
    /// Only workloads whose name contains this.
    pub filter: Option<String>,
    /// Seconds for each workload and level; the fastest pass within them counts.
    pub seconds: f64,
    /// The sizes, in items.
    pub sizes: Vec<usize>,
    /// The sizes of hierarchies, in boxes.
    pub tree_sizes: Vec<usize>,
    /// The largest size of a world whose boxes drift for a thousand frames.
    pub drift_size: usize,
}

impl BenchOptions {
    /// The options of the command line.
    pub fn new(filter: Option<String>, large: bool) -> Self {
        let mut options = Self { filter, ..Self::default() };
        if large {
            options.tree_sizes.push(10_000_000);
            options.drift_size = 1_000_000;
        }
        options
    }

    /// Whether a workload is to run.
    pub(super) fn wants(&self, name: &str) -> bool {
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
