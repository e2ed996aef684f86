//! The record: the figures as they are written.

use clap::ValueEnum;
use serde::Serialize;

use super::bounds::{BoundRow, Wrong};
use super::clustering::{MaterialRow, MeshoptRow, ProbabilityRow};
use super::hierarchy::HierarchyRow;
use cullet_command::machine::Machine;

/// Who makes the clusters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Clusterer {
    /// Ours: greedy merging by what a cluster is expected to save, then filling
    Cullet,
    /// Meshoptimizer's meshlets, with a cone weight of 0.5
    Meshopt,
}

/// All that the command finds.
#[derive(Debug, Serialize)]
pub(super) struct JohannsenCarterRecord {
    pub(super) schema: u32,
    pub(super) model: ModelRecord,
    pub(super) clusters_by: Clusterer,
    /// t/r that clusters of ours are made for.
    pub(super) test_cost: f64,
    /// The same in words, with where it comes from.
    pub(super) test_cost_from: String,
    pub(super) clustering_seconds: f64,
    /// Views at each distance.
    pub(super) directions: u32,
    /// Distance of the shares, in radii of the model's sphere, where no other is named.
    pub(super) distance_radii: f64,
    pub(super) clusters: usize,
    pub(super) triangles_per_cluster: f64,
    /// Clusters of ours that are culled too seldom to pay for a test.
    pub(super) never_culled: Option<u32>,
    /// Expected cost of our clusters, in triangles drawn for each triangle of the model.
    pub(super) expected_cost: Option<f64>,
    pub(super) exact_percent: f64,
    pub(super) ideal_percent: f64,
    pub(super) bounds: Vec<BoundRow>,
    /// Johannsen & Carter's bound by where its origin is.
    pub(super) origins: Vec<BoundRow>,
    /// In radii: what the shares by distance are of.
    pub(super) distances_radii: [f64; 5],
    pub(super) exact_percent_by_distance: Vec<f64>,
    pub(super) ideal_percent_by_distance: Vec<f64>,
    pub(super) hierarchy: Option<HierarchyRow>,
    /// Probabilities of greedy merging alone.
    pub(super) probabilities: Vec<ProbabilityRow>,
    pub(super) materials: Option<MaterialRow>,
    pub(super) against_meshopt: Option<MeshoptRow>,
    pub(super) wrong: Wrong,
    pub(super) machine: Machine,
    /// False where Ctrl-C stopped the command early.
    pub(super) complete: bool,
}

#[derive(Debug, Serialize)]
pub(super) struct ModelRecord {
    pub(super) name: String,
    /// Triangles that have an area.
    pub(super) triangles: u64,
    /// Materials of all instances.
    pub(super) parts: usize,
    /// Why it is no solid, where it is taken for one-sided all the same.
    pub(super) defect: Option<String>,
}
