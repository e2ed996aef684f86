//! Frames before, curved surfaces, hardware and scenes that move: what the paper leaves to others.

use crate::item::Item;

pub(super) const ITEMS: &[Item] = &[];
