//! The log of a cull: the counts of the funnel, reasons, and the record of what each stage took.
//!
//! Every stage counts what it takes where it takes it; what it leaves is what the next one
//! receives.

use alloc::vec::Vec;
use core::ops::Range;

use super::frame::Frame;
use super::run::{Run, triangles_of};
use crate::funnel::{Counts, FrustumWork, FunnelRow, OcclusionWork, Reason, Stage, Unit};
use crate::mesh::Mesh;
use crate::scene::Tally;
use crate::sort::{pair, sort_by};
use crate::visible::{DroppedRange, Visible};

/// Where the stages write what they did.
pub(super) struct Log<'a> {
    reasons: &'a mut Vec<Option<Reason>>,
    dropped: &'a mut Vec<DroppedRange>,
    rows: &'a mut Vec<FunnelRow>,
    clock: Option<fn() -> u64>,
    wants_reasons: bool,
    wants_dropped: bool,
    stage_began: u64,
    /// Totals that the stages so far left.
    pub(super) left: Tally,
    pub(super) frustum: FrustumWork,
    pub(super) occlusion: OcclusionWork,
}

/// Results of a log when the cull is over.
pub(super) struct Work {
    pub(super) left: Counts,
    pub(super) frustum: FrustumWork,
    pub(super) occlusion: OcclusionWork,
}

impl<'a> Log<'a> {
    pub(super) fn new(frame: &Frame<'_>, result: &'a mut Visible) -> Self {
        let Visible { reasons, dropped, funnel, .. } = result;
        reasons.clear();
        dropped.clear();
        funnel.rows.clear();
        let culler = frame.culler;
        if culler.reasons {
            reasons.resize(frame.scene.slot_count() as usize, None);
        }
        let mut log = Self {
            reasons,
            dropped,
            rows: &mut funnel.rows,
            clock: culler.clock,
            wants_reasons: culler.reasons,
            wants_dropped: culler.reasons && culler.dropped,
            stage_began: 0,
            left: Tally::default(),
            frustum: FrustumWork::default(),
            occlusion: OcclusionWork::default(),
        };
        log.stage_began = log.now();
        log
    }

    pub(super) fn finish(self) -> Work {
        sort_by(self.dropped, &|d| pair(d.slot, d.first_triangle) as u64);
        Work { left: self.left.counts, frustum: self.frustum, occlusion: self.occlusion }
    }

    /// Nanoseconds by the culler's clock; 0 where it has none.
    pub(super) fn now(&self) -> u64 {
        self.clock.map_or(0, |now| now())
    }

    /// Whether times are wanted.
    pub(super) fn has_clock(&self) -> bool {
        self.clock.is_some()
    }

    /// Whether reasons are wanted.
    pub(super) fn wants_reasons(&self) -> bool {
        self.wants_reasons
    }

    /// Whether triangles that went on their own or with their cluster are listed.
    pub(super) fn lists_dropped(&self) -> bool {
        self.wants_dropped
    }

    /// The reason of a slot, as far as the pipeline has run.
    pub(super) fn reason(&self, slot: u32) -> Option<Reason> {
        self.reasons.get(slot as usize).copied().flatten()
    }

    /// Notes why the instance of a slot went.
    pub(super) fn drop_slot(&mut self, slot: u32, reason: Reason) {
        if self.wants_reasons {
            self.reasons[slot as usize] = Some(reason);
        }
    }

    /// Ends a stage of instances that took `dropped`.
    pub(super) fn instance_row(&mut self, stage: Stage, dropped: Tally) {
        let entered = self.left.counts;
        self.left -= dropped;
        self.row(stage, Unit::Instances, entered);
    }

    /// Ends a stage that `entered` came into, and that left [`left`](Self::left).
    pub(super) fn row(&mut self, stage: Stage, unit: Unit, entered: Counts) {
        let left = self.left.counts;
        let nanoseconds = self.clock.map_or(FunnelRow::NO_TIME, |now| {
            let now = now();
            let took = now.saturating_sub(self.stage_began);
            self.stage_began = now;
            took
        });
        self.rows.push(FunnelRow { stage, unit, entered, left, nanoseconds });
    }

    /// Notes that a stage took clusters of an instance: those of `before` that are not in `kept`.
    /// Both ascend, and the second lies within the first. How much is left is counted; where no
    /// cluster is left, the instance goes, and with it its degenerate triangles.
    pub(super) fn drop_clusters(
        &mut self,
        stage: Stage,
        mesh: &Mesh,
        slot: u32,
        before: &[Run],
        kept: &[Run],
    ) {
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
                    gone.triangles += u64::from(count(&triangles));
                    self.drop_range(stage, Unit::Clusters, (slot, run.level), triangles);
                }
                at = next.map_or(end, |k| k.first_cluster + k.cluster_count);
                rest = &rest[usize::from(next.is_some())..];
            }
        }
        if kept.is_empty() {
            gone.instances = 1;
            let degenerate = mesh.degenerate_triangles();
            gone.triangles += u64::from(count(&degenerate));
            self.left.degenerate -= u64::from(count(&degenerate));
            let level = before.first().map_or(0, |run| run.level);
            self.drop_range(stage, Unit::Clusters, (slot, level), degenerate);
        }
        self.left.counts -= gone;
    }

    /// Notes which triangles of an ascending list a stage did not keep, where that is wanted.
    pub(super) fn drop_triangles(
        &mut self,
        stage: Stage,
        (slot, level): (u32, u32),
        before: impl Iterator<Item = u32>,
        kept: &[u32],
    ) {
        let mut kept = kept.iter().copied().peekable();
        for t in before.filter(|&t| kept.next_if_eq(&t).is_none()) {
            self.drop_range(stage, Unit::Triangles, (slot, level), t..t + 1);
        }
    }

    /// Takes back why an instance went: it is drawn after all.
    pub(super) fn keep_slot(&mut self, slot: u32) {
        if self.wants_reasons {
            self.reasons[slot as usize] = None;
        }
    }

    /// Lists triangles that a stage took. (Culling with and without each stage in place of this
    /// list would name other stages than the funnel counts: clusters are tested before triangles,
    /// whatever their stages, and what is drawn as an occluder depends on what the others left.)
    pub(super) fn drop_range(
        &mut self,
        stage: Stage,
        unit: Unit,
        (slot, level): (u32, u32),
        range: Range<u32>,
    ) {
        if !self.wants_dropped || range.is_empty() {
            return;
        }
        let range = DroppedRange {
            slot,
            level,
            first_triangle: range.start,
            triangle_count: count(&range),
            stage,
            unit,
        };
        match self.dropped.last_mut() {
            Some(last)
                if last.first_triangle + last.triangle_count == range.first_triangle
                    && (last.slot, last.stage, last.unit) == (slot, stage, unit) =>
            {
                last.triangle_count += range.triangle_count;
            }
            _ => self.dropped.push(range),
        }
    }
}

/// Returns the length of `range`. Not by `len`, which holds two numbers against each other and
/// would put them into words.
fn count(range: &Range<u32>) -> u32 {
    range.end - range.start
}
