//! Levels of detail: in place of an instance's mesh the coarsest of its levels that is near enough to it.

use super::super::frame::Frame;
use super::super::log::Log;
use super::super::sets::{Coarse, Instances, slots};
use crate::bits;
use crate::funnel::{Counts, Stage};
use crate::lod::{Budget, LevelEye, Lod, PixelScale, Selection};
use crate::scene::Tally;

/// Memory of the stage.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct Cache {
    selection: Selection,
    best: Selection,
    budget: Budget,
    /// The threshold of the last view.
    pub(in super::super) pixels: Option<f64>,
}

/// Replaces the meshes of instances by levels that have fewer triangles.
pub(in super::super) fn instances(
    frame: &Frame<'_>,
    cache: &mut Cache,
    set: &Instances,
    coarse: &mut Coarse,
    log: &mut Log<'_>,
) {
    cache.pixels = None;
    let Some(mut lod) = frame.culler.lod else { return };
    let scene = frame.scene;
    if scene.has_levels() {
        let scale = PixelScale::of(frame.seen_by, lod.at_corners);
        if let Some(most) = lod.triangles {
            lod.pixels = within_budget(frame, &lod, most, &scale, &mut cache.budget, set);
        }
        for &word in &set.live {
            let word = word as usize;
            for slot in slots(word, set.alive[word] & !scene.exempt()[word]) {
                replace(frame, &lod, &scale, slot, cache, coarse);
            }
        }
    }
    cache.pixels = Some(lod.pixels);
    log.instance_row(Stage::Lod, coarse.saved());
}

/// The threshold at which no more triangles are drawn than the budget has: one pass over all groups.
fn within_budget(
    frame: &Frame<'_>,
    lod: &Lod,
    most: u64,
    scale: &PixelScale,
    budget: &mut Budget,
    set: &Instances,
) -> f64 {
    let scene = frame.scene;
    budget.begin(lod.pixels);
    let finest = Lod { pixels: budget.finest(), ..*lod };
    let mut all = 0;
    for &word in &set.live {
        for slot in slots(word as usize, set.alive[word as usize]) {
            let levels = scene.levels(scene.mesh_id(slot));
            let whole = scene.tally_of(slot).counts;
            all += whole.triangles;
            let is_exempt = bits::get(scene.exempt(), slot as usize);
            if levels.is_empty() || is_exempt || !scene.is_rigid(slot) {
                budget.add_whole(whole.triangles);
                continue;
            }
            let eye = LevelEye::new(&finest, scale, scene.transform(slot), frame.seen_by.eyes);
            let levels = levels.iter().map(|l| &l.levels);
            budget.add([whole.triangles, whole.clusters], levels, &eye);
        }
    }
    // In full where that was asked for, or nothing that means anything, and it is not too much.
    let is_full = lod.pixels <= 0.0 || lod.pixels.is_nan();
    if is_full && all <= most { lod.pixels } else { budget.pixels(most) }
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
        cache.pixels.unwrap_or(lod.pixels)
    )
}
