//! All items, a file for each subject.

mod backface;
mod clipping;
mod clusters;
mod coherence;
mod culling;
mod frustum;
mod kinds;
mod lod;
mod masks;
mod occlusion;
mod pipeline;
mod sides;
mod small;
mod subject;
mod visibility;

use crate::lecture::item::Item;

/// The subjects, in the order of the numbers of their items.
const SUBJECTS: &[&[Item]] = &[
    pipeline::ITEMS,
    visibility::ITEMS,
    kinds::ITEMS,
    backface::ITEMS,
    masks::ITEMS,
    coherence::ITEMS,
    clusters::ITEMS,
    frustum::ITEMS,
    small::ITEMS,
    sides::ITEMS,
    occlusion::ITEMS,
    lod::ITEMS,
    culling::ITEMS,
    clipping::ITEMS,
];

/// All items, ascending by number.
pub fn items() -> impl Iterator<Item = &'static Item> {
    SUBJECTS.iter().flat_map(|subject| subject.iter())
}
