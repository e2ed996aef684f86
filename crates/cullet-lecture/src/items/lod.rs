//! Levels of detail.

use crate::item::Item;

pub(super) const ITEMS: &[Item] = &[];
