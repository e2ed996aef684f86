//! Resources that this process has taken so far.

use std::time::Duration;

/// Time of the processors, of all threads together, where the system tells it; elsewhere the time
/// on the wall since the first call.
#[must_use]
pub fn cpu_time() -> Duration {
    #[cfg(unix)]
    {
        use nix::time::{ClockId, clock_gettime};
        // Never refused: every system that Rust runs on has this clock.
        clock_gettime(ClockId::CLOCK_PROCESS_CPUTIME_ID).map_or(Duration::ZERO, Duration::from)
    }
    #[cfg(not(unix))]
    Duration::from_nanos(crate::clock::clock())
}

/// The most memory that was resident at once, where the system tells it (Linux).
#[must_use]
pub fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse().ok().map(|kib: u64| kib * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_takes_time_and_memory() {
        let before = cpu_time();
        let sum = (0..5_000_000_u64).fold(0, |a, b| std::hint::black_box(a ^ b));
        assert!(cpu_time() > before, "{sum}");
        if cfg!(target_os = "linux") {
            let held = vec![1_u8; 64 << 20];
            assert!(peak_bytes().is_some_and(|peak| peak > 64 << 20), "{}", held.len());
        }
    }
}
