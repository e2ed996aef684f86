//! Time that work takes on this thread, apart from what else the machine does.

use std::time::Duration;

/// Time that some work took of this thread's processor, where the system tells it: what else runs
/// on a busy machine takes none of it, but for the caches that it shares. Elsewhere the clock on
/// the wall.
pub(crate) fn of_thread(work: impl FnOnce()) -> Duration {
    let begin = now();
    work();
    now().saturating_sub(begin)
}

/// The thread's time so far, from a moment that does not change.
#[cfg(any(target_os = "linux", target_os = "android", target_vendor = "apple"))]
fn now() -> Duration {
    use nix::time::{ClockId, clock_gettime};
    // Never refused: every version of these systems that Rust runs on has this clock.
    clock_gettime(ClockId::CLOCK_THREAD_CPUTIME_ID).map_or(Duration::ZERO, Duration::from)
}

/// The time since the first call.
#[cfg(not(any(target_os = "linux", target_os = "android", target_vendor = "apple")))]
fn now() -> Duration {
    Duration::from_nanos(cullet_command::clock::clock())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Instant;

    #[test]
    fn work_takes_time_and_other_threads_none_of_it() {
        let begin = Instant::now();
        let worked = of_thread(|| while begin.elapsed() < Duration::from_millis(5) {});
        assert!(worked > Duration::ZERO && worked <= begin.elapsed());
        if cfg!(any(target_os = "linux", target_vendor = "apple")) {
            let slept = of_thread(|| std::thread::sleep(Duration::from_millis(20)));
            assert!(slept < Duration::from_millis(15), "{slept:?}");
        }
    }
}
