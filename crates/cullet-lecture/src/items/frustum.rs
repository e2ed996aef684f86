//! The frustum, bounding volumes and hierarchies.

use crate::item::Item;

pub(super) const ITEMS: &[Item] = &[];
