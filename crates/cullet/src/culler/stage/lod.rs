//! Levels of detail: in place of an instance's mesh the coarsest of its levels that is near enough to it.

use super::super::frame::Frame;
use super::super::log::Log;
use super::super::sets::{Coarse, Instances, slots};
use crate::bits;
use crate::funnel::{Counts, Stage};
use crate::lod::{LevelEye, Lod, PixelScale, Selection};
use crate::scene::Tally;

/// Memory of the stage.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct Cache {
    selection: Selection,
    best: Selection,
}

/// Replaces the meshes of instances by levels that have fewer triangles.
pub(in super::super) fn instances(
    frame: &Frame<'_>,
    cache: &mut Cache,
    set: &Instances,
    coarse: &mut Coarse,
    log: &mut Log<'_>,
) {
    let Some(lod) = &frame.culler.lod else { return };
    let scene = frame.scene;
    if scene.has_levels() {
        let scale = PixelScale::of(frame.seen_by, lod.at_corners);
        for &word in &set.live {
            let word = word as usize;
            for slot in slots(word, set.alive[word] & !scene.exempt()[word]) {
                replace(frame, lod, &scale, slot, cache, coarse);
            }
        }
    }
    log.instance_row(Stage::Lod, coarse.saved());
}

fn replace(
    frame: &Frame<'_>,
    lod: &Lod,
    scale: &PixelScale,
    slot: u32,
    cache: &mut Cache,
    coarse: &mut Coarse,
) {
    let scene = frame.scene;
    let own = scene.mesh_id(slot);
    let all = scene.levels(own);
    if all.is_empty() || !scene.is_rigid(slot) {
        return;
    }
    let eye = LevelEye::new(lod, scale, scene.transform(slot), frame.seen_by.eyes);
    let whole = scene.tally_of(slot);
    let mut least = whole.counts;
    let mut found = None;
    for (at, levels) in all.iter().enumerate() {
        let is_drawn = levels.levels.select(frame.culler.level, &eye, &mut cache.selection);
        let counts = Counts {
            instances: 1,
            clusters: u64::from(cache.selection.cluster_count()),
            triangles: cache.selection.triangle_count(),
        };
        // The levels may be cut into smaller clusters than the mesh.
        if is_drawn
            && counts.triangles < least.triangles
            && counts.clusters <= whole.counts.clusters
        {
            (least, found) = (counts, Some((at as u32 + 1, levels.mesh)));
            std::mem::swap(&mut cache.selection, &mut cache.best);
        }
    }
    if let Some((level, mesh)) = found {
        let tally = Tally { counts: least, degenerate: 0 };
        coarse.push((slot, mesh, level), (whole, tally), cache.best.ranges());
    }
}

/// How large the errors of an instance are allowed to be, and what is drawn of it.
pub(in super::super) fn finding(frame: &Frame<'_>, cache: &Cache, slot: u32) -> String {
    let scene = frame.scene;
    let Some(lod) = &frame.culler.lod else { return String::new() };
    let all = scene.levels(scene.mesh_id(slot));
    if all.is_empty() || !scene.is_rigid(slot) || bits::get(scene.exempt(), slot as usize) {
        return "has no levels of detail, or is not drawn just as its mesh says".to_owned();
    }
    let triangles = match cache.best.triangle_count() {
        0 => scene.tally_of(slot).counts.triangles,
        triangles => triangles,
    };
    format!(
        "{triangles} of {} triangles within {} pixels of the original",
        scene.tally_of(slot).counts.triangles,
        lod.pixels
    )
}
