//! Jobs side by side, their results in order.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Runs `count` jobs on so many threads, each with a state of its own; the results in the order of
/// the jobs, whoever ran them. `None` where `go_on` said no before the last was begun.
pub(crate) fn run<S, T: Send>(
    threads: usize,
    count: usize,
    state: impl Fn() -> S + Sync,
    job: impl Fn(&mut S, usize) -> T + Sync,
    go_on: impl Fn() -> bool + Sync,
) -> Option<Vec<T>> {
    let next = AtomicUsize::new(0);
    let work = || {
        let mut state = state();
        let mut done = Vec::new();
        while go_on() {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if number >= count {
                break;
            }
            done.push((number, job(&mut state, number)));
        }
        done
    };
    let helpers = threads.min(count).saturating_sub(1);
    let mut all = std::thread::scope(|scope| {
        // A thread that cannot be had leaves its work to the others.
        let helpers: Vec<_> = (0..helpers)
            .filter_map(|_| {
                std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, work).ok()
            })
            .collect();
        let mut all = work();
        for helper in helpers {
            match helper.join() {
                Ok(done) => all.extend(done),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        all
    });
    all.sort_unstable_by_key(|(number, _)| *number);
    (all.len() == count).then(|| all.into_iter().map(|(_, result)| result).collect())
}

/// Runs jobs like [`run`]; `step` is called after each job, by its thread, and says whether to go
/// on. `None` where it once said no.
pub(crate) fn run_while<S, T: Send>(
    threads: usize,
    count: usize,
    state: impl Fn() -> S + Sync,
    job: impl Fn(&mut S, usize) -> T + Sync,
    step: impl Fn(usize) -> bool + Sync,
) -> Option<Vec<T>> {
    let stopped = AtomicBool::new(false);
    let job = |state: &mut S, number: usize| {
        let result = job(state, number);
        if !step(number) {
            stopped.store(true, Ordering::Relaxed);
        }
        result
    };
    let results = run(threads.max(1), count, state, job, || !stopped.load(Ordering::Relaxed))?;
    (!stopped.load(Ordering::Relaxed)).then_some(results)
}

/// Room for the deepest chain of portals.
const STACK: usize = 4 << 20;
