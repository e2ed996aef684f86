//! Levels of detail of instances that stand for others: which of them are drawn.
//!
//! Those that stand for instances that are left form a tree. What is drawn of each is the less of a
//! cut of its own levels and of what would be drawn of those below it: found from above, where one
//! that is surely less than anything below spares the rest, and then from below.

use alloc::vec::Vec;

use super::super::evidence::Evidence;
use super::super::frame::Frame;
use super::super::log::Log;
use super::super::sets::{Coarse, Instances, slots};
use crate::funnel::{Counts, Reason, Stage};
use crate::lod::{LevelEye, Lod, PixelScale, Selection};
use crate::scene::{Scene, StandIns, Tally};
use crate::sort::sort;

/// State of every stand-in in one view. Its memory is used again.
#[derive(Clone, Debug, Default)]
pub(super) struct Cache {
    of: Vec<OfStandIn>,
    /// Numbers of the stand-ins that stand for an instance that is left, ascending.
    touched: Vec<u32>,
    selection: Selection,
}

/// State of one stand-in.
#[derive(Clone, Copy, Debug, Default)]
struct OfStandIn {
    touched: bool,
    /// Counts of the meshes of the instances that are left, of those that it stands for.
    left: Tally,
    /// Fewest triangles that may be drawn for those instances, by any levels of theirs or of the
    /// stand-ins between.
    fewest: u64,
    /// Triangles of its cut, and which of its mesh's levels that is of; `None` where it must not be
    /// drawn.
    own: Option<(u64, u32)>,
    /// Triangles of what is drawn of those below.
    below: u64,
    /// One of those above is drawn, or it is.
    covered: bool,
    drawn: bool,
}

impl Cache {
    /// Finds those of which something is left, and which of their levels are within the threshold.
    pub(super) fn open(
        &mut self,
        frame: &Frame<'_>,
        lod: &Lod,
        scale: &PixelScale,
        set: &Instances,
    ) {
        let scene = frame.scene;
        let Some(stands) = scene.stand_ins() else { return };
        self.of.clear();
        self.of.resize(stands.all.len(), OfStandIn::default());
        self.touched.clear();
        for &word in &set.live {
            let word = word as usize;
            for slot in slots(word, set.alive[word]) {
                let Some(own) = self.of.get_mut(stands.of_slot(slot) as usize) else { continue };
                let whole = scene.tally_of(slot);
                own.left += whole;
                own.fewest += fewest_of(scene, slot).min(whole.counts.triangles);
                self.touch(stands, stands.of_slot(slot));
            }
        }
        sort(&mut self.touched);
        // From below to above: those in between may have fewer than all that is below them.
        for &number in &self.touched {
            let stand_in = &stands.all[number as usize];
            let OfStandIn { left, fewest, .. } = self.of[number as usize];
            if let Some(above) = self.of.get_mut(stand_in.above as usize) {
                above.left += left;
                let own = if stand_in.off { u64::MAX } else { fewest_of(scene, stand_in.slot) };
                above.fewest += fewest.min(own);
            }
        }
        for &number in self.touched.iter().rev() {
            let stand_in = &stands.all[number as usize];
            let above = self.of.get(stand_in.above as usize);
            if above.is_some_and(|above| above.covered) {
                self.of[number as usize].covered = true;
                continue;
            }
            if stand_in.off {
                continue;
            }
            let eye = LevelEye::new(lod, scale, scene.transform(stand_in.slot), frame.seen_by.eyes);
            let own = &mut self.of[number as usize];
            let most = own.left.counts;
            let all = scene.levels(scene.mesh_id(stand_in.slot));
            for (level, levels) in (1..).zip(all).filter(|(_, l)| l.is_used(lod)) {
                let is_there = levels.levels.select(frame.culler.simd, &eye, &mut self.selection);
                let triangles = self.selection.triangle_count();
                if is_there
                    && triangles <= own.own.map_or(most.triangles, |o| o.0 - 1)
                    && u64::from(self.selection.cluster_count()) <= most.clusters
                {
                    own.own = Some((triangles, level));
                    own.covered = triangles <= own.fewest;
                    own.drawn = own.covered;
                    if triangles == 0 {
                        break;
                    }
                }
            }
        }
    }

    /// Notes that something is left of what one stands for, and all above it.
    fn touch(&mut self, stands: &StandIns, number: u32) {
        let mut at = number;
        while let Some(own) = self.of.get_mut(at as usize).filter(|own| !own.touched) {
            own.touched = true;
            self.touched.push(at);
            at = stands.all[at as usize].above;
        }
    }

    /// Whether one that stands for the instance of a slot is surely drawn.
    pub(super) fn covers(&self, stands: &StandIns, slot: u32) -> bool {
        self.of.get(stands.of_slot(slot) as usize).is_some_and(|own| own.covered)
    }

    /// Notes how many triangles are drawn of an instance that nobody was surely drawn for.
    pub(super) fn count(&mut self, stands: &StandIns, slot: u32, triangles: u64) {
        if let Some(own) = self.of.get_mut(stands.of_slot(slot) as usize) {
            own.below += triangles;
        }
    }

    /// Puts those that are drawn in the place of what they stand for; what the stage took, with
    /// what the cuts of all others save.
    pub(super) fn close(
        &mut self,
        frame: &Frame<'_>,
        (lod, scale): (&Lod, &PixelScale),
        set: &mut Instances,
        coarse: &mut Coarse,
        log: &mut Log<'_>,
    ) -> Tally {
        let scene = frame.scene;
        let Some(stands) = scene.stand_ins() else { return Tally::default() };
        for &number in &self.touched {
            let own = &mut self.of[number as usize];
            let mut least = own.below;
            if let Some((triangles, _)) = own.own.filter(|o| own.drawn || o.0 <= least) {
                (least, own.drawn) = (triangles, true);
            }
            if let Some(above) = self.of.get_mut(stands.all[number as usize].above as usize) {
                above.below += least;
            }
        }
        for &number in self.touched.iter().rev() {
            let above = stands.all[number as usize].above;
            let is_covered = self.of.get(above as usize).is_some_and(|above| above.covered);
            let own = &mut self.of[number as usize];
            own.drawn &= !is_covered;
            own.covered = is_covered || own.drawn;
        }
        let mut taken = Tally::default();
        for at in 0..set.live.len() {
            let word = set.live[at] as usize;
            for slot in slots(word, set.alive[word]) {
                if self.covers(stands, slot) {
                    taken += scene.tally_of(slot);
                    set.drop_slot(slot);
                    log.drop_slot(slot, Reason { stage: Stage::Lod, detail: 0 });
                }
            }
        }
        coarse.drop_slots(|slot| self.covers(stands, slot));
        taken += coarse.replaced();
        let of = &self.of;
        let drawn = || self.touched.iter().filter(|&&number| of[number as usize].drawn);
        for &number in drawn() {
            let slot = stands.all[number as usize].slot;
            let Some((_, level)) = of[number as usize].own else { continue };
            let Some(levels) = scene.levels(scene.mesh_id(slot)).get(level as usize - 1) else {
                continue;
            };
            let eye = LevelEye::new(lod, scale, scene.transform(slot), frame.seen_by.eyes);
            levels.levels.select(frame.culler.simd, &eye, &mut self.selection);
            let whole = scene.tally_of(slot);
            let tally = Tally { counts: counts_of(&self.selection), degenerate: 0 };
            coarse.push((slot, levels.mesh, level), (whole, tally), self.selection.ranges());
            log.keep_slot(slot);
        }
        set.put_in(drawn().map(|&number| stands.all[number as usize].slot));
        coarse.sort();
        taken -= coarse.drawn();
        taken
    }
}

/// The fewest triangles that any levels of a slot's mesh have.
fn fewest_of(scene: &Scene, slot: u32) -> u64 {
    let levels = scene.levels(scene.mesh_id(slot)).iter();
    levels.map(|l| l.levels.fewest_triangles()).min().unwrap_or(u64::MAX)
}

/// The one instance that is culled alone, where somebody is drawn in its place.
pub(super) fn replaced_alone(frame: &Frame<'_>) -> Option<u32> {
    let only = frame.only?;
    let reason = only.all.reasons.get(only.slot as usize).copied().flatten();
    reason.filter(|reason| reason.stage == Stage::Lod).map(|_| only.slot)
}

/// Returns who is drawn in the place of an instance.
pub(super) fn evidence(frame: &Frame<'_>, slot: u32) -> Option<Evidence> {
    let scene = frame.scene;
    replaced_alone(frame).filter(|&only| only == slot)?;
    // One that nobody wanted is in no layer; one that was wanted may be hidden since.
    let reason = |slot: u32| *frame.only?.all.reasons.get(slot as usize)?;
    let mut by = scene.stand_in_of(slot)?;
    while reason(by).is_some_and(|reason| reason.stage == Stage::Layer)
        && let Some(above) = scene.stand_in_of(by)
    {
        by = above;
    }
    Some(Evidence::Replaced { by, count: scene.stood_for_by(by).len() as u32 })
}

/// Returns the counts of one instance that is drawn as the clusters of `selection`.
pub(super) fn counts_of(selection: &Selection) -> Counts {
    Counts {
        instances: 1,
        clusters: u64::from(selection.cluster_count()),
        triangles: selection.triangle_count(),
    }
}
