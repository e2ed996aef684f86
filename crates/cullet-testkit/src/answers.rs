//! Answers, and what they say, as plain sets.

use std::collections::BTreeSet;

use cullet::{Culler, View, ViewState, Visible};
use cullet_cells::InCells;

/// The answer of a culler that remembers nothing.
pub fn cull<'a>(culler: &Culler, world: impl Into<InCells<'a>>, view: &View) -> Visible {
    let mut result = Visible::default();
    world.into().cull(culler, view, &mut ViewState::default(), &mut result);
    result
}

/// The slots of an answer, in order: whole ones and those of which parts are left.
pub fn slots(v: &Visible) -> Vec<u32> {
    let mut slots: Vec<u32> = v.whole.iter().flat_map(|r| r.first..r.first + r.count).collect();
    let mut partial: Vec<u32> = v.partial.iter().map(|d| d.slot).collect();
    partial.dedup();
    slots.extend(partial);
    slots.sort_unstable();
    slots
}

/// Slots and triangles that are listed, as they come.
pub fn listed_in_order(v: &Visible) -> Vec<(u32, u32)> {
    v.triangle_ranges
        .iter()
        .flat_map(|r| {
            v.triangles[r.first as usize..(r.first + r.count) as usize].iter().map(|&t| (r.slot, t))
        })
        .collect()
}

/// Slots and triangles that are listed.
pub fn listed(v: &Visible) -> BTreeSet<(u32, u32)> {
    listed_in_order(v).into_iter().collect()
}
