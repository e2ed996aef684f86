//! The working set of triangles: a list that each stage shortens in place.

use alloc::vec::Vec;

use super::super::log::Log;
use super::super::run::Run;
use crate::funnel::{Counts, Reason, Stage, Unit};
use crate::visible::{TriangleRange, Visible};

/// Triangles that are still there.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct Triangles {
    /// Ascending by slot: ranges of the list.
    pub(in super::super) ranges: Vec<TriangleRange>,
    /// In the order of each instance's mesh.
    pub(in super::super) list: Vec<u32>,
    kept: Vec<u32>,
}

impl Triangles {
    pub(in super::super) fn clear(&mut self) {
        self.ranges.clear();
        self.list.clear();
    }

    /// Changes lists with an answer, whose memory is to be used.
    pub(in super::super) fn swap_with(&mut self, result: &mut Visible) {
        core::mem::swap(&mut self.ranges, &mut result.triangle_ranges);
        core::mem::swap(&mut self.list, &mut result.triangles);
    }

    /// Runs a stage over every range in place. The closure appends what it keeps, or returns
    /// `false` to keep all.
    pub(in super::super) fn filter(
        &mut self,
        runs: &[Run],
        stage: Stage,
        log: &mut Log<'_>,
        mut keep: impl FnMut(TriangleRange, &[u32], &mut Vec<u32>) -> bool,
    ) {
        let entered = log.left.counts;
        let Self { ranges, list, kept } = self;
        let mut write = 0;
        for range in ranges {
            let read = range.first as usize..(range.first + range.count) as usize;
            kept.clear();
            let count = if keep(*range, &list[read.clone()], kept) {
                if log.lists_dropped() && kept.len() < read.len() {
                    let before = list[read].iter().copied();
                    log.drop_triangles(stage, (range.slot, range.level), before, kept);
                }
                list[write..write + kept.len()].copy_from_slice(kept);
                kept.len()
            } else {
                list.copy_within(read.clone(), write);
                read.len()
            };
            *range = TriangleRange { first: write as u32, count: count as u32, ..*range };
            write += count;
        }
        list.truncate(write);
        self.end(runs, stage, entered, log);
    }

    /// Forgets instances of which a stage left no triangle, counts what is left, and ends the
    /// stage.
    pub(in super::super) fn end(
        &mut self,
        runs: &[Run],
        stage: Stage,
        entered: Counts,
        log: &mut Log<'_>,
    ) {
        let detail = if stage == Stage::Frustum { Reason::MIXED } else { 0 };
        self.ranges.retain(|range| {
            if range.count == 0 {
                log.drop_slot(range.slot, Reason { stage, detail });
                let first = runs.partition_point(|run| run.slot < range.slot);
                let own = runs[first..].iter().take_while(|run| run.slot == range.slot);
                let left = &mut log.left.counts;
                left.instances -= 1;
                left.clusters -= own.map(|run| u64::from(run.cluster_count)).sum::<u64>();
            }
            range.count > 0
        });
        log.left.counts.triangles = self.list.len() as u64;
        log.row(stage, Unit::Triangles, entered);
    }
}
