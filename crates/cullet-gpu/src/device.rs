//! A device without a window: for tests, measurements and programs that have none of their own.

use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use wgpu::util::new_instance_with_webgpu_detection;
use wgpu::{
    Adapter, Backend, Backends, Buffer, BufferDescriptor, BufferUsages, Device, DeviceDescriptor,
    DeviceLostReason, DeviceType, Features, Instance, InstanceDescriptor, Limits, PollType, Queue,
};

use super::checked::{checked_later, refusal};
use super::error::GpuError;
use super::read_back::{mapped, wait};
use super::tier::{Tier, cure, described};

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
    refused: Refused,
}

/// The first error that no error scope caught, until it is returned.
type Refused = Arc<Mutex<Option<GpuError>>>;

fn look(refused: &Refused) -> MutexGuard<'_, Option<GpuError>> {
    refused.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Gpu {
    /// Opens the best adapter that has a tier, with its own limits, a clock, and what the tiers
    /// above take where it has them. `WGPU_BACKEND` is followed. Not in browsers: see
    /// [`request`](Self::request).
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`] names the adapters that were found, what each lacks, and what to do;
    /// [`GpuError::NoDevice`] if one has the tier and cannot be opened.
    pub fn open(least: Tier) -> Result<Self, GpuError> {
        let features = Features::TIMESTAMP_QUERY | Tier::MultiDrawCount.features();
        wait(Self::request(least, features, None))
    }

    /// Opens an adapter that has a tier with these limits and no feature beyond the tier's, as a
    /// lesser device has them.
    ///
    /// # Errors
    /// As [`open`](Self::open). An adapter that has less than these limits cannot be opened.
    pub fn open_least(least: Tier, limits: Limits) -> Result<Self, GpuError> {
        wait(Self::request(least, Features::empty(), Some(limits)))
    }

    /// Opens the best adapter that has a tier, with those of `features` that it has, and with its
    /// own limits unless `limits` are given. It is awaited: in a browser, where nobody may wait,
    /// there is no other way.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub async fn request(
        least: Tier,
        features: Features,
        limits: Option<Limits>,
    ) -> Result<Self, GpuError> {
        let environment = InstanceDescriptor::new_without_display_handle_from_env();
        let instance = new_instance_with_webgpu_detection(environment).await;
        Self::on(&instance, least, features, limits).await
    }

    /// Does the same with an instance of the caller's own, whatever the environment says.
    ///
    /// # Errors
    /// As [`request`](Self::request).
    pub async fn on(
        instance: &Instance,
        least: Tier,
        features: Features,
        limits: Option<Limits>,
    ) -> Result<Self, GpuError> {
        let adapter = adapter(instance, least).await?;
        let wanted = DeviceDescriptor {
            required_limits: limits.unwrap_or_else(|| adapter.limits()),
            required_features: least.features() | (adapter.features() & features),
            ..DeviceDescriptor::default()
        };
        let opened = adapter.request_device(&wanted).await;
        let (device, queue) = opened.map_err(|e| GpuError::NoDevice {
            adapter: described(&adapter.get_info()),
            why: e.to_string(),
        })?;
        let (lost, refused) = (Arc::new(OnceLock::new()), Arc::new(Mutex::new(None)));
        let told = lost.clone();
        device.set_device_lost_callback(move |reason, message| {
            // Only the first reason is one.
            let _ = told.set(why_lost(reason, &message));
        });
        let told: Refused = refused.clone();
        device.on_uncaptured_error(Arc::new(move |error| {
            // The first error is the cause of the others.
            look(&told).get_or_insert_with(|| refusal(&error));
        }));
        Ok(Self { adapter, device, queue, lost, refused })
    }

    /// Returns the tier that the device was opened with.
    #[must_use]
    pub fn tier(&self) -> Tier {
        Tier::of(&self.device)
    }

    /// Waits until the device has nothing left to do. In a browser it only asks whether the device
    /// is still there.
    ///
    /// # Errors
    /// If it is lost, or has refused something that was recorded or made since the last call.
    pub fn finish(&self) -> Result<(), GpuError> {
        let polled = self.device.poll(PollType::wait_indefinitely());
        self.is_there()?;
        look(&self.refused).take().map_or(Ok(()), Err)?;
        polled.map(|_| ()).map_err(|e| GpuError::Lost(e.to_string()))
    }

    /// Whether the device is still there, as far as is known: it says so itself, at the latest when
    /// it is [waited for](Self::finish).
    ///
    /// # Errors
    /// If it is lost.
    pub fn is_there(&self) -> Result<(), GpuError> {
        self.lost.get().map_or(Ok(()), |why| Err(GpuError::Lost(why.clone())))
    }

    /// Reads a buffer when all work before is done; it must have been made to be copied from. Not
    /// in browsers: see [`read_later`](Self::read_later).
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

/// Stands in [`GpuError::NoAdapter`] for the adapters that were found.
pub(crate) const NONE: &str = "none was found";

/// Finds the best adapter that has a tier: one that is no program in the place of a graphics card
/// before one that is, then any other backend before OpenGL, then the first that is listed.
async fn adapter(instance: &Instance, least: Tier) -> Result<Adapter, GpuError> {
    let mut found = instance.enumerate_adapters(Backends::all()).await;
    found.sort_by_key(|adapter| {
        let info = adapter.get_info();
        (info.device_type == DeviceType::Cpu, info.backend == Backend::Gl)
    });
    let mut lacks = Vec::new();
    for adapter in found {
        let Some(lack) = least.lack(&adapter) else { return Ok(adapter) };
        lacks.push(format!("{}: {lack}", described(&adapter.get_info())));
    }
    let found = if lacks.is_empty() { NONE.to_owned() } else { lacks.join("; ") };
    Err(GpuError::NoAdapter { tier: least, found, cure: cure() })
}

fn why_lost(reason: DeviceLostReason, message: &str) -> String {
    match (reason, message.trim().trim_end_matches('.')) {
        (DeviceLostReason::Destroyed, "") => "it was closed".to_owned(),
        (_, "") => "the driver does not say why".to_owned(),
        (_, message) => message.to_owned(),
    }
}
