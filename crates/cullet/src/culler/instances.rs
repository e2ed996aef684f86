//! The stages of instances and of clusters.

use super::backfaces::Backs;
use super::run::{OfMesh, Pass, Run, is_parted, push_whole};
use super::{Backface, Output};
use crate::bits;
use crate::bounds::Side;
use crate::cull::frustum::batch::Planes;
use crate::cull::frustum::exact::ExactFrustum;
use crate::funnel::{FrustumWork, Reason, Stage, Unit};
use crate::mesh::Mesh;
use crate::scene::Tally;
use crate::view::CullFace;

impl Pass<'_> {
    /// The stages of instances that are answered by slot masks: layers, then the frustum.
    ///
    /// What a view sees is mostly a small part of a scene, so only the words of the masks that hold
    /// something are ever looked at, unless reasons are wanted: those are for what is not seen.
    pub(super) fn layers_and_frustum(&mut self) {
        let scene = self.scene;
        self.forget_alive();
        let all = match self.only {
            Some(slot) => {
                let all = scene.tally_of(slot);
                let is_in = scene.layers(slot) & self.view.layers != 0;
                self.in_layers = if is_in { all } else { Tally::default() };
                all
            }
            None => {
                self.in_layers = scene.tally_of_layers(self.view.layers);
                scene.tally()
            }
        };
        let all_in = all.counts.instances == self.in_layers.counts.instances;
        self.push_row(Stage::Layer, Unit::Instances, all.counts, self.in_layers.counts);
        if self.culler.reasons && !all_in {
            let slots = self.only.map_or(0..scene.slot_count(), |slot| slot..slot + 1);
            for slot in slots.filter(|&s| !scene.is_removed(s)) {
                if scene.layers(slot) & self.view.layers == 0 {
                    self.drop_slot(slot, Reason { stage: Stage::Layer, detail: 0 });
                }
            }
        }
        if let Some(slot) = self.only {
            if all_in {
                self.take_alone(slot);
            }
        } else if self.culler.frustum {
            self.take_visible(all_in);
        } else {
            let words = scene.hierarchy().present().len();
            (0..words).for_each(|word| self.take(word, u64::MAX, u64::MAX, all_in));
        }
        if self.culler.frustum {
            self.instance_row(Stage::Frustum, Tally::default());
        }
    }

    /// Forgets the last view's instances.
    fn forget_alive(&mut self) {
        let s = &mut *self.scratch;
        for &word in &s.live {
            s.alive[word as usize] = 0;
            s.inside[word as usize] = 0;
        }
        s.live.clear();
        let words = self.scene.hierarchy().present().len();
        s.alive.resize(words, 0);
        s.inside.resize(words, 0);
    }

    /// Takes the instances of one word of the masks: those that are there, in a layer of the view, and not
    /// outside.
    fn take(&mut self, word: usize, visible: u64, inside: u64, all_in: bool) {
        let scene = self.scene;
        let exempt = scene.exempt()[word];
        let mut alive = (visible | exempt) & scene.hierarchy().present()[word];
        if !all_in {
            for bit in bits::ones(alive) {
                let slot = (word * 64 + bit) as u32;
                if scene.layers(slot) & self.view.layers == 0 {
                    alive &= !(1 << bit);
                }
            }
        }
        if alive != 0 {
            let s = &mut *self.scratch;
            s.alive[word] = alive;
            s.inside[word] = inside | exempt;
            s.live.push(word as u32);
        }
    }

    /// Takes what the frustum does not reject, by the scene's hierarchy.
    fn take_visible(&mut self, all_in: bool) {
        let scene = self.scene;
        let hierarchy = scene.hierarchy();
        let planes = Planes::new(&self.frustum);
        let mut coherent = std::mem::take(&mut self.scratch.coherent);
        if std::mem::replace(&mut self.scratch.scene, scene.id()) != scene.id() {
            coherent.forget();
        }
        let (boxes, version) = (hierarchy.boxes(), hierarchy.change_version());
        coherent.cull(self.culler.level, &planes, hierarchy.nodes(), boxes, version);
        let cut = coherent.cut();
        self.result.funnel.frustum = FrustumWork {
            nodes: cut.nodes_asked(),
            blocks: cut.leaves_asked(),
            plane_tests: cut.plane_tests(),
            remembered: coherent.answered(),
            swept: cut.swept(),
        };
        let mut exempt = scene.exempt_words().peekable();
        for word in cut.touched() {
            while let Some(before) = exempt.next_if(|&e| e < word) {
                self.take(before, 0, 0, all_in);
            }
            exempt.next_if_eq(&word);
            self.take(word, cut.visible()[word], cut.inside()[word], all_in);
        }
        exempt.for_each(|word| self.take(word, 0, 0, all_in));
        if self.culler.frustum_exact {
            self.drop_beyond_planes();
        }
        if self.culler.reasons {
            for word in 0..hierarchy.present().len() {
                let dropped = hierarchy.present()[word] & !self.scratch.alive[word];
                for slot in slots(word, dropped) {
                    // What is in no layer was dropped before.
                    if all_in || scene.layers(slot) & self.view.layers != 0 {
                        let detail = planes.first_rejecting(scene.boxes(), slot as usize);
                        self.drop_slot(slot, Reason { stage: Stage::Frustum, detail });
                    }
                }
            }
        }
        self.scratch.coherent = coherent;
    }

    /// Drops boxes that straddle planes but lie beyond the frustum's corners.
    fn drop_beyond_planes(&mut self) {
        let exact = ExactFrustum::new(&self.frustum);
        for at in 0..self.scratch.live.len() {
            let word = self.scratch.live[at] as usize;
            let s = &mut *self.scratch;
            let asked = s.alive[word] & !s.inside[word];
            for slot in slots(word, asked) {
                if exact.is_outside_beyond_planes(&self.scene.bounds(slot)) {
                    s.alive[word] &= !(1 << (slot % 64));
                }
            }
        }
    }

    /// Takes one slot, by the arithmetic of the batch test, so with the same answer.
    fn take_alone(&mut self, slot: u32) {
        let scene = self.scene;
        let bit = 1 << (slot % 64);
        let word = slot as usize / 64;
        let exempt = scene.exempt()[word] & bit != 0;
        let planes = Planes::new(&self.frustum);
        let bounds = scene.bounds(slot);
        let mut side =
            if self.culler.frustum { planes.classify_box(&bounds) } else { Side::Inside };
        if self.culler.frustum_exact
            && side == Side::Straddling
            && ExactFrustum::new(&self.frustum).is_outside_beyond_planes(&bounds)
        {
            side = Side::Outside;
        }
        if side == Side::Outside && !exempt {
            let detail = planes.first_rejecting(scene.boxes(), slot as usize);
            self.drop_slot(slot, Reason { stage: Stage::Frustum, detail });
            return;
        }
        let s = &mut *self.scratch;
        s.alive[word] = bit;
        s.inside[word] = if exempt || side == Side::Inside { bit } else { 0 };
        s.live.push(word as u32);
    }

    /// Instances that are not too small on the screen.
    pub(super) fn detail(&mut self) {
        let Some(detail) = self.culler.detail else { return };
        let (scene, view) = (self.scene, self.view);
        let dropped = self.filter_words(Stage::Detail, |word, asked| {
            let small = slots(word, asked).filter(|&slot| {
                let rectangle = view.project_box(&scene.bounds(slot), scene.origin());
                detail.is_small(rectangle.as_ref())
            });
            small.fold(0, |small, slot| small | 1 << (slot % 64))
        });
        self.instance_row(Stage::Detail, dropped);
    }

    /// Instances that their transform does not flatten to a line or a point.
    pub(super) fn collapsed(&mut self) {
        let scene = self.scene;
        let dropped =
            self.filter_words(Stage::Degenerate, |word, asked| asked & scene.collapsed()[word]);
        self.instance_row(Stage::Degenerate, dropped);
    }

    /// Drops the instances that `drops` names among those of a word, exempt ones apart; returns what they hold.
    fn filter_words(&mut self, stage: Stage, drops: impl Fn(usize, u64) -> u64) -> Tally {
        let mut sum = Tally::default();
        for at in 0..self.scratch.live.len() {
            let word = self.scratch.live[at] as usize;
            let asked = self.scratch.alive[word] & !self.scene.exempt()[word];
            let dropped = drops(word, asked);
            self.scratch.alive[word] &= !dropped;
            sum += self.scene.tally_of_bits(word, dropped);
            if self.culler.reasons {
                slots(word, dropped).for_each(|s| self.drop_slot(s, Reason { stage, detail: 0 }));
            }
        }
        sum
    }

    /// Answers with whole instances: nothing more is asked.
    pub(super) fn emit_instances(&mut self) {
        let mut sum = Tally::default();
        for &word in &self.scratch.live {
            let alive = self.scratch.alive[word as usize];
            for run in bits::runs(alive) {
                let first = word * 64 + run.start as u32;
                push_whole(&mut self.result.whole, first, run.len() as u32);
            }
            sum += self.scene.tally_of_bits(word as usize, alive);
        }
        self.tally = sum;
        self.settle_rows(sum);
    }

    /// Turns instances into runs of clusters: all of those inside and of those with [few](is_parted), and of
    /// the others what is not outside the frustum. Where clusters are wanted and no later stage can drop one of
    /// an instance, its bit is [settled](super::run::Scratch::settled) and it gets no run: most of what is seen
    /// of very many things.
    pub(super) fn clusters(&mut self) {
        let scene = self.scene;
        let by_cluster = self.culler.frustum && self.culler.output >= Output::Clusters;
        let settles = self.culler.output == Output::Clusters;
        let backs =
            self.culls_backs_by_cluster().then(|| Backs::new(self.culler, scene, self.view));
        self.scratch.settled.resize(self.scratch.alive.len(), 0);
        self.scratch.of_meshes.clear();
        self.scratch.of_meshes.resize(scene.meshes().len(), OfMesh::default());
        // Of the instances that are taken whole, and of those of which some clusters may be outside.
        let (mut whole, mut straddling) = (Tally::default(), Tally::default());
        for at in 0..self.scratch.live.len() {
            let word = self.scratch.live[at] as usize;
            self.scratch.settled[word] = 0;
            // Those of which only their mesh can say that they are not drawn whole.
            let inside = if by_cluster { self.scratch.inside[word] } else { u64::MAX };
            let may_settle = if settles { inside & self.unhidden(word) } else { 0 };
            for slot in slots(word, self.scratch.alive[word]) {
                let of = self.scratch.of_meshes[scene.mesh_id(slot) as usize];
                let may_settle = may_settle >> (slot % 64) & 1 == 1 || of.is_whole;
                if settles && of.has_no_backs && may_settle {
                    self.settle(slot);
                    whole += of.tally;
                    continue;
                }
                let mesh = scene.mesh(slot);
                let tally = scene.tally_of(slot);
                let cluster_count = mesh.levels()[0].cluster_count;
                let inside =
                    inside >> (slot % 64) & 1 == 1 || !scene.is_rigid(slot) || cluster_count == 0;
                let run = Run { slot, first_cluster: 0, cluster_count, inside };
                if !inside && is_parted(mesh) {
                    straddling += tally;
                    self.tally += tally;
                    self.clusters_of(run, mesh);
                    continue;
                }
                whole += tally;
                if !settles
                    || self.may_hide_clusters(slot)
                    || backs.as_ref().is_some_and(|b| b.may_cull_clusters(slot))
                {
                    self.scratch.runs.push(run);
                    continue;
                }
                self.settle(slot);
                // What holds for the mesh, and not for this instance alone.
                let has_no_backs = backs.as_ref().is_none_or(|b| b.none_of_mesh(slot));
                self.scratch.of_meshes[scene.mesh_id(slot) as usize] =
                    OfMesh { has_no_backs, is_whole: !is_parted(mesh), tally };
            }
        }
        self.tally += whole;
        whole += straddling;
        self.settle_rows(whole);
        if by_cluster {
            self.row(Stage::Frustum, Unit::Clusters, whole.counts);
        }
    }

    /// Notes that an instance is drawn whole.
    fn settle(&mut self, slot: u32) {
        self.scratch.settled[slot as usize / 64] |= 1 << (slot % 64);
    }

    /// Whether back faces are culled by whole clusters.
    pub(super) fn culls_backs_by_cluster(&self) -> bool {
        self.culler.backface == Backface::Fast
            && self.view.cull_face != CullFace::None
            && self.culler.output >= Output::Clusters
    }

    /// Lists the clusters of an instance that the frustum does not reject.
    fn clusters_of(&mut self, all: Run, mesh: &Mesh) {
        let slot = all.slot;
        let planes = Planes::new(&self.world_frustum.to_object_space(self.scene.transform(slot)));
        let mut runs = std::mem::take(&mut self.scratch.runs);
        let first = runs.len();
        let cut = &mut self.scratch.cluster_cut;
        cut.cull(self.culler.level, &planes, mesh.cluster_nodes(), mesh.cluster_boxes());
        for word in cut.touched() {
            for bit in bits::ones(cut.visible()[word]) {
                let cluster = (word * 64 + bit) as u32;
                let inside = cut.inside()[word] >> bit & 1 == 1;
                match runs[first..].last_mut() {
                    Some(run)
                        if run.inside == inside
                            && run.first_cluster + run.cluster_count == cluster =>
                    {
                        run.cluster_count += 1;
                    }
                    _ => {
                        runs.push(Run { slot, first_cluster: cluster, cluster_count: 1, inside });
                    }
                }
            }
        }
        if (cut.count() as u32) < all.cluster_count {
            self.drop_clusters(Stage::Frustum, slot, &[all], &runs[first..]);
        }
        if runs.len() == first {
            self.drop_slot(slot, Reason { stage: Stage::Frustum, detail: Reason::MIXED });
        }
        self.scratch.runs = runs;
    }
}

/// The slots of the bits that are set in a word.
fn slots(word: usize, value: u64) -> impl Iterator<Item = u32> {
    bits::ones(value).map(move |bit| (word * 64 + bit) as u32)
}
