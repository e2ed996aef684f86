//! Why frames are slow: the pipeline and its slowest link.

use crate::item::Item;

pub(super) const ITEMS: &[Item] = &[];
