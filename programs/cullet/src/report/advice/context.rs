//! Inputs of the advice.

use cullet_command::console::grouped;
use cullet_io::Model;

use crate::record::{Advice, MeshRecord, Summary};
use crate::survey::Survey;

/// Names given in a text; all of them, up to [`NAMES_KEPT`], are in the record.
const NAMES_SHOWN: usize = 3;
pub(super) const NAMES_KEPT: usize = 100;

/// Results of a run.
pub(super) struct Context<'a> {
    pub(super) survey: &'a Survey,
    pub(super) model: &'a Model,
    pub(super) summary: &'a Summary,
    pub(super) meshes: &'a [MeshRecord],
    pub(super) views: usize,
    pub(super) tiny_px: f64,
}

/// The first names, quoted, and how many more there are.
pub(super) fn shown(names: &[String]) -> String {
    let first: Vec<String> = names.iter().take(NAMES_SHOWN).map(|n| format!("“{n}”")).collect();
    let more = names.len().saturating_sub(NAMES_SHOWN);
    let list = first.join(", ");
    if more > 0 { format!("{list} and {} more", grouped(more as u64)) } else { list }
}

impl Context<'_> {
    pub(super) fn advice(
        &self,
        kind: &'static str,
        title: String,
        text: String,
        triangles: u64,
        mut names: Vec<String>,
    ) -> Advice {
        names.truncate(NAMES_KEPT);
        let triangles_per_view = triangles as f64 / self.views as f64;
        Advice { kind, title, text, triangles_per_view, names }
    }

    /// Meshes picked by a figure, the greatest first; its sum, and their names.
    pub(super) fn worst(
        &self,
        pick: impl Fn(&MeshRecord) -> Option<u64>,
    ) -> Option<(Vec<&MeshRecord>, u64, Vec<String>)> {
        let mut found: Vec<(u64, &MeshRecord)> =
            self.meshes.iter().filter_map(|m| pick(m).map(|n| (n, m))).collect();
        found.sort_by_key(|(n, m)| (std::cmp::Reverse(*n), m.mesh));
        let sum = found.iter().map(|(n, _)| n).sum();
        let names = found.iter().map(|(_, m)| m.name.clone()).collect();
        (!found.is_empty()).then(|| (found.into_iter().map(|(_, m)| m).collect(), sum, names))
    }
}
