//! Moving many things at once.

use bytemuck::Zeroable;

use super::slots::NO_SLOT;
use super::{Handle, Hierarchy, HierarchyError};
use crate::bits;
use crate::bounds::{Aabb, LANES, gather_into};

/// Slots whose boxes are written together: with what comes to them, they fit in the second cache.
const NEAR: usize = 4096;
/// Of so many slots, one for every other block.
const FEW: usize = NEAR / LANES / 2;

/// Memory that one call after another uses.
#[derive(Clone, Debug, Default)]
pub(super) struct Moves {
    slots: Vec<u32>,
    /// Where the next for each [`NEAR`] slots goes; in the end, where they end.
    places: Vec<u32>,
    arrived: Vec<Arrival>,
}

/// A box on its way to its slot.
#[derive(Clone, Copy, Debug, Zeroable)]
struct Arrival {
    bounds: Aabb,
    slot: u32,
}

impl Hierarchy {
    /// Moves many things: [`set_bounds`](Self::set_bounds) for each, the last one of a handle counting, and a
    /// [`refit`](Self::refit), in a fraction of the time. Nothing is changed on an error.
    ///
    /// Whoever names things by handle has them in another order than they lie in here, and one by one each
    /// misses the caches twelve times. So boxes first go to where they are near, then to their slots. Keeps
    /// 32 bytes for each that moved.
    ///
    /// # Errors
    /// If a handle names nothing, or there are more moves than there can be slots.
    pub fn set_many(&mut self, moves: &[(Handle, Aabb)]) -> Result<(), HierarchyError> {
        if u32::try_from(moves.len()).is_err() {
            return Err(HierarchyError::Full(NO_SLOT));
        }
        let mut memory = std::mem::take(&mut self.moves);
        let found = memory.find(self, moves);
        if found.is_ok() {
            memory.bring_near(moves, self.boxes.len());
            let mut first = 0;
            for &end in &memory.places {
                self.settle_near(&memory.arrived[first..end as usize]);
                first = end as usize;
            }
            self.refit();
            self.change_version += 1;
        }
        self.moves = memory;
        found
    }

    /// Writes boxes that all belong to the same [`NEAR`] slots.
    fn settle_near(&mut self, arrived: &[Arrival]) {
        let Some(any) = arrived.first() else { return };
        let base = any.slot as usize / NEAR * NEAR;
        // Where most blocks have none, a table of their slots is dearer than what it brings.
        if arrived.len() < FEW {
            for arrival in arrived {
                let slot = arrival.slot as usize;
                self.boxes.set(slot, &arrival.bounds);
                if slot < self.nodes.len() {
                    bits::set(&mut self.loose, slot / LANES, true);
                }
            }
            return;
        }
        let mut numbers = [NO_SLOT; NEAR];
        for (number, arrival) in (0..).zip(arrived) {
            numbers[arrival.slot as usize - base] = number;
        }
        let bounds = |number: u32| arrived[number as usize].bounds;
        let (blocks, _) = numbers.as_chunks::<LANES>();
        for (block, numbers) in (base / LANES..).zip(blocks) {
            let present =
                (0..).zip(numbers).fold(0, |set, (lane, &n)| set | u64::from(n != NO_SLOT) << lane);
            if present == (1 << LANES) - 1 {
                let to = &mut self.boxes.blocks_mut()[block..=block];
                gather_into(self.level, to, std::slice::from_ref(numbers), bounds);
            } else {
                for lane in bits::ones(present) {
                    self.boxes.set(block * LANES + lane, &bounds(numbers[lane]));
                }
            }
        }
        // While they are near: a subtree of its own.
        let end = (base + NEAR).min(self.nodes.len());
        self.nodes.refit_range(self.level, &self.boxes, base.min(end)..end);
    }
}

impl Moves {
    /// The slots of all handles.
    fn find(&mut self, h: &Hierarchy, moves: &[(Handle, Aabb)]) -> Result<(), HierarchyError> {
        self.slots.clear();
        self.slots.reserve(moves.len());
        for &(handle, _) in moves {
            self.slots.push(h.slot(handle)?);
        }
        Ok(())
    }

    /// Sorts the boxes by [`NEAR`] slots each, in their order.
    fn bring_near(&mut self, moves: &[(Handle, Aabb)], len: usize) {
        self.places.clear();
        self.places.resize(len.div_ceil(NEAR), 0);
        for &slot in &self.slots {
            self.places[slot as usize / NEAR] += 1;
        }
        let mut start = 0;
        for place in &mut self.places {
            start += std::mem::replace(place, start);
        }
        self.arrived.resize(moves.len(), Arrival::zeroed());
        for (&slot, &(_, bounds)) in self.slots.iter().zip(moves) {
            let place = &mut self.places[slot as usize / NEAR];
            self.arrived[*place as usize] = Arrival { bounds, slot };
            *place += 1;
        }
    }
}
