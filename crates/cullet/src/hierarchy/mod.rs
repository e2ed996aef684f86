//! Bounding-volume hierarchies that stay in plain arrays.
//!
//! [`spatial_order`] sorts boxes along a curve through space; [`Nodes`] puts sixteen-fold nodes
//! over a batch of boxes, implicit, without a pointer; [`Hierarchy`] keeps both for items that
//! come, go and move, under stable handles. What walks them for a view is
//! [`cull::frustum::tree`](crate::cull::frustum::tree).
//!
//! The nodes always hold what is below them, so a walk is right at any time. Moving an item lets
//! the nodes above it grow; [`Hierarchy::refit`] fits them again, [`Hierarchy::commit`] sorts
//! everything anew, [`Hierarchy::commit_slice`] a little of it, so that a world in motion never
//! waits for a commit.

mod classes;
mod nodes;
mod order;
mod sizes;
mod slots;

pub use nodes::{NodeStatistics, Nodes, NodesError};
pub use order::spatial_order;
pub(crate) use sizes::Span;
pub(crate) use slots::NO_SLOT;
pub use slots::{Commit, Handle};

use alloc::vec;
use alloc::vec::Vec;

use thiserror::Error;

use crate::Simd;
use crate::bits;
use crate::bounds::{Aabb, Boxes, LANES};
use crate::sort::sort;
use order::Orderer;
use slots::Slots;

/// Why a hierarchy refuses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum HierarchyError {
    /// The handle's item was removed, or the handle is of another hierarchy.
    #[error("handle {0:?} names nothing in this hierarchy")]
    NoItem(Handle),
    /// Slots are u32.
    #[error("a hierarchy holds at most {0} items")]
    Full(u32),
}

/// Boxes in dense slots under stable handles, with nodes over them.
///
/// An item's slot changes only in [`commit`](Self::commit) and
/// [`commit_slice`](Self::commit_slice). A removed item leaves an empty slot until a commit. A box
/// that is not finite is everywhere, and so are the nodes above it; an empty one is nowhere.
#[derive(Clone, Debug)]
pub struct Hierarchy {
    simd: Simd,
    boxes: Boxes,
    nodes: Nodes,
    slots: Slots,
    /// Blocks of sixteen whose nodes may be larger than they need be.
    loose: Vec<u64>,
    order_version: u64,
    change_version: u64,
    orderer: Orderer,
    /// From this slot on lies what moves: see [`commit_parts`](Self::commit_parts).
    first_moving: usize,
    /// The first key of each window of those slots, at the last commit.
    windows: Vec<u32>,
    next_window: usize,
}

/// Slots that [`Hierarchy::commit_slice`] sorts together with those that they exchange items with.
const WINDOW: usize = 1024;
/// How many windows exchange items at once.
const EXCHANGE: usize = 4;
/// Nodes are fitted one by one where fewer than one in so many blocks of boxes were written.
const FEW: usize = 2;

impl Default for Hierarchy {
    fn default() -> Self {
        Self {
            simd: Simd::best(),
            boxes: Boxes::new(),
            nodes: Nodes::default(),
            slots: Slots::default(),
            loose: Vec::new(),
            order_version: 0,
            change_version: 0,
            orderer: Orderer::default(),
            first_moving: 0,
            windows: Vec::new(),
            next_window: 0,
        }
    }
}

impl Hierarchy {
    /// Over nothing.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Builds a hierarchy over `boxes`, sorted by [`spatial_order`]. The handle of `boxes[i]` is
    /// `handles[i]`. O(n).
    ///
    /// # Errors
    /// If there are more boxes than slots.
    pub fn build(boxes: &[Aabb]) -> Result<(Self, Vec<Handle>), HierarchyError> {
        let count = u32::try_from(boxes.len()).map_err(|_| HierarchyError::Full(NO_SLOT))?;
        let handle = |index| Handle { index, generation: 0 };
        let mut h = Self::new();
        let mut order = Vec::new();
        h.orderer.order(boxes.len(), |i| boxes[i], &mut order);
        h.orderer.forget_keys();
        h.boxes.gather(h.simd, boxes, &order);
        h.slots = Slots::in_order(order.into_iter().map(handle).collect());
        h.settle(0);
        Ok((h, (0..count).map(handle).collect()))
    }

    /// Adds an item, in a new slot at the end. It lies under no node until the next commit: walks
    /// take such items one by one.
    ///
    /// # Errors
    /// If there are as many as there can be.
    pub fn insert(&mut self, bounds: &Aabb) -> Result<Handle, HierarchyError> {
        let handle = self.slots.push().ok_or(HierarchyError::Full(NO_SLOT))?;
        self.change_version += 1;
        self.boxes.push(bounds);
        Ok(handle)
    }

    /// Removes an item. Its slot stays empty until a commit.
    ///
    /// # Errors
    /// If the handle names nothing.
    pub fn remove(&mut self, handle: Handle) -> Result<(), HierarchyError> {
        let slot = self.slots.remove(handle).ok_or(HierarchyError::NoItem(handle))?;
        self.set_slot(slot as usize, &Aabb::EMPTY);
        Ok(())
    }

    /// Moves an item: gives it other bounds. The nodes above grow as far as they must.
    ///
    /// # Errors
    /// If the handle names nothing.
    pub fn set_bounds(&mut self, handle: Handle, bounds: &Aabb) -> Result<(), HierarchyError> {
        let slot = self.slot(handle)?;
        self.set_slot(slot as usize, bounds);
        Ok(())
    }

    /// [`set_bounds`](Self::set_bounds) by slot.
    ///
    /// # Panics
    /// If there is no such slot.
    pub(crate) fn set_slot(&mut self, slot: usize, bounds: &Aabb) {
        self.change_version += 1;
        self.boxes.set(slot, bounds);
        self.nodes.grow(&self.boxes, slot);
        if slot < self.nodes.len() {
            bits::set(&mut self.loose, slot / LANES, true);
        }
    }

    /// Replaces a box and nothing else: [`refit_written`](Self::refit_written) must follow.
    pub(crate) fn write(&mut self, slot: usize, bounds: &Aabb) {
        self.boxes.set(slot, bounds);
        if slot < self.nodes.len() {
            bits::set(&mut self.loose, slot / LANES, true);
        }
    }

    /// Fits the nodes above all boxes that were written: at the cost of those where they are few,
    /// and else all nodes at once, which streams.
    pub(crate) fn refit_written(&mut self) {
        self.change_version += 1;
        let blocks = self.loose.iter().map(|word| word.count_ones() as usize).sum::<usize>();
        if blocks * LANES * FEW < self.nodes.len() {
            self.refit();
        } else {
            self.nodes.refit(self.simd, &self.boxes);
            self.loose.fill(0);
        }
    }

    /// Calls `write` with the boxes of all slots, to be written in place, and then fits the nodes
    /// above those that were written, also if `write` panics. The cost is that of what was written,
    /// and at most O(n), once through all nodes.
    pub fn write_bounds<R>(&mut self, write: impl FnOnce(&mut BoundsWriter<'_>) -> R) -> R {
        // Lent and never given away: a guard that is dropped by its owner could be leaked, and
        // nodes that do not hold their boxes would cull what is visible.
        write(&mut BoundsWriter { hierarchy: self })
    }

    /// Fits the nodes above all boxes that were set since the last time.
    pub fn refit(&mut self) {
        self.nodes.refit_blocks(self.simd, &self.boxes, &mut self.loose);
    }

    /// Sorts everything anew and closes the gaps that removed items left. O(items).
    pub fn commit(&mut self) -> Commit {
        self.commit_parts(|_| false)
    }

    /// [`commit`](Self::commit) with the slots of which `last` is true after all others, each kind
    /// sorted for itself: what moves shares no node with what stands.
    pub fn commit_parts(&mut self, last: impl Fn(u32) -> bool) -> Commit {
        // Of ten million items each list takes 40 MB: none is larger, or kept for longer, than it
        // is needed.
        let (mut standing, mut moving) = (Vec::with_capacity(self.len() as usize), Vec::new());
        for slot in bits::in_words(self.slots.present()).map(|slot| slot as u32) {
            if last(slot) { moving.push(slot) } else { standing.push(slot) }
        }
        let first_moving = if moving.is_empty() { 0 } else { standing.len() };
        let mut from = Vec::with_capacity(standing.len() + moving.len());
        let mut order = Vec::new();
        // Moving items come last, and so their curve is the one that is kept.
        for part in [standing, moving].into_iter().filter(|p| !p.is_empty()) {
            self.orderer.order(part.len(), |i| self.boxes.get(part[i] as usize), &mut order);
            from.extend(order.iter().map(|&i| part[i as usize]));
        }
        drop(order);
        self.orderer.forget_keys();
        let before = self.boxes.len();
        {
            let staged: Vec<_> = (0..before).map(|slot| self.boxes.get(slot)).collect();
            self.boxes.gather_stored(&staged, &from);
        }
        self.slots.gather(&from);
        let mut slot_of_old = vec![NO_SLOT; before];
        (0..).zip(&from).for_each(|(new, &old)| slot_of_old[old as usize] = new);
        drop(from);
        self.settle(first_moving);
        self.order_version += 1;
        self.change_version += 1;
        Commit { slot_of_old, order_version: self.order_version }
    }

    /// Nodes over the boxes in the order in which they lie, as after a [`commit`](Self::commit)
    /// that found nothing to sort: for items that were inserted in the order of an earlier commit.
    /// Any other order is right too, but walks are slow. Empty slots stay, and
    /// [`commit_slice`](Self::commit_slice) does nothing until the next commit. O(items), but it
    /// streams through them once.
    pub fn commit_in_order(&mut self) {
        self.settle(self.boxes.len());
        self.order_version += 1;
        self.change_version += 1;
    }

    /// Nodes and the rest for boxes that were just sorted.
    fn settle(&mut self, first_moving: usize) {
        self.loose.clear();
        self.loose.resize(self.boxes.len().div_ceil(LANES * 64), 0);
        self.nodes.rebuild(self.simd, &self.boxes);
        self.first_moving = first_moving;
        let firsts = (first_moving..self.boxes.len()).step_by(WINDOW);
        self.windows = firsts.map(|slot| self.orderer.key(&self.boxes.get(slot))).collect();
        self.next_window = 0;
    }

    /// Sorts a little of what moves (all, if nothing was said to): takes the next window of 1024
    /// slots, and up to three others to which most items that left it belong, and sorts them
    /// together. Call it some times a frame in a world in motion: items that leave their window
    /// then come home. Returns the slots that changed, as old and new.
    ///
    /// Empty slots stay, at the end of their windows; only [`commit`](Self::commit) closes them.
    pub fn commit_slice(&mut self) -> Vec<[u32; 2]> {
        let count = self.windows.len();
        if count == 0 {
            return Vec::new();
        }
        let home = self.next_window % count;
        self.next_window = home + 1;
        let (start, end) = (self.first_moving, self.nodes.len());
        let slots_of = |w: usize| start + w * WINDOW..(start + (w + 1) * WINDOW).min(end);
        let wanted = |slot: usize| {
            let key = self.orderer.key(&self.boxes.get(slot));
            self.windows.partition_point(|&first| first <= key).saturating_sub(1) as u32
        };
        let mut away: Vec<u32> =
            slots_of(home).map(wanted).filter(|&w| w as usize != home).collect();
        sort(&mut away);
        // How many want to go where.
        let mut partners: Vec<u64> = away
            .chunk_by(|a, b| a == b)
            .map(|run| (run.len() as u64) << 32 | u64::from(run[0]))
            .collect();
        sort(&mut partners);
        let most = partners.iter().rev().take(EXCHANGE - 1);
        let mut windows: Vec<_> = most.map(|&partner| partner as u32).collect();
        windows.push(home as u32);
        sort(&mut windows);
        let to: Vec<_> =
            windows.iter().flat_map(|&w| slots_of(w as usize)).map(|s| s as u32).collect();
        let staged: Vec<_> = to.iter().map(|&s| self.boxes.get(s as usize)).collect();
        let mut order = Vec::new();
        self.orderer.order_again(to.len(), |i| staged[i], &mut order);
        let from: Vec<_> = order.iter().map(|&i| to[i as usize]).collect();
        self.slots.rearrange(&from, &to);
        self.boxes.scatter_stored(&staged, &order, &to);
        for &w in &windows {
            self.nodes.refit_range(self.simd, &self.boxes, slots_of(w as usize));
        }
        let moves = from.iter().zip(&to).filter(|(a, b)| a != b).map(|(&a, &b)| [a, b]);
        let moves: Vec<_> = moves.collect();
        self.order_version += u64::from(!moves.is_empty());
        self.change_version += 1;
        moves
    }

    /// The slot of an item.
    ///
    /// # Errors
    /// If the handle names nothing.
    pub fn slot(&self, handle: Handle) -> Result<u32, HierarchyError> {
        self.slots.slot(handle).ok_or(HierarchyError::NoItem(handle))
    }

    /// No handle has an index that is not below it.
    pub(crate) fn index_count(&self) -> usize {
        self.slots.index_count()
    }

    /// The slot of the item whose handle has an index; `None` where there is none.
    pub(crate) fn slot_of_index(&self, index: usize) -> Option<usize> {
        self.slots.slot_of_index(index)
    }

    /// The handle of the item in a slot; `None` for an empty slot or one beyond the last.
    #[must_use]
    pub fn handle(&self, slot: u32) -> Option<Handle> {
        self.slots.handle(slot)
    }

    /// How many slots there are, empty ones included.
    #[must_use]
    pub fn slot_count(&self) -> u32 {
        self.slots.len()
    }

    /// One bit a slot: there is something in it.
    #[must_use]
    pub fn present(&self) -> &[u64] {
        self.slots.present()
    }

    /// Number of items.
    #[must_use]
    pub fn len(&self) -> u32 {
        self.slots.len() - self.slots.removed()
    }

    /// Whether there is nothing.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Rises whenever slots were permuted.
    #[must_use]
    pub fn order_version(&self) -> u64 {
        self.order_version
    }

    /// Rises whenever a box or the order of the slots may have changed: what was found out about
    /// boxes under one number holds as long as the number is the same.
    #[must_use]
    pub fn change_version(&self) -> u64 {
        self.change_version
    }

    /// The boxes by slot.
    #[must_use]
    pub fn boxes(&self) -> &Boxes {
        &self.boxes
    }

    /// The nodes over them.
    #[must_use]
    pub fn nodes(&self) -> &Nodes {
        &self.nodes
    }

    /// Checks everything that must hold, and measures the tree. O(items).
    ///
    /// # Errors
    /// If a node does not hold its children.
    pub fn validate(&self) -> Result<NodeStatistics, NodesError> {
        self.nodes.validate(&self.boxes)
    }
}

/// The boxes of a [`Hierarchy`], to be written in place: see [`Hierarchy::write_bounds`].
#[derive(Debug)]
pub struct BoundsWriter<'a> {
    hierarchy: &'a mut Hierarchy,
}

impl BoundsWriter<'_> {
    /// Replaces the box of a slot. The slot of a removed item stays empty.
    ///
    /// # Panics
    /// If there is no such slot.
    pub fn set(&mut self, slot: u32, bounds: &Aabb) {
        let count = self.hierarchy.slot_count();
        assert!(slot < count, "slot {slot} of {count}");
        if bits::get(self.hierarchy.present(), slot as usize) {
            self.hierarchy.write(slot as usize, bounds);
        }
    }
}

impl Drop for BoundsWriter<'_> {
    fn drop(&mut self) {
        self.hierarchy.refit_written();
    }
}
