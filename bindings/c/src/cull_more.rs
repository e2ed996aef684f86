//! Culls that know more than a scene and a view: candidates, both eyes of a headset, and threads of
//! the caller's.

use std::ffi::c_void;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use engine::candidates::Candidates;
use engine::jobs::{Job, Jobs as EngineJobs};

use crate::cull::{Asked, STATES, State, cull, given, settings_of};
use crate::memory::{Out, Plain, read, reserved, value};
use crate::results::write;
use crate::scene::{SCENES, Scene};
use crate::settings::Settings;
use crate::status::{Error, Status, call};
use crate::view::{View, to_engine};

/// Culls as `cullet_cull` does, among candidates: instances that may be visible for all that you
/// know, by fog of war, streaming or what an editor isolates. Bit s mod 64 of word s / 64 is that of
/// slot s; there must be as many words as the scene's `slot_count` needs. All others are culled
/// after the frustum, by `CULLET_STAGE_PVS`; instances that are always visible stay. The words are
/// not kept, and so is no answer: each call culls. Cells of the scene play no part.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_cull_among(
    scene: Scene,
    view: *const View,
    settings: *const Settings,
    words: *const u64,
    word_count: usize,
    state: State,
) -> Status {
    call("cullet_cull_among", || {
        // SAFETY: as the header asks of the caller.
        let view = unsafe { value("view", view) }?;
        // SAFETY: as the header asks of the caller.
        let words = unsafe { read("words", words, word_count) }?;
        let (seen, culler) = (to_engine(&view)?, settings_of(settings)?);
        let scene = SCENES.get(scene.id)?;
        let mut state = STATES.get_mut(state.id)?;
        words.check(&scene).map_err(|e| Error::value(e.to_string()))?;
        state.answer(&scene, (Asked::Among, view, given(settings)?), &culler, |own, visible| {
            let done = culler.cull_among(&scene, &seen, &words, own, visible);
            done.map_err(|e| Error::value(e.to_string()))
        })
    })
}

/// Culls once for both eyes of a headset: what either eye sees stays, and what is hidden from both
/// goes. Perspective views of the same viewport, depth and layers, turned against each other by less
/// than a right angle. Back faces are culled by whole clusters alone, and cells cull nothing. Cost:
/// little more than that of one view. Otherwise as `cullet_cull`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_cull_stereo(
    scene: Scene,
    left: *const View,
    right: *const View,
    settings: *const Settings,
    state: State,
) -> Status {
    call("cullet_cull_stereo", || {
        // SAFETY: as the header asks of the caller.
        let left = unsafe { value("left", left) }?;
        // SAFETY: as the header asks of the caller.
        let right = to_engine(&unsafe { value("right", right) }?)?;
        let both = engine::View::stereo(&to_engine(&left)?, &right)
            .map_err(|e| Error::new(Status::View, e.to_string()))?;
        let culler = settings_of(settings)?;
        let scene = SCENES.get(scene.id)?;
        let mut state = STATES.get_mut(state.id)?;
        state.answer(&scene, (Asked::Stereo, left, given(settings)?), &culler, |own, visible| {
            culler.cull_one(&scene, &both, own, visible);
            Ok(())
        })
    })
}

/// Writes which eye may see each slot of `cullet_visible_slots`, a byte each in that order: bit 0
/// for `left`, bit 1 for `right`, at least one of them. The views are those of
/// `cullet_cull_stereo`; `capacity` and `count` as for `cullet_visible_slots`. The scene must be as
/// it was culled.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_visible_eyes(
    state: State,
    scene: Scene,
    left: *const View,
    right: *const View,
    eyes: *mut u8,
    capacity: usize,
    count: *mut usize,
) -> Status {
    call("cullet_visible_eyes", || {
        // SAFETY: as the header asks of the caller.
        let left = to_engine(&unsafe { value("left", left) }?)?;
        // SAFETY: as the header asks of the caller.
        let right = to_engine(&unsafe { value("right", right) }?)?;
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::array("eyes", eyes, capacity) }?;
        // SAFETY: as the header asks of the caller.
        let mut count = unsafe { Out::one("count", count) }?;
        let scene = SCENES.get(scene.id)?;
        let state = STATES.get(state.id)?;
        state.check_scene(&scene)?;
        let eyes = state.visible.by_eye(&scene, &left, &right).map(|(_, eyes)| eyes);
        write(&mut out, &mut count, eyes, state.slot_count())
    })
}

/// Threads of yours that run jobs: your pool.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Jobs {
    /// How many jobs run side by side, the calling thread included; at least 1.
    pub threads: u32,
    /// 0.
    pub reserved: u32,
    /// Calls `job(jobs, 0)`, `job(jobs, 1)` and so on below `count`, each once, in any order and on
    /// any threads, and returns when all have returned. What it leaves out runs on the calling
    /// thread afterwards; a job that it calls twice runs once.
    pub run: Option<
        unsafe extern "C" fn(
            context: *mut c_void,
            job: Option<unsafe extern "C" fn(jobs: *mut c_void, number: usize)>,
            jobs: *mut c_void,
            count: usize,
        ),
    >,
    /// Handed to `run`.
    pub context: *mut c_void,
}

// The pointer to a function is called only where it is not NULL; that it is one is the caller's
// promise, as with any pointer.
impl Plain for Jobs {}

/// The pool of a caller for the length of a call.
struct Pool(Jobs);

// SAFETY: `run` and `context` are handed to the caller's own function alone, from the thread that
// made the call.
unsafe impl Sync for Pool {}

/// Jobs while they are run.
struct Batch {
    /// The first of `count` jobs, as `*mut Job`.
    jobs: *mut c_void,
    count: usize,
    /// Bits of the jobs that were begun, and of those that are done.
    begun: AtomicU64,
    done: AtomicU64,
    has_panicked: AtomicBool,
}

/// The most jobs of one run; the engine makes fewer.
const MOST: usize = 64;

/// Runs a job of a batch, unless it was begun before or there is none of that number.
///
/// # Safety
/// `batch` must point to a [`Batch`] whose jobs are there.
unsafe extern "C" fn run_job(batch: *mut c_void, number: usize) {
    // SAFETY: the caller's promise.
    let batch = unsafe { &*batch.cast::<Batch>() };
    if number >= batch.count
        || batch.begun.fetch_or(1 << number, Ordering::AcqRel) >> number & 1 == 1
    {
        return;
    }
    let job = batch.jobs.cast::<Job<'_>>();
    // SAFETY: the job is there, and this is the one thread that has begun it.
    let job = unsafe { &mut *job.add(number) };
    if catch_unwind(AssertUnwindSafe(job)).is_err() {
        batch.has_panicked.store(true, Ordering::Release);
    }
    batch.done.fetch_or(1 << number, Ordering::AcqRel);
}

impl EngineJobs for Pool {
    fn threads(&self) -> usize {
        self.0.threads as usize
    }

    fn run(&self, jobs: &mut [Job<'_>]) {
        let count = jobs.len();
        let Some(run) = self.0.run.filter(|_| (2..=MOST).contains(&count)) else {
            return jobs.iter_mut().for_each(|job| job());
        };
        let batch = Batch {
            jobs: jobs.as_mut_ptr().cast(),
            count,
            begun: AtomicU64::new(0),
            done: AtomicU64::new(0),
            has_panicked: AtomicBool::new(false),
        };
        let pointer = std::ptr::from_ref(&batch).cast_mut().cast();
        // SAFETY: what the header says of `run` is the caller's promise.
        unsafe { run(self.0.context, Some(run_job), pointer, count) };
        for number in 0..count {
            // SAFETY: the batch is the one above.
            unsafe { run_job(pointer, number) };
        }
        // A job that was begun elsewhere must not outlive what it works on.
        while batch.done.load(Ordering::Acquire).count_ones() as usize != count {
            std::thread::yield_now();
        }
        assert!(!batch.has_panicked.load(Ordering::Acquire), "a job panicked");
    }
}

/// Culls as `cullet_cull` does, with the same answer, on threads of yours: `jobs->run` is called,
/// from this thread, some times in a call that has enough to do for several, and not at all in
/// others. It must not use `state`. Occlusion alone is split into jobs; to cull several views at
/// once, calls of `cullet_cull` side by side do better. A scene with cells is culled on the calling
/// thread. `state` is larger by a few hundred kilobytes for each thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_cull_on(
    jobs: *const Jobs,
    scene: Scene,
    view: *const View,
    settings: *const Settings,
    state: State,
) -> Status {
    call("cullet_cull_on", || {
        // SAFETY: as the header asks of the caller.
        let jobs = unsafe { value("jobs", jobs) }?;
        reserved("jobs->reserved", jobs.reserved)?;
        if jobs.threads == 0 {
            return Err(Error::value("jobs->threads is 0: it must be at least 1"));
        }
        if jobs.run.is_none() {
            let message = "jobs->run is NULL: it must be a function that runs jobs";
            return Err(Error::new(Status::NullPointer, message));
        }
        // SAFETY: as the header asks of the caller.
        let view = unsafe { value("view", view) }?;
        cull(scene, view, settings, state, Some(&Pool(jobs)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Calls jobs from two threads, the second one twice, and leaves out the last.
    unsafe extern "C" fn badly(
        context: *mut c_void,
        job: Option<unsafe extern "C" fn(*mut c_void, usize)>,
        jobs: *mut c_void,
        count: usize,
    ) {
        // SAFETY: the context is that of the test.
        let calls = unsafe { &*context.cast::<AtomicU64>() };
        calls.fetch_add(1, Ordering::Relaxed);
        let (job, address) = (job.unwrap(), jobs.expose_provenance());
        std::thread::scope(|scope| {
            for part in 0..2 {
                scope.spawn(move || {
                    for number in (part..count - 1).step_by(2).chain([1, 1, count, 9999]) {
                        // SAFETY: the jobs live until this function returns.
                        unsafe { job(std::ptr::with_exposed_provenance_mut(address), number) };
                    }
                });
            }
        });
    }

    #[test]
    fn each_job_runs_once_however_a_pool_calls_them() {
        let calls = AtomicU64::new(0);
        let context = std::ptr::from_ref(&calls).cast_mut().cast();
        let pool = Pool(Jobs { threads: 2, reserved: 0, run: Some(badly), context });
        let mut counts = [0; 7];
        let mut work = counts.each_mut().map(|count| move || *count += 1);
        let mut jobs = work.each_mut().map(|job| job as Job<'_>);
        pool.run(&mut jobs);
        pool.run(&mut jobs[..1]);
        assert_eq!(counts, [2, 1, 1, 1, 1, 1, 1]);
        assert_eq!(calls.into_inner(), 1);
        let mut work = [(); 3].map(|()| || assert_eq!(counts[0], 0, "a job that panics"));
        let mut jobs = work.each_mut().map(|job| job as Job<'_>);
        let status = call("test", || {
            let calls = AtomicU64::new(0);
            let context = std::ptr::from_ref(&calls).cast_mut().cast();
            Pool(Jobs { threads: 2, reserved: 0, run: Some(badly), context }).run(&mut jobs);
            Ok(())
        });
        assert_eq!(status, Status::Internal);
    }
}
