//! What a run of the benchmarks found, as JSON and as a table.

use std::fmt;

use serde::Serialize;

/// All results of one run.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Results {
    /// The version of this form: 1.
    pub(crate) schema: u32,
    /// Where it ran.
    pub(crate) machine: Machine,
    /// One entry a workload and level.
    pub(crate) results: Vec<Measured>,
}

/// The machine of a run.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Machine {
    /// Operating system.
    pub(crate) os: &'static str,
    /// Instruction set.
    pub(crate) arch: &'static str,
    /// The processor's name, where the system tells it.
    pub(crate) cpu: Option<String>,
    /// Threads that can run at once; each workload uses one.
    pub(crate) threads: usize,
    /// The best SIMD level.
    pub(crate) level: &'static str,
}

/// One workload at one SIMD level.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Measured {
    /// Like `frustum/boxes/1e5/30%`: what, how many, how much of it is visible.
    pub(crate) name: String,
    /// The SIMD level.
    pub(crate) level: &'static str,
    /// How many items.
    pub(crate) items: usize,
    /// How many of them are visible.
    pub(crate) visible: usize,
    /// Time an item, of the fastest pass.
    pub(crate) ns_per_item: f64,
    /// Bytes that must be read for an item.
    pub(crate) bytes_per_item: usize,
    /// Time to read those bytes at the best level in the same run.
    pub(crate) limit_ns_per_item: f64,
    /// The two times' ratio: 1 is the fastest that can be.
    pub(crate) limit_ratio: f64,
    /// Whether the answer was that of the scalar oracle.
    pub(crate) checked: bool,
    /// Another way to the same answer in the same run, and how many times its time is this one's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) versus: Option<(&'static str, f64)>,
}

impl Measured {
    /// The machine's streaming rate, in 1e9 bytes a second.
    pub(crate) fn streaming_rate(&self) -> f64 {
        self.bytes_per_item as f64 / self.limit_ns_per_item
    }

    /// The heading of [`Display`](fmt::Display)'s columns.
    pub(crate) const HEADING: &'static str =
        "workload                  level   ns/item  bytes  streaming GB/s  x limit  checked";
}

impl fmt::Display for Measured {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{:<25} {:<7} {:>7.3} {:>6} {:>15.1} {:>8.2}  {}",
            self.name,
            self.level,
            self.ns_per_item,
            self.bytes_per_item,
            self.streaming_rate(),
            self.limit_ratio,
            if self.checked { "yes" } else { "NO" },
        )?;
        self.versus.map_or(Ok(()), |(name, times)| write!(f, "      {times:.1} x {name}"))
    }
}

impl fmt::Display for Results {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let m = &self.machine;
        let cpu = m.cpu.as_deref().unwrap_or(m.arch);
        writeln!(f, "{cpu}, {} threads (one used), {}, {}", m.threads, m.os, m.level)?;
        writeln!(f, "{}", Measured::HEADING)?;
        self.results.iter().try_for_each(|r| writeln!(f, "{r}"))
    }
}

impl Machine {
    /// This machine.
    pub(crate) fn here() -> Self {
        let cpu = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
            let line = text.lines().find(|l| l.starts_with("model name"))?;
            Some(line.split_once(':')?.1.trim().to_owned())
        });
        Self {
            os: std::env::consts::OS,
            arch: std::env::consts::ARCH,
            cpu,
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            level: cullet::cull::frustum::batch::levels()[0].0,
        }
    }
}
