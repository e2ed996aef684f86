//! Candidates of the caller: what is none of them goes, and of those that are seen in part, the
//! clusters beside that.

use alloc::vec::Vec;

use super::super::frame::Frame;
use super::super::log::Log;
use super::super::run::is_parted;
use super::super::sets::{Clusters, Instances, slots};
use crate::cull::frustum::batch::Planes;
use crate::cull::frustum::tree::Cut;
use crate::funnel::{Reason, Stage};
use crate::mesh::Mesh;
use crate::scene::Tally;

/// Memory of the tests of clusters.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct Cache {
    cut: Cut,
    kept: Vec<u64>,
}

/// Drops the instances that are no candidates by `stage`.
pub(in super::super) fn instances(
    frame: &Frame<'_>,
    stage: Stage,
    set: &mut Instances,
    log: &mut Log<'_>,
) {
    let Some(candidates) = frame.candidates_of(stage) else { return };
    candidates.look(stage, &frame.look(), &set.alive, &set.live);
    let (scene, mut dropped) = (frame.scene, Tally::default());
    for &word in &set.live {
        let word = word as usize;
        let others = set.alive[word] & !(candidates.word(stage, word) | scene.exempt()[word]);
        set.alive[word] &= !others;
        dropped += scene.tally_of_bits(word, others);
        if log.wants_reasons() {
            for slot in slots(word, others) {
                log.drop_slot(slot, Reason { stage, detail: candidates.detail(stage, slot) });
            }
        }
    }
    log.instance_row(stage, dropped);
}

/// Returns one bit for each slot of `word`: its instance may be visible in part only.
pub(in super::super) fn straddling(frame: &Frame<'_>, word: usize) -> u64 {
    frame
        .candidates_of(Stage::Portal)
        .map_or(0, |candidates| candidates.straddling(word) & !frame.scene.exempt()[word])
}

/// Whether some cluster of the instance of `slot` may be beside what may be visible of it.
pub(in super::super) fn may_cut(frame: &Frame<'_>, slot: u32) -> bool {
    may_cut_mesh(frame, slot, frame.scene.mesh(slot))
}

/// Whether some cluster may be, of an instance that is drawn by `mesh`: its own, or that of its
/// levels.
fn may_cut_mesh(frame: &Frame<'_>, slot: u32, mesh: &Mesh) -> bool {
    straddling(frame, slot as usize / 64) >> (slot % 64) & 1 == 1
        && mesh.clusters().len() > 1
        && is_parted(mesh)
        && frame.scene.is_rigid(slot)
}

/// Drops the clusters that are beside what may be visible of their instance.
pub(in super::super) fn clusters(
    frame: &Frame<'_>,
    cache: &mut Cache,
    set: &mut Clusters,
    log: &mut Log<'_>,
) {
    let Some(candidates) = frame.candidates_of(Stage::Portal) else { return };
    let scene = frame.scene;
    set.filter(scene, Stage::Portal, log, |runs, culled| {
        let (slot, mesh) = (runs[0].slot, &scene.meshes()[runs[0].mesh as usize]);
        if !may_cut_mesh(frame, slot, mesh) {
            return false;
        }
        let Cache { cut, kept } = cache;
        kept.clear();
        kept.resize(mesh.clusters().len().div_ceil(64), 0);
        candidates.frusta(scene, slot, &mut |frustum| {
            let planes = Planes::in_object_space(frustum, scene.transform(slot), u32::MAX);
            cut.cull(frame.culler.simd, &planes, mesh.cluster_nodes(), mesh.cluster_boxes());
            for word in cut.touched() {
                kept[word] |= cut.visible()[word];
            }
        });
        culled.clear();
        culled.extend(kept.iter().map(|word| !word));
        true
    });
}
