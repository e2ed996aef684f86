//! What visibility is: classes of problems, sets, and what is enough.

use crate::item::Item;

pub(super) const ITEMS: &[Item] = &[];
