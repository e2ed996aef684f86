//! The pipeline of one view: each stage reads what the one before left, cheapest test first.
//!
//! Instances are bits in words of 64 slots; what is left of them becomes runs of clusters, and those
//! become a list of triangles. A stage runs over everything before the next begins, so that its time
//! and its counts are its own.

use super::occlusion::OcclusionState;
use super::{Backface, Culler, Output};
use crate::bits;
use crate::cull::frustum::tree::{Coherent, Cut};
use crate::funnel::{FrustumWork, OcclusionWork, Reason};
use crate::mesh::{MAX_CLUSTER_TRIANGLES, Mesh};
use crate::scene::{Scene, Tally};
use crate::view::{CullFace, Frustum, View};
use crate::visible::{DrawRange, SlotRange, Visible};

/// Consecutive clusters of one instance to which the frustum gave the same answer.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    pub(super) slot: u32,
    pub(super) first_cluster: u32,
    pub(super) cluster_count: u32,
    /// No triangle of it needs an outcode.
    pub(super) inside: bool,
}

/// What one view knows of a mesh.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct OfMesh {
    /// No cluster of any instance is culled for facing away. The rest holds where this does.
    pub(super) has_no_backs: bool,
    /// Its clusters are not culled by themselves.
    pub(super) is_whole: bool,
    pub(super) tally: Tally,
}

/// Memory that one view's culls use again and again.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    /// Which scene the last frame was of, and what it saw.
    pub(super) scene: u64,
    pub(super) coherent: Coherent,
    pub(super) cluster_cut: Cut,
    pub(super) occlusion: OcclusionState,
    /// One bit a slot: still in the running, and known to be inside the frustum.
    pub(super) alive: Vec<u64>,
    pub(super) inside: Vec<u64>,
    /// The words of the two that are not zero, ascending.
    pub(super) live: Vec<u32>,
    /// One bit a slot, of the live words: drawn whole, and in no run. Only where clusters are wanted.
    pub(super) settled: Vec<u64>,
    pub(super) of_meshes: Vec<OfMesh>,
    pub(super) cluster_culled: Vec<u64>,
    pub(super) runs: Vec<Run>,
    pub(super) kept_runs: Vec<Run>,
    pub(super) culled: Vec<u64>,
    pub(super) kept: Vec<u32>,
}

/// One cull of one view.
pub(super) struct Pass<'a> {
    pub(super) culler: &'a Culler,
    pub(super) scene: &'a Scene,
    pub(super) view: &'a View,
    /// In world space, and relative to the scene's origin, as its boxes are.
    pub(super) world_frustum: Frustum,
    pub(super) frustum: Frustum,
    pub(super) scratch: &'a mut Scratch,
    pub(super) result: &'a mut Visible,
    /// The one slot that is asked about, where an explanation is wanted.
    pub(super) only: Option<u32>,
    pub(super) stage_began: u64,
    /// What the layers left.
    pub(super) in_layers: Tally,
    /// What is still there, once the stages of instances are through.
    pub(super) tally: Tally,
}

impl<'a> Pass<'a> {
    pub(super) fn new(
        culler: &'a Culler,
        scene: &'a Scene,
        view: &'a View,
        scratch: &'a mut Scratch,
        result: &'a mut Visible,
    ) -> Self {
        let world_frustum = view.frustum();
        let frustum = world_frustum.relative_to(scene.origin());
        Self {
            culler,
            scene,
            view,
            world_frustum,
            frustum,
            scratch,
            result,
            only: None,
            stage_began: 0,
            in_layers: Tally::default(),
            tally: Tally::default(),
        }
    }

    /// Restricts the pass to one slot.
    pub(super) fn only(mut self, slot: u32) -> Self {
        self.only = Some(slot);
        self
    }

    pub(super) fn run(mut self) {
        self.clear();
        self.layers_and_frustum();
        if self.culler.detail.is_some() {
            self.detail();
        }
        if self.culler.degenerate {
            self.collapsed();
        }
        if let Some(settings) = self.culler.occlusion {
            self.occlusion(&settings);
        }
        match self.culler.output {
            Output::Instances => self.emit_instances(),
            Output::Clusters => {
                self.cluster_stages();
                self.emit();
            }
            Output::Triangles => {
                self.cluster_stages();
                self.triangle_stages();
                self.emit();
            }
        }
        if self.culler.degenerate && self.culler.output != Output::Triangles {
            self.degenerates_of_the_rest();
        }
        let r = &mut *self.result;
        (r.instance_count, r.triangle_count) =
            (self.tally.counts.instances, self.tally.counts.triangles);
        r.dropped.sort_unstable_by_key(|d| (d.slot, d.first_triangle));
    }

    fn cluster_stages(&mut self) {
        self.clusters();
        if self.culler.occlusion.is_some() {
            self.occlusion_of_clusters();
        }
        if self.culls_backs_by_cluster() {
            self.backfaces_of_clusters();
        }
    }

    fn triangle_stages(&mut self) {
        self.list_triangles();
        if self.culler.backface != Backface::Off && self.view.cull_face != CullFace::None {
            self.backfaces_of_triangles();
        }
        if self.culler.degenerate {
            self.degenerate_triangles();
        }
    }

    fn clear(&mut self) {
        let r = &mut *self.result;
        r.whole.clear();
        r.partial.clear();
        r.triangle_ranges.clear();
        r.triangles.clear();
        r.reasons.clear();
        r.dropped.clear();
        r.funnel.rows.clear();
        r.funnel.frustum = FrustumWork::default();
        r.funnel.occlusion = OcclusionWork::default();
        if self.culler.reasons {
            r.reasons.resize(self.scene.slot_count() as usize, None);
        }
        self.scratch.runs.clear();
        self.stage_began = self.now();
    }

    /// Nanoseconds by the culler's clock; 0 where it has none.
    pub(super) fn now(&self) -> u64 {
        self.culler.clock.map_or(0, |now| now())
    }

    pub(super) fn drop_slot(&mut self, slot: u32, reason: Reason) {
        if self.culler.reasons {
            self.result.reasons[slot as usize] = Some(reason);
        }
    }

    /// Writes slot ranges and draw ranges.
    fn emit(&mut self) {
        let by_triangle = self.culler.output == Output::Triangles;
        let r = &mut *self.result;
        let mut settled = Settled::new(&self.scratch.live, &self.scratch.settled);
        let mut ranges = r.triangle_ranges.iter().peekable();
        for runs in self.scratch.runs.chunk_by(|a, b| a.slot == b.slot) {
            let slot = runs[0].slot;
            if by_triangle {
                // Both ascend by slot; a slot without a range has lost all its triangles.
                if ranges.next_if(|range| range.slot == slot).is_none() {
                    continue;
                }
            }
            settled.list_before(slot, &mut r.whole);
            let mesh = self.scene.mesh(slot);
            let clusters: u32 = runs.iter().map(|run| run.cluster_count).sum();
            if clusters == mesh.levels()[0].cluster_count {
                push_whole(&mut r.whole, slot, 1);
            } else {
                for run in runs {
                    let Run { slot, first_cluster, cluster_count, .. } = *run;
                    match r.partial.last_mut() {
                        Some(d)
                            if d.slot == slot
                                && d.first_cluster + d.cluster_count == first_cluster =>
                        {
                            d.cluster_count += cluster_count;
                        }
                        _ => r.partial.push(DrawRange {
                            slot,
                            level: 0,
                            first_cluster,
                            cluster_count,
                        }),
                    }
                }
            }
        }
        settled.list_before(u32::MAX, &mut r.whole);
    }
}

/// The settled slots that are not listed yet.
struct Settled<'a> {
    live: &'a [u32],
    words: &'a [u64],
    /// What is left of the first live word.
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
pub(super) fn push_whole(whole: &mut Vec<SlotRange>, first: u32, count: u32) {
    match whole.last_mut() {
        Some(range) if range.first + range.count == first => range.count += count,
        _ => whole.push(SlotRange { first, count }),
    }
}

/// The fewest triangles of a mesh of which clusters are culled by themselves, two clusters' worth. Of less so
/// little goes that finding it, some 200 ns an instance, costs more than drawing it.
const LEAST_PARTED: u32 = 2 * MAX_CLUSTER_TRIANGLES as u32;

/// Whether it pays to cull the clusters of a mesh by themselves.
pub(super) fn is_parted(mesh: &Mesh) -> bool {
    mesh.triangle_count() > LEAST_PARTED
}

/// The triangles of a run: clusters follow each other in the mesh's order.
pub(super) fn triangles_of(mesh: &Mesh, run: Run) -> std::ops::Range<u32> {
    let clusters = &mesh.clusters()[run.first_cluster as usize..];
    let Some(first) = clusters.first() else { return 0..0 };
    let last = clusters[run.cluster_count as usize - 1];
    first.first_triangle..last.first_triangle + last.triangle_count
}
