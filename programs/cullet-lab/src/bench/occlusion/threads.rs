//! Several threads against one: the list of a view, drawn by each in turn.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use cullet::Simd;
use cullet_command::exit::Failure;
use serde::Serialize;

use super::engine::{Engine, Job};
use super::measure::Passes;
use super::rasteriser::Rasteriser;
use super::scene::{Prepared, Scratch};

/// Times of drawing in bands, on several threads and on one: means over views of the fastest pass, in milliseconds
/// without clearing.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(crate) struct Shared {
    /// How many threads drew.
    pub(super) threads: u16,
    /// All that is in the frustum, nearest first, drawn by one thread in the same passes.
    pub(super) one_sorted_ms: f64,
    /// The same without what is hidden by then, as the bands are drawn.
    pub(super) one_interleaved_ms: f64,
    /// By all threads, from the clock on the wall.
    pub(super) all_ms: f64,
    /// Of that, what the caller's thread does before there are jobs.
    pub(super) prepare_ms: f64,
    /// The longest of the jobs, run one after the other on one thread: what does not depend on whether there were
    /// as many cores free.
    pub(super) longest_ms: f64,
    /// Whether each view's pixels were the same as one thread's.
    pub(super) alike: bool,
}

/// Threads that stand ready: as an engine's do within a frame.
struct Workers {
    pool: rayon::ThreadPool,
    threads: usize,
}

impl Workers {
    fn new(threads: usize) -> Result<Self, Failure> {
        let builder = rayon::ThreadPoolBuilder::new().num_threads(threads).use_current_thread();
        Ok(Self { pool: builder.build().map_err(Failure::usage)?, threads })
    }

    /// Has all but the caller's thread wait, awake, until the returned flag is set.
    fn ready(&self) -> Arc<AtomicBool> {
        let (go, here) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicUsize::new(1)));
        for _ in 1..self.threads {
            let (go, here) = (go.clone(), here.clone());
            self.pool.spawn(move || {
                here.fetch_add(1, Ordering::Release);
                while !go.load(Ordering::Acquire) {
                    std::hint::spin_loop();
                }
            });
        }
        while here.load(Ordering::Acquire) < self.threads {
            std::thread::yield_now();
        }
        go
    }

    /// Runs jobs, the first on the caller's thread.
    fn run(&self, jobs: Vec<Job<'_>>, go: &AtomicBool) {
        self.pool.scope(|scope| {
            let mut jobs = jobs.into_iter();
            let first = jobs.next();
            for job in jobs {
                scope.spawn(move |_| job());
            }
            go.store(true, Ordering::Release);
            if let Some(job) = first {
                job();
            }
        });
    }
}

/// Time on the wall that some work takes: what several threads do is not in the time of one.
fn timed(work: impl FnOnce()) -> Duration {
    let start = Instant::now();
    work();
    start.elapsed()
}

/// Measures all views in turn, with so many passes each; `go_on` is called after each.
pub(super) fn measure(
    prepared: &Prepared,
    level: Simd,
    engine: &mut Engine<'_>,
    threads: u16,
    passes: Passes,
    go_on: &mut dyn FnMut() -> bool,
) -> Result<Shared, Failure> {
    let workers = Workers::new(threads.into())?;
    let mut scratch = Scratch::default();
    let mut shared = Shared { threads, alike: true, ..Shared::default() };
    let mut sums = [0.0; 5];
    let mut views = 0;
    for (view, culling_view) in prepared.views.iter().enumerate() {
        prepared.sorted(level, view, &mut scratch);
        let order = &scratch.pieces;
        let mut best = [Duration::MAX; 5];
        let begin = Instant::now();
        let mut done = 0;
        while passes.go_on(done, begin) {
            engine.clear(culling_view);
            let sorted = timed(|| engine.draw(order));
            engine.clear(culling_view);
            let interleaved = timed(|| _ = engine.draw_unless_hidden(order));
            // What is drawn is the same in every pass, and reading it takes long.
            let alone = (done == 0).then(|| engine.pixels());
            engine.clear(culling_view);
            let go = workers.ready();
            let all = timed(|| {
                engine.draw_in_jobs(order, threads.into(), |jobs| workers.run(jobs, &go));
            });
            shared.alike &= alone.is_none_or(|alone| engine.pixels() == alone);
            engine.clear(culling_view);
            let mut jobs_took = (Duration::ZERO, Duration::ZERO);
            let whole = timed(|| {
                engine.draw_in_jobs(order, threads.into(), |jobs| {
                    for job in jobs {
                        let time = timed(job);
                        jobs_took = (jobs_took.0 + time, jobs_took.1.max(time));
                    }
                });
            });
            let (sum, longest) = jobs_took;
            let now = [sorted, interleaved, all, whole.saturating_sub(sum), longest];
            for (best, now) in best.iter_mut().zip(now) {
                *best = (*best).min(now);
            }
            done += 1;
        }
        for (sum, best) in sums.iter_mut().zip(best) {
            *sum += best.as_secs_f64() * 1e3;
        }
        views += 1;
        if !go_on() {
            break;
        }
    }
    let [sorted, interleaved, all, prepare, longest] = sums.map(|s| s / f64::from(views.max(1)));
    (shared.one_sorted_ms, shared.one_interleaved_ms) = (sorted, interleaved);
    (shared.all_ms, shared.prepare_ms, shared.longest_ms) = (all, prepare, longest);
    Ok(shared)
}
