//! Long work off the interpreter's thread, which Ctrl-C ends.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

/// How often the interpreter is asked whether somebody pressed Ctrl-C.
const LOOK: Duration = Duration::from_millis(50);

/// Runs work on a thread of its own while others of the interpreter go on. The work is to end soon once its argument is
/// true, and then the call raises what the interpreter has to raise.
pub(crate) fn interruptible<R: Send>(
    py: Python<'_>,
    work: impl FnOnce(&Arc<AtomicBool>) -> R + Send,
) -> PyResult<R> {
    let stop = Arc::new(AtomicBool::new(false));
    std::thread::scope(|threads| {
        let (done, end) = channel::<()>();
        let stop = &stop;
        let job = move || {
            // Dropped when the work ends, however it ends.
            let _done = done;
            work(stop)
        };
        let worker = std::thread::Builder::new()
            .spawn_scoped(threads, job)
            .map_err(|e| PyRuntimeError::new_err(format!("no thread can be started: {e}")))?;
        let mut raised = Ok(());
        let end = std::sync::Mutex::new(end);
        while py.detach(|| {
            let end = end.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            end.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout)
        }) {
            if raised.is_ok() {
                raised = py.check_signals();
                stop.store(raised.is_err(), Ordering::Relaxed);
            }
        }
        let ended = py.detach(|| worker.join());
        raised?;
        ended.map_err(|_| {
            PyRuntimeError::new_err("the engine ended with a fault of its own; please report it")
        })
    })
}

/// Runs work on so many threads of its own; 0 is those of rayon's pool.
pub(crate) fn on_threads<R: Send>(threads: usize, work: impl FnOnce() -> R + Send) -> R {
    if threads > 0
        && let Ok(pool) = rayon::ThreadPoolBuilder::new().num_threads(threads).build()
    {
        return pool.install(work);
    }
    work()
}
