//! Jobs: parts of one call that run side by side, on threads of the caller.

use core::array;

/// A part of a call, to be called once.
pub type Job<'a> = &'a mut (dyn FnMut() + Send);

/// Threads that run jobs: the caller's pool.
///
/// [`Culler::cull_one_on`](crate::Culler::cull_one_on) takes one. The feature `rayon` has
/// [`Rayon`]; any other pool is a few lines, as here with threads of the standard library (which
/// take longer to start than most culls):
///
/// ```
/// use cullet::jobs::{Job, Jobs};
/// # use cullet::{Culler, Scene, View, ViewState, Visible};
///
/// struct Threads(usize);
///
/// impl Jobs for Threads {
///     fn threads(&self) -> usize {
///         self.0
///     }
///
///     fn run(&self, jobs: &mut [Job<'_>]) {
///         std::thread::scope(|scope| {
///             for job in jobs {
///                 scope.spawn(job);
///             }
///         });
///     }
/// }
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let (scene, mut state, mut visible) = (Scene::new(), ViewState::default(), Visible::default());
/// # let view = View::perspective([0.0; 3], [0.0, 0.0, -1.0], 0.8, 0.1, 100.0, [640, 480])?;
/// Culler::default().cull_one_on(&Threads(2), &scene, &view, &mut state, &mut visible);
/// # Ok(())
/// # }
/// ```
pub trait Jobs: Sync {
    /// Number of jobs that run side by side, the caller's thread included.
    fn threads(&self) -> usize;

    /// Calls each of `jobs` once, in any order and on any threads, and returns when all have
    /// returned. They do not call `run` themselves.
    fn run(&self, jobs: &mut [Job<'_>]);

    /// Calls `work`, which calls [`run`](Self::run) again and again, some microseconds apart. A
    /// pool whose threads take longer than that to wake keeps them awake until `work` returns.
    fn keep_awake(&self, work: Job<'_>) {
        work();
    }
}

/// The thread of the caller alone.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OneThread;

impl Jobs for OneThread {
    fn threads(&self) -> usize {
        1
    }

    fn run(&self, jobs: &mut [Job<'_>]) {
        jobs.iter_mut().for_each(|job| job());
    }
}

/// Rayon's pool: that of the thread that calls, or the global one.
///
/// While a view is culled that has enough to do, the other threads of the pool wait busily: a
/// thread that sleeps takes longer to wake than most of what it is wanted for. They take other work
/// of the pool meanwhile, and then the cull returns no sooner than that is done.
#[cfg(feature = "rayon")]
#[derive(Clone, Copy, Debug, Default)]
pub struct Rayon;

#[cfg(feature = "rayon")]
impl Jobs for Rayon {
    fn threads(&self) -> usize {
        rayon::current_num_threads()
    }

    fn run(&self, jobs: &mut [Job<'_>]) {
        match jobs {
            [] => {}
            [job] => job(),
            _ => {
                let (some, others) = jobs.split_at_mut(jobs.len() / 2);
                rayon::join(|| self.run(some), || self.run(others));
            }
        }
    }

    fn keep_awake(&self, work: Job<'_>) {
        use core::sync::atomic::{AtomicBool, Ordering};

        /// Lets the others go, also where the work panics.
        struct Done<'a>(&'a AtomicBool);

        impl Drop for Done<'_> {
            fn drop(&mut self) {
                self.0.store(true, Ordering::Release);
            }
        }

        let is_done = AtomicBool::new(false);
        rayon::scope(|scope| {
            for _ in 1..rayon::current_num_threads().min(MOST) {
                scope.spawn(|_| {
                    while !is_done.load(Ordering::Acquire) {
                        if rayon::yield_now() != Some(rayon::Yield::Executed) {
                            core::hint::spin_loop();
                        }
                    }
                });
            }
            let _done = Done(&is_done);
            work();
        });
    }
}

/// The most jobs that a part of a cull is split into.
pub(crate) const MOST: usize = 8;

/// Returns into how many jobs work is split of which `least` is worth a job of its own: at the most
/// `each` for each thread, and one for one thread.
pub(crate) fn split(jobs: &dyn Jobs, work: f32, least: f32, each: usize) -> usize {
    if jobs.threads() <= 1 {
        return 1;
    }
    // What is not a number becomes one job.
    ((work / least) as usize).min(jobs.threads().saturating_mul(each)).clamp(1, MOST)
}

/// Works on each piece, as one job; on the first [`MOST`], which is all that a caller makes.
pub(crate) fn each<T: Send>(jobs: &dyn Jobs, pieces: &mut [T], work: impl Fn(&mut T) + Sync) {
    debug_assert!(pieces.len() <= MOST, "{}", pieces.len());
    let count = pieces.len().min(MOST);
    if let [piece] = pieces {
        return work(piece);
    }
    let mut pieces = pieces.iter_mut();
    let work = &work;
    let mut all: [_; MOST] = array::from_fn(|_| {
        let mut piece = pieces.next();
        move || {
            if let Some(piece) = &mut piece {
                work(piece);
            }
        }
    });
    jobs.run(&mut all.each_mut().map(|job| job as Job<'_>)[..count]);
}
