//! How long a frame takes on the device, where it has a clock.

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

use eframe::wgpu::*;

/// Measures one frame at a time: while an answer is on its way, frames pass unmeasured.
#[derive(Debug)]
pub(super) struct Timer {
    queries: QuerySet,
    resolved: Buffer,
    read: Buffer,
    state: Arc<AtomicU8>,
    /// The last frame that was measured, in milliseconds.
    pub(super) last_ms: Option<f32>,
}

const IDLE: u8 = 0;
const WAITING: u8 = 1;
const READY: u8 = 2;
const FAILED: u8 = 3;

impl Timer {
    /// `None` where the device has no clock, or was opened without it.
    pub(super) fn new(device: &Device) -> Option<Self> {
        if !device.features().contains(Features::TIMESTAMP_QUERY) {
            return None;
        }
        let buffer = |label, usage| {
            device.create_buffer(&BufferDescriptor {
                label: Some(label),
                size: 16,
                usage,
                mapped_at_creation: false,
            })
        };
        Some(Self {
            queries: device.create_query_set(&QuerySetDescriptor {
                label: Some("start and end of a frame"),
                ty: QueryType::Timestamp,
                count: 2,
            }),
            resolved: buffer("times", BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC),
            read: buffer("times to read", BufferUsages::MAP_READ | BufferUsages::COPY_DST),
            state: Arc::new(AtomicU8::new(IDLE)),
            last_ms: None,
        })
    }

    /// Returns the timestamps that the pass of this frame writes, if it is measured. Reads those of
    /// an earlier frame.
    pub(super) fn start(&mut self, queue: &Queue) -> Option<RenderPassTimestampWrites<'_>> {
        match self.state.load(Ordering::Acquire) {
            READY => {
                if let Ok(bytes) = self.read.slice(..).get_mapped_range() {
                    let ticks: &[u64] = bytemuck::cast_slice(&bytes);
                    let span = ticks[1].saturating_sub(ticks[0]) as f64;
                    self.last_ms =
                        Some((span * f64::from(queue.get_timestamp_period()) / 1e6) as f32);
                }
                self.read.unmap();
                self.state.store(IDLE, Ordering::Release);
            }
            FAILED => self.state.store(IDLE, Ordering::Release),
            WAITING => return None,
            _ => {}
        }
        Some(RenderPassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(0),
            end_of_pass_write_index: Some(1),
        })
    }

    /// Has the times copied, after the pass.
    pub(super) fn resolve(&self, encoder: &mut CommandEncoder) {
        encoder.resolve_query_set(&self.queries, 0..2, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.read, 0, 16);
    }

    /// Asks for the times, after the frame was submitted.
    pub(super) fn submitted(&self) {
        self.state.store(WAITING, Ordering::Release);
        let state = self.state.clone();
        self.read.map_async(MapMode::Read, .., move |answer| {
            state.store(if answer.is_ok() { READY } else { FAILED }, Ordering::Release);
        });
    }
}
