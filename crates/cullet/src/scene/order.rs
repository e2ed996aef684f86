//! The order of the slots: commits, which sort them by place.

use super::Scene;
use crate::bits;
use crate::hierarchy::{Commit, NO_SLOT};
use crate::prepared::Preparation;
use crate::transform::Transform;

impl Scene {
    /// Fits the nodes of the hierarchy to what moved since the last time: makes the next cull faster,
    /// never different. The cost is that of what moved.
    ///
    /// Where the scene has [cells](Self::set_cells), what moved is found in them again.
    pub fn refit(&mut self) {
        self.hierarchy.refit();
        self.assign_moved();
    }

    /// Sorts the slots by place, those of [dynamic](crate::InstanceFlags::dynamic) instances after all others, and
    /// closes the gaps that removed instances left. Returns where each slot went. O(instances). Call it after
    /// loading, and again after much was added or moved far.
    ///
    /// Then [prepares](Self::prepare) the meshes that came since, for back faces and occlusion.
    pub fn commit(&mut self) -> Commit {
        self.prepare(Preparation::default());
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
        gather_transforms(&mut self.transforms, &from);
        gather(&mut self.mesh, &from);
        gather(&mut self.layers, &from);
        self.flags.gather(&from);
        self.overrides.gather(&from);
        self.size_weights.gather(&from);
        self.users.gather(&from);
        gather_bits(&mut self.exempt, &from);
        gather_bits(&mut self.collapsed, &from);
        self.note_exempt();
        self.gather_stand_ins(&from);
        if let Some(cells) = &mut self.cells {
            cells.gather(&from);
        }
        self.assign_all();
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
        self.assign_all();
        self.change += 1;
    }

    /// Sorts some of the slots: call it once or more a frame where much moves, so that the order does not
    /// decay and no frame waits for a [`commit`](Self::commit). Returns the slots that changed, as old and
    /// new. See [`Hierarchy::commit_slice`](crate::hierarchy::Hierarchy::commit_slice).
    pub fn commit_slice(&mut self) -> Vec<[u32; 2]> {
        let moves = self.hierarchy.commit_slice();
        rearrange(&mut self.mesh, &moves);
        rearrange(&mut self.transforms, &moves);
        rearrange(&mut self.layers, &moves);
        self.flags.rearrange(&moves);
        self.overrides.rearrange(&moves);
        self.size_weights.rearrange(&moves);
        self.users.rearrange(&moves);
        rearrange_bits(&mut self.exempt, &moves);
        rearrange_bits(&mut self.collapsed, &moves);
        self.rearrange_stand_ins(&moves);
        if let Some(cells) = &mut self.cells {
            cells.rearrange(&moves);
        }
        self.assign_moved();
        let mut words: Vec<u32> = moves.iter().flatten().map(|&slot| slot / 64).collect();
        words.sort_unstable();
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

    /// Notes which words of `exempt` are not zero.
    pub(super) fn note_exempt(&mut self) {
        self.exempt_words.clear();
        self.exempt_words.resize(self.exempt.len().div_ceil(64), 0);
        for (word, &bits) in self.exempt.iter().enumerate() {
            bits::set(&mut self.exempt_words, word, bits != 0);
        }
    }
}

/// Puts `values[from[i]]` at i.
pub(super) fn gather<T: Copy>(values: &mut Vec<T>, from: &[u32]) {
    *values = from.iter().map(|&old| values[old as usize]).collect();
}

/// The same of transforms, a part of each at a time: a second copy of them would be half of what a scene takes. (In place,
/// cycle by cycle, took several times as long, since each step is somewhere else and waits for the one before.)
fn gather_transforms(transforms: &mut Vec<Transform>, from: &[u32]) {
    gather_part(transforms, from, |t| &mut t.translation);
    for column in 0..3 {
        gather_part(transforms, from, |t| &mut t.linear[column]);
    }
    transforms.truncate(from.len());
}

fn gather_part<P: Copy>(
    transforms: &mut [Transform],
    from: &[u32],
    part: impl Fn(&mut Transform) -> &mut P,
) {
    let moved: Vec<P> = from.iter().map(|&old| *part(&mut transforms[old as usize])).collect();
    transforms.iter_mut().zip(moved).for_each(|(to, moved)| *part(to) = moved);
}

pub(super) fn gather_bits(words: &mut Vec<u64>, from: &[u32]) {
    let mut new = vec![0; from.len().div_ceil(64)];
    for (to, &old) in from.iter().enumerate() {
        bits::set(&mut new, to, bits::get(words, old as usize));
    }
    *words = new;
}

/// Moves values from old places to new ones, all at once.
pub(super) fn rearrange<T: Copy>(values: &mut [T], moves: &[[u32; 2]]) {
    let moved: Vec<_> = moves.iter().map(|m| values[m[0] as usize]).collect();
    moves.iter().zip(moved).for_each(|(m, v)| values[m[1] as usize] = v);
}

pub(super) fn rearrange_bits(words: &mut [u64], moves: &[[u32; 2]]) {
    let moved: Vec<_> = moves.iter().map(|m| bits::get(words, m[0] as usize)).collect();
    moves.iter().zip(moved).for_each(|(m, v)| bits::set(words, m[1] as usize, v));
}
