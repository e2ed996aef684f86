//! The record: the figures as they are written.

use serde::Serialize;

use cullet_command::machine::Machine;

/// All that the command finds.
#[derive(Debug, Serialize)]
pub(super) struct AssarssonMollerRecord {
    pub(super) schema: u32,
    pub(super) model: String,
    pub(super) boxes: u64,
    pub(super) frames: u32,
    pub(super) degrees: f64,
    pub(super) stride: f64,
    pub(super) fov_degrees: f64,
    /// Percent of all boxes, mean over the frames.
    pub(super) visible_percent: f64,
    pub(super) machine: Machine,
    /// The scalar binary tree, in f64: plain, each trick alone, all together.
    pub(super) rows: Vec<TricksRow>,
    /// The engine's own tree, in f32, sixteen boxes at once.
    pub(super) wide: Vec<WideRow>,
    /// Frames in which a variant of the scalar tree found something else than the plain one; 0, or
    /// a fault.
    pub(super) frames_differing: u64,
    /// Visible for the plain tree and not for the engine's; 0, or a fault.
    pub(super) lost: u64,
    /// Kept by the engine's tree alone, where f32 cannot tell; of so many boxes visible in all
    /// frames.
    pub(super) kept_at_the_border: u64,
    pub(super) visible_in_all: u64,
    /// False where Ctrl-C stopped the command early; then the figures are of the frames done.
    pub(super) complete: bool,
}

/// Costs of a way of culling in a frame; means over the frames.
#[derive(Debug, Serialize)]
pub(super) struct TricksRow {
    pub(super) variant: &'static str,
    pub(super) nodes: f64,
    pub(super) plane_tests: f64,
    pub(super) ns: f64,
    /// Plane tests of the plain tree over its own, and the same of the times.
    pub(super) fewer_tests: f64,
    pub(super) speedup: f64,
}

#[derive(Debug, Serialize)]
pub(super) struct WideRow {
    pub(super) variant: &'static str,
    /// Sixteen boxes against a plane count as sixteen.
    pub(super) plane_tests: f64,
    pub(super) ns: f64,
    pub(super) speedup: f64,
}
