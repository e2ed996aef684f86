//! Instances that stand for others: one mesh with levels of detail in place of many instances that
//! are far away.

use alloc::collections::BTreeSet;
use alloc::vec::Vec;

use super::column::{Bits, Permute};
use super::{Scene, SceneError};
use crate::bits;
use crate::bounds::Aabb;
use crate::hierarchy::Handle;

/// In place of the number of a stand-in: there is none.
pub(crate) const NO_STAND_IN: u32 = u32::MAX;

/// One that stands for others.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StandIn {
    handle: Handle,
    /// The slot of its own instance.
    pub(crate) slot: u32,
    /// The number of the one that stands for it, higher than its own, or [`NO_STAND_IN`].
    pub(crate) above: u32,
    /// Whether something that it stands for has changed, so that it must not be drawn.
    pub(crate) off: bool,
}

/// All of a scene.
#[derive(Clone, Debug, Default)]
pub(crate) struct StandIns {
    /// Stand-ins of the scene. Those below come before those above.
    pub(crate) all: Vec<StandIn>,
    /// One entry per slot, up to the last that had one when a stand-in was added: the number of the
    /// stand-in for its instance, or [`NO_STAND_IN`]; for a stand-in its own number.
    numbers: Vec<u32>,
    /// One bit a slot: its instance stands for others.
    own: Bits,
}

impl StandIns {
    /// Returns the number of the stand-in for the instance of a slot, or [`NO_STAND_IN`].
    pub(crate) fn of_slot(&self, slot: u32) -> u32 {
        match self.has(slot as usize) {
            true => NO_STAND_IN,
            false => self.numbers.get(slot as usize).copied().unwrap_or(NO_STAND_IN),
        }
    }

    /// Returns the number of the stand-in in a slot, if there is one.
    fn number_of(&self, slot: u32) -> Option<u32> {
        self.has(slot as usize).then(|| self.numbers[slot as usize])
    }

    /// Makes room for an entry per slot.
    pub(super) fn resize(&mut self, slots: usize) {
        self.numbers.resize(slots, NO_STAND_IN);
        self.own.resize(slots.div_ceil(64), 0);
    }

    /// One bit a slot of a word: its instance stands for others.
    pub(crate) fn word(&self, word: usize) -> u64 {
        self.own.get(word).copied().unwrap_or(0)
    }

    /// Whether the instance of a slot stands for others.
    pub(crate) fn has(&self, slot: usize) -> bool {
        self.word(slot / 64) >> (slot % 64) & 1 == 1
    }

    /// Switches off all that stand for the instance of a slot, and the one that it is itself.
    fn leave(&mut self, slot: u32) {
        let mut at = self.number_of(slot).unwrap_or_else(|| self.of_slot(slot));
        while let Some(stand_in) = self.all.get_mut(at as usize).filter(|s| !s.off) {
            stand_in.off = true;
            at = stand_in.above;
        }
    }
}

impl Permute for StandIns {
    fn gather(&mut self, from: &[u32]) {
        self.numbers.gather(from);
        self.own.gather(from);
        // Those that were removed are in no slot any more.
        self.all.iter_mut().for_each(|stand_in| stand_in.slot = u32::MAX);
        for slot in bits::in_words(&self.own) {
            self.all[self.numbers[slot] as usize].slot = slot as u32;
        }
        self.all.iter_mut().for_each(|stand_in| stand_in.off |= stand_in.slot == u32::MAX);
    }

    fn rearrange(&mut self, moves: &[[u32; 2]]) {
        self.numbers.rearrange(moves);
        self.own.rearrange(moves);
        for &[_, slot] in moves {
            if let Some(number) = self.number_of(slot) {
                self.all[number as usize].slot = slot;
            }
        }
    }
}

impl Scene {
    /// Lets an instance stand for others: where levels of detail are drawn,
    /// [`Culler::lod`](crate::Culler::lod) draws a cut of its levels in place of all of them, if
    /// that is within the threshold and has no more triangles than what would be drawn of those
    /// that are left. Its surface should be theirs, and the errors of its levels be measured
    /// against theirs.
    ///
    /// From then on the instance is in no layer and is drawn for nothing else,
    /// [`slots`](Self::slots) leaves it out, and it is in no count of the scene's. The others may
    /// stand for instances themselves, so that groups become a tree. They should be in the same
    /// layers: it is drawn as soon as one of them is left.
    ///
    /// If one of them is moved, removed, put in another layer, given other flags or bounds, or if
    /// its mesh is edited, all that stand for it are never drawn again. O(instances).
    ///
    /// # Errors
    /// If a handle names no instance, the mesh of `stand_in` has no levels, or an instance does not
    /// qualify; then nothing has changed.
    pub fn stand_for(&mut self, stand_in: Handle, others: &[Handle]) -> Result<(), SceneError> {
        let own = self.slot(stand_in)?;
        if self.levels(self.mesh_id(own)).is_empty() {
            return Err(SceneError::NoLevels(stand_in));
        }
        let stands = self.stand_ins.as_deref();
        let is_stand_in = |slot: u32| stands.is_some_and(|s| s.has(slot as usize));
        let is_taken = |slot: u32| stands.is_some_and(|s| s.of_slot(slot) != NO_STAND_IN);
        if is_stand_in(own) || is_taken(own) {
            return Err(SceneError::Taken(stand_in));
        }
        let (mut slots, mut below) = (BTreeSet::new(), BTreeSet::new());
        for &other in others.iter().chain([&stand_in]) {
            let slot = self.slot(other)?;
            if !self.is_rigid(slot) || bits::get(&self.exempt, slot as usize) {
                return Err(SceneError::NotRigid(other));
            }
        }
        for &other in others {
            let slot = self.slot(other)?;
            if slot == own {
                return Err(SceneError::Taken(other));
            }
            let number = stands.and_then(|s| s.number_of(slot));
            let is_free = match (stands, number) {
                (Some(stands), Some(number)) => {
                    stands.all[number as usize].above == NO_STAND_IN && below.insert(number)
                }
                _ => !is_taken(slot) && slots.insert(slot),
            };
            if !is_free {
                return Err(SceneError::Taken(other));
            }
        }
        let at = own as usize;
        self.tallies.leave(self.mesh[at], self.layers[at]);
        self.layers[at] = 0;
        let count = self.slot_count() as usize;
        let stands = self.stand_ins.get_or_insert_default();
        stands.resize(count);
        let number = stands.all.len() as u32;
        let off = below.iter().any(|&b| stands.all[b as usize].off);
        slots.into_iter().for_each(|slot| stands.numbers[slot as usize] = number);
        below.into_iter().for_each(|b| stands.all[b as usize].above = number);
        stands.numbers[at] = number;
        bits::set(&mut stands.own, at, true);
        stands.all.push(StandIn { handle: stand_in, slot: own, above: NO_STAND_IN, off });
        self.update_slot(own);
        self.change += 1;
        Ok(())
    }

    /// Returns the stand-ins of this scene, if any.
    pub(crate) fn stand_ins(&self) -> Option<&StandIns> {
        // Nobody else looks at them.
        self.stand_ins.as_deref().filter(|_| cfg!(feature = "lossy"))
    }

    /// Whether the instance of a slot stands for [others](Self::stand_for).
    #[must_use]
    pub fn is_stand_in(&self, slot: u32) -> bool {
        self.stand_ins.as_ref().is_some_and(|s| s.has(slot as usize))
    }

    /// The slots of the instances that [stand for others](Self::stand_for), from below to above.
    pub fn stand_in_slots(&self) -> impl Iterator<Item = u32> + '_ {
        self.stand_ins.iter().flat_map(|s| s.all.iter().map(|s| s.slot))
    }

    /// Whether the instance of a slot stands for others of which one has changed since, so that it
    /// is never drawn.
    #[must_use]
    pub fn is_stand_in_off(&self, slot: u32) -> bool {
        let own = |s: &StandIns| s.number_of(slot).is_some_and(|own| s.all[own as usize].off);
        self.stand_ins.as_deref().is_some_and(own)
    }

    /// The slot of the instance that stands for that of a slot, itself one that stands for others
    /// or not; `None` where there is none.
    #[must_use]
    pub fn stand_in_of(&self, slot: u32) -> Option<u32> {
        let stands = self.stand_ins.as_deref()?;
        let above = match stands.number_of(slot) {
            Some(own) => stands.all[own as usize].above,
            None => stands.of_slot(slot),
        };
        Some(stands.all.get(above as usize)?.slot)
    }

    /// The slots of the instances that are drawn as themselves where one that stands for others is
    /// not, nor any below it; ascending. O(slots).
    #[must_use]
    pub fn stood_for_by(&self, stand_in: u32) -> Vec<u32> {
        let Some(stands) = self.stand_ins.as_deref() else { return Vec::new() };
        let mut within: Vec<bool> = stands.all.iter().map(|s| s.slot == stand_in).collect();
        for number in (0..within.len()).rev() {
            let above = stands.all[number].above as usize;
            within[number] |= within.get(above).copied().unwrap_or(false);
        }
        let is_in =
            |slot: &u32| within.get(stands.of_slot(*slot) as usize).copied().unwrap_or(false);
        (0..self.slot_count()).filter(is_in).collect()
    }

    /// Forgets who stands for whom: those instances are removed.
    pub fn clear_stand_ins(&mut self) {
        let Some(stands) = self.stand_ins.as_ref() else { return };
        for handle in stands.all.iter().map(|s| s.handle).collect::<Vec<_>>() {
            // Some may have been removed.
            let _ = self.remove(handle);
        }
        self.stand_ins = None;
    }

    /// Takes note that the instance of a slot is no longer what others stand for.
    pub(super) fn leave_stand_ins(&mut self, slot: u32) {
        if let Some(stands) = &mut self.stand_ins {
            stands.leave(slot);
        }
    }

    /// Takes note of the meshes that were edited.
    pub(super) fn leave_stand_ins_of(&mut self, edited: &[bool]) {
        let Some(stands) = &mut self.stand_ins else { return };
        for (slot, mesh) in (0..).zip(&self.mesh) {
            if edited[*mesh as usize] {
                stands.leave(slot);
            }
        }
    }

    /// The bounds of a slot in the hierarchy: none of those that stand for others, which nobody is
    /// to find there.
    pub(super) fn box_to_find(&self, slot: usize) -> Aabb {
        if self.is_stand_in(slot as u32) { Aabb::EMPTY } else { self.world_box(slot) }
    }
}
