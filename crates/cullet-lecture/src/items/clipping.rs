//! Clipping lines, polygons and triangles.

use crate::item::Item;

pub(super) const ITEMS: &[Item] = &[];
