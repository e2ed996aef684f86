//! The machine that something is measured on.

use cullet::Simd;
use serde::Serialize;

/// The machine of a run.
#[derive(Clone, Debug, Serialize)]
pub struct Machine {
    /// Operating system.
    pub os: &'static str,
    /// Instruction set.
    pub arch: &'static str,
    /// The processor's name, where the system tells it.
    pub cpu: Option<String>,
    /// Threads that can run at once; a workload uses one, unless its name says two.
    pub threads: usize,
    /// The best SIMD level.
    pub level: &'static str,
}

impl Machine {
    /// This machine.
    #[must_use]
    pub fn here() -> Self {
        let cpu = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
            let line = text.lines().find(|l| l.starts_with("model name"))?;
            Some(line.split_once(':')?.1.trim().to_owned())
        });
        Self {
            os: std::env::consts::OS,
            arch: std::env::consts::ARCH,
            cpu,
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            level: Simd::best().name(),
        }
    }
}

/// The SIMD levels that this machine and this build have, best first, with their names.
#[must_use]
pub fn levels() -> Vec<(&'static str, Simd)> {
    Simd::all().into_iter().map(|simd| (simd.name(), simd)).collect()
}
