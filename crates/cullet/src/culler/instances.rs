//! The stages of instances and of clusters.

use super::backfaces::Backs;
use super::run::{OfMesh, Pass, Run, is_parted, push_whole, triangles_of};
use super::{Backface, Output};
use crate::bits;
use crate::bounds::Side;
use crate::cull::frustum::batch::Planes;
use crate::cull::frustum::exact::ExactFrustum;
use crate::mesh::Mesh;
use crate::view::CullFace;
use crate::visible::{FrustumWork, Reason, Stage, Unit};

impl Pass<'_> {
    /// The stages of instances that are answered by slot masks: layers, then the frustum.
    ///
    /// What a view sees is mostly a small part of a scene, so only the words of the masks that hold
    /// something are ever looked at, unless reasons are wanted: those are for what is not seen.
    pub(super) fn layers_and_frustum(&mut self) {
        let scene = self.scene;
        self.forget_alive();
        let (entered, left) = match self.only {
            Some(slot) => (1, u64::from(scene.layers(slot) & self.view.layers != 0)),
            None => (
                u64::from(scene.instance_count()),
                u64::from(scene.count_in_layers(self.view.layers)),
            ),
        };
        let all_in = entered == left;
        self.row(Stage::Layer, Unit::Instances, entered, left);
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
            let alive = self.alive_count();
            self.row(Stage::Frustum, Unit::Instances, left, alive);
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
        let entered = self.alive_count();
        let (scene, view) = (self.scene, self.view);
        self.filter_words(Stage::Detail, |word, asked| {
            let small = slots(word, asked).filter(|&slot| {
                let rectangle = view.project_box(&scene.bounds(slot), scene.origin());
                detail.is_small(rectangle.as_ref())
            });
            small.fold(0, |small, slot| small | 1 << (slot % 64))
        });
        let left = self.alive_count();
        self.row(Stage::Detail, Unit::Instances, entered, left);
    }

    /// Instances that their transform does not flatten to a line or a point.
    pub(super) fn collapsed(&mut self) {
        let entered = self.alive_count();
        let scene = self.scene;
        self.filter_words(Stage::Degenerate, |word, asked| asked & scene.collapsed()[word]);
        let left = self.alive_count();
        self.row(Stage::Degenerate, Unit::Instances, entered, left);
    }

    /// Drops the instances that `drops` names among those of a word, exempt ones apart.
    fn filter_words(&mut self, stage: Stage, drops: impl Fn(usize, u64) -> u64) {
        for at in 0..self.scratch.live.len() {
            let word = self.scratch.live[at] as usize;
            let asked = self.scratch.alive[word] & !self.scene.exempt()[word];
            let dropped = drops(word, asked);
            self.scratch.alive[word] &= !dropped;
            if self.culler.reasons {
                slots(word, dropped).for_each(|s| self.drop_slot(s, Reason { stage, detail: 0 }));
            }
        }
    }

    /// Answers with whole instances: nothing more is asked.
    pub(super) fn emit_instances(&mut self) {
        let (scene, r) = (self.scene, &mut *self.result);
        for &word in &self.scratch.live {
            let alive = self.scratch.alive[word as usize];
            for run in bits::runs(alive) {
                push_whole(&mut r.whole, word * 64 + run.start as u32, run.len() as u32);
            }
            r.instance_count += u64::from(alive.count_ones());
            let drawn = |slot| {
                let mesh = scene.mesh(slot);
                u64::from(mesh.triangle_count() - mesh.degenerate_count())
            };
            r.triangle_count += slots(word as usize, alive).map(drawn).sum::<u64>();
        }
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
        let (mut entered, mut left) = (0, 0);
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
                    self.settle(slot, of);
                    entered += u64::from(of.clusters);
                    left += u64::from(of.clusters);
                    continue;
                }
                let mesh = scene.mesh(slot);
                let cluster_count = mesh.levels()[0].cluster_count;
                entered += u64::from(cluster_count);
                let inside =
                    inside >> (slot % 64) & 1 == 1 || !scene.is_rigid(slot) || cluster_count == 0;
                if inside || !is_parted(mesh) {
                    let run = Run { slot, first_cluster: 0, cluster_count, inside };
                    left += u64::from(cluster_count);
                    if !settles || self.may_hide_clusters(slot) {
                        self.scratch.runs.push(run);
                        continue;
                    }
                    let triangles = triangles_of(mesh, run).len() as u32;
                    let mut of = OfMesh {
                        clusters: cluster_count,
                        triangles,
                        is_whole: !is_parted(mesh),
                        has_no_backs: true,
                    };
                    if backs.as_ref().is_some_and(|b| b.may_cull_clusters(slot)) {
                        self.scratch.runs.push(run);
                        continue;
                    }
                    self.settle(slot, of);
                    // What holds for the mesh, and not for this instance alone.
                    of.has_no_backs = backs.as_ref().is_none_or(|b| b.none_of_mesh(slot));
                    self.scratch.of_meshes[scene.mesh_id(slot) as usize] = of;
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

    /// Notes that an instance is drawn whole.
    fn settle(&mut self, slot: u32, of: OfMesh) {
        self.scratch.settled[slot as usize / 64] |= 1 << (slot % 64);
        self.settled_clusters += u64::from(of.clusters);
        self.result.instance_count += 1;
        self.result.triangle_count += u64::from(of.triangles);
    }

    /// Whether back faces are culled by whole clusters.
    pub(super) fn culls_backs_by_cluster(&self) -> bool {
        self.culler.backface == Backface::Fast
            && self.view.cull_face != CullFace::None
            && self.culler.output >= Output::Clusters
    }

    fn clusters_of(&mut self, slot: u32, mesh: &Mesh) -> u32 {
        let planes = Planes::new(&self.world_frustum.to_object_space(self.scene.transform(slot)));
        let s = &mut *self.scratch;
        let cut = &mut s.cluster_cut;
        cut.cull(self.culler.level, &planes, mesh.cluster_nodes(), mesh.cluster_boxes());
        for word in cut.touched() {
            for bit in bits::ones(cut.visible()[word]) {
                let cluster = (word * 64 + bit) as u32;
                let inside = cut.inside()[word] >> bit & 1 == 1;
                match s.runs.last_mut() {
                    Some(run)
                        if run.slot == slot
                            && run.inside == inside
                            && run.first_cluster + run.cluster_count == cluster =>
                    {
                        run.cluster_count += 1;
                    }
                    _ => {
                        let (first_cluster, cluster_count) = (cluster, 1);
                        s.runs.push(Run { slot, first_cluster, cluster_count, inside });
                    }
                }
            }
        }
        cut.count() as u32
    }
}

/// The slots of the bits that are set in a word.
fn slots(word: usize, value: u64) -> impl Iterator<Item = u32> {
    bits::ones(value).map(move |bit| (word * 64 + bit) as u32)
}
