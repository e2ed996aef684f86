//! The kinds of culling, at a glance.

use crate::item::Item;

pub(super) const ITEMS: &[Item] = &[];
