//! Records in `report.json`: plain data, serialised as it stands.

use serde::Serialize;

use super::saved::CostsRecord;
use crate::record::{MeshRecord, SceneRecord, Summary, ViewRecord};

/// The whole of `report.json`.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Record {
    pub(crate) schema: u32,
    pub(crate) scene: SceneRecord,
    pub(crate) settings: Settings,
    pub(crate) views: Vec<ViewRecord>,
    pub(crate) summary: Summary,
    /// Only where levels of detail are on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) levels: Option<LevelsCost>,
    /// Null where no costs are known.
    pub(crate) costs: Option<CostsRecord>,
    /// Meshes, those that waste the most first.
    pub(crate) meshes: Vec<MeshRecord>,
    /// False where Ctrl-C stopped the run before its last view.
    pub(crate) complete: bool,
}

/// Size of levels of detail against what they save.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct LevelsCost {
    /// Triangles of the meshes themselves, each mesh once, and those of their levels.
    pub(crate) stored_triangles: u64,
    pub(crate) stored_level_triangles: u64,
    /// Triangles drawn over all views, without levels and with them.
    pub(crate) drawn_triangles: [u64; 2],
    /// Estimated cost of drawing those, in milliseconds a view; null where no costs are known.
    pub(crate) ms_per_view: Option<[f64; 2]>,
}

/// Arguments of the run.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Settings {
    pub(crate) path: String,
    pub(crate) size: [u32; 2],
    pub(crate) samples: u32,
    pub(crate) seed: u64,
    /// Names of the stages that were on, with their threshold where they have one.
    pub(crate) culling: Vec<String>,
    pub(crate) version: &'static str,
}
