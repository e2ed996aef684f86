//! Figures of the device's decision: read back when it is done, some frames later, so that nobody
//! waits for it.

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

use cullet_gpu::DrawArguments;
use eframe::wgpu::*;

use super::super::frame::{DeviceFigures, DeviceTimes};

/// Measures one frame at a time: while an answer is on its way, frames pass unmeasured.
#[derive(Debug)]
pub(super) struct Measuring {
    /// Where the device has a clock.
    clock: Option<(QuerySet, Buffer)>,
    read: Buffer,
    /// Bytes of what is copied: bits in the view, visible bits, arguments of the early phase and of
    /// what is listed.
    sizes: [u64; 4],
    draws: usize,
    state: Arc<AtomicU8>,
    /// Frames so far.
    pub(super) frames: u64,
    /// The frame whose figures are on their way.
    asked: u64,
    /// The newest figures.
    pub(super) last: DeviceFigures,
}

const IDLE: u8 = 0;
const ASKED: u8 = 1;
const WAITING: u8 = 2;
const READY: u8 = 3;
const FAILED: u8 = 4;

/// Times that are taken in a frame.
const MARKS: u32 = 5;

/// Bytes before the first of what is copied.
const TIMES: u64 = MARKS as u64 * 8;

impl Measuring {
    pub(super) fn new(device: &Device, sizes: [u64; 4], draws: usize) -> Self {
        let buffer = |label, size, usage| {
            let descriptor =
                BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false };
            device.create_buffer(&descriptor)
        };
        let clock = device.features().contains(Features::TIMESTAMP_QUERY).then(|| {
            let queries = device.create_query_set(&QuerySetDescriptor {
                label: Some("steps of culling"),
                ty: QueryType::Timestamp,
                count: MARKS,
            });
            let usage = BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC;
            (queries, buffer("times of culling", TIMES, usage))
        });
        let read = BufferUsages::MAP_READ | BufferUsages::COPY_DST;
        Self {
            clock,
            read: buffer("figures of culling", TIMES + sizes.iter().sum::<u64>(), read),
            sizes,
            draws,
            state: Arc::new(AtomicU8::new(IDLE)),
            frames: 0,
            asked: 0,
            last: DeviceFigures::default(),
        }
    }

    /// Begins a frame: true if it is measured. Takes in the figures of an earlier one.
    pub(super) fn start(&mut self, queue: &Queue) -> bool {
        self.frames += 1;
        match self.state.load(Ordering::Acquire) {
            READY => {
                if let Ok(bytes) = self.read.slice(..).get_mapped_range() {
                    self.last = self.taken(&bytes, queue.get_timestamp_period());
                }
                self.read.unmap();
            }
            ASKED | WAITING => return false,
            _ => {}
        }
        self.state.store(ASKED, Ordering::Release);
        self.asked = self.frames;
        true
    }

    fn taken(&self, bytes: &[u8], period: f32) -> DeviceFigures {
        let (times, mut rest) = bytes.split_at(TIMES as usize);
        let [in_view, visible, early, listed] = self.sizes.map(|size| {
            let (own, after) = rest.split_at(size as usize);
            rest = after;
            own
        });
        let ones = |bytes: &[u8]| bytes.iter().map(|b| b.count_ones()).sum::<u32>();
        let arguments = |bytes: &[u8]| -> Vec<DrawArguments> {
            let size = self.draws * size_of::<DrawArguments>();
            bytemuck::pod_collect_to_vec(&bytes[..size])
        };
        let triangles = |all: &[DrawArguments]| {
            let of = |a: &DrawArguments| u64::from(a.index_count / 3) * u64::from(a.instance_count);
            all.iter().map(of).sum()
        };
        let listed = arguments(listed);
        let times = self.clock.as_ref().map(|_| {
            let ticks: Vec<u64> = bytemuck::pod_collect_to_vec(times);
            let span = |i: usize| {
                let ticks = ticks[i + 1].saturating_sub(ticks[i]) as f64;
                (ticks * f64::from(period) * 1e-6) as f32
            };
            DeviceTimes { early: span(0), depth: span(1), pyramid: span(2), late: span(3) }
        });
        DeviceFigures {
            frame: self.asked,
            in_view: ones(in_view),
            visible: ones(visible),
            triangles: triangles(&listed),
            early_triangles: triangles(&arguments(early)),
            draws: listed.len() as u32,
            draws_in_use: listed.iter().filter(|a| a.instance_count > 0).count() as u32,
            times,
        }
    }

    /// Records that the device is to note the time.
    pub(super) fn mark(&self, encoder: &mut CommandEncoder, number: u32) {
        if let Some((query_set, _)) = &self.clock {
            // A pass with nothing in it: times between passes take an optional feature.
            encoder.begin_compute_pass(&ComputePassDescriptor {
                label: Some("time"),
                timestamp_writes: Some(ComputePassTimestampWrites {
                    query_set,
                    beginning_of_pass_write_index: Some(number),
                    end_of_pass_write_index: None,
                }),
            });
        }
    }

    /// Has everything copied, after the passes.
    pub(super) fn resolve(&self, encoder: &mut CommandEncoder, all: [&Buffer; 4]) {
        if let Some((queries, resolved)) = &self.clock {
            encoder.resolve_query_set(queries, 0..MARKS, resolved, 0);
            encoder.copy_buffer_to_buffer(resolved, 0, &self.read, 0, TIMES);
        }
        let mut at = TIMES;
        for (from, size) in all.into_iter().zip(self.sizes) {
            encoder.copy_buffer_to_buffer(from, 0, &self.read, at, size);
            at += size;
        }
    }

    /// Asks for what was copied, after the frame was submitted.
    pub(super) fn submitted(&self) {
        if self.state.load(Ordering::Acquire) != ASKED {
            return;
        }
        self.state.store(WAITING, Ordering::Release);
        let state = self.state.clone();
        self.read.map_async(MapMode::Read, .., move |answer| {
            state.store(if answer.is_ok() { READY } else { FAILED }, Ordering::Release);
        });
    }
}
