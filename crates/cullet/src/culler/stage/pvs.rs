//! Potentially visible sets: what is not in the set of the eye's cell.

use super::super::evidence::{CellTest, Evidence, Finding};
use super::super::frame::Frame;
use super::super::log::Log;
use super::super::sets::Instances;
use super::stand::{Idle, detail, list, place_of, stand};
use crate::array::Each;
use crate::bits;
use crate::cull::pvs::{Targets, VisibleSets};
use crate::funnel::{Reason, Stage};
use crate::scene::{Scene, SceneCells, Tally};

/// Knowledge of the stage about a view: what may be seen from the cells that the eye is in. It is
/// found anew when the eye comes into other cells, and when the cells, their slots, their sets or
/// the use of mirrors change.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct Cache {
    idle: Idle,
    /// [Version](SceneCells::version) of the cells for which `row` and `seen` were found, and
    /// whether with mirrors.
    of: Option<((u64, u64), bool)>,
    /// Cells for which `row` and `seen` were found: those that the near plane may be in, that of
    /// the eye first.
    starts: Vec<u32>,
    found: Vec<u32>,
    /// One bit a target.
    row: Vec<u64>,
    /// One bit a slot, of those that there were: in the sets.
    seen: Vec<u64>,
}

/// Drops the instances that are in none of the sets.
pub(in super::super) fn instances(
    frame: &Frame<'_>,
    cache: &mut Cache,
    set: &mut Instances,
    log: &mut Log<'_>,
) {
    let mut dropped = match frame.candidates {
        None => Tally::default(),
        Some(candidates) => {
            set.filter(frame.scene, Stage::Pvs, log, |word, alive| alive & !candidates.word(word))
        }
    };
    if !frame.culler.pvs {
        cache.idle = Idle::NoSets;
        return log.instance_row(Stage::Pvs, dropped);
    }
    cache.idle = match frame.scene.cells().map(|cells| (cells, cells.sets())) {
        None => Idle::NoCells,
        Some((_, None)) => Idle::NoSets,
        Some((cells, Some(sets))) => match stand(frame, cells, &mut cache.found) {
            Err(idle) => idle,
            Ok(_) => {
                cache.look_up(frame, cells, sets);
                dropped += cache.drop_unseen(frame.scene, (cells, sets), set, log);
                Idle::No
            }
        },
    };
    log.instance_row(Stage::Pvs, dropped);
}

/// One bit a slot: instances that are seen from everywhere.
fn everywhere<'a>(cells: &'a SceneCells, sets: &VisibleSets<'_>) -> &'a [u64] {
    match sets.targets() {
        Targets::Cells => cells.loose(),
        Targets::Instances => cells.changed(),
    }
}

impl Cache {
    /// Finds which slots are in the sets of the cells that the eye is in.
    fn look_up(&mut self, frame: &Frame<'_>, cells: &SceneCells, sets: &VisibleSets<'_>) {
        let mirrors = frame.culler.portal.is_some_and(|portal| portal.mirrors > 0);
        let of = Some((cells.version(), mirrors));
        if self.of == of && self.starts == self.found {
            return;
        }
        self.of = of;
        self.starts.clone_from(&self.found);
        self.row.fill(0);
        self.starts.iter().for_each(|&cell| sets.add_row_to(cell, &mut self.row));
        if mirrors {
            self.add_mirrors(cells, sets);
        }
        let scene = frame.scene;
        self.seen.clear();
        self.seen.resize(scene.slot_count().div_ceil(64) as usize, 0);
        match sets.targets() {
            Targets::Cells => {
                for cell in bits::in_words(&self.row) {
                    for &slot in cells.slots_in(cell as u32) {
                        bits::set(&mut self.seen, slot as usize, true);
                    }
                }
            }
            Targets::Instances => {
                for slot in scene.slots() {
                    let index = scene.handle(slot).map_or(u32::MAX, |handle| handle.index);
                    // What came later is none of the targets.
                    let is_seen =
                        index >= sets.target_count() || bits::get(&self.row, index as usize);
                    bits::set(&mut self.seen, slot as usize, is_seen);
                }
            }
        }
    }

    /// Adds the sets of the mirrors' cells to the row: what may be seen from a mirror's cell may be
    /// seen in the mirror. Where the targets are cells, it adds only mirrors whose cell is in the
    /// row by then. Where they are instances, it adds all mirrors.
    fn add_mirrors(&mut self, cells: &SceneCells, sets: &VisibleSets<'_>) {
        let mut left: Vec<u32> = cells.graph().mirrors().iter().map(|mirror| mirror.cell).collect();
        left.sort_unstable();
        left.dedup();
        loop {
            let is_seen = |row: &[u64], cell: u32| match sets.targets() {
                Targets::Cells => bits::get(row, cell as usize),
                // Of cells nothing is known.
                Targets::Instances => true,
            };
            let Some(at) = left.iter().position(|&cell| is_seen(&self.row, cell)) else { return };
            let cell = left.swap_remove(at);
            sets.add_row_to(cell, &mut self.row);
        }
    }

    fn drop_unseen(
        &self,
        scene: &Scene,
        (cells, sets): (&SceneCells, &VisibleSets<'_>),
        set: &mut Instances,
        log: &mut Log<'_>,
    ) -> Tally {
        let (everywhere, mut sum) = (everywhere(cells, sets), Tally::default());
        for &word in &set.live {
            let at = word as usize;
            // Words that are not there are of slots that came since.
            let kept = [&*self.seen, everywhere].each(|w| w.get(at).copied().unwrap_or(u64::MAX));
            let dropped = set.alive[at] & !(kept[0] | kept[1] | scene.exempt()[at]);
            set.alive[at] &= !dropped;
            sum += scene.tally_of_bits(at, dropped);
            if log.wants_reasons() {
                for bit in bits::ones(dropped) {
                    let slot = word * 64 + bit as u32;
                    log.drop_slot(slot, Reason { stage: Stage::Pvs, detail: detail(cells, slot) });
                }
            }
        }
        sum
    }

    /// In whose set an instance is, or not.
    pub(in super::super) fn finding(&self, frame: &Frame<'_>, slot: u32) -> Finding {
        let word = frame.candidates.map(|candidates| candidates.word(slot as usize / 64));
        match word.map(|word| word >> (slot % 64) & 1 == 1) {
            Some(false) => return "none of the candidates".into(),
            Some(true) if !frame.culler.pvs => return "one of the candidates".into(),
            _ => {}
        }
        let sets = frame.scene.cells().and_then(|cells| Some((cells, cells.sets()?)));
        let Some((cells, sets)) = sets.filter(|_| self.idle == Idle::No) else {
            return self.idle.words().into();
        };
        let own = match sets.targets() {
            Targets::Cells => cells.of_slot(slot),
            Targets::Instances => &[],
        };
        let place = match sets.targets() {
            Targets::Cells => format!("{}, ", place_of(own)),
            Targets::Instances => String::new(),
        };
        let (instance, eye) = (own.to_vec(), self.starts.clone());
        let test = CellTest { instance, eye, in_sight: true, ..CellTest::default() };
        if bits::get(everywhere(cells, sets), slot as usize) {
            let words = format!("{place}seen from everywhere: beyond the cells, or moved since");
            return Finding::new(words, Evidence::Cells(test));
        }
        let is_seen = bits::get(&self.seen, slot as usize);
        let (set, not) = (
            if self.starts.len() == 1 { "set of cell" } else { "sets of cells" },
            if is_seen { "" } else { "not " },
        );
        let words = format!("{place}{not}in the {set} {}", list(&self.starts));
        Finding::new(words, Evidence::Cells(CellTest { in_sight: is_seen, ..test }))
    }
}
