//! Options that all bakes have: threads, units in a folder, shares, progress and cancelling.

use std::ffi::{c_char, c_void};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use cullet_bake::work::{Rounds, RunOptions, UnitFolder, run as run_rounds};

use crate::memory::{Plain, reserved, text, value};
use crate::status::{Error, Result, Status};

/// Threads, progress and units of a bake. Set it to zero before its fields. Nothing of it changes
/// what is baked.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct BakeOptions {
    /// Threads that work, up to 1024; 0 and 1 for one. They are the library's own, end before the
    /// call does, and have stacks of up to 8 MiB.
    pub threads: u32,
    /// Number of this share of the work, from 0 and below `share_count`.
    pub share: u32,
    /// Shares that the work is split into, each a call on any machine with the same folder and the
    /// same scene; 0 and 1 for all of it. A share does its own units, and those of others where the
    /// rest of the work needs them. Such a call returns `CULLET_STATUS_STOPPED` once its share lies
    /// in the folder and others are missing. A call without shares joins what is there.
    pub share_count: u32,
    /// 0.
    pub reserved: u32,
    /// Folder for finished units, UTF-8; it is made where it is not there. What lies there of the
    /// same scene and settings is not done again, so that a bake goes on after a stop. NULL for none.
    pub folder: *const c_char,
    /// Called after each unit of work with the share of it that is done, 0 to 1 and never falling;
    /// returns 1 to go on, and 0 to stop: the call then returns `CULLET_STATUS_STOPPED` as soon as
    /// the units that were begun are done. Called on threads of the bake, by one at a time, and no
    /// more once it returned 0. It may make calls, but none that changes the scene that is baked.
    /// NULL for none.
    pub step: Option<unsafe extern "C" fn(context: *mut c_void, share: f64) -> u32>,
    /// Handed to `step`.
    pub context: *mut c_void,
}

// The pointer to a function is called only where it is not NULL; that it is one is the caller's
// promise, as with any pointer.
impl Plain for BakeOptions {}

/// Options as they were given, checked.
pub(crate) struct Bake<'a> {
    pub(crate) threads: usize,
    shares: Option<[u32; 2]>,
    folder: Option<&'a str>,
    progress: Progress,
}

/// The most threads.
const MOST_THREADS: u32 = 1024;
/// Room for the deepest chain of portals.
const STACK: usize = 8 << 20;

impl Bake<'_> {
    /// Checks options; NULL is one thread alone.
    ///
    /// # Safety
    /// As the header asks of the caller: options that are there, and in them a text and a function
    /// that live until the call ends.
    pub(crate) unsafe fn of(options: *const BakeOptions) -> Result<Self> {
        if options.is_null() {
            let progress = Progress::new(None, std::ptr::null_mut());
            return Ok(Self { threads: 1, shares: None, folder: None, progress });
        }
        // SAFETY: the caller's promise.
        let of = unsafe { value("options", options) }?;
        reserved("options->reserved", of.reserved)?;
        if of.threads > MOST_THREADS {
            let message =
                format!("options->threads is {}: it must be 0 to {MOST_THREADS}", of.threads);
            return Err(Error::value(message));
        }
        let mut folder = None;
        if !of.folder.is_null() {
            // SAFETY: the caller's promise.
            folder = Some(unsafe { text("options->folder", of.folder) }?);
        }
        if of.share > 0 && of.share >= of.share_count {
            let message = format!(
                "options->share is {}: it must be below options->share_count, {}",
                of.share, of.share_count
            );
            return Err(Error::value(message));
        }
        let shares = (of.share_count > 1).then_some([of.share, of.share_count]);
        if shares.is_some() && folder.is_none() {
            let message = "options->folder is NULL: shares are joined in a folder, so name one";
            return Err(Error::value(message));
        }
        let progress = Progress::new(of.step, of.context);
        Ok(Self { threads: of.threads.max(1) as usize, shares, folder, progress })
    }

    /// Refuses units, for work that has none.
    pub(crate) fn no_units(&self) -> Result {
        match self.folder {
            None => Ok(()),
            Some(_) => Err(Error::value("options->folder: this bake has no units; leave it NULL")),
        }
    }

    /// Notes that so much is done; returns whether to go on.
    pub(crate) fn at(&self, share: f64) -> bool {
        self.progress.at(share)
    }

    /// Whether nobody stopped it.
    pub(crate) fn goes_on(&self) -> bool {
        !self.progress.is_stopped.load(Ordering::Relaxed)
    }

    /// Runs all rounds of a work.
    pub(crate) fn run(&self, work: &mut impl Rounds) -> Result {
        let failed = |e: std::io::Error| {
            let folder = self.folder.unwrap_or_default();
            Error::new(Status::File, format!("{folder}: a unit cannot be kept: {e}"))
        };
        let folder =
            self.folder.map(|path| UnitFolder::new(Path::new(path))).transpose().map_err(failed)?;
        let default = RunOptions::default();
        let (threads, share) = (self.threads, self.shares);
        let options = RunOptions { threads, folder: folder.as_ref(), share, ..default };
        run_rounds(work, &options, &|share| self.at(share)).map_err(failed)?;
        if !self.goes_on() {
            return Err(stopped());
        }
        if !work.costs().is_empty() {
            let message = "this share is done; call it without shares once all of them are";
            return Err(Error::new(Status::Stopped, message));
        }
        Ok(())
    }
}

pub(crate) fn stopped() -> Error {
    Error::new(Status::Stopped, "options->step stopped the bake")
}

/// Runs a bake on a thread whose stack is deep enough, whatever that of the caller is.
pub(crate) fn on_deep_stack<T: Send>(work: impl FnOnce() -> Result<T> + Send) -> Result<T> {
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, work);
        let thread = thread.map_err(|e| {
            Error::new(Status::Full, format!("no thread can be started for the bake: {e}"))
        })?;
        thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}

/// The caller's callback.
struct Progress {
    step: Mutex<Step>,
    is_stopped: AtomicBool,
}

struct Step {
    call: Option<unsafe extern "C" fn(context: *mut c_void, share: f64) -> u32>,
    context: *mut c_void,
    most: f64,
}

// SAFETY: the context is handed to the caller's own function alone, by one thread at a time; the
// header says that those are threads of the bake.
unsafe impl Send for Step {}

impl Progress {
    fn new(
        call: Option<unsafe extern "C" fn(*mut c_void, f64) -> u32>,
        context: *mut c_void,
    ) -> Self {
        let step = Mutex::new(Step { call, context, most: 0.0 });
        Self { step, is_stopped: AtomicBool::new(false) }
    }

    fn at(&self, share: f64) -> bool {
        let mut step = self.step.lock().unwrap_or_else(PoisonError::into_inner);
        if self.is_stopped.load(Ordering::Relaxed) {
            return false;
        }
        let Some(call) = step.call else { return true };
        // The first number is no NaN, so that it is taken where the second is one.
        step.most = step.most.max(share.min(1.0));
        // SAFETY: what the header says of `step` is the caller's promise.
        let goes_on = unsafe { call(step.context, step.most) } != 0;
        self.is_stopped.store(!goes_on, Ordering::Relaxed);
        goes_on
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Notes the shares, and stops at the third.
    unsafe extern "C" fn note(context: *mut c_void, share: f64) -> u32 {
        // SAFETY: the context is that of the test.
        let seen = unsafe { &mut *context.cast::<Vec<f64>>() };
        seen.push(share);
        u32::from(seen.len() < 3)
    }

    #[test]
    fn progress_never_falls_and_a_stopped_bake_calls_no_more() {
        let mut seen: Vec<f64> = Vec::new();
        let progress = Progress::new(Some(note), std::ptr::from_mut(&mut seen).cast());
        assert!(progress.at(0.5) && progress.at(0.25) && !progress.at(7.0) && !progress.at(0.9));
        assert_eq!(seen, [0.5, 0.5, 1.0]);
    }
}
