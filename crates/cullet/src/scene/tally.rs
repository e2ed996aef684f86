//! How many clusters and triangles the instances of a scene have, kept so that culling can count
//! without visiting every instance.

use alloc::vec::Vec;
use core::ops::{Add, AddAssign, SubAssign};

use crate::bits;
use crate::funnel::Counts;
use crate::mesh::Mesh;

/// Counts of some instances, and how many of their triangles are degenerate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Tally {
    pub(crate) counts: Counts,
    pub(crate) degenerate: u64,
}

impl Tally {
    /// One instance of a mesh.
    fn of_mesh(mesh: &Mesh) -> Self {
        let counts = Counts {
            instances: 1,
            clusters: mesh.clusters().len() as u64,
            triangles: u64::from(mesh.triangle_count()),
        };
        Self { counts, degenerate: u64::from(mesh.degenerate_count()) }
    }
}

/// Words of slots that are counted together: those below a node of 4,096.
const GROUP: usize = 64;

impl Add for Tally {
    type Output = Self;

    fn add(mut self, other: Self) -> Self {
        self += other;
        self
    }
}

impl AddAssign for Tally {
    fn add_assign(&mut self, other: Self) {
        self.counts += other.counts;
        self.degenerate += other.degenerate;
    }
}

impl SubAssign for Tally {
    fn sub_assign(&mut self, other: Self) {
        self.counts -= other.counts;
        self.degenerate -= other.degenerate;
    }
}

/// The tallies of a scene.
#[derive(Clone, Debug, Default)]
pub(super) struct Tallies {
    /// One instance of each mesh.
    by_mesh: Vec<Tally>,
    /// The instances of each word of 64 slots.
    by_word: Vec<Tally>,
    /// The instances of each group of 64 words.
    by_group: Vec<Tally>,
    /// The instances of each mask of layers, ascending by mask.
    by_layers: Vec<(u32, Tally)>,
}

impl Tallies {
    pub(super) fn add_mesh(&mut self, mesh: &Mesh) {
        self.by_mesh.push(Tally::of_mesh(mesh));
    }

    /// Takes note of a mesh that was edited; whether it holds other numbers now.
    pub(super) fn set_mesh(&mut self, at: usize, mesh: &Mesh) -> bool {
        let tally = Tally::of_mesh(mesh);
        core::mem::replace(&mut self.by_mesh[at], tally) != tally
    }

    pub(super) fn of_mesh(&self, mesh: u32) -> Tally {
        self.by_mesh[mesh as usize]
    }

    pub(super) fn add(&mut self, slot: usize, mesh: u32, layers: u32) {
        let tally = self.of_mesh(mesh);
        self.by_word.resize(self.by_word.len().max(slot / 64 + 1), Tally::default());
        self.by_word[slot / 64] += tally;
        self.by_group.resize(self.by_word.len().div_ceil(GROUP), Tally::default());
        self.by_group[slot / 64 / GROUP] += tally;
        self.join_layers(tally, layers);
    }

    /// Takes an instance out; without layers where it has [left](Self::leave) those.
    pub(super) fn remove(&mut self, slot: usize, mesh: u32, layers: Option<u32>) {
        let tally = self.of_mesh(mesh);
        self.by_word[slot / 64] -= tally;
        self.by_group[slot / 64 / GROUP] -= tally;
        if let Some(layers) = layers {
            self.leave_layers(tally, layers);
        }
    }

    /// Takes an instance out of the counts of layers, and so of all, but not of its slot.
    pub(super) fn leave(&mut self, mesh: u32, layers: u32) {
        self.leave_layers(self.of_mesh(mesh), layers);
    }

    pub(super) fn change_layers(&mut self, mesh: u32, from: u32, to: u32) {
        let tally = self.of_mesh(mesh);
        self.leave_layers(tally, from);
        self.join_layers(tally, to);
    }

    fn join_layers(&mut self, tally: Tally, layers: u32) {
        match self.place_of(layers) {
            Ok(at) => self.by_layers[at].1 += tally,
            Err(at) => self.by_layers.insert(at, (layers, tally)),
        }
    }

    fn leave_layers(&mut self, tally: Tally, layers: u32) {
        if let Ok(at) = self.place_of(layers) {
            let of_layers = &mut self.by_layers[at].1;
            *of_layers -= tally;
            if of_layers.counts.instances == 0 {
                self.by_layers.remove(at);
            }
        }
    }

    fn place_of(&self, layers: u32) -> Result<usize, usize> {
        self.by_layers.binary_search_by_key(&layers, |l| l.0)
    }

    /// Counts some words again, which ascend, after slots were permuted.
    pub(super) fn recount(
        &mut self,
        words: impl Iterator<Item = usize>,
        mesh: &[u32],
        present: &[u64],
    ) {
        self.by_word.resize(present.len(), Tally::default());
        self.by_group.resize(present.len().div_ceil(GROUP), Tally::default());
        let mut words = words.peekable();
        while let Some(word) = words.next() {
            self.by_word[word] = self.one_by_one(word, present[word], mesh);
            let group = word / GROUP;
            if words.peek().is_none_or(|next| next / GROUP != group) {
                let all = self.by_word[group * GROUP..].iter().take(GROUP);
                self.by_group[group] = all.fold(Tally::default(), |sum, own| sum + *own);
            }
        }
    }

    /// Counts all layers again, after meshes were edited, without the slots that have
    /// [left](Self::leave) them.
    pub(super) fn recount_layers(
        &mut self,
        mesh: &[u32],
        layers: &[u32],
        present: &[u64],
        has_left: impl Fn(usize) -> bool,
    ) {
        self.by_layers.clear();
        for slot in bits::in_words(present).filter(|&slot| !has_left(slot)) {
            self.join_layers(self.by_mesh[mesh[slot] as usize], layers[slot]);
        }
    }

    /// All instances in any of some layers.
    pub(super) fn in_layers(&self, layers: u32) -> Tally {
        let mut sum = Tally::default();
        let wanted = self.by_layers.iter().filter(|(own, _)| own & layers != 0);
        wanted.for_each(|(_, tally)| sum += *tally);
        sum
    }

    /// All instances.
    pub(super) fn all(&self) -> Tally {
        let mut sum = Tally::default();
        self.by_layers.iter().for_each(|(_, tally)| sum += *tally);
        sum
    }

    /// The instances of some bits of a word, all of which are `present`: by those that are missing,
    /// where that is shorter.
    pub(super) fn of_bits(&self, word: usize, bits: u64, present: u64, mesh: &[u32]) -> Tally {
        let missing = present & !bits;
        if missing.count_ones() >= bits.count_ones() {
            return self.one_by_one(word, bits, mesh);
        }
        let mut sum = self.by_word[word];
        sum -= self.one_by_one(word, missing, mesh);
        sum
    }

    /// The same of some words from `first` on; of whole groups that are all there, at the cost of
    /// comparing bits.
    pub(super) fn of_words(
        &self,
        first: usize,
        words: &[u64],
        present: &[u64],
        mesh: &[u32],
    ) -> Tally {
        let mut sum = Tally::default();
        if words.len() == GROUP && first.is_multiple_of(GROUP) && words == present {
            return self.by_group[first / GROUP];
        }
        for (word, (&bits, &present)) in (first..).zip(words.iter().zip(present)) {
            if bits != 0 {
                sum += self.of_bits(word, bits, present, mesh);
            }
        }
        sum
    }

    fn one_by_one(&self, word: usize, bits: u64, mesh: &[u32]) -> Tally {
        let mut sum = Tally::default();
        for bit in bits::ones(bits) {
            sum += self.of_mesh(mesh[word * 64 + bit]);
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_of_words_hold_what_their_slots_do() {
        let of = |triangles| Tally {
            counts: Counts { instances: 1, clusters: 2, triangles },
            degenerate: triangles / 3,
        };
        let by_mesh = vec![of(5), of(12), of(300)];
        let mut tallies = Tallies { by_mesh: by_mesh.clone(), ..Tallies::default() };
        let mut mesh: Vec<u32> = (0..9000).map(|slot| slot * 7 % 11 % 3).collect();
        (0..).zip(&mesh).for_each(|(slot, &mesh)| tallies.add(slot, mesh, 1));
        let words = mesh.len().div_ceil(64);
        let mut present = vec![0; words];
        bits::words_of(0..mesh.len()).for_each(|(word, bits)| present[word] = bits);
        let check = |tallies: &Tallies, mesh: &[u32], present: &[u64]| {
            for range in [0..64, 64..128, 128..present.len(), 3..70, 0..0, 20..30] {
                // All of them, and some.
                for mask in [u64::MAX, 0x0f0f_00ff_1234_5678, 0] {
                    let wanted: Vec<_> = present[range.clone()].iter().map(|w| w & mask).collect();
                    let slots = bits::in_words(&wanted).map(|bit| range.start * 64 + bit);
                    let expected = slots
                        .map(|slot| by_mesh[mesh[slot] as usize])
                        .fold(Tally::default(), |sum, own| sum + own);
                    let there = &present[range.clone()];
                    let found = tallies.of_words(range.start, &wanted, there, mesh);
                    assert_eq!(found, expected, "{range:?} {mask:x}");
                }
            }
        };
        check(&tallies, &mesh, &present);
        for slot in (0..mesh.len()).step_by(97) {
            tallies.remove(slot, mesh[slot], Some(1));
            bits::set(&mut present, slot, false);
        }
        check(&tallies, &mesh, &present);
        // Some words, and all of fewer.
        (64..200).for_each(|slot| mesh[slot] = 2);
        tallies.recount([1, 2, 3].into_iter(), &mesh, &present);
        check(&tallies, &mesh, &present);
        present.truncate(130);
        mesh[..6000].reverse();
        tallies.recount(0..130, &mesh, &present);
        check(&tallies, &mesh, &present);
    }

    #[test]
    fn layers_are_counted_in_whatever_order_they_come() {
        let tally =
            Tally { counts: Counts { instances: 1, clusters: 1, triangles: 7 }, degenerate: 0 };
        let mut tallies = Tallies { by_mesh: vec![tally], ..Tallies::default() };
        let layers = [4, 1, 2, 6, 1, 4, 3];
        (0..).zip(layers).for_each(|(slot, layers)| tallies.add(slot, 0, layers));
        tallies.change_layers(0, 6, 8);
        tallies.remove(1, 0, Some(1));
        for (wanted, count) in [(1, 2), (2, 2), (4, 2), (8, 1), (6, 4), (u32::MAX, 6)] {
            assert_eq!(tallies.in_layers(wanted).counts.instances, count, "layers {wanted}");
        }
        assert_eq!(tallies.all().counts.triangles, 6 * 7);
    }
}
