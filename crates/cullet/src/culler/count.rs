//! The counts of the funnel, and the record of what each stage took.
//!
//! What an instance holds is looked up where it is visited anyway: the stages of instances note only what they
//! take, and the sum of what they leave, which the first stage after them finds, gives all their rows.

use super::run::{Pass, Run, triangles_of};
use crate::funnel::{Counts, FunnelRow, Stage, Unit};
use crate::mesh::Mesh;
use crate::scene::Tally;
use crate::visible::DroppedRange;

impl Pass<'_> {
    /// Ends a stage of instances that took some: its row is complete once [`settle_rows`](Self::settle_rows) has run.
    pub(super) fn instance_row(&mut self, stage: Stage, dropped: Tally) {
        self.push_row(stage, Unit::Instances, dropped.counts, Counts::default());
    }

    /// Completes the rows of the stages of instances, of which the last left `alive`. What the frustum took is the
    /// rest of what the layers left.
    pub(super) fn settle_rows(&mut self, alive: Tally) {
        let mut left = alive.counts;
        let in_layers = self.in_layers.counts;
        for row in self.result.funnel.rows.iter_mut().rev() {
            let entered = match row.stage {
                Stage::Layer => break,
                Stage::Frustum => in_layers,
                _ => left + row.entered,
            };
            (row.entered, row.left) = (entered, left);
            left = entered;
        }
        debug_assert_eq!(left, in_layers, "counts of the stages of instances");
    }

    /// Ends a stage after those of instances: what came in is what the row before left.
    pub(super) fn row(&mut self, stage: Stage, unit: Unit, entered: Counts) {
        self.push_row(stage, unit, entered, self.tally.counts);
    }

    pub(super) fn push_row(&mut self, stage: Stage, unit: Unit, entered: Counts, left: Counts) {
        let nanoseconds = self.culler.clock.map(|now| {
            let now = now();
            let took = now.saturating_sub(self.stage_began);
            self.stage_began = now;
            took
        });
        self.result.funnel.rows.push(FunnelRow { stage, unit, entered, left, nanoseconds });
    }

    /// Ends the degenerate stage of an answer in instances or clusters: degenerate triangles are in no cluster, so
    /// they are in no answer.
    pub(super) fn degenerates_of_the_rest(&mut self) {
        let entered = self.tally.counts;
        self.tally.counts.triangles -= std::mem::take(&mut self.tally.degenerate);
        self.row(Stage::Degenerate, Unit::Triangles, entered);
        if !self.lists_dropped() || entered == self.tally.counts {
            return;
        }
        let (scene, words) = (self.scene, std::mem::take(&mut self.scratch.live));
        for &word in &words {
            for bit in crate::bits::ones(self.scratch.alive[word as usize]) {
                let slot = word * 64 + bit as u32;
                // Those of which every cluster was dropped are listed with the last.
                if self.result.reasons[slot as usize].is_some() {
                    continue;
                }
                let mesh = scene.mesh(slot);
                let degenerate = degenerate_of(mesh);
                self.drop_range(Stage::Degenerate, Unit::Triangles, slot, degenerate);
            }
        }
        self.scratch.live = words;
    }

    /// Notes that a stage took clusters of an instance: those of `before` that are not in `kept`. Both ascend, and
    /// the second lies within the first. How much is left is counted; where no cluster is left, the instance goes,
    /// and with it its degenerate triangles.
    pub(super) fn drop_clusters(&mut self, stage: Stage, slot: u32, before: &[Run], kept: &[Run]) {
        let mesh = self.scene.mesh(slot);
        let mut gone = Counts::default();
        let mut rest = kept;
        for run in before {
            let (mut at, end) = (run.first_cluster, run.first_cluster + run.cluster_count);
            while at < end {
                let next = rest.first().filter(|k| k.first_cluster < end);
                let to = next.map_or(end, |k| k.first_cluster);
                if at < to {
                    let cluster_count = to - at;
                    let triangles =
                        triangles_of(mesh, Run { first_cluster: at, cluster_count, ..*run });
                    gone.clusters += u64::from(cluster_count);
                    gone.triangles += triangles.len() as u64;
                    self.drop_range(stage, Unit::Clusters, slot, triangles);
                }
                at = next.map_or(end, |k| k.first_cluster + k.cluster_count);
                rest = &rest[usize::from(next.is_some())..];
            }
        }
        if kept.is_empty() {
            gone.instances = 1;
            let degenerate = degenerate_of(mesh);
            gone.triangles += degenerate.len() as u64;
            self.tally.degenerate -= degenerate.len() as u64;
            self.drop_range(stage, Unit::Clusters, slot, degenerate);
        }
        self.tally.counts -= gone;
    }

    /// Notes which triangles of an ascending list a stage did not keep, where that is asked for.
    pub(super) fn drop_triangles(
        &mut self,
        stage: Stage,
        slot: u32,
        before: impl Iterator<Item = u32>,
        kept: &[u32],
    ) {
        let mut kept = kept.iter().copied().peekable();
        for t in before.filter(|&t| kept.next_if_eq(&t).is_none()) {
            self.drop_range(stage, Unit::Triangles, slot, t..t + 1);
        }
    }

    /// Whether triangles that went on their own or with their cluster are listed.
    pub(super) fn lists_dropped(&self) -> bool {
        self.culler.reasons && self.culler.dropped
    }

    fn drop_range(&mut self, stage: Stage, unit: Unit, slot: u32, range: std::ops::Range<u32>) {
        if !self.lists_dropped() || range.is_empty() {
            return;
        }
        let range = DroppedRange {
            slot,
            first_triangle: range.start,
            triangle_count: range.len() as u32,
            stage,
            unit,
        };
        match self.result.dropped.last_mut() {
            Some(last)
                if last.first_triangle + last.triangle_count == range.first_triangle
                    && (last.slot, last.stage, last.unit) == (slot, stage, unit) =>
            {
                last.triangle_count += range.triangle_count;
            }
            _ => self.result.dropped.push(range),
        }
    }
}

/// The degenerate triangles of a mesh: they follow the last cluster.
pub(super) fn degenerate_of(mesh: &Mesh) -> std::ops::Range<u32> {
    let count = mesh.triangle_count();
    count - mesh.degenerate_count()..count
}
