//! Sorting by numbers.
//!
//! Each pair of a type and a comparison that `sort_unstable_by` is given compiles to two thousand
//! lines of LLVM IR, and the thirty of the engine were a seventh of its build. So what is sorted
//! has a number for a key, and one sort of numbers serves all. That sort is a short one, since the
//! standard library's takes 7 kB of WebAssembly for each type.

use alloc::vec::Vec;

/// Ranges of at most this length are sorted by insertion.
const SHORT: usize = 16;
/// Fewer keys than this are not sorted by digits, each of which takes 256 steps.
const FEW: usize = 160;

/// Sorts `items` ascending. O(n log n), in place.
pub(crate) fn sort<T: Copy + Ord>(items: &mut [T]) {
    sort_by(items, &itself);
}

/// Returns `item`: one function, so that sorting and selecting share their code.
fn itself<T: Copy>(item: &T) -> T {
    *item
}

/// Sorts `items` by keys, ascending, those of one key in any order. O(n log n) keys, in place.
#[inline(never)]
pub(crate) fn sort_by<T: Copy, K: Copy + Ord>(mut items: &mut [T], key: &impl Fn(&T) -> K) {
    let mut rounds = rounds(items.len());
    while items.len() > SHORT {
        if rounds == 0 {
            return heap_sort(items, key);
        }
        rounds -= 1;
        let (low, _, high) = part(items, key);
        // The shorter side by recursion, so that the stack stays at a logarithm.
        let (short, long) = if low.len() < high.len() { (low, high) } else { (high, low) };
        sort_by(short, key);
        items = long;
    }
    for end in 1..items.len() {
        let item = items[end];
        let (own, mut at) = (key(&item), end);
        while at > 0 && own < key(&items[at - 1]) {
            items[at] = items[at - 1];
            at -= 1;
        }
        items[at] = item;
    }
}

/// Puts the items of the `count` least keys first, in no order on either side; keys are unique.
/// O(n log n) at the worst, O(n) as a rule.
#[inline(never)]
pub(crate) fn select_by<T: Copy, K: Copy + Ord>(
    mut items: &mut [T],
    mut count: usize,
    key: &impl Fn(&T) -> K,
) {
    let mut rounds = rounds(items.len());
    while items.len() > SHORT && rounds > 0 {
        rounds -= 1;
        let (low, same, high) = part(items, key);
        if count <= low.len() {
            items = low;
        } else if count <= low.len() + same {
            return;
        } else {
            count -= low.len() + same;
            items = high;
        }
    }
    if count < items.len() {
        sort_by(items, key);
    }
}

/// Returns the number of divisions after which their pivots were chosen too badly.
fn rounds(len: usize) -> u32 {
    2 * (len | 1).ilog2()
}

/// Divides at a pivot: the items below it, and the items above with those equal to it; where none
/// is below, the number of the equal ones lies between.
fn part<'a, T, K: Copy + Ord>(
    items: &'a mut [T],
    key: &impl Fn(&T) -> K,
) -> (&'a mut [T], usize, &'a mut [T]) {
    let len = items.len();
    let at = |eighth: usize| key(&items[len / 8 * eighth]);
    let middle = |a: K, b: K, c: K| a.min(b).max(a.max(b).min(c));
    let pivot = middle(
        middle(at(0), at(1), at(2)),
        middle(at(3), at(4), at(5)),
        middle(at(6), at(7), key(&items[len - 1])),
    );
    let low = put_first(items, |item| key(item) < pivot);
    // What is above the pivot with its equals is shorter by what is below. Only where nothing is,
    // the equals are taken out, so that many of one key end soon.
    let same = if low == 0 { put_first(items, |item| key(item) <= pivot) } else { 0 };
    let (low, rest) = items.split_at_mut(low);
    (low, same, &mut rest[same..])
}

/// Moves the items that are `first` to the front, without a branch on it; returns their number.
fn put_first<T>(items: &mut [T], first: impl Fn(&T) -> bool) -> usize {
    let mut count = 0;
    for i in 0..items.len() {
        let is_first = first(&items[i]);
        items.swap(count, i);
        count += usize::from(is_first);
    }
    count
}

/// Sorts `keys` whose lower 32 bits ascend: by the 96 bits above, eight at a time from the lowest
/// on. O(n), and memory for as many keys in `other`.
#[inline(never)]
pub(crate) fn sort_above(keys: &mut Vec<u128>, other: &mut Vec<u128>) {
    if keys.len() < FEW {
        return sort(keys);
    }
    let varying = keys.iter().fold(0, |varying, key| varying | (key ^ keys[0]));
    other.resize(keys.len(), 0);
    for byte in (4..16).filter(|byte| varying >> (byte * 8) & 0xff != 0) {
        // A shift of half a key is one instruction.
        let digit = |key: u128| {
            let half = if byte < 8 { key as u64 } else { (key >> 64) as u64 };
            usize::from((half >> (byte % 8 * 8)) as u8)
        };
        let mut places = [0_u32; 256];
        keys.iter().for_each(|&key| places[digit(key)] += 1);
        let mut sum = 0;
        places.iter_mut().for_each(|place| sum += core::mem::replace(place, sum));
        for &key in &*keys {
            let place = &mut places[digit(key)];
            other[*place as usize] = key;
            *place += 1;
        }
        core::mem::swap(keys, other);
    }
}

fn heap_sort<T, K: Copy + Ord>(items: &mut [T], key: &impl Fn(&T) -> K) {
    let len = items.len();
    // First the heap is built, from its lowest parents up; then its greatest goes to the end.
    for step in 0..len / 2 + len {
        let (mut at, end) = if step < len / 2 {
            (len / 2 - 1 - step, len)
        } else {
            let end = len - 1 - (step - len / 2);
            items.swap(0, end);
            (0, end)
        };
        while at * 2 + 1 < end {
            let left = at * 2 + 1;
            let is_right = left + 1 < end && key(&items[left]) < key(&items[left + 1]);
            let child = left + usize::from(is_right);
            if key(&items[child]) <= key(&items[at]) {
                break;
            }
            items.swap(at, child);
            at = child;
        }
    }
}

/// Memory for sorting: nothing is allocated once it has held as many items.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sorter {
    /// Key and place of each item.
    keys: Vec<u128>,
    other: Vec<u128>,
}

impl Sorter {
    /// Sorts by keys of at most 96 bits, the least first; items of one key stay in their order.
    pub(crate) fn sort<T>(&mut self, items: &mut [T], key: impl Fn(&T) -> u128) {
        self.note(items, key);
        sort_above(&mut self.keys, &mut self.other);
        self.arrange(items);
    }

    /// Sorts by seven numbers, the first before the second and so on; items of the same numbers
    /// stay in their order. Three passes of [`sort`](Self::sort), the last numbers first.
    pub(crate) fn sort_by_seven<T>(&mut self, items: &mut [T], numbers: impl Fn(&T) -> [u32; 7]) {
        for some in [4..7, 1..4, 0..1] {
            self.sort(items, |item| {
                numbers(item)[some.clone()].iter().fold(0, |key, &n| key << 32 | u128::from(n))
            });
        }
    }

    /// Puts the items of the `count` least keys first, and of those of one key the first ones; in
    /// no order on either side.
    pub(crate) fn split<T>(&mut self, items: &mut [T], count: usize, key: impl Fn(&T) -> u128) {
        self.note(items, key);
        select_by(&mut self.keys, count, &itself);
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
    extern crate std;

    use alloc::vec;
    use core::cell::RefCell;

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
    fn sorts_as_the_standard_library() {
        let mut rng = Rng(11);
        for len in [0, 1, 2, 15, 16, 17, 18, 64, 100, 1000, 5000] {
            for kinds in [1, 2, 30, u64::MAX] {
                let mut random: Vec<u64> = (0..len).map(|_| rng.bits() % kinds).collect();
                for shape in 0..4 {
                    let mut expected = random.clone();
                    expected.sort_unstable();
                    let mut heap = random.clone();
                    heap_sort(&mut heap, &|&v| v);
                    assert_eq!(heap, expected);
                    let mut sorted = random.clone();
                    sort(&mut sorted);
                    assert_eq!(sorted, expected);
                    // Next in order, then backwards, then in two halves.
                    random = expected;
                    match shape {
                        1 => random.reverse(),
                        2 => random.rotate_left(len / 2),
                        _ => {}
                    }
                }
            }
        }
    }

    #[test]
    fn keys_of_96_bits_are_sorted_by_all_of_them() {
        let mut rng = Rng(14);
        let mut sorter = Sorter::default();
        // Keys that differ in some bytes alone, too.
        for mask in [u128::MAX >> 32, 0xff, 0xff << 88, 0xf00f << 24 | 1 << 60] {
            for len in [FEW - 1, FEW, 3000, 500] {
                let wide = |rng: &mut Rng| u128::from(rng.bits()) << 32 ^ u128::from(rng.bits());
                let mut items: Vec<(u128, usize)> =
                    (0..len).map(|place| (wide(&mut rng) & mask, place)).collect();
                let mut expected = items.clone();
                expected.sort_by_key(|item| item.0);
                sorter.sort(&mut items, |item| item.0);
                assert_eq!(items, expected, "{mask:x}");
            }
        }
    }

    #[test]
    fn sorts_by_seven_numbers_as_by_a_tuple() {
        let mut rng = Rng(13);
        let mut items: Vec<[u32; 7]> = (0..500)
            .map(|_| [(); 7].map(|()| if rng.below(2) == 0 { 0 } else { rng.bits() as u32 }))
            .collect();
        let mut expected = items.clone();
        expected.sort_unstable();
        Sorter::default().sort_by_seven(&mut items, |&item| item);
        assert_eq!(items, expected);
    }

    #[test]
    fn selects_the_least() {
        let mut rng = Rng(12);
        for len in [1, 16, 17, 100, 3000] {
            let items: Vec<u64> = (0..len).map(|i| rng.below(1 << 20) << 32 | i).collect();
            let mut expected = items.clone();
            expected.sort_unstable();
            for count in [0, 1, len / 3, len - 1, len].map(|count| count as usize) {
                let mut parts = items.clone();
                select_by(&mut parts, count, &|&v| v);
                parts[..count].sort_unstable();
                parts[count..].sort_unstable();
                assert_eq!(parts, expected);
            }
        }
    }

    /// The adversary of `McIlroy` (*A Killer Adversary for Quicksort*, 1999): it gives numbers to
    /// keys when they are compared, so that each pivot becomes one of the least.
    struct Adversary {
        numbers: Vec<u32>,
        given: u32,
        pivot: usize,
        comparisons: u32,
    }

    std::thread_local! {
        static ADVERSARY: RefCell<Adversary> = const {
            RefCell::new(Adversary { numbers: Vec::new(), given: 0, pivot: 0, comparisons: 0 })
        };
    }

    #[derive(Clone, Copy, PartialEq, Eq)]
    struct Gas(usize);

    impl Ord for Gas {
        fn cmp(&self, other: &Self) -> core::cmp::Ordering {
            ADVERSARY.with_borrow_mut(|game| {
                game.comparisons += 1;
                let (a, b) = (self.0, other.0);
                if game.numbers[a] == u32::MAX && game.numbers[b] == u32::MAX {
                    let frozen = if a == game.pivot { a } else { b };
                    game.numbers[frozen] = game.given;
                    game.given += 1;
                }
                if game.numbers[a] == u32::MAX {
                    game.pivot = a;
                } else if game.numbers[b] == u32::MAX {
                    game.pivot = b;
                }
                game.numbers[a].cmp(&game.numbers[b])
            })
        }
    }

    impl PartialOrd for Gas {
        fn partial_cmp(&self, other: &Self) -> Option<core::cmp::Ordering> {
            Some(self.cmp(other))
        }
    }

    #[test]
    fn no_order_takes_the_square_of_its_length() {
        let len = 20_000;
        let play = |with: &dyn Fn(&mut [usize])| {
            ADVERSARY.with_borrow_mut(|game| {
                game.numbers = vec![u32::MAX; len];
                (game.given, game.pivot, game.comparisons) = (0, 0, 0);
            });
            with(&mut (0..len).collect::<Vec<_>>());
            let comparisons = ADVERSARY.with_borrow(|game| game.comparisons);
            // 14 is the logarithm of the length.
            assert!(comparisons < len as u32 * 14 * 10, "{comparisons} comparisons");
        };
        play(&|items| sort_by(items, &|&item| Gas(item)));
        play(&|items| select_by(items, len / 2, &|&item| Gas(item)));
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
