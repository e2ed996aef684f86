//! Sorting by numbers, compiled once for all that is not sorted in a hot loop.

/// A number for each f64, ascending as [`f64::total_cmp`] does.
pub(crate) fn bits(v: f64) -> u64 {
    let bits = v.to_bits();
    // Negative ones descend as their bits ascend.
    if bits >> 63 == 1 { !bits } else { bits | 1 << 63 }
}

/// One number of two, the first of which counts more.
pub(crate) fn pair(high: u32, low: u32) -> u64 {
    u64::from(high) << 32 | u64::from(low)
}

/// Copies of `items`, ascending by `key`; equals keep their order. At most 2³² items.
pub(crate) fn sorted_by<T: Copy>(items: &[T], key: impl Fn(&T) -> u64) -> Vec<T> {
    let mut keys: Vec<(u64, u32)> = items.iter().map(key).zip(0..).collect();
    sort_numbered(&mut keys);
    keys.iter().map(|&(_, i)| items[i as usize]).collect()
}

/// Sorts numbers that come with others.
#[inline(never)]
pub(crate) fn sort_numbered(keys: &mut [(u64, u32)]) {
    keys.sort_unstable();
}

/// Sorts numbers.
#[inline(never)]
pub(crate) fn sort(keys: &mut [u64]) {
    keys.sort_unstable();
}

/// The largest number but for so many, fewer than there are; puts them into another order.
pub(crate) fn largest_but(n: usize, of: &mut [f32]) -> f32 {
    let at = of.len() - 1 - n;
    *of.select_nth_unstable_by(at, f32::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_ascend_as_numbers_do_and_equals_keep_their_order() {
        let ascending =
            [-f64::NAN, f64::NEG_INFINITY, -1.5, -1e-300, -0.0, 0.0, 1e-300, 2.0, f64::NAN];
        assert!(ascending.windows(2).all(|w| bits(w[0]) < bits(w[1])));
        assert_eq!(bits(1.5), bits(1.5));
        let items = [(3, 'a'), (1, 'b'), (3, 'c'), (1, 'd')];
        let sorted = sorted_by(&items, |item| item.0);
        assert_eq!(sorted, [(1, 'b'), (1, 'd'), (3, 'a'), (3, 'c')]);
        assert_eq!([0, 1, 2].map(|n| largest_but(n, &mut [2.0, 9.0, 5.0])), [9.0, 5.0, 2.0]);
        assert!(pair(1, 0) > pair(0, u32::MAX) && pair(1, 2) > pair(1, 1));
    }
}
