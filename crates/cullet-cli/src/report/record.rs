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
    /// Null where no costs are known.
    pub(crate) costs: Option<CostsRecord>,
    /// Meshes, those that waste the most first.
    pub(crate) meshes: Vec<MeshRecord>,
    /// False where Ctrl-C stopped the run before its last view.
    pub(crate) complete: bool,
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
