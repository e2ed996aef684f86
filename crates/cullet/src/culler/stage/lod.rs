//! Levels of detail: in place of an instance's mesh the coarsest of its levels that is near enough
//! to it.

use super::super::evidence::Evidence;
use super::super::frame::Frame;
use super::super::log::Log;
use super::super::sets::{Coarse, Instances, slots};
use super::stand_ins::{self, counts_of};
use crate::bits;
use crate::funnel::{Reason, Stage};
use crate::lod::{Budget, LevelEye, Lod, PixelScale, Selection};
use crate::scene::{NO_STAND_IN, Tally};

/// Memory of the stage.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct Cache {
    selection: Selection,
    best: Selection,
    budget: Budget,
    stand_ins: stand_ins::Cache,
    /// The threshold of the last view.
    pub(in super::super) pixels: Option<f64>,
}

/// Replaces the meshes of instances by levels that have fewer triangles, and many instances by one
/// that stands for them.
pub(in super::super) fn instances(
    frame: &Frame<'_>,
    cache: &mut Cache,
    set: &mut Instances,
    coarse: &mut Coarse,
    log: &mut Log<'_>,
) {
    cache.pixels = None;
    let Some(mut lod) = frame.culler.lod_settings() else { return };
    let scene = frame.scene;
    let mut taken = Tally::default();
    if let Some(slot) = stand_ins::replaced_alone(frame).filter(|&slot| set.has(slot)) {
        taken = scene.tally_of(slot);
        set.drop_slot(slot);
        log.drop_slot(slot, Reason { stage: Stage::Lod, detail: 0 });
    } else if scene.has_levels() {
        let scale = PixelScale::of(frame.seen_by, lod.at_corners);
        if let Some(most) = lod.triangles {
            lod.pixels = within_budget(frame, &lod, most, &scale, cache, set);
        }
        // Of one alone it is known.
        let stands = scene.stand_ins().filter(|_| frame.only.is_none() && lod.stand_ins);
        if stands.is_some() {
            cache.stand_ins.open(frame, &lod, &scale, set);
        }
        for &word in &set.live {
            let word = word as usize;
            for slot in slots(word, set.alive[word]) {
                if stands.is_some_and(|stands| cache.stand_ins.covers(stands, slot)) {
                    continue;
                }
                let is_exempt = bits::get(scene.exempt(), slot as usize);
                let drawn = match is_exempt {
                    true => scene.tally_of(slot).counts.triangles,
                    false => replace(frame, &lod, &scale, slot, cache, coarse),
                };
                if let Some(stands) = stands {
                    cache.stand_ins.count(stands, slot, drawn);
                }
            }
        }
        if stands.is_some() {
            taken = cache.stand_ins.close(frame, (&lod, &scale), set, coarse, log);
        } else {
            taken = coarse.replaced();
            taken -= coarse.drawn();
        }
    }
    cache.pixels = Some(lod.pixels);
    log.instance_row(Stage::Lod, taken);
}

/// The threshold at which no more triangles are drawn than the budget has: one pass over all
/// groups.
fn within_budget(
    frame: &Frame<'_>,
    lod: &Lod,
    most: u64,
    scale: &PixelScale,
    cache: &mut Cache,
    set: &Instances,
) -> f64 {
    let scene = frame.scene;
    let budget = &mut cache.budget;
    let stands = scene.stand_ins().filter(|_| frame.only.is_none() && lod.stand_ins);
    budget.begin(lod.pixels, stands.map_or(0, |s| s.all.len()));
    let finest = Lod { pixels: budget.finest(), ..*lod };
    let mut all = 0;
    for &word in &set.live {
        for slot in slots(word as usize, set.alive[word as usize]) {
            let levels = scene.levels(scene.mesh_id(slot));
            let whole = scene.tally_of(slot).counts;
            all += whole.triangles;
            let by = stands.map_or(NO_STAND_IN, |s| s.of_slot(slot));
            let is_exempt = bits::get(scene.exempt(), slot as usize);
            if levels.is_empty() || is_exempt || !scene.is_rigid(slot) {
                budget.add_whole(by, [whole.triangles, whole.clusters]);
                continue;
            }
            let eye = LevelEye::new(&finest, scale, scene.transform(slot), frame.seen_by.eyes);
            budget.add(
                by,
                [whole.triangles, whole.clusters],
                levels.iter().filter(|l| l.is_used(lod)).map(|l| &l.levels),
                &eye,
            );
        }
    }
    if let Some(stands) = stands {
        for (number, stand_in) in (0..).zip(&stands.all) {
            let slot = stand_in.slot;
            let levels = if stand_in.off { &[] } else { scene.levels(scene.mesh_id(slot)) };
            let eye = || LevelEye::new(&finest, scale, scene.transform(slot), frame.seen_by.eyes);
            let levels = levels.iter().filter(|l| l.is_used(lod)).map(|l| &l.levels);
            budget.stand_in(number, stand_in.above, levels, eye);
        }
    }
    // In full where that was asked for, or nothing that means anything, and it is not too much.
    let is_full = lod.pixels <= 0.0 || lod.pixels.is_nan();
    if is_full && all <= most { lod.pixels } else { budget.pixels(most) }
}

/// Replaces the mesh of an instance, if its levels have fewer triangles: how many are drawn.
fn replace(
    frame: &Frame<'_>,
    lod: &Lod,
    scale: &PixelScale,
    slot: u32,
    cache: &mut Cache,
    coarse: &mut Coarse,
) -> u64 {
    let scene = frame.scene;
    let own = scene.mesh_id(slot);
    let all = scene.levels(own);
    let whole = scene.tally_of(slot);
    if all.is_empty() || !scene.is_rigid(slot) {
        return whole.counts.triangles;
    }
    let eye = LevelEye::new(lod, scale, scene.transform(slot), frame.seen_by.eyes);
    let mut least = whole.counts;
    let mut found = None;
    for (number, levels) in (1..).zip(all).filter(|(_, l)| l.is_used(lod)) {
        let is_drawn = levels.levels.select(frame.culler.simd, &eye, &mut cache.selection);
        let counts = counts_of(&cache.selection);
        // The levels may be cut into smaller clusters than the mesh.
        if is_drawn
            && counts.triangles < least.triangles
            && counts.clusters <= whole.counts.clusters
        {
            (least, found) = (counts, Some((number, levels.mesh)));
            core::mem::swap(&mut cache.selection, &mut cache.best);
        }
    }
    if let Some((level, mesh)) = found {
        let tally = Tally { counts: least, degenerate: 0 };
        coarse.push((slot, mesh, level), (whole, tally), cache.best.ranges());
    }
    least.triangles
}

/// Returns how large the errors of an instance are allowed to be, and what is drawn of it.
pub(in super::super) fn evidence(frame: &Frame<'_>, cache: &Cache, slot: u32) -> Evidence {
    let scene = frame.scene;
    let Some(lod) = frame.culler.lod_settings() else { return Evidence::None };
    if let Some(by) = stand_ins::evidence(frame, slot) {
        return by;
    }
    if scene.levels(scene.mesh_id(slot)).is_empty() || !scene.is_rigid(slot) {
        return Evidence::NoLevels;
    }
    let triangles = scene.tally_of(slot).counts.triangles;
    let drawn = match cache.best.triangle_count() {
        0 => triangles,
        fewer => fewer,
    };
    Evidence::Levels { drawn, triangles, pixels: cache.pixels.unwrap_or(lod.pixels) }
}
