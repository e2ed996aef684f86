//! Degenerate: what has no area, and so covers no pixel.

use super::super::evidence::Evidence;
use super::super::frame::Frame;
use super::super::log::Log;
use super::super::sets::{Instances, Sets, groups, slots};
use crate::cull::degenerate::Flattening;
use crate::funnel::{Stage, Unit};
use crate::scene::Tally;

/// Drops the instances that their transform flattens to a line or a point, or of whose mesh no
/// triangle has an area.
pub(in super::super) fn instances(frame: &Frame<'_>, set: &mut Instances, log: &mut Log<'_>) {
    let scene = frame.scene;
    let collapsed = |word, tested| tested & scene.collapsed()[word];
    // Most scenes have none, of which the words tell by groups.
    let any = groups(&set.live).any(|live| {
        let words = live[0] as usize..live[live.len() - 1] as usize + 1;
        scene.collapsed()[words].iter().any(|&word| word != 0)
    });
    let dropped = match any {
        true => set.filter(scene, Stage::Degenerate, log, collapsed),
        false => Tally::default(),
    };
    log.instance_row(Stage::Degenerate, dropped);
}

/// Drops triangles without area: those found when the mesh was made, and those that a flattening
/// transform makes.
pub(in super::super) fn triangles(frame: &Frame<'_>, sets: &mut Sets, log: &mut Log<'_>) {
    let scene = frame.scene;
    sets.triangles.filter(&sets.clusters.runs, Stage::Degenerate, log, |range, triangles, kept| {
        let (slot, mesh) = (range.slot, scene.mesh_at(range.slot, range.level));
        let drawn = mesh.degenerate_triangles().start;
        let flattening = Flattening::of(scene.transform(slot));
        let flattened = scene.is_rigid(slot) && flattening.rank() < 3;
        if !flattened && triangles.last().is_none_or(|&t| t < drawn) {
            return false;
        }
        let has_area =
            |&t: &u32| t < drawn && !(flattened && flattening.flattens(&mesh.corners(t)));
        kept.extend(triangles.iter().copied().filter(has_area));
        true
    });
}

/// The same for an answer in instances or clusters: degenerate triangles are in no cluster, so they
/// are in no answer.
pub(in super::super) fn of_the_rest(frame: &Frame<'_>, sets: &Sets, log: &mut Log<'_>) {
    let entered = log.left.counts;
    log.left.counts.triangles -= core::mem::take(&mut log.left.degenerate);
    log.row(Stage::Degenerate, Unit::Triangles, entered);
    if !log.lists_dropped() || entered == log.left.counts {
        return;
    }
    for &word in &sets.instances.live {
        for slot in slots(word as usize, sets.instances.alive[word as usize]) {
            // Those of which every cluster was dropped are listed with the last.
            if log.reason(slot).is_none() && sets.coarse.cut_of(slot).is_none() {
                let degenerate = frame.scene.mesh(slot).degenerate_triangles();
                log.drop_range(Stage::Degenerate, Unit::Triangles, (slot, 0), degenerate);
            }
        }
    }
}

/// Returns how much area is left of an instance.
pub(in super::super) fn evidence(frame: &Frame<'_>, slot: u32) -> Evidence {
    let (mesh, rank) = (frame.scene.mesh(slot), frame.scene.transform(slot).rank());
    let triangles = mesh.triangle_count();
    Evidence::Area { rank, with_area: triangles - mesh.degenerate_count(), triangles }
}
