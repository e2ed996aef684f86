//! The order of the slots: commits, which sort them by place.

use alloc::vec;
use alloc::vec::Vec;

use super::Scene;
use super::column::Permute;
use crate::bits;
use crate::hierarchy::{Commit, NO_SLOT};
use crate::prepared::Preparation;
use crate::sort::sort;

impl Scene {
    /// Fits the nodes of the hierarchy to what moved since the last time: makes the next cull
    /// faster, never different. The cost is that of what moved.
    pub fn refit(&mut self) {
        self.hierarchy.refit();
    }

    /// Sorts the slots by place, those of [dynamic](crate::InstanceFlags::dynamic) instances after
    /// all others, and closes the gaps that removed instances left. Returns where each slot went.
    /// O(instances). Call it after loading, and again after much was added or moved far.
    ///
    /// Before that it [prepares](Self::prepare) the meshes that came since the last commit, for the
    /// stages of a culler and nothing else: `scene.commit(&culler)`. Scenes of several cullers take
    /// the [union](Preparation::and) of what those use.
    pub fn commit(&mut self, wanted: impl Into<Preparation>) -> Commit {
        self.prepare(wanted);
        self.sort()
    }

    /// The part of [`commit`](Self::commit) that sorts, without preparing any mesh.
    pub fn sort(&mut self) -> Commit {
        let (flags, stands) = (&self.flags, self.stand_ins.as_deref());
        let is_apart = |slot: u32| {
            // Those that stand for others have no place among them.
            stands.is_some_and(|s| s.has(slot as usize)) || flags.get(slot as usize).dynamic
        };
        let commit = self.hierarchy.commit_parts(is_apart);
        let len = self.hierarchy.slot_count() as usize;
        let mut from = vec![0; len];
        for (old, &new) in commit.slot_of_old.iter().enumerate() {
            if new != NO_SLOT {
                from[new as usize] = old as u32;
            }
        }
        let before = commit.slot_of_old.len();
        self.columns(before).for_each(|column| column.gather(&from));
        self.note_exempt();
        self.log_all();
        let present = self.hierarchy.present();
        self.tallies.recount(0..present.len(), &self.mesh, present);
        self.change += 1;
        commit
    }

    /// Commits without sorting. Use it for a scene whose instances were added in the slot order of
    /// a scene that was committed. The slots stay as they are, and no mesh is prepared. See
    /// [`Hierarchy::commit_in_order`](crate::hierarchy::Hierarchy::commit_in_order).
    pub fn commit_in_order(&mut self) {
        self.hierarchy.commit_in_order();
        self.note_exempt();
        self.log_all();
        self.change += 1;
    }

    /// Sorts some of the slots: call it once or more a frame where much moves, so that the order
    /// does not decay and no frame waits for a [`commit`](Self::commit). Returns the slots that
    /// changed, as old and new. See
    /// [`Hierarchy::commit_slice`](crate::hierarchy::Hierarchy::commit_slice).
    pub fn commit_slice(&mut self) -> Vec<[u32; 2]> {
        let moves = self.hierarchy.commit_slice();
        let slots = self.slot_count() as usize;
        self.columns(slots).for_each(|column| column.rearrange(&moves));
        self.log_moves(&moves);
        let mut words: Vec<u32> = moves.iter().flatten().map(|&slot| slot / 64).collect();
        sort(&mut words);
        words.dedup();
        self.tallies.recount(
            words.into_iter().map(|word| word as usize),
            &self.mesh,
            self.hierarchy.present(),
        );
        for &[_, slot] in &moves {
            if bits::get(&self.exempt, slot as usize) {
                bits::set(&mut self.exempt_words, slot as usize / 64, true);
            }
        }
        self.change += u64::from(!moves.is_empty());
        moves
    }

    /// Returns all that is stored by slot, each with an entry for each of so many `slots`.
    ///
    /// Every field of a scene is named here: one that is new does not compile until it is said
    /// whether it follows the slots.
    fn columns(&mut self, slots: usize) -> impl Iterator<Item = &mut dyn Permute> {
        let Self {
            mesh,
            transforms,
            layers,
            flags,
            overrides,
            size_weights,
            user_data,
            exempt,
            collapsed,
            stand_ins,
            // Those that have no slots, or that are made anew of the others after each permutation.
            id: _,
            origin: _,
            change: _,
            mesh_version: _,
            meshes: _,
            prepared: _,
            kinds: _,
            free_meshes: _,
            levels: _,
            level_count: _,
            no_mesh: _,
            tallies: _,
            exempt_words: _,
            hierarchy: _,
            log: _,
        } = self;
        let stand_ins = stand_ins.as_deref_mut().map(|stand_ins| {
            stand_ins.resize(slots);
            stand_ins as &mut dyn Permute
        });
        let all: [&mut dyn Permute; 9] = [
            mesh,
            transforms,
            layers,
            flags,
            overrides,
            size_weights,
            user_data,
            exempt,
            collapsed,
        ];
        all.into_iter().chain(stand_ins)
    }

    /// Notes which words of `exempt` are not zero.
    pub(super) fn note_exempt(&mut self) {
        self.exempt_words.clear();
        self.exempt_words.resize(self.exempt.len().div_ceil(64), 0);
        for (word, &bits) in self.exempt.iter().enumerate() {
            bits::set(&mut self.exempt_words, word, bits != 0);
        }
    }
}
