//! Record of an explanation, as `--json` writes it: see `docs/schema/explain.schema.json`.

use cullet::{Handle, Stage, explain::Evidence, funnel::Unit};
use serde::Serialize;

/// Number of the form of the record.
pub(super) const SCHEMA: u32 = 1;

/// All that is told.
#[derive(Debug, Serialize)]
pub(super) struct ExplainRecord {
    pub(super) schema: u32,
    pub(super) scene: String,
    pub(super) view: ViewPlace,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) pixel: Option<PixelRecord>,
    /// None where a pixel shows nothing.
    pub(super) instance: Option<InstanceRecord>,
}

/// The view that was drawn.
#[derive(Debug, Serialize)]
pub(super) struct ViewPlace {
    pub(super) index: u32,
    /// Homogeneous: w is 0 for parallel lines of sight.
    pub(super) eye: [f64; 4],
    pub(super) size: [u32; 2],
    /// The stages that ran.
    pub(super) stages: Vec<Stage>,
}

/// A pixel and what is there.
#[derive(Debug, Serialize)]
pub(super) struct PixelRecord {
    pub(super) at: [u32; 2],
    /// The original number of the triangle that owns it, and how far from the eye it is.
    pub(super) triangle: Option<u32>,
    pub(super) distance: Option<f64>,
    /// Culled instances behind it, the nearest first, and whether there are more.
    pub(super) behind: Vec<BehindRecord>,
    pub(super) more_behind: bool,
}

/// A culled instance behind a pixel.
#[derive(Debug, Serialize)]
pub(super) struct BehindRecord {
    pub(super) name: String,
    pub(super) handle: Handle,
    pub(super) distance: f64,
    pub(super) stage: Stage,
}

/// An instance, and why it is drawn or not.
#[derive(Debug, Serialize)]
pub(super) struct InstanceRecord {
    pub(super) name: String,
    pub(super) handle: Handle,
    pub(super) mesh: String,
    /// Its box in world space.
    pub(super) bounds: [[f64; 3]; 2],
    pub(super) triangles: u64,
    /// How many of them are drawn, and how many pixels it owns in the image without culling.
    pub(super) drawn_triangles: u64,
    pub(super) owned_pixels: u64,
    pub(super) kept: bool,
    /// Stage that dropped it, and why in words.
    pub(super) stage: Option<Stage>,
    pub(super) reason: Option<String>,
    pub(super) steps: Vec<StepRecord>,
    /// Names of the instances that hide it, front to back.
    pub(super) hidden_by: Vec<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) level: Option<LevelRecord>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) triangle: Option<TriangleRecord>,
    /// All of it in a sentence.
    pub(super) sentence: String,
}

/// A stage that it came to.
#[derive(Debug, Serialize)]
pub(super) struct StepRecord {
    pub(super) stage: Stage,
    pub(super) unit: Unit,
    pub(super) entered: u64,
    pub(super) left: u64,
    pub(super) outcome: &'static str,
    /// In the words of the engine.
    pub(super) finding: String,
    pub(super) evidence: Evidence,
    /// Limit that the measured size is compared to, in pixels or their squares.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) limit: Option<f64>,
}

/// The level of detail that is drawn.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct LevelRecord {
    pub(super) level: u32,
    /// Pixels by which the worst of its clusters may be off from here, and by which any was allowed
    /// to be.
    pub(super) error_px: f64,
    pub(super) allowed_px: f64,
}

/// A triangle, and why it is drawn or not.
#[derive(Debug, Serialize)]
pub(super) struct TriangleRecord {
    /// Its number in the file.
    pub(super) triangle: u32,
    /// The cluster that it is in; none for one without area.
    pub(super) cluster: Option<u32>,
    /// In world space.
    pub(super) corners: [[f64; 3]; 3],
    pub(super) area: f64,
    pub(super) planes: Vec<cullet::explain::PlaneTest>,
    /// n·(eye − p) with the unit normal: above 0 the eye is before it.
    pub(super) facing: Option<f64>,
    /// Whether that is proved, by more than rounding: front, back, or edge.
    pub(super) side: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) cone: Option<ConeRecord>,
    pub(super) owned_pixels: u64,
    pub(super) drawn: bool,
    pub(super) stage: Option<Stage>,
    pub(super) sentence: String,
}

/// The cone of a cluster's normals against the eye, in the space of the mesh: the eye is behind all
/// of the cluster where `along` is below 0 and `within` above it.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct ConeRecord {
    /// axis·(eye − apex).
    pub(super) along: f64,
    /// The square of that less the squares across it.
    pub(super) within: f64,
    pub(super) behind: bool,
}
