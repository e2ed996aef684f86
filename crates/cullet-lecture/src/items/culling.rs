//! Culling by planes, boxes and trees, as the third lecture has it.

use crate::item::Item;

pub(super) const ITEMS: &[Item] = &[];
