//! The back-face stages: whole clusters by their cones, then triangles by their planes.

use super::run::{Pass, Run, triangles_of};
use super::triangles::clusters_of_list;
use super::{Backface, Culler};
use crate::cull::backface::{BackfaceEye, Backfaces, ClusterCones, ObjectEye, ViewEye};
use crate::cull::output::keep_listed;
use crate::funnel::{Reason, Stage, Unit};
use crate::mesh::Mesh;
use crate::scene::Scene;
use crate::view::View;

/// What the back faces of a view's instances are asked with.
pub(super) struct Backs<'a> {
    culler: &'a Culler,
    scene: &'a Scene,
    eye: ViewEye,
}

/// The eye of one instance.
enum Eye<'a> {
    /// None that proves anything: all is kept.
    Undecided,
    /// Only the test from the corners is fine enough, or it is asked for.
    Exact(ObjectEye),
    /// Cones and planes.
    Fast(ObjectEye, &'a Backfaces, BackfaceEye),
}

impl<'a> Backs<'a> {
    pub(super) fn new(culler: &'a Culler, scene: &'a Scene, view: &View) -> Self {
        Self { culler, scene, eye: ViewEye::new(view) }
    }

    /// Whether an instance has sides that are not drawn, and stays in the shape of its mesh.
    fn has_back(&self, slot: u32) -> bool {
        let scene = self.scene;
        let exempt = scene.exempt()[slot as usize / 64] >> (slot % 64) & 1 == 1;
        let two_sided = scene.mesh(slot).is_two_sided() || scene.flags(slot).double_sided;
        !exempt && !two_sided && scene.is_rigid(slot)
    }

    /// The cones of the mesh of an instance; a box has none, since no cluster of it faces one way.
    fn cones(&self, slot: u32) -> Option<&'a ClusterCones> {
        self.scene.prepared_of(slot).cluster_cones(self.eye.culled_side())
    }

    /// Whether there may be an eye that some cluster of an instance faces away from.
    pub(super) fn may_cull_clusters(&self, slot: u32) -> bool {
        self.has_back(slot) && self.cones(slot).is_some()
    }

    /// Whether it is the mesh for which [`may_cull_clusters`](Self::may_cull_clusters) says no.
    pub(super) fn none_of_mesh(&self, slot: u32) -> bool {
        let mesh = self.scene.mesh(slot);
        mesh.is_two_sided() || mesh.is_deformable() || self.cones(slot).is_none()
    }

    fn eye_of(&self, slot: u32) -> Eye<'a> {
        let eye = self.eye.in_space_of(self.scene.transform(slot));
        if !eye.culls_any() {
            return Eye::Undecided;
        }
        let planes = self.scene.prepared_of(slot).backfaces();
        let fast = planes
            .filter(|_| self.culler.backface == Backface::Fast)
            .and_then(|planes| Some(Eye::Fast(eye, planes, planes.eye(&eye)?)));
        fast.unwrap_or(Eye::Exact(eye))
    }

    /// Sets the bits of those clusters of an instance that face away; whether there may be any.
    fn cull_clusters(&self, slot: u32, culled: &mut Vec<u64>) -> bool {
        if !self.has_back(slot) {
            return false;
        }
        let Some(cones) = self.cones(slot) else { return false };
        let Eye::Fast(_, _, eye) = self.eye_of(slot) else { return false };
        cones.cull(self.culler.level, &eye, culled);
        true
    }
}

impl Pass<'_> {
    /// Drops the clusters of which every triangle faces away.
    pub(super) fn backfaces_of_clusters(&mut self) {
        let backs = Backs::new(self.culler, self.scene, self.view);
        self.filter_clusters(Stage::Backface, |runs, culled| {
            backs.cull_clusters(runs[0].slot, culled)
        });
    }

    /// Runs a stage of clusters over the runs of every instance. `cull` sets the bits of clusters to drop, or returns
    /// `false` to keep all. Degenerate triangles are in no cluster, and go with the last one of their instance.
    pub(super) fn filter_clusters(
        &mut self,
        stage: Stage,
        mut cull: impl FnMut(&[Run], &mut Vec<u64>) -> bool,
    ) {
        let entered = self.tally.counts;
        let runs = std::mem::take(&mut self.scratch.runs);
        let mut kept = std::mem::take(&mut self.scratch.kept_runs);
        let mut culled = std::mem::take(&mut self.scratch.cluster_culled);
        kept.clear();
        for runs in runs.chunk_by(|a, b| a.slot == b.slot) {
            if !cull(runs, &mut culled) {
                kept.extend_from_slice(runs);
                continue;
            }
            let (slot, first) = (runs[0].slot, kept.len());
            split(runs, &culled, &mut kept);
            self.drop_clusters(stage, slot, runs, &kept[first..]);
            if kept.len() == first {
                self.drop_slot(slot, Reason { stage, detail: 0 });
            }
        }
        self.scratch.runs = kept;
        self.scratch.kept_runs = runs;
        self.scratch.cluster_culled = culled;
        self.row(stage, Unit::Clusters, entered);
    }

    /// Drops back faces (or front faces) of one-sided parts.
    pub(super) fn backfaces_of_triangles(&mut self) {
        let backs = Backs::new(self.culler, self.scene, self.view);
        // A copy: the end of the stage counts the clusters of the instances that are gone by the runs.
        let mut runs = std::mem::take(&mut self.scratch.kept_runs);
        runs.clear();
        runs.extend_from_slice(&self.scratch.runs);
        let mut words = std::mem::take(&mut self.scratch.culled);
        let mut doubt = std::mem::take(&mut self.scratch.cluster_culled);
        let mut rest = &runs[..];
        self.filter_triangles(Stage::Backface, |slot, triangles, kept| {
            if !backs.has_back(slot) {
                return false;
            }
            let (level, mesh) = (backs.culler.level, backs.scene.mesh(slot));
            match backs.eye_of(slot) {
                Eye::Undecided => return false,
                Eye::Exact(eye) => keep_exact(mesh, &eye, triangles, kept),
                Eye::Fast(exact, planes, eye) => {
                    // Runs and ranges ascend by slot, most often in step.
                    let of = |from: &[Run], wanted: fn(u32, u32) -> bool| {
                        from.iter().take_while(|run| wanted(run.slot, slot)).count()
                    };
                    rest = &rest[of(rest, |run, slot| run < slot)..];
                    let own;
                    (own, rest) = rest.split_at(of(rest, |run, slot| run == slot));
                    let base = triangles.first().map_or(0, |&t| t / 64);
                    words.clear();
                    // In two turns: neighbouring runs share a word, and the first turn writes it anew.
                    for find_doubt in [false, true] {
                        for run in own {
                            let range = triangles_of(mesh, *run);
                            // The first triangles of a run may have gone for the frustum.
                            let (first, end) =
                                ((range.start / 64).max(base), range.end.div_ceil(64));
                            if end <= first {
                                continue;
                            }
                            words.resize(words.len().max((end - base) as usize), 0);
                            let words = &mut words[(first - base) as usize..(end - base) as usize];
                            if !find_doubt {
                                planes.cull_words(level, &eye, first as usize, words);
                                continue;
                            }
                            doubt.resize(words.len(), 0);
                            planes.keep_words(level, &eye, first as usize, &mut doubt);
                            doubt.iter_mut().zip(&*words).for_each(|(d, w)| *d = !(*d | w));
                            cull_in_doubt(mesh, &exact, *run, first, &doubt, words);
                        }
                    }
                    keep_listed(level, triangles, base, &words, kept);
                }
            }
            true
        });
        self.scratch.kept_runs = runs;
        self.scratch.culled = words;
        self.scratch.cluster_culled = doubt;
    }
}

/// Appends what is left of runs without the culled clusters.
fn split(runs: &[Run], culled: &[u64], kept: &mut Vec<Run>) {
    for run in runs {
        let (mut at, end) = (run.first_cluster, run.first_cluster + run.cluster_count);
        while at < end {
            let first = next_bit(culled, at, end, false);
            at = next_bit(culled, first, end, true);
            if first < at {
                kept.push(Run { first_cluster: first, cluster_count: at - first, ..*run });
            }
        }
    }
}

/// The first of `from..end` whose bit is `set`, or `end`.
fn next_bit(words: &[u64], from: u32, end: u32, set: bool) -> u32 {
    let mut at = from;
    while at < end {
        let word = words.get(at as usize / 64).copied().unwrap_or(0);
        let word = (if set { word } else { !word }) >> (at % 64);
        if word != 0 {
            return (at + word.trailing_zeros()).min(end);
        }
        at = (at / 64 + 1) * 64;
    }
    end
}

/// Adds those triangles in doubt that the test from the corners culls: few, but for flat things near their
/// horizon, as roofs and floors of a city seen along its streets. Words begin at word `first`.
fn cull_in_doubt(
    mesh: &Mesh,
    eye: &ObjectEye,
    run: Run,
    first: u32,
    doubt: &[u64],
    culled: &mut [u64],
) {
    let clusters = &mesh.clusters()[run.first_cluster as usize..][..run.cluster_count as usize];
    for cluster in clusters.iter().filter(|c| !mesh.parts()[c.part as usize].two_sided) {
        let range = cluster.triangles();
        let mut t = range.start.max(first * 64);
        while t < range.end {
            t = next_bit(doubt, t - first * 64, range.end - first * 64, true) + first * 64;
            if t < range.end && eye.culls(&mesh.corners(t)) {
                let at = t - first * 64;
                culled[at as usize / 64] |= 1 << (at % 64);
            }
            t += 1;
        }
    }
}

/// The test of every triangle from its corners.
fn keep_exact(mesh: &Mesh, eye: &ObjectEye, triangles: &[u32], kept: &mut Vec<u32>) {
    let mut rest = triangles;
    for cluster in clusters_of_list(mesh, triangles) {
        let end = cluster.triangles().end;
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
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_split_at_the_clusters_that_go() {
        let run = |first_cluster, cluster_count| Run {
            slot: 3,
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
