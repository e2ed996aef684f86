//! Back faces: whole clusters by their cones, then triangles by their planes.

use alloc::vec::Vec;

use super::super::Backface;
use super::super::frame::Frame;
use super::super::log::Log;
use super::super::run::{Run, triangles_of};
use super::super::sets::{Clusters, Sets};
use crate::bits;
use crate::cull::backface::{BackfaceEye, Backfaces, ClusterCones, ObjectEye, ViewEye};
use crate::cull::output::keep_listed;
use crate::funnel::Stage;
use crate::mesh::{Cluster, Mesh};
use crate::scene::{MeshId, MeshKind};

/// Memory of the stage.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct Cache {
    culled: Vec<u64>,
    doubt: Vec<u64>,
}

/// The tests of the back faces of a view's instances.
pub(super) struct Backs<'a> {
    frame: &'a Frame<'a>,
    eye: ViewEye,
    /// The other eye of a stereo view, whose clusters both must see from behind.
    other: Option<ViewEye>,
}

/// The eye of one instance.
enum Eye<'a> {
    /// None that proves anything: all is kept.
    Undecided,
    /// Only the test from the corners is fine enough, or the settings choose it.
    Exact(ObjectEye),
    /// Cones of clusters, planes of triangles, and corners where those are in doubt.
    Planes(ObjectEye, &'a Backfaces, BackfaceEye),
}

impl<'a> Backs<'a> {
    pub(super) fn new(frame: &'a Frame<'a>) -> Self {
        if frame.is_stereo() {
            let [eye, other] = ViewEye::of_stereo(frame.view);
            return Self { frame, eye, other: Some(other) };
        }
        Self { frame, eye: ViewEye::new(frame.view), other: None }
    }

    /// Whether an instance, drawn by a mesh, has sides that are not drawn, and stays in the shape
    /// of that mesh.
    fn has_back(&self, slot: u32, mesh: MeshId) -> bool {
        let scene = self.frame.scene;
        let exempt = scene.exempt()[slot as usize / 64] >> (slot % 64) & 1 == 1;
        let two_sided =
            scene.meshes()[mesh as usize].is_two_sided() || scene.flags(slot).double_sided;
        !exempt && !two_sided && scene.is_rigid(slot)
    }

    /// The cones of a mesh; a box has none, since no cluster of it faces one way.
    fn cones(&self, mesh: MeshId) -> Option<&'a ClusterCones> {
        self.frame.scene.prepared()[mesh as usize].cluster_cones(self.eye.culled_side())
    }

    /// Whether there may be an eye that some cluster of an instance faces away from.
    pub(super) fn may_cull_clusters(&self, slot: u32) -> bool {
        let mesh = self.frame.scene.mesh_id(slot);
        self.has_back(slot, mesh) && self.cones(mesh).is_some()
    }

    /// Whether [`may_cull_clusters`](Self::may_cull_clusters) says no of every instance of a mesh.
    pub(super) fn none_of(&self, kind: MeshKind) -> bool {
        !kind.may_be_culled(self.eye.culled_side())
    }

    /// An eye of the view for triangles.
    fn eye_of(&self, eye: &ViewEye, slot: u32, mesh: MeshId) -> Eye<'a> {
        let eye = eye.in_space_of(self.frame.scene.transform(slot));
        if !eye.culls_any() {
            return Eye::Undecided;
        }
        let prepared = self.frame.scene.prepared()[mesh as usize].backfaces();
        let is_exact = self.frame.culler.backface == Backface::Exact;
        let Some(planes) = prepared.filter(|_| !is_exact) else { return Eye::Exact(eye) };
        planes.eye(&eye).map_or(Eye::Exact(eye), |of| Eye::Planes(eye, planes, of))
    }

    /// Sets the bits of those clusters of an instance that face away; whether there may be any.
    /// `spare` is memory for a second eye.
    pub(super) fn cull_clusters(
        &self,
        slot: u32,
        mesh: MeshId,
        culled: &mut Vec<u64>,
        spare: &mut Vec<u64>,
    ) -> bool {
        if !self.has_back(slot, mesh) {
            return false;
        }
        let Some(cones) = self.cones(mesh) else { return false };
        let simd = self.frame.culler.simd;
        let Eye::Planes(_, _, eye) = self.eye_of(&self.eye, slot, mesh) else { return false };
        cones.cull(simd, &eye, culled);
        let Some(other) = &self.other else { return true };
        let Eye::Planes(_, _, eye) = self.eye_of(other, slot, mesh) else { return false };
        cones.cull(simd, &eye, spare);
        culled.iter_mut().zip(spare).for_each(|(culled, other)| *culled &= *other);
        true
    }
}

/// Drops the clusters of which every triangle faces away.
pub(in super::super) fn clusters(
    frame: &Frame<'_>,
    cache: &mut Cache,
    set: &mut Clusters,
    log: &mut Log<'_>,
) {
    if !frame.culls_backs_by_cluster() {
        return;
    }
    let backs = Backs::new(frame);
    set.filter(frame.scene, Stage::Backface, log, |runs, culled| {
        backs.cull_clusters(runs[0].slot, runs[0].mesh, culled, &mut cache.culled)
    });
}

/// Drops back faces (or front faces) of one-sided parts.
pub(in super::super) fn triangles(
    frame: &Frame<'_>,
    cache: &mut Cache,
    sets: &mut Sets,
    log: &mut Log<'_>,
) {
    if !frame.culls_backs_by_triangle() {
        return;
    }
    let backs = Backs::new(frame);
    let Cache { culled: words, doubt } = cache;
    let Sets { clusters, triangles, .. } = sets;
    let mut rest = &clusters.runs[..];
    triangles.filter(&clusters.runs, Stage::Backface, log, |range, triangles, kept| {
        let slot = range.slot;
        let id = frame.scene.mesh_id_at(slot, range.level);
        if !backs.has_back(slot, id) {
            return false;
        }
        let (simd, mesh) = (frame.culler.simd, &frame.scene.meshes()[id as usize]);
        let (exact, planes, eye) = match backs.eye_of(&backs.eye, slot, id) {
            Eye::Undecided => return false,
            Eye::Exact(eye) => {
                keep_exact(mesh, &eye, triangles, kept);
                return true;
            }
            Eye::Planes(exact, planes, eye) => (exact, planes, eye),
        };
        // Runs and ranges ascend by slot, most often in step.
        let of = |from: &[Run], wanted: fn(u32, u32) -> bool| {
            from.iter().take_while(|run| wanted(run.slot, slot)).count()
        };
        rest = &rest[of(rest, |run, slot| run < slot)..];
        let own;
        (own, rest) = rest.split_at(of(rest, |run, slot| run == slot));
        let base = triangles.first().map_or(0, |&t| t / 64);
        words.clear();
        doubt.clear();
        // Words of the mask that a run touches: the first triangles of it may have gone for the
        // frustum.
        let words_of = |run: Run| {
            let range = triangles_of(mesh, run);
            ((range.start / 64).max(base), range.end.div_ceil(64))
        };
        for run in own {
            let (first, end) = words_of(*run);
            if end <= first {
                continue;
            }
            let here = (first - base) as usize..(end - base) as usize;
            words.resize(words.len().max(here.end), 0);
            doubt.resize(words.len(), 0);
            let (words, doubt) = (&mut words[here.clone()], &mut doubt[here]);
            planes.test_words(simd, &eye, first as usize, words, doubt);
        }
        // In a second turn: neighbouring runs share a word, and the first turn writes it anew.
        for run in own {
            let (first, end) = words_of(*run);
            if end > first {
                let here = (first - base) as usize..(end - base) as usize;
                cull_in_doubt(mesh, &exact, *run, first, &doubt[here.clone()], &mut words[here]);
            }
        }
        keep_listed(simd, triangles, base, words, kept);
        true
    });
}

/// Adds those triangles in doubt that the test from the corners culls: few, but for flat meshes
/// near their horizon, as roofs and floors of a city seen along its streets. Words begin at word
/// `first`.
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
            t = bits::next(doubt, t - first * 64, range.end - first * 64, true) + first * 64;
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

/// The clusters from the one of the first triangle of an ascending list on.
fn clusters_of_list<'m>(mesh: &'m Mesh, triangles: &[u32]) -> &'m [Cluster] {
    let first = triangles.first().copied().unwrap_or(0);
    let clusters = mesh.clusters();
    let at = clusters.partition_point(|c| c.first_triangle + c.triangle_count <= first);
    &clusters[at..]
}
