//! Stable handles for items that lie in dense slots.

use alloc::vec;
use alloc::vec::Vec;
use core::fmt;

use crate::bits;

/// The caller's stable name for an item in a slot: an index, and a generation that tells a removed
/// item from the one that took its index.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, bytemuck::Pod, bytemuck::Zeroable)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(from = "[u32; 2]", into = "[u32; 2]"))]
#[repr(C)]
pub struct Handle {
    /// Index into the handle table.
    pub index: u32,
    /// How often that index was reused.
    pub generation: u32,
}

// What would be derived needs the standard library's builders of lines, which nothing else does.
impl fmt::Debug for Handle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Handle {{ index: {}, generation: {} }}", self.index, self.generation)
    }
}

impl From<[u32; 2]> for Handle {
    fn from([index, generation]: [u32; 2]) -> Self {
        Self { index, generation }
    }
}

impl From<Handle> for [u32; 2] {
    fn from(handle: Handle) -> Self {
        [handle.index, handle.generation]
    }
}

/// Changes of a commit to the slots.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Commit {
    /// The new slot of each old slot; `u32::MAX` where its item was removed.
    pub slot_of_old: Vec<u32>,
    /// The new order version.
    pub order_version: u64,
}

pub(crate) const NO_SLOT: u32 = u32::MAX;

const NOTHING: Handle = Handle { index: NO_SLOT, generation: 0 };

/// Map between handles and slots. A look-up in either direction is O(1).
#[derive(Clone, Debug, Default)]
pub(super) struct Slots {
    /// One handle per slot; `NOTHING` in an empty slot.
    handles: Vec<Handle>,
    /// One entry per handle index: generation and slot.
    entries: Vec<(u32, u32)>,
    free: Vec<u32>,
    removed: u32,
    /// One bit a slot: there is something in it.
    present: Vec<u64>,
}

impl Slots {
    /// Makes the map of `handles`, one per slot. Their indices must be the numbers 0 to n − 1, each
    /// once, and their generations 0.
    pub(super) fn in_order(handles: Vec<Handle>) -> Self {
        let mut entries = vec![(0, NO_SLOT); handles.len()];
        (0..).zip(&handles).for_each(|(slot, handle)| entries[handle.index as usize].1 = slot);
        let present = all_of(handles.len());
        Self { handles, entries, present, ..Self::default() }
    }

    /// A handle for a new slot at the end; `None` if there are as many as there can be.
    pub(super) fn push(&mut self) -> Option<Handle> {
        let slot = self.len();
        if slot == NO_SLOT {
            return None;
        }
        let index = self.free.pop().unwrap_or_else(|| {
            self.entries.push((0, NO_SLOT));
            (self.entries.len() - 1) as u32
        });
        let entry = &mut self.entries[index as usize];
        entry.1 = slot;
        let handle = Handle { index, generation: entry.0 };
        self.handles.push(handle);
        self.present.resize(self.handles.len().div_ceil(64), 0);
        bits::set(&mut self.present, slot as usize, true);
        Some(handle)
    }

    /// Empties the slot of a handle, and returns it.
    pub(super) fn remove(&mut self, handle: Handle) -> Option<u32> {
        let slot = self.slot(handle)?;
        let entry = &mut self.entries[handle.index as usize];
        *entry = (entry.0.wrapping_add(1), NO_SLOT);
        self.free.push(handle.index);
        self.handles[slot as usize] = NOTHING;
        bits::set(&mut self.present, slot as usize, false);
        self.removed += 1;
        Some(slot)
    }

    pub(super) fn slot(&self, handle: Handle) -> Option<u32> {
        let &(generation, slot) = self.entries.get(handle.index as usize)?;
        (generation == handle.generation && slot != NO_SLOT).then_some(slot)
    }

    /// How many handles there ever were at once: their indices are below it.
    pub(super) fn index_count(&self) -> usize {
        self.entries.len()
    }

    /// The slot of the handle of an index that is not free.
    pub(super) fn slot_of_index(&self, index: usize) -> Option<usize> {
        self.entries.get(index).filter(|e| e.1 != NO_SLOT).map(|e| e.1 as usize)
    }

    pub(super) fn handle(&self, slot: u32) -> Option<Handle> {
        self.handles.get(slot as usize).copied().filter(|h| *h != NOTHING)
    }

    pub(super) fn len(&self) -> u32 {
        self.handles.len() as u32
    }

    pub(super) fn present(&self) -> &[u64] {
        &self.present
    }

    pub(super) fn removed(&self) -> u32 {
        self.removed
    }

    /// Puts what lies in slot `from[i]` into slot `to[i]`, for all i at once.
    pub(super) fn rearrange(&mut self, from: &[u32], to: &[u32]) {
        let moved: Vec<_> = from.iter().map(|&old| self.handles[old as usize]).collect();
        for (&slot, handle) in to.iter().zip(moved) {
            self.handles[slot as usize] = handle;
            bits::set(&mut self.present, slot as usize, handle != NOTHING);
            if handle != NOTHING {
                self.entries[handle.index as usize].1 = slot;
            }
        }
    }

    /// Keeps what lies in the slots `from`, which are all that are not empty, in this order.
    pub(super) fn gather(&mut self, from: &[u32]) {
        self.handles = from.iter().map(|&old| self.handles[old as usize]).collect();
        let handles = (0..).zip(&self.handles);
        handles.for_each(|(slot, handle)| self.entries[handle.index as usize].1 = slot);
        self.present = all_of(from.len());
        self.removed = 0;
    }
}

/// One bit for each of the first `len`.
fn all_of(len: usize) -> Vec<u64> {
    let mut present = vec![0; len.div_ceil(64)];
    bits::words_of(0..len).for_each(|(word, bits)| present[word] = bits);
    present
}
