//! Normal masks.

use crate::item::Item;

pub(super) const ITEMS: &[Item] = &[];
