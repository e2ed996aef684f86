//! Frames of a flight, and their sums.

use cullet_command::console::grouped;
use cullet_command::process;
use serde::Serialize;

/// A frame.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct Frame {
    pub(super) seconds: f64,
    pub(super) eye: [f64; 3],
    /// Whether it is of the second half of the way.
    pub(super) high: bool,
    pub(super) cull_ms: f64,
    /// Time that the frame took to say where the eye is and to take in what was loaded.
    pub(super) look_ms: f64,
    pub(super) instances: u32,
    pub(super) visible: u64,
    /// Triangles that are visible, at their levels of detail.
    pub(super) triangles: u64,
    pub(super) tiles: usize,
    /// Tiles that are wanted and not there.
    pub(super) wanted: usize,
    pub(super) bytes: u64,
}

/// Times of a half of the way, in milliseconds.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(super) struct Half {
    pub(super) median_ms: f64,
    pub(super) p99_ms: f64,
    pub(super) most_ms: f64,
    /// Mean of the frames.
    pub(super) visible: f64,
}

/// The figures.
#[derive(Debug, Serialize)]
pub(super) struct Record {
    pub(super) schema: u32,
    pub(super) world: String,
    /// Instances of the whole world.
    pub(super) instances: u64,
    /// View cells whose rows say what is loaded first.
    pub(super) cells: u32,
    pub(super) frames: usize,
    /// At the most in the scene, and bytes counted at the most.
    pub(super) most_instances: u32,
    pub(super) most_tiles: usize,
    pub(super) most_bytes: u64,
    pub(super) budget: u64,
    pub(super) peak_bytes: Option<u64>,
    pub(super) loaded: u64,
    pub(super) built: u64,
    pub(super) longest_build_seconds: f64,
    pub(super) longest_look_ms: f64,
    pub(super) low: Half,
    pub(super) high: Half,
    pub(super) checked: u32,
    pub(super) false_culls: u64,
    pub(super) failed: Vec<String>,
    pub(super) complete: bool,
}

impl Record {
    pub(super) fn new(budget: u64) -> Self {
        Self {
            schema: 1,
            world: String::new(),
            instances: 0,
            cells: 0,
            frames: 0,
            most_instances: 0,
            most_tiles: 0,
            most_bytes: 0,
            budget,
            peak_bytes: None,
            loaded: 0,
            built: 0,
            longest_build_seconds: 0.0,
            longest_look_ms: 0.0,
            low: Half::default(),
            high: Half::default(),
            checked: 0,
            false_culls: 0,
            failed: Vec::new(),
            complete: false,
        }
    }

    /// Adds up the frames.
    pub(super) fn sum(&mut self, frames: &[Frame]) {
        self.frames = frames.len();
        self.most_instances = frames.iter().map(|f| f.instances).max().unwrap_or(0);
        self.most_tiles = frames.iter().map(|f| f.tiles).max().unwrap_or(0);
        self.most_bytes = frames.iter().map(|f| f.bytes).max().unwrap_or(0);
        self.longest_look_ms = frames.iter().map(|f| f.look_ms).fold(0.0, f64::max);
        self.peak_bytes = process::peak_bytes();
        (self.low, self.high) = (Half::of(frames, false), Half::of(frames, true));
    }
}

impl Half {
    fn of(frames: &[Frame], high: bool) -> Self {
        let of: Vec<&Frame> = frames.iter().filter(|f| f.high == high).collect();
        let mut times: Vec<f64> = of.iter().map(|f| f.cull_ms).collect();
        times.sort_unstable_by(f64::total_cmp);
        let Some(last) = times.len().checked_sub(1) else { return Self::default() };
        let at = |share: f64| times[(last as f64 * share) as usize];
        let visible = of.iter().map(|f| f.visible as f64).sum::<f64>() / of.len() as f64;
        Self { median_ms: at(0.5), p99_ms: at(0.99), most_ms: at(1.0), visible }
    }
}

pub(super) fn mebibytes(bytes: u64) -> String {
    grouped(bytes >> 20)
}
