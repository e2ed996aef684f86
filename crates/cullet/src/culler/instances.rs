//! The stages of instances and of clusters.

use super::Output;
use super::run::{Pass, Run};
use crate::bounds::Side;
use crate::cull::frustum::batch::{self, Planes};
use crate::cull::frustum::exact::ExactFrustum;
use crate::mesh::Mesh;
use crate::visible::{Reason, Stage, Unit};

impl Pass<'_> {
    /// Instances that share a layer with the view.
    pub(super) fn layers(&mut self) {
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
    pub(super) fn frustum_of_instances(&mut self) {
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
    pub(super) fn detail(&mut self) {
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
    pub(super) fn collapsed(&mut self) {
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
    pub(super) fn clusters(&mut self) {
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
}

fn reset(words: &mut Vec<u64>, len: usize) {
    words.clear();
    words.resize(len, 0);
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
