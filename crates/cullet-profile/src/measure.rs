//! Times of frames with the work of one link doubled, round by round.

use std::time::Instant;

use cullet_gpu::{Gpu, GpuError};
use wgpu::{PollType, SubmissionIndex};

use super::elasticity::Elasticity;
use super::link::Link;

/// Something that draws frames, and can double the work of one link.
pub trait Workload {
    /// Hands in one frame.
    ///
    /// # Errors
    /// If the device cannot.
    fn frame(&mut self, gpu: &Gpu, doubled: Option<Link>) -> Result<SubmissionIndex, GpuError>;
}

/// How it is measured.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// How often each way is timed, one after the other.
    pub rounds: usize,
    /// Seconds that a burst of frames should take.
    pub burst: f64,
}

impl Default for Effort {
    fn default() -> Self {
        Self { rounds: 30, burst: 0.05 }
    }
}

/// Milliseconds a frame, and the elasticities in the order of [`Link::ALL`].
#[derive(Clone, Copy, Debug)]
pub struct Measured {
    /// Median milliseconds a frame, nothing doubled.
    pub frame_ms: f64,
    /// Of each link.
    pub elasticity: [Elasticity; 4],
}

/// Draws bursts of frames, with nothing doubled and with each link, in another order each round, so that what else the machine does meets
/// all alike. At most two frames are under way at a time.
///
/// # Errors
/// If the device cannot.
pub fn measure(gpu: &Gpu, work: &mut impl Workload, effort: Effort) -> Result<Measured, GpuError> {
    let mut ways: Vec<Option<Link>> = std::iter::once(None).chain(Link::ALL.map(Some)).collect();
    // Pipelines and buffers are made, clocks settle.
    for way in &ways {
        burst(gpu, work, *way, 2)?;
    }
    let one = burst(gpu, work, None, 3)?.max(1e-6);
    let frames = ((effort.burst / one).ceil() as usize).clamp(1, 1000);
    let mut rounds = [const { Vec::new() }; 4];
    let mut bases = Vec::new();
    for round in 0..effort.rounds {
        ways.rotate_left(1 + round % 3);
        if round % 2 == 1 {
            ways.reverse();
        }
        let (mut base, mut doubled) = (0.0, [0.0; 4]);
        for way in &ways {
            let took = burst(gpu, work, *way, frames)?;
            match way {
                None => base = took,
                Some(link) => doubled[*link as usize] = took,
            }
        }
        bases.push(base * 1e3);
        for (own, took) in rounds.iter_mut().zip(doubled) {
            own.push([base, took]);
        }
    }
    bases.sort_by(f64::total_cmp);
    Ok(Measured {
        frame_ms: bases.get(bases.len() / 2).copied().unwrap_or(0.0),
        elasticity: rounds.each_ref().map(|own| Elasticity::of(own)),
    })
}

/// Seconds a frame.
fn burst(
    gpu: &Gpu,
    work: &mut impl Workload,
    way: Option<Link>,
    frames: usize,
) -> Result<f64, GpuError> {
    gpu.finish()?;
    let began = Instant::now();
    let mut before: Option<SubmissionIndex> = None;
    for _ in 0..frames {
        let now = work.frame(gpu, way)?;
        if let Some(index) = before.replace(now) {
            let wait = PollType::Wait { submission_index: Some(index), timeout: None };
            gpu.device.poll(wait).map_err(|e| GpuError::Lost(e.to_string()))?;
        }
    }
    gpu.finish()?;
    Ok(began.elapsed().as_secs_f64() / frames as f64)
}
