//! Times of frames in several ways, round by round.

use std::time::Instant;

use cullet_gpu::{Gpu, GpuError};
use wgpu::{PollType, SubmissionIndex};

use super::elasticity::{Elasticity, median};
use super::link::{Link, Way};

/// Something that draws frames, and can double the work of one link.
pub trait Workload {
    /// How many frames there are, which are drawn in turn.
    fn frames(&self) -> usize;

    /// Hands in one of them.
    ///
    /// # Errors
    /// If the device cannot.
    fn frame(&mut self, gpu: &Gpu, number: usize, way: Way) -> Result<SubmissionIndex, GpuError>;
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

/// Seconds a frame, by round and way.
#[derive(Clone, Debug)]
pub struct Times {
    ways: Vec<Way>,
    rounds: Vec<Vec<f64>>,
}

impl Times {
    /// Draws bursts of frames in each way, in another order each round, so that what else the
    /// machine does meets all alike. At most two frames are under way at a time. After each round
    /// `go_on` is asked whether there is time for another.
    ///
    /// # Errors
    /// If the device cannot.
    pub fn measure(
        gpu: &Gpu,
        work: &mut impl Workload,
        cullers: usize,
        effort: Effort,
        mut go_on: impl FnMut() -> bool,
    ) -> Result<Self, GpuError> {
        let own = [Way::Plain, Way::EmptyDraws, Way::VerticesAgain].into_iter();
        let links = Link::ALL.map(Way::Doubled);
        let ways: Vec<Way> = own.chain(links).chain((0..cullers).map(Way::Culled)).collect();
        // Pipelines and buffers are made, clocks settle.
        for way in &ways {
            burst(gpu, work, *way, 1)?;
        }
        let turn = burst(gpu, work, Way::Plain, 1)?.max(1e-6) * work.frames().max(1) as f64;
        let turns = ((effort.burst / turn).ceil() as usize).clamp(1, 1000);
        let mut order: Vec<usize> = (0..ways.len()).collect();
        let mut rounds = Vec::new();
        for round in 0..effort.rounds {
            order.rotate_left(1 + round % 3);
            if round % 2 == 1 {
                order.reverse();
            }
            let mut times = vec![0.0; ways.len()];
            for at in &order {
                times[*at] = burst(gpu, work, ways[*at], turns)?;
            }
            rounds.push(times);
            if !go_on() {
                break;
            }
        }
        Ok(Self { ways, rounds })
    }

    /// How many rounds there are.
    #[must_use]
    pub fn rounds(&self) -> usize {
        self.rounds.len()
    }

    /// The median of a way's seconds a frame; 0 of none.
    #[must_use]
    pub fn seconds(&self, way: Way) -> f64 {
        let at = self.ways.iter().position(|w| *w == way);
        median(at.map_or(vec![], |at| self.rounds.iter().map(|times| times[at]).collect()))
    }

    /// The elasticities in the order of [`Link::ALL`].
    #[must_use]
    pub fn elasticities(&self) -> [Elasticity; 4] {
        Link::ALL.map(|link| {
            let without = if link == Link::Transform { Way::EmptyDraws } else { Way::Plain };
            self.change(without, Way::Doubled(link))
        })
    }

    /// Returns the share of the transform's elasticity that is due to triangles that reach the
    /// screen, and not to vertices.
    #[must_use]
    pub fn set_up(&self) -> Elasticity {
        self.change(Way::VerticesAgain, Way::Doubled(Link::Transform))
    }

    /// Returns the share of a plain frame by which one way takes longer than another.
    #[must_use]
    pub fn change(&self, from: Way, to: Way) -> Elasticity {
        let at = |way| self.ways.iter().position(|w| *w == way);
        let (Some(plain), Some(from), Some(to)) = (at(Way::Plain), at(from), at(to)) else {
            return Elasticity::of(&[]);
        };
        let round = |times: &Vec<f64>| [times[plain], times[plain] + (times[to] - times[from])];
        Elasticity::of(&self.rounds.iter().map(round).collect::<Vec<_>>())
    }
}

/// Seconds a frame, over so many turns of all frames.
fn burst(gpu: &Gpu, work: &mut impl Workload, way: Way, turns: usize) -> Result<f64, GpuError> {
    gpu.finish()?;
    let frames = work.frames().max(1);
    let began = Instant::now();
    let mut before: Option<SubmissionIndex> = None;
    for number in (0..turns).flat_map(|_| 0..frames) {
        let now = work.frame(gpu, number, way)?;
        if let Some(index) = before.replace(now) {
            let wait = PollType::Wait { submission_index: Some(index), timeout: None };
            gpu.device.poll(wait).map_err(|e| GpuError::Lost(e.to_string()))?;
        }
    }
    gpu.finish()?;
    Ok(began.elapsed().as_secs_f64() / (frames * turns) as f64)
}
