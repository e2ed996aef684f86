//! The working set of clusters: runs of them, and the instances of which no cluster can go by
//! itself.

use alloc::vec::Vec;

use super::super::log::Log;
use super::super::run::Run;
use crate::bits;
use crate::funnel::{Reason, Stage, Unit};
use crate::scene::Scene;

/// Clusters that are still there.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct Clusters {
    /// Ascending by slot and cluster.
    pub(in super::super) runs: Vec<Run>,
    /// One bit a slot, of the words of instances that are live: drawn whole, and in no run. Only
    /// where clusters are wanted.
    pub(in super::super) settled: Vec<u64>,
    kept: Vec<Run>,
    culled: Vec<u64>,
}

impl Clusters {
    /// Notes that an instance is drawn whole.
    pub(in super::super) fn settle(&mut self, slot: u32) {
        self.settled[slot as usize / 64] |= 1 << (slot % 64);
    }

    /// Runs a stage over the runs of every instance. `cull` sets the bits of clusters to drop, or
    /// returns `false` to keep all. Degenerate triangles are in no cluster, and go with the last
    /// one of their instance.
    pub(in super::super) fn filter(
        &mut self,
        scene: &Scene,
        stage: Stage,
        log: &mut Log<'_>,
        mut cull: impl FnMut(&[Run], &mut Vec<u64>) -> bool,
    ) {
        let entered = log.left.counts;
        let Self { runs, kept, culled, .. } = self;
        kept.clear();
        for runs in runs.chunk_by(|a, b| a.slot == b.slot) {
            if !cull(runs, culled) {
                kept.extend_from_slice(runs);
                continue;
            }
            let (slot, first) = (runs[0].slot, kept.len());
            split(runs, culled, kept);
            log.drop_clusters(
                stage,
                &scene.meshes()[runs[0].mesh as usize],
                slot,
                runs,
                &kept[first..],
            );
            if kept.len() == first {
                log.drop_slot(slot, Reason { stage, detail: 0 });
            }
        }
        core::mem::swap(runs, kept);
        log.row(stage, Unit::Clusters, entered);
    }
}

/// Appends what is left of runs without the culled clusters.
fn split(runs: &[Run], culled: &[u64], kept: &mut Vec<Run>) {
    for run in runs {
        let (mut at, end) = (run.first_cluster, run.first_cluster + run.cluster_count);
        while at < end {
            let first = bits::next(culled, at, end, false);
            at = bits::next(culled, first, end, true);
            if first < at {
                kept.push(Run { first_cluster: first, cluster_count: at - first, ..*run });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_split_at_the_clusters_that_go() {
        let run = |first_cluster, cluster_count| Run {
            slot: 3,
            mesh: 0,
            level: 0,
            first_cluster,
            cluster_count,
            inside: true,
        };
        let parts = |runs: &[Run], culled: &[u64]| {
            let mut kept = Vec::new();
            split(runs, culled, &mut kept);
            kept.iter().map(|r| (r.first_cluster, r.cluster_count)).collect::<Vec<_>>()
        };
        assert_eq!(parts(&[run(2, 5), run(60, 80)], &[0; 3]), [(2, 5), (60, 80)]);
        assert_eq!(
            parts(&[run(2, 5), run(60, 80)], &[0b1001100, 1, 0]),
            [(4, 2), (60, 4), (65, 75)]
        );
        assert_eq!(parts(&[run(0, 128)], &[u64::MAX, u64::MAX >> 1]), [(127, 1)]);
        assert_eq!(parts(&[run(0, 128)], &[u64::MAX; 2]), []);
    }
}
