//! Sides of triangles, and the switches of graphics interfaces.

use crate::item::Item;

pub(super) const ITEMS: &[Item] = &[];
