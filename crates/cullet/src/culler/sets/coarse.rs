//! The instances of which levels of detail are drawn, and which clusters of those.

use alloc::vec::Vec;
use core::ops::Range;

use super::super::run::Run;
use crate::bits;
use crate::scene::{MeshId, Tally};
use crate::sort::Sorter;

/// Levels that are drawn in place of an instance's mesh.
#[derive(Clone, Debug)]
pub(in super::super) struct Cut {
    pub(in super::super) slot: u32,
    /// The mesh that holds them.
    pub(in super::super) mesh: MeshId,
    pub(in super::super) level: u32,
    /// Counts of what is drawn of these levels.
    pub(in super::super) tally: Tally,
    /// Counts of the mesh that these levels replace.
    whole: Tally,
    /// Where their ranges of clusters are listed.
    ranges: Range<usize>,
}

/// Cuts of instances, ascending by slot.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct Coarse {
    cuts: Vec<Cut>,
    /// Ranges of clusters, of one cut after the other.
    ranges: Vec<Range<u32>>,
    /// Counts of all cuts.
    drawn: Tally,
    /// Counts of the meshes that the cuts replace.
    replaced: Tally,
    sorter: Sorter,
}

impl Coarse {
    pub(in super::super) fn clear(&mut self) {
        self.cuts.clear();
        self.ranges.clear();
        (self.drawn, self.replaced) = (Tally::default(), Tally::default());
    }

    /// Adds the cut of a slot above all others, with what its mesh would hold in its place.
    /// Otherwise [`sort`](Self::sort) is to follow.
    pub(in super::super) fn push(
        &mut self,
        (slot, mesh, level): (u32, MeshId, u32),
        (whole, tally): (Tally, Tally),
        ranges: impl Iterator<Item = Range<u32>>,
    ) {
        let first = self.ranges.len();
        self.ranges.extend(ranges);
        self.drawn += tally;
        self.replaced += whole;
        let ranges = first..self.ranges.len();
        self.cuts.push(Cut { slot, mesh, level, tally, whole, ranges });
    }

    /// Takes out the cuts of slots.
    pub(in super::super) fn drop_slots(&mut self, mut is_dropped: impl FnMut(u32) -> bool) {
        let Self { cuts, drawn, replaced, .. } = self;
        cuts.retain(|cut| {
            let drops = is_dropped(cut.slot);
            if drops {
                *drawn -= cut.tally;
                *replaced -= cut.whole;
            }
            !drops
        });
    }

    /// Brings cuts into the order of their slots, after some were added that are not above all
    /// others.
    pub(in super::super) fn sort(&mut self) {
        self.sorter.sort(&mut self.cuts, |cut| cut.slot.into());
    }

    /// Returns the counts of all cuts.
    pub(in super::super) fn drawn(&self) -> Tally {
        self.drawn
    }

    /// Returns the counts of the meshes that the cuts replace.
    pub(in super::super) fn replaced(&self) -> Tally {
        self.replaced
    }

    /// The cut of a slot; `None` where the mesh itself is drawn.
    pub(in super::super) fn cut_of(&self, slot: u32) -> Option<&Cut> {
        let at = self.cuts.binary_search_by_key(&slot, |cut| cut.slot).ok()?;
        self.cuts.get(at)
    }

    /// One bit a slot of a word: it has a cut.
    pub(in super::super) fn word(&self, word: u32) -> u64 {
        let first = self.cuts.partition_point(|cut| cut.slot < word * 64);
        let own = self.cuts[first..].iter().take_while(|cut| cut.slot / 64 == word);
        own.fold(0, |bits, cut| bits | 1 << (cut.slot % 64))
    }

    /// The clusters of a cut, as runs of which it is not known whether they are inside the frustum.
    pub(in super::super) fn runs_of<'a>(&'a self, cut: &'a Cut) -> impl Iterator<Item = Run> + 'a {
        self.ranges[cut.ranges.clone()].iter().map(move |range| Run {
            slot: cut.slot,
            mesh: cut.mesh,
            level: cut.level,
            first_cluster: range.start,
            cluster_count: range.len() as u32,
            inside: false,
        })
    }

    /// The clusters of all cuts, ascending.
    pub(in super::super) fn runs(&self) -> impl Iterator<Item = Run> + '_ {
        self.cuts.iter().flat_map(|cut| self.runs_of(cut))
    }

    /// The parts of a cut's ranges that are bits of a list, ascending: from which cluster to which.
    pub(in super::super) fn within<'a>(
        &'a self,
        cut: &'a Cut,
        wanted: &'a [u64],
    ) -> impl Iterator<Item = Range<u32>> + 'a {
        self.ranges[cut.ranges.clone()].iter().flat_map(move |range| {
            let (mut at, end) = (range.start, range.end);
            core::iter::from_fn(move || {
                let first = bits::next(wanted, at, end, true);
                at = bits::next(wanted, first, end, false);
                (first < at).then_some(first..at)
            })
        })
    }
}
