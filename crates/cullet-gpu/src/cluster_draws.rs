//! Draws of clusters in each phase: one for each cluster, or those of visible ones alone.

use std::ops::Range;

use wgpu::{Buffer, CommandEncoder, Device, Queue, RenderPass};

use super::clusters::{ClusterArguments, ClusterInstances};
use super::counted::CountedArguments;
use super::error::GpuError;
use super::lists::{DrawArguments, LaneBuffers, ListSource};
use super::passes::Passes;

const SIZE: u64 = size_of::<DrawArguments>() as u64;

/// Draws of clusters by phase.
#[derive(Debug)]
pub(crate) enum ClusterDraws {
    /// One for each, of which some have no instance.
    Each([ClusterArguments; 3]),
    /// Clusters that are listed.
    Counted {
        all: Box<[CountedArguments; 3]>,
        /// Bytes of their lanes on the device.
        of_lanes: u64,
    },
}

impl ClusterDraws {
    pub(crate) fn new(
        (device, queue, passes): (&Device, &Queue, &Passes),
        clusters: &ClusterInstances,
        sources: [ListSource<'_>; 3],
        is_counted: bool,
    ) -> Result<Self, GpuError> {
        let [early, late, blended] = sources;
        if is_counted {
            let lanes = LaneBuffers::new(device, queue, &clusters.lanes())?;
            let both = (&passes.counted, &passes.lists);
            let of =
                |source| CountedArguments::new(device, queue, both, (clusters, &lanes), source);
            let all = [of(early)?, of(late)?, of(blended)?];
            return Ok(Self::Counted { all: Box::new(all), of_lanes: lanes.bytes() });
        }
        let of = |source| ClusterArguments::new(device, queue, &passes.arguments, clusters, source);
        Ok(Self::Each([of(early)?, of(late)?, of(blended)?]))
    }

    pub(crate) fn record(&self, passes: &Passes, encoder: &mut CommandEncoder, phase: usize) {
        match self {
            Self::Each(all) => passes.arguments.record(encoder, &all[phase]),
            Self::Counted { all, .. } => {
                passes.counted.record(&passes.lists, encoder, &all[phase]);
            }
        }
    }

    /// Draws one call's.
    pub(crate) fn draw(
        &self,
        pass: &mut RenderPass<'_>,
        phase: usize,
        (call, numbers): (usize, &Range<u32>),
    ) {
        let (first, most) = (u64::from(numbers.start) * SIZE, numbers.end - numbers.start);
        match self {
            Self::Each(all) => {
                let arguments = all[phase].arguments();
                pass.multi_draw_indexed_indirect(arguments, first, most);
            }
            Self::Counted { all, .. } => {
                /// Offset of the instance count among arguments.
                const COUNT: u64 = 4;
                let own = &all[phase];
                let count = call as u64 * SIZE + COUNT;
                let counts = own.counts();
                pass.multi_draw_indexed_indirect_count(own.arguments(), first, counts, count, most);
            }
        }
    }

    /// Arguments whose instances are the clusters that are drawn, and how many there are.
    pub(crate) fn arguments(&self, phase: usize, clusters: &ClusterInstances) -> (&Buffer, usize) {
        match self {
            Self::Each(all) => (all[phase].arguments(), clusters.slots().len()),
            Self::Counted { all, .. } => {
                let own = &all[phase];
                (own.counts(), own.calls())
            }
        }
    }

    /// Bytes on the device.
    pub(crate) fn bytes(&self) -> u64 {
        match self {
            Self::Each(all) => all.iter().map(|own| own.arguments().size()).sum(),
            Self::Counted { all, of_lanes } => {
                of_lanes + all.iter().map(CountedArguments::bytes).sum::<u64>()
            }
        }
    }
}
