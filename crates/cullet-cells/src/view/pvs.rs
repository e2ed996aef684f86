//! Potentially visible sets: what is not in the set of the eye's cell.

use alloc::vec::Vec;

use cullet::{
    Scene,
    candidates::Look,
    explain::{CellTest, Evidence, Sight},
};

use super::stand::stand;
use crate::bits;
use crate::cells::Cells;
use crate::pvs::{Targets, VisibleSets};

/// Knowledge of the stage about a view: what may be seen from the cells that the eye is in. It is
/// found anew when the eye comes into other cells, and when the cells, their slots, their sets or
/// the use of mirrors change.
#[derive(Clone, Debug, Default)]
pub(super) struct Cache {
    /// The sets of the eye's cells hide something; otherwise `idle` says why not.
    is_used: bool,
    idle: Evidence,
    /// [Version](Cells::version) of the cells for which `row` and `seen` were found, and
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

impl Cache {
    /// Looks from a view, with `mirrors` also into the sets of the cells that have some.
    pub(super) fn look(&mut self, look: &Look<'_>, cells: &Cells, mirrors: bool) {
        let sets = cells.visible_sets().ok_or(Evidence::NoSets);
        let sets = sets.and_then(|sets| stand(look.view, cells, &mut self.found).map(|_| sets));
        self.is_used = sets.is_ok();
        match sets {
            Err(idle) => self.idle = idle,
            Ok(sets) => self.look_up(look.scene, (cells, sets), mirrors),
        }
    }

    /// Returns one bit for each slot of `word`: in the sets, or seen from everywhere.
    pub(super) fn word(&self, cells: &Cells, word: usize) -> u64 {
        if !self.is_used {
            return u64::MAX;
        }
        // Words that are not there are of slots that came since.
        self.seen.get(word).copied().unwrap_or(u64::MAX) | self.everywhere(cells, word)
    }

    /// Returns one bit for each slot of `word`: seen from everywhere. Of sets of instances, those
    /// that changed are in `seen`.
    fn everywhere(&self, cells: &Cells, word: usize) -> u64 {
        match cells.visible_sets().map(VisibleSets::targets) {
            Some(Targets::Instances) => 0,
            _ => cells.loose(word),
        }
    }

    /// Finds which slots are in the sets of the cells that the eye is in.
    fn look_up(&mut self, scene: &Scene, (cells, sets): (&Cells, &VisibleSets<'_>), mirrors: bool) {
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
                    let is_seen = index >= sets.target_count()
                        || bits::get(&self.row, index as usize)
                        || cells.has_changed(index);
                    bits::set(&mut self.seen, slot as usize, is_seen);
                }
            }
        }
    }

    /// Adds the sets of the mirrors' cells to the row: what may be seen from a mirror's cell may be
    /// seen in the mirror. Where the targets are cells, it adds only mirrors whose cell is in the
    /// row by then. Where they are instances, it adds all mirrors.
    fn add_mirrors(&mut self, cells: &Cells, sets: &VisibleSets<'_>) {
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

    /// Returns in whose set an instance is, or not.
    pub(super) fn evidence(
        &self,
        (scene, cells): (&Scene, &Cells),
        slot: u32,
        is_late: bool,
    ) -> Evidence {
        let Some(sets) = cells.visible_sets().filter(|_| self.is_used) else {
            return self.idle.clone();
        };
        let (word, bit) = (slot as usize / 64, slot % 64);
        let is_everywhere = is_late
            || match sets.targets() {
                Targets::Cells => cells.loose(word) >> bit & 1 == 1,
                Targets::Instances => {
                    scene.handle(slot).is_some_and(|handle| cells.has_changed(handle.index))
                }
            };
        Evidence::Cells(CellTest {
            instance: cells.cells_of(slot).to_vec(),
            eye: self.starts.clone(),
            in_sight: is_everywhere || bits::get(&self.seen, slot as usize),
            sight: if is_everywhere { Sight::Everywhere } else { Sight::Sets },
            ..CellTest::default()
        })
    }
}
