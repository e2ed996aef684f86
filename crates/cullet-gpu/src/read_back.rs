//! Waiting for what a device says: here, or in a program that may not wait.

use std::future::poll_fn;
use std::pin::pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, Waker};

use wgpu::{Buffer, BufferAsyncError, MapMode};

/// State of a buffer that is being mapped, and who waits for it.
#[derive(Default)]
struct Mapping {
    answer: Option<Result<(), BufferAsyncError>>,
    waker: Option<Waker>,
}

/// Begins at once to map a buffer for reading; ready when the device has done all before it.
pub(crate) fn mapped(
    buffer: &Buffer,
) -> impl Future<Output = Result<(), BufferAsyncError>> + use<> {
    fn look(mapping: &Mutex<Mapping>) -> MutexGuard<'_, Mapping> {
        mapping.lock().unwrap_or_else(PoisonError::into_inner)
    }
    let mapping = Arc::new(Mutex::new(Mapping::default()));
    let told = mapping.clone();
    buffer.map_async(MapMode::Read, .., move |answer| {
        let mut told = look(&told);
        told.answer = Some(answer);
        if let Some(waker) = told.waker.take() {
            waker.wake();
        }
    });
    poll_fn(move |context| {
        let mut mapping = look(&mapping);
        match mapping.answer.take() {
            Some(answer) => Poll::Ready(answer),
            None => {
                mapping.waker = Some(context.waker().clone());
                Poll::Pending
            }
        }
    })
}

/// Waits for what a device says later. Not in browsers, where it comes when nobody waits.
pub fn wait<T>(future: impl Future<Output = T>) -> T {
    let mut future = pin!(future);
    loop {
        if let Poll::Ready(value) = future.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
            return value;
        }
        std::thread::yield_now();
    }
}
