//! The pipeline of one view: each stage reads what the one before left, cheapest test first.
//!
//! Instances are bits in words of 64 slots; what is left of them becomes runs of clusters, and those
//! become a list of triangles. A stage runs over everything before the next begins, so that its time
//! and its counts are its own.

use super::{Culler, Output};
use crate::bounds::Side;
use crate::clip::outcode::ObjectRegion;
use crate::cull::backface::ObjectEye;
use crate::cull::degenerate::Flattening;
use crate::cull::frustum::batch::{self, Planes};
use crate::cull::frustum::exact::ExactFrustum;
use crate::mesh::{Cluster, Mesh};
use crate::scene::Scene;
use crate::view::{CullFace, Frustum, View};
use crate::visible::{
    DrawRange, FunnelRow, Reason, SlotRange, Stage, TriangleRange, Unit, Visible,
};

/// Consecutive clusters of one instance to which the frustum gave the same answer.
#[derive(Clone, Copy, Debug)]
struct Run {
    slot: u32,
    first_cluster: u32,
    cluster_count: u32,
    /// No triangle of it needs an outcode.
    inside: bool,
}

/// Memory that one view's culls use again and again.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    alive: Vec<u64>,
    visible: Vec<u64>,
    inside: Vec<u64>,
    cluster_visible: Vec<u64>,
    cluster_inside: Vec<u64>,
    runs: Vec<Run>,
    kept: Vec<u32>,
}

/// One cull of one view.
pub(super) struct Pass<'a> {
    culler: &'a Culler,
    scene: &'a Scene,
    view: &'a View,
    /// In world space, and relative to the scene's origin, as its boxes are.
    world_frustum: Frustum,
    frustum: Frustum,
    scratch: &'a mut Scratch,
    result: &'a mut Visible,
    /// The one slot that is asked about, where an explanation is wanted.
    only: Option<u32>,
    stage_began: u64,
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
        }
    }

    /// Restricts the pass to one slot.
    pub(super) fn only(mut self, slot: u32) -> Self {
        self.only = Some(slot);
        self
    }

    pub(super) fn run(mut self) {
        self.clear();
        self.layers();
        if self.culler.frustum {
            self.frustum_of_instances();
        }
        if self.culler.detail.is_some() {
            self.detail();
        }
        if self.culler.degenerate {
            self.collapsed();
        }
        self.clusters();
        if self.culler.output == Output::Triangles {
            self.list_triangles();
            if self.culler.backface && self.view.cull_face != CullFace::None {
                self.backfaces();
            }
            if self.culler.degenerate {
                self.degenerate_triangles();
            }
        }
        self.emit();
    }

    fn clear(&mut self) {
        let r = &mut *self.result;
        r.whole.clear();
        r.partial.clear();
        r.triangle_ranges.clear();
        r.triangles.clear();
        r.reasons.clear();
        r.funnel.rows.clear();
        if self.culler.reasons {
            r.reasons.resize(self.scene.slot_count() as usize, None);
        }
        self.scratch.runs.clear();
        self.stage_began = self.culler.clock.map_or(0, |now| now());
    }

    fn row(&mut self, stage: Stage, unit: Unit, entered: u64, left: u64) {
        let nanoseconds = self.culler.clock.map(|now| {
            let now = now();
            let took = now.saturating_sub(self.stage_began);
            self.stage_began = now;
            took
        });
        self.result.funnel.rows.push(FunnelRow { stage, unit, entered, left, nanoseconds });
    }

    fn drop_slot(&mut self, slot: u32, reason: Reason) {
        if self.culler.reasons {
            self.result.reasons[slot as usize] = Some(reason);
        }
    }

    fn alive_count(&self) -> u64 {
        self.scratch.alive.iter().map(|w| u64::from(w.count_ones())).sum()
    }

    /// Instances that share a layer with the view.
    fn layers(&mut self) {
        let scene = self.scene;
        let slots = scene.slot_count();
        self.scratch.alive.clear();
        self.scratch.alive.resize((slots as usize).div_ceil(64), 0);
        let asked = self.only.map_or(0..slots, |slot| slot..slot + 1);
        let mut entered = 0;
        for slot in asked {
            if scene.is_removed(slot) {
                continue;
            }
            entered += 1;
            if scene.layers(slot) & self.view.layers != 0 {
                self.scratch.alive[slot as usize / 64] |= 1 << (slot % 64);
            } else {
                self.drop_slot(slot, Reason { stage: Stage::Layer, detail: 0 });
            }
        }
        let left = self.alive_count();
        self.row(Stage::Layer, Unit::Instances, entered, left);
    }

    /// Instances whose box is not outside the frustum; which of them are wholly inside is kept.
    fn frustum_of_instances(&mut self) {
        let entered = self.alive_count();
        let scene = self.scene;
        let planes = Planes::new(&self.frustum);
        let s = &mut *self.scratch;
        reset(&mut s.visible, s.alive.len());
        reset(&mut s.inside, s.alive.len());
        if let Some(slot) = self.only {
            // The arithmetic of the batch test, so the same answer.
            let side = planes.classify_box(&scene.bounds(slot));
            let (word, bit) = (slot as usize / 64, slot % 64);
            s.visible[word] = u64::from(side != Side::Outside) << bit;
            s.inside[word] = u64::from(side == Side::Inside) << bit;
        } else {
            let (level, boxes) = (self.culler.level, scene.boxes());
            batch::classify_boxes(level, &planes, boxes, 0, &mut s.visible, &mut s.inside);
        }
        let exact = self.culler.frustum_exact.then(|| ExactFrustum::new(&self.frustum));
        for word in 0..self.scratch.alive.len() {
            let s = &mut *self.scratch;
            let exempt = scene.exempt()[word];
            s.inside[word] |= exempt;
            let mut dropped = s.alive[word] & !s.visible[word] & !exempt;
            if let Some(exact) = &exact {
                for slot in bits(word, s.alive[word] & s.visible[word] & !s.inside[word]) {
                    if exact.is_outside_beyond_planes(&scene.bounds(slot)) {
                        dropped |= 1 << (slot % 64);
                    }
                }
            }
            s.alive[word] &= !dropped;
            if self.culler.reasons {
                for slot in bits(word, dropped) {
                    let detail = planes.first_rejecting(scene.boxes(), slot as usize);
                    self.drop_slot(slot, Reason { stage: Stage::Frustum, detail });
                }
            }
        }
        let left = self.alive_count();
        self.row(Stage::Frustum, Unit::Instances, entered, left);
    }

    /// Instances that are not too small on the screen.
    fn detail(&mut self) {
        let Some(detail) = self.culler.detail else { return };
        let entered = self.alive_count();
        let (scene, view) = (self.scene, self.view);
        self.filter_instances(Stage::Detail, |slot| {
            let bounds = scene.bounds(slot);
            !detail.is_small(view.project_box(&bounds, scene.origin()).as_ref())
        });
        let left = self.alive_count();
        self.row(Stage::Detail, Unit::Instances, entered, left);
    }

    /// Instances that their transform does not flatten to a line or a point.
    fn collapsed(&mut self) {
        let entered = self.alive_count();
        let scene = self.scene;
        self.filter_instances(Stage::Degenerate, |slot| {
            scene.collapsed()[slot as usize / 64] >> (slot % 64) & 1 == 0
        });
        let left = self.alive_count();
        self.row(Stage::Degenerate, Unit::Instances, entered, left);
    }

    /// Drops the instances that `keep` refuses, exempt ones apart.
    fn filter_instances(&mut self, stage: Stage, keep: impl Fn(u32) -> bool) {
        for word in 0..self.scratch.alive.len() {
            let asked = self.scratch.alive[word] & !self.scene.exempt()[word];
            for slot in bits(word, asked).filter(|&slot| !keep(slot)) {
                self.scratch.alive[word] &= !(1 << (slot % 64));
                self.drop_slot(slot, Reason { stage, detail: 0 });
            }
        }
    }

    /// Turns instances into runs of clusters: all of those inside, and of the others what is not
    /// outside the frustum.
    fn clusters(&mut self) {
        let scene = self.scene;
        let by_cluster = self.culler.frustum && self.culler.output >= Output::Clusters;
        let (mut entered, mut left) = (0, 0);
        for word in 0..self.scratch.alive.len() {
            for slot in bits(word, self.scratch.alive[word]) {
                let mesh = scene.mesh(slot);
                let cluster_count = mesh.levels()[0].cluster_count;
                entered += u64::from(cluster_count);
                let inside = !by_cluster
                    || self.scratch.inside[word] >> (slot % 64) & 1 == 1
                    || !scene.is_rigid(slot)
                    || cluster_count == 0;
                if inside {
                    let run = Run { slot, first_cluster: 0, cluster_count, inside: true };
                    self.scratch.runs.push(run);
                    left += u64::from(cluster_count);
                    continue;
                }
                let kept = self.clusters_of(slot, mesh);
                left += u64::from(kept);
                if kept == 0 && cluster_count > 0 {
                    self.drop_slot(slot, Reason { stage: Stage::Frustum, detail: Reason::MIXED });
                }
            }
        }
        if by_cluster {
            self.row(Stage::Frustum, Unit::Clusters, entered, left);
        }
    }

    fn clusters_of(&mut self, slot: u32, mesh: &Mesh) -> u32 {
        let planes = Planes::new(&self.world_frustum.to_object_space(self.scene.transform(slot)));
        let s = &mut *self.scratch;
        let boxes = mesh.cluster_boxes();
        let (visible, inside) = (&mut s.cluster_visible, &mut s.cluster_inside);
        reset(visible, batch::mask_words(boxes.len()));
        reset(inside, visible.len());
        batch::classify_boxes(self.culler.level, &planes, boxes, 0, visible, inside);
        let level = mesh.levels()[0];
        let mut kept = 0;
        for cluster in level.first_cluster..level.first_cluster + level.cluster_count {
            let (word, bit) = (cluster as usize / 64, cluster % 64);
            if s.cluster_visible[word] >> bit & 1 == 0 {
                continue;
            }
            kept += 1;
            let inside = s.cluster_inside[word] >> bit & 1 == 1;
            match s.runs.last_mut() {
                Some(run)
                    if run.slot == slot
                        && run.inside == inside
                        && run.first_cluster + run.cluster_count == cluster =>
                {
                    run.cluster_count += 1;
                }
                _ => s.runs.push(Run { slot, first_cluster: cluster, cluster_count: 1, inside }),
            }
        }
        kept
    }

    /// Lists the triangles of all runs, those of straddling clusters by their outcodes.
    fn list_triangles(&mut self) {
        let scene = self.scene;
        let (mut entered, mut left) = (0, 0);
        let mut region = None;
        for i in 0..self.scratch.runs.len() {
            let run = self.scratch.runs[i];
            let mesh = scene.mesh(run.slot);
            let triangles = triangles_of(mesh, run);
            let list = &mut self.result.triangles;
            let before = list.len();
            if run.inside {
                list.extend(triangles.clone());
            } else {
                // Runs of a slot follow each other: its region is made once.
                if region.as_ref().is_none_or(|(slot, _)| *slot != run.slot) {
                    let transform = scene.transform(run.slot);
                    region = Some((run.slot, ObjectRegion::new(&self.world_frustum, transform)));
                }
                let Some((_, region)) = &region else { continue };
                let (positions, indices) = (mesh.positions(), mesh.indices());
                region.keep_into(positions, indices, triangles.clone(), region.present(), list);
            }
            entered += triangles.len() as u64;
            // Degenerate triangles are in no cluster; they go with the last run of their instance.
            let last = self.scratch.runs.get(i + 1).is_none_or(|next| next.slot != run.slot);
            if last {
                let count = mesh.triangle_count();
                let degenerate = count - mesh.degenerate_count()..count;
                entered += degenerate.len() as u64;
                list.extend(degenerate);
            }
            let count = (list.len() - before) as u32;
            left += u64::from(count);
            match self.result.triangle_ranges.last_mut() {
                Some(range) if range.slot == run.slot => range.count += count,
                _ => self.result.triangle_ranges.push(TriangleRange {
                    slot: run.slot,
                    first: before as u32,
                    count,
                }),
            }
        }
        if self.culler.frustum {
            self.row(Stage::Frustum, Unit::Triangles, entered, left);
            self.drop_empty_ranges(Stage::Frustum);
        }
    }

    /// Drops back faces (or front faces) of one-sided parts.
    fn backfaces(&mut self) {
        let (scene, view) = (self.scene, self.view);
        self.filter_triangles(Stage::Backface, |slot, triangles, kept| {
            let mesh = scene.mesh(slot);
            let exempt = scene.exempt()[slot as usize / 64] >> (slot % 64) & 1 == 1;
            let two_sided = scene.flags(slot).double_sided || mesh.is_two_sided();
            if exempt || two_sided || !scene.is_rigid(slot) {
                return false;
            }
            let eye = ObjectEye::of_view(view, scene.transform(slot));
            let mut rest = triangles;
            for cluster in clusters_of_list(mesh, triangles) {
                let end = cluster.first_triangle + cluster.triangle_count;
                let (of_cluster, after) = rest.split_at(rest.partition_point(|&t| t < end));
                rest = after;
                if of_cluster.is_empty() && rest.is_empty() {
                    break;
                }
                if mesh.parts()[cluster.part as usize].two_sided {
                    kept.extend_from_slice(of_cluster);
                } else {
                    let front = |t: &&u32| !eye.culls(&mesh.corners(**t));
                    kept.extend(of_cluster.iter().filter(front));
                }
            }
            // Degenerate triangles follow the last cluster; they have no back.
            kept.extend_from_slice(rest);
            true
        });
    }

    /// Drops triangles without area: those found when the mesh was made, and those that a flattening
    /// transform makes.
    fn degenerate_triangles(&mut self) {
        let scene = self.scene;
        self.filter_triangles(Stage::Degenerate, |slot, triangles, kept| {
            let mesh = scene.mesh(slot);
            let drawn = mesh.triangle_count() - mesh.degenerate_count();
            let flattening = Flattening::of(scene.transform(slot));
            let flattened = scene.is_rigid(slot) && flattening.rank() < 3;
            if !flattened && triangles.last().is_none_or(|&t| t < drawn) {
                return false;
            }
            kept.extend(
                triangles.iter().copied().filter(|&t| {
                    t < drawn && !(flattened && flattening.flattens(&mesh.corners(t)))
                }),
            );
            true
        });
    }

    /// Runs a triangle stage over every range in place. The closure appends what it keeps, or returns
    /// `false` to keep all.
    fn filter_triangles(
        &mut self,
        stage: Stage,
        mut keep: impl FnMut(u32, &[u32], &mut Vec<u32>) -> bool,
    ) {
        let entered = self.result.triangles.len() as u64;
        let r = &mut *self.result;
        let kept = &mut self.scratch.kept;
        let mut write = 0;
        for range in &mut r.triangle_ranges {
            let read = range.first as usize..(range.first + range.count) as usize;
            kept.clear();
            let count = if keep(range.slot, &r.triangles[read.clone()], kept) {
                r.triangles[write..write + kept.len()].copy_from_slice(kept);
                kept.len()
            } else {
                r.triangles.copy_within(read.clone(), write);
                read.len()
            };
            *range = TriangleRange { slot: range.slot, first: write as u32, count: count as u32 };
            write += count;
        }
        r.triangles.truncate(write);
        self.row(stage, Unit::Triangles, entered, write as u64);
        self.drop_empty_ranges(stage);
    }

    /// Forgets instances of which a stage left no triangle.
    fn drop_empty_ranges(&mut self, stage: Stage) {
        let reasons = &mut self.result.reasons;
        let detail = if stage == Stage::Frustum { Reason::MIXED } else { 0 };
        self.result.triangle_ranges.retain(|range| {
            if range.count == 0 && !reasons.is_empty() {
                reasons[range.slot as usize] = Some(Reason { stage, detail });
            }
            range.count > 0
        });
    }

    /// Writes slot ranges and draw ranges.
    fn emit(&mut self) {
        let by_triangle = self.culler.output == Output::Triangles;
        let r = &mut *self.result;
        r.triangle_count = 0;
        r.instance_count = 0;
        let mut ranges = r.triangle_ranges.iter().peekable();
        for runs in self.scratch.runs.chunk_by(|a, b| a.slot == b.slot) {
            let slot = runs[0].slot;
            if by_triangle {
                // Both ascend by slot; a slot without a range has lost all its triangles.
                if ranges.next_if(|range| range.slot == slot).is_none() {
                    continue;
                }
            }
            r.instance_count += 1;
            let mesh = self.scene.mesh(slot);
            let clusters: u32 = runs.iter().map(|run| run.cluster_count).sum();
            if clusters == mesh.levels()[0].cluster_count {
                match r.whole.last_mut() {
                    Some(range) if range.first + range.count == slot => range.count += 1,
                    _ => r.whole.push(SlotRange { first: slot, count: 1 }),
                }
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
            if !by_triangle {
                r.triangle_count +=
                    runs.iter().map(|&run| triangles_of(mesh, run).len() as u64).sum::<u64>();
            }
        }
        if by_triangle {
            r.triangle_count = r.triangles.len() as u64;
        }
    }
}

fn reset(words: &mut Vec<u64>, len: usize) {
    words.clear();
    words.resize(len, 0);
}

/// The triangles of a run: clusters follow each other in the mesh's order.
fn triangles_of(mesh: &Mesh, run: Run) -> std::ops::Range<u32> {
    let clusters = &mesh.clusters()[run.first_cluster as usize..];
    let Some(first) = clusters.first() else { return 0..0 };
    let last = clusters[run.cluster_count as usize - 1];
    first.first_triangle..last.first_triangle + last.triangle_count
}

/// The clusters from the one of the first triangle of an ascending list on.
fn clusters_of_list<'m>(mesh: &'m Mesh, triangles: &[u32]) -> &'m [Cluster] {
    let first = triangles.first().copied().unwrap_or(0);
    let clusters = mesh.clusters();
    let at = clusters.partition_point(|c| c.first_triangle + c.triangle_count <= first);
    &clusters[at..]
}

/// The slots of the bits that are set in a word.
fn bits(word: usize, mut value: u64) -> impl Iterator<Item = u32> {
    std::iter::from_fn(move || {
        (value != 0).then(|| {
            let bit = value.trailing_zeros();
            value &= value - 1;
            word as u32 * 64 + bit
        })
    })
}
