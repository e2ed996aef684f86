//! Work beside the window: in a thread natively, at once on a web page, which has none.

use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};

/// Progress of a task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress<T> {
    /// It is not finished.
    Working,
    /// It is finished.
    Done(T),
    /// It ended without a result: a fault of ours, or no thread was to be had.
    Lost,
}

/// Some work under way.
#[derive(Debug)]
pub struct Task<T> {
    result: Receiver<T>,
}

impl<T: Send + 'static> Task<T> {
    /// Begins; `wake` is called when it is finished, so that the window looks.
    pub fn start(
        work: impl FnOnce() -> T + Send + 'static,
        wake: impl FnOnce() + Send + 'static,
    ) -> Self {
        let (send, task) = Self::waiting();
        let run = move || {
            // Nobody listens any more when the user has gone on to something else.
            let _ = send.send(work());
            wake();
        };
        #[cfg(not(target_arch = "wasm32"))]
        {
            // Without a thread the sender is dropped, which is told as `Lost`.
            let _ = std::thread::Builder::new().name("cullet work".to_owned()).spawn(run);
        }
        #[cfg(target_arch = "wasm32")]
        run();
        task
    }

    /// Work that is done elsewhere: its result is sent to the first of the two.
    #[must_use]
    pub fn waiting() -> (Sender<T>, Self) {
        let (send, result) = channel();
        (send, Self { result })
    }

    /// Returns its progress. A result is returned once.
    pub fn poll(&self) -> Progress<T> {
        match self.result.try_recv() {
            Ok(result) => Progress::Done(result),
            Err(TryRecvError::Empty) => Progress::Working,
            Err(TryRecvError::Disconnected) => Progress::Lost,
        }
    }
}

/// Nanoseconds since some moment, the same for the whole run: the clock that cullers are given.
#[must_use]
pub fn clock() -> u64 {
    static BEGAN: std::sync::OnceLock<web_time::Instant> = std::sync::OnceLock::new();
    BEGAN.get_or_init(web_time::Instant::now).elapsed().as_nanos() as u64
}

/// For how many nanoseconds at a time a page, which has one thread, may be kept from drawing.
pub(crate) const SLICE: u64 = 12_000_000;

/// Until when work may go on that began at some moment and can be left half done: natively to its
/// end.
pub(crate) fn until(began: u64) -> u64 {
    if cfg!(target_arch = "wasm32") { began + SLICE } else { u64::MAX }
}
