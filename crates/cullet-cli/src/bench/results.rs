//! What a run of the benchmarks found, as JSON and as a table.

use std::fmt;

use serde::Serialize;

use super::occlusion::Occlusion;
use crate::console::count;

/// All results of one run.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Results {
    /// The version of this form: 1.
    pub(crate) schema: u32,
    /// Where it ran.
    pub(crate) machine: Machine,
    /// One entry a workload and level.
    pub(crate) results: Vec<Measured>,
    /// Occlusion culling in more detail, where it was measured.
    #[serde(flatten)]
    pub(crate) occlusion: Option<Occlusion>,
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
    /// Threads that can run at once; a workload uses one, unless its name says two.
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
    /// What the time is held against.
    #[serde(flatten)]
    pub(crate) yardstick: Yardstick,
    /// Whether the answer was that of the scalar oracle.
    pub(crate) checked: bool,
    /// Another way to the same answer in the same run, and how many times its time is this one's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) versus: Option<(&'static str, f64)>,
}

/// What a time is held against.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub(crate) enum Yardstick {
    /// Reading what must be read.
    Streaming {
        /// Bytes that must be read for an item.
        bytes_per_item: usize,
        /// Time to read those bytes at the best level in the same run.
        limit_ns_per_item: f64,
        /// The two times' ratio: 1 is the fastest that can be.
        limit_ratio: f64,
    },
    /// Another way to do the same, or half as much, timed in turns with it.
    Other {
        /// Which.
        ratio_to: String,
        /// The two times' ratio: below 1 is faster than the other.
        ratio: f64,
    },
}

impl Yardstick {
    /// Nanoseconds for all items against those for reading them.
    pub(crate) fn streaming(bytes: usize, items: usize, time: f64, limit: f64) -> Self {
        Self::Streaming {
            bytes_per_item: bytes,
            limit_ns_per_item: limit / items as f64,
            limit_ratio: time / limit,
        }
    }

    /// How many times as long as what it is held against.
    #[cfg(test)]
    pub(crate) fn ratio(&self) -> f64 {
        match self {
            Self::Streaming { limit_ratio: ratio, .. } | Self::Other { ratio, .. } => *ratio,
        }
    }
}

impl Measured {
    /// The heading of [`Display`](fmt::Display)'s columns, which depend on the yardstick.
    pub(crate) fn heading(&self) -> &'static str {
        match self.yardstick {
            Yardstick::Streaming { .. } => {
                "workload                               level   ns/item  bytes  streaming GB/s  x limit  checked"
            }
            Yardstick::Other { .. } => {
                "workload                               level         ms  visible  checked  times another"
            }
        }
    }
}

impl fmt::Display for Measured {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let checked = if self.checked { "yes" } else { "NO" };
        let ms = self.ns_per_item * self.items as f64 * 1e-6;
        match &self.yardstick {
            Yardstick::Streaming { bytes_per_item, limit_ns_per_item, limit_ratio } => write!(
                f,
                "{:<38} {:<7} {:>7.3} {:>6} {:>15.1} {:>8.2}  {checked}",
                self.name,
                self.level,
                self.ns_per_item,
                bytes_per_item,
                *bytes_per_item as f64 / limit_ns_per_item,
                limit_ratio,
            )?,
            Yardstick::Other { ratio_to, ratio } => write!(
                f,
                "{:<38} {:<7} {ms:>8.3} {:>8}  {checked:<7}  {ratio:.3} x {ratio_to}",
                self.name, self.level, self.visible,
            )?,
        }
        self.versus.map_or(Ok(()), |(name, times)| write!(f, "      {times:.1} x {name}"))
    }
}

impl fmt::Display for Results {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let m = &self.machine;
        let cpu = m.cpu.as_deref().unwrap_or(m.arch);
        writeln!(
            f,
            "{cpu}, {} (one used), {}, {}",
            count(m.threads as u64, "thread", "threads"),
            m.os,
            m.level
        )?;
        let mut heading = "";
        self.results.iter().try_for_each(|r| {
            if std::mem::replace(&mut heading, r.heading()) != r.heading() {
                writeln!(f, "{heading}")?;
            }
            writeln!(f, "{r}")
        })
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
