//! A device without a window: for tests, measurements and programs that have none of their own.

use std::pin::pin;
use std::task::{Context, Poll, Waker};

use wgpu::{
    Adapter, Buffer, BufferDescriptor, BufferUsages, Device, DeviceDescriptor, ErrorFilter,
    Features, Instance, InstanceDescriptor, MapMode, PollType, Queue, RequestAdapterOptions,
};

use super::error::GpuError;

/// A graphics device without a window.
#[derive(Debug)]
pub struct Gpu {
    /// The graphics card, or a program in its place.
    pub adapter: Adapter,
    /// Opened, with the adapter's own limits.
    pub device: Device,
    /// Where work for it is handed in.
    pub queue: Queue,
}

impl Gpu {
    /// The first adapter there is, with its own limits, and a clock and what [tiers](super::Tier) need where it has them; what the
    /// environment says of backends (`WGPU_BACKEND`) is followed.
    ///
    /// # Errors
    /// If there is none, or it cannot be opened.
    pub fn open() -> Result<Self, GpuError> {
        Self::open_with(Features::INDIRECT_FIRST_INSTANCE | Features::MULTI_DRAW_INDIRECT_COUNT)
    }

    /// The same with a clock, and those of some more features that the adapter has.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn open_with(more: Features) -> Result<Self, GpuError> {
        let instance = Instance::new(InstanceDescriptor::new_without_display_handle_from_env());
        let adapter = wait(instance.request_adapter(&RequestAdapterOptions::default()))
            .map_err(|e| GpuError::NoAdapter(e.to_string()))?;
        let wanted = DeviceDescriptor {
            required_limits: adapter.limits(),
            required_features: adapter.features() & (Features::TIMESTAMP_QUERY | more),
            ..DeviceDescriptor::default()
        };
        let opened = wait(adapter.request_device(&wanted));
        let (device, queue) = opened.map_err(|e| GpuError::NoDevice {
            adapter: adapter.get_info().name,
            why: e.to_string(),
        })?;
        Ok(Self { adapter, device, queue })
    }

    /// Waits until the device has nothing left to do.
    ///
    /// # Errors
    /// If it is lost.
    pub fn finish(&self) -> Result<(), GpuError> {
        let polled = self.device.poll(PollType::wait_indefinitely());
        polled.map(|_| ()).map_err(|e| GpuError::Lost(e.to_string()))
    }

    /// What a buffer holds, when all work before is done; it must have been made to be copied from.
    ///
    /// # Errors
    /// If the device is lost.
    pub fn read(&self, buffer: &Buffer, bytes: u64) -> Result<Vec<u8>, GpuError> {
        if bytes == 0 {
            return Ok(Vec::new());
        }
        // Of a lost device every buffer is invalid.
        let lost = |error| match error {
            GpuError::Passes(why) => GpuError::Lost(why),
            other => other,
        };
        let copy = || {
            let to = self.device.create_buffer(&BufferDescriptor {
                label: Some("read back"),
                size: bytes,
                usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
                mapped_at_creation: false,
            });
            let mut encoder = self.device.create_command_encoder(&Default::default());
            encoder.copy_buffer_to_buffer(buffer, 0, &to, 0, bytes);
            self.queue.submit([encoder.finish()]);
            to.map_async(MapMode::Read, .., |_| {});
            to
        };
        let to = checked(&self.device, copy).map_err(lost)?;
        self.finish()?;
        let mapped = to.get_mapped_range(..).map_err(|e| GpuError::Lost(e.to_string()))?;
        Ok(mapped.to_vec())
    }
}

/// What `make` makes, unless the device says that it is not valid. In a browser, where nobody may wait for that, it says so later.
pub(crate) fn checked<T>(device: &Device, make: impl FnOnce() -> T) -> Result<T, GpuError> {
    if cfg!(target_arch = "wasm32") {
        return Ok(make());
    }
    // What a driver does not link is an internal error.
    let outer = device.push_error_scope(ErrorFilter::Internal);
    let inner = device.push_error_scope(ErrorFilter::Validation);
    let made = make();
    let found = [wait(inner.pop()), wait(outer.pop())];
    match found.into_iter().flatten().next() {
        None => Ok(made),
        Some(error) => Err(GpuError::Passes(innermost(&error))),
    }
}

/// What an error comes from.
fn innermost(error: &dyn std::error::Error) -> String {
    error.source().map_or_else(|| error.to_string(), innermost)
}

fn wait<T>(future: impl Future<Output = T>) -> T {
    let mut future = pin!(future);
    loop {
        if let Poll::Ready(value) = future.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
            return value;
        }
        std::thread::yield_now();
    }
}
