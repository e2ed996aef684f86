//! Drawing without a window: a device, and pictures read back from it.

use std::pin::pin;
use std::task::{Context, Poll, Waker};

use eframe::wgpu::{
    Adapter, BufferDescriptor, BufferUsages, COPY_BYTES_PER_ROW_ALIGNMENT, Device,
    DeviceDescriptor, Features, Instance, InstanceDescriptor, MapMode, PollType, Queue,
    RequestAdapterOptions, TexelCopyBufferInfo, TexelCopyBufferLayout,
};

use crate::draw::Renderer;

/// A graphics device without a window.
#[derive(Debug)]
pub struct Gpu {
    /// The graphics card, or a program in its place.
    pub adapter: Adapter,
    /// Opened.
    pub device: Device,
    /// Where work for it is handed in.
    pub queue: Queue,
}

impl Gpu {
    /// The first adapter there is, with its own limits and a clock where it has one; what the environment says
    /// of backends (`WGPU_BACKEND`) is followed. `None` where there is no adapter.
    #[must_use]
    pub fn open() -> Option<Self> {
        let instance = Instance::new(InstanceDescriptor::new_without_display_handle_from_env());
        let adapter = wait(instance.request_adapter(&RequestAdapterOptions::default())).ok()?;
        let asked = DeviceDescriptor {
            required_limits: adapter.limits(),
            required_features: adapter.features() & Features::TIMESTAMP_QUERY,
            ..DeviceDescriptor::default()
        };
        let (device, queue) = wait(adapter.request_device(&asked)).ok()?;
        Some(Self { adapter, device, queue })
    }

    /// Waits until the device has nothing left to do; false if it is lost.
    pub fn finish(&self) -> bool {
        self.device.poll(PollType::wait_indefinitely()).is_ok()
    }

    /// The renderer's picture, when it is finished: width, height and RGBA. `None` if the device is lost.
    #[must_use]
    pub fn read(&self, renderer: &Renderer) -> Option<([u32; 2], Vec<[u8; 4]>)> {
        let texture = renderer.colour().texture();
        let size = [texture.width(), texture.height()];
        let row = (size[0] * 4).next_multiple_of(COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = self.device.create_buffer(&BufferDescriptor {
            label: Some("read back"),
            size: u64::from(row) * u64::from(size[1]),
            usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let layout =
            TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            TexelCopyBufferInfo { buffer: &buffer, layout },
            texture.size(),
        );
        self.queue.submit([encoder.finish()]);
        buffer.map_async(MapMode::Read, .., |_| {});
        if !self.finish() {
            return None;
        }
        let bytes = buffer.get_mapped_range(..).ok()?;
        let rows = bytes.chunks_exact(row as usize);
        let pixels = rows.flat_map(|r| r[..size[0] as usize * 4].as_chunks::<4>().0).copied();
        Some((size, pixels.collect()))
    }
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
