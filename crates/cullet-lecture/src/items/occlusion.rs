//! What is hidden behind others, and systems that find it.

use crate::item::Item;

pub(super) const ITEMS: &[Item] = &[];
