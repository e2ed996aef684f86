//! The answer: from what is left in the working sets to [`Visible`].

use alloc::vec::Vec;

use super::Output;
use super::frame::Frame;
use super::log::Work;
use super::run::Run;
use super::sets::Sets;
use crate::bits;
use crate::funnel::Unit;
use crate::visible::{DrawRange, SlotRange, Visible};

/// Writes what is left. The triangles are in the answer's own lists already.
pub(super) fn write(frame: &Frame<'_>, sets: &Sets, work: Work, result: &mut Visible) {
    result.version = frame.scene.version();
    result.whole.clear();
    result.partial.clear();
    (result.funnel.frustum, result.funnel.occlusion) = (work.frustum, work.occlusion);
    (result.instance_count, result.triangle_count) = (work.left.instances, work.left.triangles);
    if frame.culler.output == Output::Instances {
        for &word in &sets.instances.live {
            let own = sets.instances.alive[word as usize] & !sets.coarse.word(word);
            for run in bits::runs(own) {
                let first = word * 64 + run.start as u32;
                push_whole(&mut result.whole, first, run.len() as u32);
            }
        }
        sets.coarse.runs().for_each(|run| push_partial(&mut result.partial, run));
    } else {
        write_clusters(frame, sets, result);
    }
}

/// Writes slot ranges and draw ranges.
fn write_clusters(frame: &Frame<'_>, sets: &Sets, result: &mut Visible) {
    let by_triangle = frame.culler.output.unit() == Unit::Triangles;
    let mut settled = Settled::new(&sets.instances.live, &sets.clusters.settled);
    let mut ranges = result.triangle_ranges.iter().peekable();
    for runs in sets.clusters.runs.chunk_by(|a, b| a.slot == b.slot) {
        let slot = runs[0].slot;
        // An instance of bounds alone has no triangles to lose.
        if by_triangle && frame.scene.meshes()[runs[0].mesh as usize].triangle_count() > 0 {
            // Both ascend by slot; a slot without a range has lost all its triangles.
            if ranges.next_if(|range| range.slot == slot).is_none() {
                continue;
            }
        }
        settled.list_before(slot, &mut result.whole);
        let mesh = frame.scene.mesh(slot);
        let is_own = runs[0].level == 0;
        let clusters: u32 = runs.iter().map(|run| run.cluster_count).sum();
        if is_own && clusters == mesh.cluster_count() {
            push_whole(&mut result.whole, slot, 1);
        } else {
            runs.iter().for_each(|run| push_partial(&mut result.partial, *run));
        }
    }
    settled.list_before(u32::MAX, &mut result.whole);
}

/// The settled slots that are not listed yet.
struct Settled<'a> {
    live: &'a [u32],
    words: &'a [u64],
    /// Bits left of the first live word.
    left: u64,
}

impl<'a> Settled<'a> {
    fn new(live: &'a [u32], words: &'a [u64]) -> Self {
        Self { live, words, left: live.first().map_or(0, |&word| words[word as usize]) }
    }

    /// Lists those before a slot.
    fn list_before(&mut self, slot: u32, whole: &mut Vec<SlotRange>) {
        while let Some((&word, rest)) = self.live.split_first() {
            if word > slot / 64 {
                return;
            }
            let before = if word == slot / 64 { (1 << (slot % 64)) - 1 } else { u64::MAX };
            for run in bits::runs(self.left & before) {
                push_whole(whole, word * 64 + run.start as u32, run.len() as u32);
            }
            self.left &= !before;
            if word == slot / 64 {
                return;
            }
            self.live = rest;
            self.left = rest.first().map_or(0, |&word| self.words[word as usize]);
        }
    }
}

/// Appends slots to ranges that ascend.
fn push_whole(whole: &mut Vec<SlotRange>, first: u32, count: u32) {
    match whole.last_mut() {
        Some(range) if range.first + range.count == first => range.count += count,
        _ => whole.push(SlotRange { first, count }),
    }
}

/// Appends a run to ranges that ascend.
fn push_partial(partial: &mut Vec<DrawRange>, run: Run) {
    let Run { slot, level, first_cluster, cluster_count, .. } = run;
    match partial.last_mut() {
        Some(d) if d.slot == slot && d.first_cluster + d.cluster_count == first_cluster => {
            d.cluster_count += cluster_count;
        }
        _ => partial.push(DrawRange { slot, level, first_cluster, cluster_count }),
    }
}
