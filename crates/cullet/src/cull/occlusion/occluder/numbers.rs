//! Map from numbers to numbers.

use alloc::vec::Vec;

use crate::sort::sort_by_key;

/// Numbers under numbers, made at once: pairs in the order of their keys. One kind of map for all,
/// since the code of each kind is as much as that of a stage.
pub(super) struct Numbers(Vec<(u64, u32)>);

impl Numbers {
    /// Makes the map of `pairs`; of those of one key the last is kept. O(n log n).
    pub(super) fn new(mut pairs: Vec<(u64, u32)>) -> Self {
        sort_by_key(&mut pairs, |pair| pair.0.into());
        pairs.dedup_by(|later, kept| {
            let is_same = later.0 == kept.0;
            if is_same {
                kept.1 = later.1;
            }
            is_same
        });
        Self(pairs)
    }

    /// Returns the number of keys.
    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    /// Returns the number under `key`. O(log n).
    pub(super) fn get(&self, key: u64) -> Option<u32> {
        let at = self.0.binary_search_by_key(&key, |pair| pair.0).ok()?;
        Some(self.0[at].1)
    }

    /// Returns the pairs, by key.
    pub(super) fn pairs(&self) -> &[(u64, u32)] {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec;

    use super::*;

    #[test]
    fn the_last_of_a_key_is_kept() {
        let map = Numbers::new(vec![(7, 1), (1 << 60, 2), (7, 3), (0, 4), (7, 5)]);
        assert_eq!(map.pairs(), [(0, 4), (7, 5), (1 << 60, 2)]);
        assert_eq!((map.len(), map.get(7), map.get(8)), (3, Some(5), None));
    }
}
