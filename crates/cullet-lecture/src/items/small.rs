//! What is too small, and what has no area.

use crate::item::Item;

pub(super) const ITEMS: &[Item] = &[];
