//! What a device makes, and whether it says that it could.

use wgpu::{Device, Error, ErrorFilter};

use super::error::GpuError;
use super::read_back::wait;

/// What `make` makes, unless the device says that it is not valid or has no room for it. In a browser, where nobody may wait for
/// that, the device says so later to whoever listens to its errors.
pub(crate) fn checked<T>(device: &Device, make: impl FnOnce() -> T) -> Result<T, GpuError> {
    if cfg!(target_arch = "wasm32") {
        return Ok(make());
    }
    wait(checked_later(device, make))
}

/// The same, awaited: for browsers too.
pub(crate) async fn checked_later<T>(
    device: &Device,
    make: impl FnOnce() -> T,
) -> Result<T, GpuError> {
    let memory = device.push_error_scope(ErrorFilter::OutOfMemory);
    // What a driver does not link is an internal error.
    let internal = device.push_error_scope(ErrorFilter::Internal);
    let validation = device.push_error_scope(ErrorFilter::Validation);
    let made = make();
    // The last that began ends first; they end here, and what they found is known later.
    let (validation, internal, memory) = (validation.pop(), internal.pop(), memory.pop());
    // Without memory what is made of it is not valid either: the cause is told.
    let found = [memory.await, validation.await, internal.await];
    found.into_iter().flatten().next().map_or(Ok(made), |error| Err(told(&error)))
}

/// What `make` makes, valid or not: nobody is told.
pub(crate) fn unchecked<T>(device: &Device, make: impl FnOnce() -> T) -> T {
    let internal = device.push_error_scope(ErrorFilter::Internal);
    let validation = device.push_error_scope(ErrorFilter::Validation);
    let made = make();
    // The last that began ends first.
    drop(validation);
    drop(internal);
    made
}

fn told(error: &Error) -> GpuError {
    let why = innermost(error);
    match error {
        Error::OutOfMemory { .. } => GpuError::OutOfMemory(why),
        _ => GpuError::Passes(why),
    }
}

/// What an error comes from.
fn innermost(error: &dyn std::error::Error) -> String {
    error.source().map_or_else(|| error.to_string(), innermost)
}
