//! The working sets that pass from stage to stage.

mod clusters;
mod coarse;
mod instances;
mod triangles;

pub(super) use clusters::Clusters;
pub(super) use coarse::{Coarse, Cut};
pub(super) use instances::{GROUP, Instances, groups, slots};
pub(super) use triangles::Triangles;

/// Instances, clusters and triangles that are left of a view's scene. Memory that its culls use
/// again.
#[derive(Clone, Debug, Default)]
pub(super) struct Sets {
    pub(super) instances: Instances,
    pub(super) coarse: Coarse,
    pub(super) clusters: Clusters,
    pub(super) triangles: Triangles,
}

impl Sets {
    /// Forgets the last view's. The instances' are forgotten by the stage that takes new ones.
    pub(super) fn clear(&mut self) {
        self.coarse.clear();
        self.clusters.runs.clear();
        self.triangles.clear();
    }
}
