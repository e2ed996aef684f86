//! Clusters that face away as a whole.

use crate::item::Item;

pub(super) const ITEMS: &[Item] = &[];
