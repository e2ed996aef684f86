//! A device without a window: for tests, measurements and programs that have none of their own.

use std::sync::{Arc, OnceLock};

use wgpu::util::new_instance_with_webgpu_detection;
use wgpu::{
    Adapter, Buffer, BufferDescriptor, BufferUsages, Device, DeviceDescriptor, DeviceLostReason,
    Features, Instance, InstanceDescriptor, Limits, PollType, Queue, RequestAdapterOptions,
};

use super::checked::checked_later;
use super::error::GpuError;
use super::read_back::{mapped, wait};

/// A graphics device without a window.
#[derive(Debug)]
pub struct Gpu {
    /// The graphics card, or a program in its place.
    pub adapter: Adapter,
    /// Opened.
    pub device: Device,
    /// Where work for it is handed in.
    pub queue: Queue,
    /// Why it went away, once it has.
    lost: Arc<OnceLock<String>>,
}

impl Gpu {
    /// The first adapter there is, with its own limits, and a clock and what [tiers](super::Tier) need where it has them; what the
    /// environment says of backends (`WGPU_BACKEND`) is followed. Not in browsers: see [`request`](Self::request).
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
        wait(Self::request(Features::TIMESTAMP_QUERY | more, None))
    }

    /// The same with no optional feature, and with limits of one's own, as a lesser device has them.
    ///
    /// # Errors
    /// As [`open`](Self::open), and if the adapter has less than these limits.
    pub fn open_least(limits: Limits) -> Result<Self, GpuError> {
        wait(Self::request(Features::empty(), Some(limits)))
    }

    /// Opens the first adapter with those of some features that it has, and with its own limits where none are given. It is awaited: in
    /// a browser, where nobody may wait, there is no other way.
    ///
    /// # Errors
    /// If there is no adapter, or it cannot be opened like this.
    pub async fn request(features: Features, limits: Option<Limits>) -> Result<Self, GpuError> {
        let environment = InstanceDescriptor::new_without_display_handle_from_env();
        Self::on(&new_instance_with_webgpu_detection(environment).await, features, limits).await
    }

    /// The same of an instance of one's own, whatever the environment says.
    ///
    /// # Errors
    /// As [`request`](Self::request).
    pub async fn on(
        instance: &Instance,
        features: Features,
        limits: Option<Limits>,
    ) -> Result<Self, GpuError> {
        let adapter = instance.request_adapter(&RequestAdapterOptions::default()).await;
        let adapter = adapter.map_err(|e| GpuError::NoAdapter(e.to_string()))?;
        let wanted = DeviceDescriptor {
            required_limits: limits.unwrap_or_else(|| adapter.limits()),
            required_features: adapter.features() & features,
            ..DeviceDescriptor::default()
        };
        let opened = adapter.request_device(&wanted).await;
        let (device, queue) = opened.map_err(|e| GpuError::NoDevice {
            adapter: adapter.get_info().name,
            why: e.to_string(),
        })?;
        let lost = Arc::new(OnceLock::new());
        let told = lost.clone();
        device.set_device_lost_callback(move |reason, message| {
            // Only the first reason is one.
            let _ = told.set(why_lost(reason, &message));
        });
        Ok(Self { adapter, device, queue, lost })
    }

    /// Waits until the device has nothing left to do. In a browser it only asks whether the device is still there.
    ///
    /// # Errors
    /// If it is lost.
    pub fn finish(&self) -> Result<(), GpuError> {
        let polled = self.device.poll(PollType::wait_indefinitely());
        self.is_there()?;
        polled.map(|_| ()).map_err(|e| GpuError::Lost(e.to_string()))
    }

    /// Whether the device is still there, as far as is known: it says so itself, at the latest when it is [waited for](Self::finish).
    ///
    /// # Errors
    /// If it is lost.
    pub fn is_there(&self) -> Result<(), GpuError> {
        self.lost.get().map_or(Ok(()), |why| Err(GpuError::Lost(why.clone())))
    }

    /// What a buffer holds, when all work before is done; it must have been made to be copied from. Not in browsers: see
    /// [`read_later`](Self::read_later).
    ///
    /// # Errors
    /// If the device is lost, or has no memory left for a copy.
    pub fn read(&self, buffer: &Buffer, bytes: u64) -> Result<Vec<u8>, GpuError> {
        wait(self.read_later(buffer, bytes))
    }

    /// The same, awaited: for browsers too.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub async fn read_later(&self, buffer: &Buffer, bytes: u64) -> Result<Vec<u8>, GpuError> {
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
            let ready = mapped(&to);
            (to, ready)
        };
        let (to, ready) = checked_later(&self.device, copy).await.map_err(lost)?;
        self.finish()?;
        ready.await.map_err(|e| GpuError::Lost(e.to_string()))?;
        let mapped = to.get_mapped_range(..).map_err(|e| GpuError::Lost(e.to_string()))?;
        Ok(mapped.to_vec())
    }
}

fn why_lost(reason: DeviceLostReason, message: &str) -> String {
    match (reason, message.trim().trim_end_matches('.')) {
        (DeviceLostReason::Destroyed, "") => "it was closed".to_owned(),
        (_, "") => "the driver does not say why".to_owned(),
        (_, message) => message.to_owned(),
    }
}
