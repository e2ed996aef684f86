//! Bits and lists of one view: by the CPU, and compared.

use std::ops::Range;

use cullet_gpu::Lanes;

/// Lists of a view of a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Lists {
    /// A bit a slot, lowest first.
    pub(crate) bits: Vec<u32>,
    /// Slots of each bucket, in three lists: of all, of those seen before, of those that are new.
    pub(crate) lists: [Vec<Vec<u32>>; 3],
}

/// Bits and lists of slots, made by the CPU: slow and obvious.
pub(crate) fn lists_ref(slots: &[u32], seen: &[u32], lanes: &Lanes) -> Lists {
    let mut bits = vec![0; seen.len()];
    slots.iter().for_each(|slot| bits[*slot as usize / 32] |= 1 << (slot % 32));
    let has = |bits: &[u32], slot: u32| bits[slot as usize / 32] >> (slot % 32) & 1 != 0;
    let list = |is_listed: &dyn Fn(u32) -> bool| {
        let of_lanes = |range: &Range<u32>| {
            let own = &lanes.slots()[range.start as usize..range.end as usize];
            own.iter().copied().filter(|slot| has(&bits, *slot) && is_listed(*slot)).collect()
        };
        lanes.buckets().iter().map(|bucket| of_lanes(&bucket.lanes)).collect()
    };
    let lists = [list(&|_| true), list(&|slot| has(seen, slot)), list(&|slot| !has(seen, slot))];
    Lists { bits, lists }
}

/// Returns in words how the device's lists differ.
pub(crate) fn difference(cpu: &Lists, device: &Lists) -> Option<String> {
    if cpu.bits != device.bits {
        let other = cpu.bits.iter().zip(&device.bits).filter(|(a, b)| a != b).count();
        return Some(format!("{other} of {} words of bits", cpu.bits.len()));
    }
    let lists = cpu.lists.iter().zip(&device.lists);
    ["all", "those seen before", "the new ones"].iter().zip(lists).find_map(
        |(name, (own, other))| {
            let bucket = (0..own.len()).find(|b| own.get(*b) != other.get(*b))?;
            Some(format!("the list of {name} in bucket {bucket} of {}", own.len()))
        },
    )
}

/// A hash of bits and lists (FNV-1a of 64 bits, by words).
pub(crate) fn hash(of: &Lists) -> u64 {
    let mut hash = 0xCBF2_9CE4_8422_2325_u64;
    let mut add = |words: &[u32]| {
        for word in std::iter::once(&(words.len() as u32)).chain(words) {
            hash = (hash ^ u64::from(*word)).wrapping_mul(0x0100_0000_01B3);
        }
    };
    add(&of.bits);
    of.lists.iter().flatten().for_each(|slots| add(slots));
    hash
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_differs_is_said() {
        let own = Lists { bits: vec![1; 8], lists: [const { Vec::new() }; 3] };
        let mut other = own.clone();
        assert_eq!(difference(&own, &other), None);
        other.bits[3] = 2;
        assert_eq!(difference(&own, &other).as_deref(), Some("1 of 8 words of bits"));
        assert_ne!(hash(&own), hash(&other));
        let mut with = own.clone();
        (with.lists[1], other.lists[1]) = (vec![vec![7]], vec![vec![]]);
        other.bits = own.bits.clone();
        let said = difference(&with, &other).unwrap();
        assert!(said.contains("seen before in bucket 0"), "{said}");
        assert_ne!(hash(&with), hash(&other));
    }
}
