//! Samples of what is left: what is likely to be drawn of it, and how much of that is hidden.
//!
//! They are picked by handles, and summed in the order of these, so that neither the order of slots
//! nor the nodes have a say in what is decided by them.

use alloc::vec::Vec;

use super::super::Output;
use super::super::frame::Frame;
use super::super::run::is_parted;
use super::super::sets::{Coarse, Instances, slots};
use super::backface::Backs;
use crate::bits;
use crate::costs::OccluderCosts;
use crate::cull::frustum::batch::{Planes, VISIBLE};
use crate::cull::occlusion::{BoxTests, OcclusionBuffer, Visibility};
use crate::funnel::Counts;
use crate::mesh::Mesh;
use crate::sort::Sorter;

/// Instances that are sampled, and clusters; and the most handles that are looked at for it.
const SAMPLES: usize = 128;
const LOOKED_AT: usize = 4096;

/// Instances with more than one of so many of all triangles are sampled in any case, where the
/// frustum cuts them: what is left of them matters.
const LARGE: u64 = SAMPLES as u64;

/// Instances that would stand for more than one of so many of all triangles stand for none but
/// themselves: as the ground of a forest.
const OUTLIER: f64 = 8.0;

/// The most clusters of an instance that are sampled.
const MOST_OF_ONE: usize = 32;

/// The most shapes that a search is expected to look at. Of more shapes, the nodes pass over most.
const MOST_LOOKED_AT: f64 = 4096.0;

/// The most clusters of a mesh of which samples are tested for facing away: that takes a test of
/// every cluster.
const MANY: usize = 1 << 14;

/// Some of the instances that are left, and some of their clusters.
#[derive(Clone, Debug, Default)]
pub(super) struct Samples {
    /// Slots, first those that were picked evenly.
    slots: Vec<u32>,
    evenly: usize,
    parts: Vec<Part>,
    /// Triangles of which there is no sample.
    unknown: f64,
    /// Clusters that are likely to be left, of instances with more than a few.
    clusters: f64,
    /// Shapes of occluders.
    shapes: f64,
    culled: Vec<u64>,
    sorter: Sorter,
}

/// A sample of the triangles that are likely to be drawn.
#[derive(Clone, Copy, Debug)]
struct Part {
    slot: u32,
    /// Cluster of the instance; `None` is all of it.
    cluster: Option<u32>,
    /// How many it stands for.
    triangles: f64,
}

impl Samples {
    /// Samples what is alive, of which the counts are `left`.
    pub(super) fn take(
        &mut self,
        frame: &Frame<'_>,
        (set, coarse): (&Instances, &Coarse),
        left: Counts,
    ) {
        self.pick(frame, set, left.instances as usize, left.triangles);
        self.parts.clear();
        let whole = |slot: u32| u64::from(frame.scene.mesh(slot).triangle_count());
        let triangles = |slot: u32| {
            coarse.cut_of(slot).map_or_else(|| whole(slot), |cut| cut.tally.counts.triangles)
        };
        let stands_for = left.instances as f64 / self.evenly.max(1) as f64;
        let is_outlier =
            |slot: u32| triangles(slot) as f64 * stands_for * OUTLIER > left.triangles as f64;
        let (mut alone, mut few) = (0, 0);
        for &slot in &self.slots {
            *(if is_outlier(slot) { &mut alone } else { &mut few }) += triangles(slot);
        }
        let rest = left.triangles.saturating_sub(alone) as f64;
        self.unknown = if few == 0 { rest } else { 0.0 };
        let factor = rest / few.max(1) as f64;
        let shapes = |slot: &u32| {
            let occluder = frame.scene.prepared_of(*slot).occluder();
            occluder.map_or(0, |o| o.shapes().len()) as f64
        };
        self.shapes = self.slots().iter().map(shapes).sum::<f64>() * stands_for;
        self.clusters = 0.0;
        let each = (SAMPLES / self.slots.len().max(1)).clamp(1, MOST_OF_ONE);
        for i in 0..self.slots.len() {
            let slot = self.slots[i];
            let factor = if is_outlier(slot) { 1.0 } else { factor };
            // Of levels it is not known here where their clusters are.
            let each = if coarse.cut_of(slot).is_some() { 0 } else { each };
            self.add(frame, set, slot, triangles(slot) as f64 * factor, each);
        }
    }

    /// Slots of the instances that were picked evenly.
    pub(super) fn slots(&self) -> &[u32] {
        &self.slots[..self.evenly]
    }

    /// How many triangles are likely to be drawn.
    pub(super) fn triangles(&self) -> f64 {
        self.parts.iter().map(|part| part.triangles).sum::<f64>() + self.unknown
    }

    /// Returns two costs in nanoseconds: of looking for occluders, however little is drawn, and of
    /// testing `instances` instances and the clusters that are likely to be left.
    pub(super) fn overheads_ns(&self, costs: &OccluderCosts, instances: f64) -> [f64; 2] {
        let OccluderCosts { begin_ns, look_ns, test_ns, .. } = costs;
        let look = begin_ns + look_ns * self.shapes.min(MOST_LOOKED_AT);
        [look, test_ns * (instances + self.clusters)]
    }

    /// The share of what is likely to be drawn, by triangles, that a buffer hides.
    pub(super) fn hidden_share(&self, frame: &Frame<'_>, buffer: &OcclusionBuffer) -> f32 {
        let scene = frame.scene;
        let tests = BoxTests::new(buffer, frame.culler.simd);
        let (mut hidden, mut all) = (0.0, self.unknown);
        for of_slot in self.parts.chunk_by(|a, b| a.slot == b.slot) {
            let slot = of_slot[0].slot;
            let sum: f64 = of_slot.iter().map(|part| part.triangles).sum();
            all += sum;
            match tests.bounds(scene.boxes(), slot as usize) {
                Err(Visibility::Outside) => {
                    all -= sum;
                    continue;
                }
                Ok(b) if buffer.covers(frame.culler.simd, &b) => {
                    hidden += sum;
                    continue;
                }
                _ if of_slot[0].cluster.is_none() => continue,
                _ => {}
            }
            let against = tests.for_object(scene.transform(slot));
            let boxes = scene.mesh(slot).cluster_boxes();
            for part in of_slot {
                let bounds = part.cluster.map(|c| against.bounds(boxes, c as usize));
                if bounds.is_some_and(|b| b.is_ok_and(|b| buffer.covers(frame.culler.simd, &b))) {
                    hidden += part.triangles;
                }
            }
        }
        if all > 0.0 { (hidden / all) as f32 } else { 0.0 }
    }

    /// Picks instances evenly, and those that are large and cut by the frustum.
    fn pick(&mut self, frame: &Frame<'_>, set: &Instances, instances: usize, triangles: u64) {
        let scene = frame.scene;
        self.slots.clear();
        let handles = scene.hierarchy().index_count();
        let step = (instances / SAMPLES).max(handles.div_ceil(LOOKED_AT)).max(1);
        for index in (0..handles).step_by(step) {
            if let Some(slot) = scene.hierarchy().slot_of_index(index)
                && set.alive.get(slot / 64).is_some_and(|_| bits::get(&set.alive, slot))
            {
                self.slots.push(slot as u32);
            }
        }
        self.evenly = self.slots.len();
        if step == 1 || !frame.culler.frustum {
            return;
        }
        let is_large = |mesh: &Mesh| u64::from(mesh.triangle_count()) * LARGE > triangles;
        // Fewer meshes than words: mostly none is so large.
        if scene.meshes().len() < set.live.len() && !scene.meshes().iter().any(is_large) {
            return;
        }
        for &word in &set.live {
            let word = word as usize;
            for slot in slots(word, set.alive[word] & !set.inside[word]) {
                if is_large(scene.mesh(slot)) && !self.slots[..self.evenly].contains(&slot) {
                    self.slots.push(slot);
                }
            }
        }
        self.sorter.sort(&mut self.slots[self.evenly..], |&slot| {
            scene.handle(slot).map_or(0, |handle| u128::from(handle.index) + 1)
        });
    }

    /// Adds an instance that stands for so many triangles: all of it, or `some` of its clusters,
    /// without those that the frustum rejects and those that face away.
    fn add(&mut self, frame: &Frame<'_>, set: &Instances, slot: u32, triangles: f64, some: usize) {
        let (scene, mesh) = (frame.scene, frame.scene.mesh(slot));
        let is_whole = some == 0 || frame.culler.output == Output::Instances;
        if is_whole || !is_parted(mesh) || !scene.is_rigid(slot) {
            self.parts.push(Part { slot, cluster: None, triangles });
            return;
        }
        let count = mesh.clusters().len();
        let some = some.min(count);
        let is_cut = frame.culler.frustum && !bits::get(&set.inside, slot as usize);
        let planes = is_cut.then(|| {
            let straddled = frame.straddled(slot);
            Planes::in_object_space(&frame.world_frustum, scene.transform(slot), straddled)
        });
        let has_backs = frame.culls_backs_by_cluster()
            && count <= MANY
            && Backs::new(frame).cull_clusters(
                slot,
                scene.mesh_id(slot),
                &mut self.culled,
                &mut Vec::new(),
            );
        let triangles = triangles / some as f64;
        for i in 0..some {
            let cluster = (2 * i + 1) * count / (2 * some);
            let is_inside = planes
                .as_ref()
                .is_none_or(|p| p.first_rejecting(mesh.cluster_boxes(), cluster) == VISIBLE);
            if is_inside && !(has_backs && bits::get(&self.culled, cluster)) {
                let cluster = Some(cluster as u32);
                self.clusters += triangles * count as f64 / f64::from(mesh.triangle_count());
                self.parts.push(Part { slot, cluster, triangles });
            }
        }
    }
}
