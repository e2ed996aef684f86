//! How many clusters and triangles the instances of a scene have, kept so that culling can count without visiting
//! every instance.

use std::collections::BTreeMap;
use std::ops::{AddAssign, SubAssign};

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
    /// The instances of each mask of layers.
    by_layers: BTreeMap<u32, Tally>,
}

impl Tallies {
    pub(super) fn add_mesh(&mut self, mesh: &Mesh) {
        self.by_mesh.push(Tally::of_mesh(mesh));
    }

    /// Takes note of a mesh that was edited; whether it holds other numbers now.
    pub(super) fn set_mesh(&mut self, at: usize, mesh: &Mesh) -> bool {
        let tally = Tally::of_mesh(mesh);
        std::mem::replace(&mut self.by_mesh[at], tally) != tally
    }

    pub(super) fn of_mesh(&self, mesh: u32) -> Tally {
        self.by_mesh[mesh as usize]
    }

    pub(super) fn add(&mut self, slot: usize, mesh: u32, layers: u32) {
        let tally = self.of_mesh(mesh);
        self.by_word.resize(self.by_word.len().max(slot / 64 + 1), Tally::default());
        self.by_word[slot / 64] += tally;
        *self.by_layers.entry(layers).or_default() += tally;
    }

    /// Takes an instance out; without layers where it has [left](Self::leave) those.
    pub(super) fn remove(&mut self, slot: usize, mesh: u32, layers: Option<u32>) {
        let tally = self.of_mesh(mesh);
        self.by_word[slot / 64] -= tally;
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
        *self.by_layers.entry(to).or_default() += tally;
    }

    fn leave_layers(&mut self, tally: Tally, layers: u32) {
        if let Some(of_layers) = self.by_layers.get_mut(&layers) {
            *of_layers -= tally;
            if of_layers.counts.instances == 0 {
                self.by_layers.remove(&layers);
            }
        }
    }

    /// Counts some words again, after slots were permuted.
    pub(super) fn recount(
        &mut self,
        words: impl Iterator<Item = usize>,
        mesh: &[u32],
        present: &[u64],
    ) {
        self.by_word.resize(present.len(), Tally::default());
        for word in words {
            self.by_word[word] = self.one_by_one(word, present[word], mesh);
        }
    }

    /// Counts all layers again, after meshes were edited, without the slots that have [left](Self::leave) them.
    pub(super) fn recount_layers(
        &mut self,
        mesh: &[u32],
        layers: &[u32],
        present: &[u64],
        has_left: impl Fn(usize) -> bool,
    ) {
        self.by_layers.clear();
        for slot in bits::in_words(present).filter(|&slot| !has_left(slot)) {
            *self.by_layers.entry(layers[slot]).or_default() += self.by_mesh[mesh[slot] as usize];
        }
    }

    /// All instances in any of some layers.
    pub(super) fn in_layers(&self, layers: u32) -> Tally {
        let mut sum = Tally::default();
        let wanted = self.by_layers.iter().filter(|(own, _)| *own & layers != 0);
        wanted.for_each(|(_, tally)| sum += *tally);
        sum
    }

    /// All instances.
    pub(super) fn all(&self) -> Tally {
        let mut sum = Tally::default();
        self.by_layers.values().for_each(|tally| sum += *tally);
        sum
    }

    /// The instances of some bits of a word, all of which are `present`: by those that are missing, where that is
    /// shorter.
    pub(super) fn of_bits(&self, word: usize, bits: u64, present: u64, mesh: &[u32]) -> Tally {
        let missing = present & !bits;
        if missing.count_ones() >= bits.count_ones() {
            return self.one_by_one(word, bits, mesh);
        }
        let mut sum = self.by_word[word];
        sum -= self.one_by_one(word, missing, mesh);
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
