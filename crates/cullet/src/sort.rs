//! Sorting by numbers.
//!
//! Each pair of a type and a comparison that `sort_unstable_by` is given compiles to two thousand
//! lines of LLVM IR, and the thirty of the engine were a seventh of its build. So what is sorted
//! has a number for a key, and one sort of numbers serves all.

use alloc::vec::Vec;

/// Memory for sorting: nothing is allocated once it has held as many items.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sorter {
    /// Key and place of each item.
    keys: Vec<u128>,
}

impl Sorter {
    /// Sorts by keys of at most 96 bits, the least first; items of one key stay in their order.
    pub(crate) fn sort<T>(&mut self, items: &mut [T], key: impl Fn(&T) -> u128) {
        self.note(items, key);
        self.keys.sort_unstable();
        self.arrange(items);
    }

    /// Puts the items of the `count` least keys first, and of those of one key the first ones; in
    /// no order on either side.
    ///
    /// # Panics
    /// If there are no more than `count`.
    pub(crate) fn split<T>(&mut self, items: &mut [T], count: usize, key: impl Fn(&T) -> u128) {
        self.note(items, key);
        self.keys.select_nth_unstable(count);
        self.arrange(items);
    }

    fn note<T>(&mut self, items: &[T], key: impl Fn(&T) -> u128) {
        self.keys.clear();
        for (place, item) in items.iter().enumerate() {
            let key = key(item);
            debug_assert!(key >> 96 == 0, "key {key:#x} has more than 96 bits");
            self.keys.push(key << 32 | place as u128);
        }
    }

    /// Moves each item to where its key is.
    fn arrange<T>(&mut self, items: &mut [T]) {
        for start in 0..items.len() {
            let mut at = start;
            // Along one cycle of places; each that is done refers to itself.
            loop {
                let from = self.keys[at] as u32 as usize;
                self.keys[at] = at as u128;
                if from == start {
                    break;
                }
                items.swap(at, from);
                at = from;
            }
        }
    }
}

/// Sorts as [`Sorter::sort`], with memory of its own.
pub(crate) fn sort_by_key<T>(items: &mut [T], key: impl Fn(&T) -> u128) {
    Sorter::default().sort(items, key);
}

/// Two numbers as a key: by the first, and of one first by the second.
pub(crate) fn pair(first: u32, second: u32) -> u128 {
    u128::from(u64::from(first) << 32 | u64::from(second))
}

/// A number in the order of [`f32::total_cmp`]; its complement is in the other.
pub(crate) fn of_f32(v: f32) -> u32 {
    let bits = v.to_bits();
    bits ^ if v.is_sign_negative() { u32::MAX } else { 1 << 31 }
}

/// A number in the order of [`f64::total_cmp`]; its complement is in the other.
pub(crate) fn of_f64(v: f64) -> u64 {
    let bits = v.to_bits();
    bits ^ if v.is_sign_negative() { u64::MAX } else { 1 << 63 }
}

#[cfg(test)]
mod tests {
    use cullet_testkit::Rng;

    use super::*;

    #[test]
    fn sorts_and_splits_as_a_stable_sort() {
        let mut rng = Rng(7);
        let mut sorter = Sorter::default();
        for len in [0, 1, 2, 3, 17, 100, 1000] {
            let items: Vec<(u32, usize)> = (0..len).map(|i| (rng.below(50) as u32, i)).collect();
            let mut expected = items.clone();
            expected.sort_by_key(|i| i.0);
            let mut sorted = items.clone();
            sorter.sort(&mut sorted, |i| u128::from(i.0));
            assert_eq!(sorted, expected);
            for count in [0, len / 2, len.saturating_sub(1)].into_iter().filter(|&c| c < len) {
                let mut parts = items.clone();
                sorter.split(&mut parts, count, |i| u128::from(i.0));
                let mut first = parts[..count].to_vec();
                first.sort_unstable();
                assert_eq!(first, expected[..count]);
            }
        }
    }

    #[test]
    fn numbers_of_floats_are_in_their_order() {
        let all =
            [f32::NEG_INFINITY, -1.5, -f32::MIN_POSITIVE, -0.0, 0.0, 1e-45, 2.0, f32::INFINITY];
        let all = [&[-f32::NAN][..], &all, &[f32::NAN]].concat();
        assert!(all.windows(2).all(|w| w[0].total_cmp(&w[1]).is_lt()));
        assert!(all.windows(2).all(|w| of_f32(w[0]) < of_f32(w[1])));
        assert!(all.windows(2).all(|w| of_f64(w[0].into()) < of_f64(w[1].into())));
    }
}
