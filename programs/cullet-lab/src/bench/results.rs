//! Results of a run of the benchmarks, as JSON and as a table.

use std::fmt;

use cullet_command::console::count;
use serde::Serialize;

use super::measured::Measured;
use super::occlusion::report::Occlusion;
use cullet_command::machine::Machine;

/// All results of one run.
#[derive(Clone, Debug, Serialize)]
pub struct Results {
    /// The version of this form: 1.
    pub schema: u32,
    /// Where it ran.
    pub machine: Machine,
    /// One entry a workload and level.
    pub results: Vec<Measured>,
    /// Occlusion culling in more detail, where it was measured.
    #[serde(flatten)]
    pub occlusion: Option<Occlusion>,
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
