//! Columns: values by slot, and how they follow the slots of their instances.

use alloc::vec;
use alloc::vec::Vec;
use core::ops::{Deref, DerefMut};

use crate::bits;
use crate::transform::Transform;

/// Values by slot, in whatever form they are stored.
pub(super) trait Permute {
    /// Puts the value of slot `from[i]` into slot i, and forgets all others.
    fn gather(&mut self, from: &[u32]);

    /// Moves values from old slots to new ones, all at once.
    fn rearrange(&mut self, moves: &[[u32; 2]]);
}

impl Permute for Vec<u32> {
    fn gather(&mut self, from: &[u32]) {
        gather(self, from);
    }

    fn rearrange(&mut self, moves: &[[u32; 2]]) {
        rearrange(self, moves);
    }
}

impl Permute for Vec<Transform> {
    /// Gathers a part of each transform at a time: a second copy of them would be half of what a
    /// scene takes. (In place, cycle by cycle, took several times as long, since each step is
    /// somewhere else and waits for the one before.)
    fn gather(&mut self, from: &[u32]) {
        gather_part(self, from, |t| &mut t.translation);
        for column in 0..3 {
            gather_part(self, from, |t| &mut t.linear[column]);
        }
        self.truncate(from.len());
    }

    fn rearrange(&mut self, moves: &[[u32; 2]]) {
        rearrange(self, moves);
    }
}

/// One bit a slot, in words of 64.
#[derive(Clone, Debug, Default)]
pub(super) struct Bits(Vec<u64>);

impl Deref for Bits {
    type Target = Vec<u64>;

    fn deref(&self) -> &Vec<u64> {
        &self.0
    }
}

impl DerefMut for Bits {
    fn deref_mut(&mut self) -> &mut Vec<u64> {
        &mut self.0
    }
}

impl Permute for Bits {
    fn gather(&mut self, from: &[u32]) {
        gather_bits(self, from);
    }

    fn rearrange(&mut self, moves: &[[u32; 2]]) {
        rearrange_bits(self, moves);
    }
}

fn gather<T: Copy>(values: &mut Vec<T>, from: &[u32]) {
    *values = from.iter().map(|&old| values[old as usize]).collect();
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

pub(super) fn rearrange_bits(words: &mut [u64], moves: &[[u32; 2]]) {
    let moved: Vec<_> = moves.iter().map(|m| bits::get(words, m[0] as usize)).collect();
    moves.iter().zip(moved).for_each(|(m, v)| bits::set(words, m[1] as usize, v));
}

pub(super) fn rearrange<T: Copy>(values: &mut [T], moves: &[[u32; 2]]) {
    let moved: Vec<_> = moves.iter().map(|m| values[m[0] as usize]).collect();
    moves.iter().zip(moved).for_each(|(m, v)| values[m[1] as usize] = v);
}

/// One value a slot, mostly the default. As long as every slot has the default no memory is taken:
/// of ten million instances few scenes give one bounds, flags or a number of its own, and those
/// that they might have are a third of what an instance takes.
#[derive(Clone, Debug)]
pub(super) struct Column<T> {
    default: T,
    len: usize,
    /// Empty as long as all are the default.
    each: Vec<T>,
}

impl<T: Copy + PartialEq> Column<T> {
    /// Creates a column without slots.
    pub(super) fn new(default: T) -> Self {
        Self { default, len: 0, each: Vec::new() }
    }

    /// Returns the value of a slot. Panics if there is no such slot, whether values are stored or
    /// not.
    #[inline]
    pub(super) fn get(&self, slot: usize) -> T {
        assert!(slot < self.len, "slot {slot} of {}", self.len);
        if self.each.is_empty() { self.default } else { self.each[slot] }
    }

    /// All values by slot; `None` where all are the default.
    pub(super) fn each(&self) -> Option<&[T]> {
        (!self.each.is_empty()).then_some(&self.each)
    }

    /// The same, to be changed; nothing where all are the default.
    pub(super) fn each_mut(&mut self) -> &mut [T] {
        &mut self.each
    }

    /// Adds a slot at the end.
    pub(super) fn push(&mut self, value: T) {
        self.len += 1;
        if !self.each.is_empty() {
            self.each.push(value);
        } else if value != self.default {
            self.each.resize(self.len, self.default);
            self.each[self.len - 1] = value;
        }
    }

    /// Replaces the value of a slot. O(slots) for the first that is not the default. Panics if
    /// there is no such slot.
    #[inline]
    pub(super) fn set(&mut self, slot: usize, value: T) {
        assert!(slot < self.len, "slot {slot} of {}", self.len);
        if self.each.is_empty() {
            if value == self.default {
                return;
            }
            self.each.resize(self.len, self.default);
        }
        self.each[slot] = value;
    }
}

impl<T: Copy> Permute for Column<T> {
    fn gather(&mut self, from: &[u32]) {
        self.len = from.len();
        if !self.each.is_empty() {
            gather(&mut self.each, from);
        }
    }

    fn rearrange(&mut self, moves: &[[u32; 2]]) {
        if !self.each.is_empty() {
            rearrange(&mut self.each, moves);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_has_the_values_that_a_plain_list_has() {
        let mut state = 1_u32;
        let mut random = |below: u32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) % below
        };
        // Of values of which all, most, or few are the default.
        for values in [1, 2, 40] {
            let (mut column, mut plain) = (Column::new(0), Vec::new());
            for _ in 0..2000 {
                let value = random(values).saturating_sub(u32::from(values == 2 && random(9) > 0));
                match random(12) {
                    0 if !plain.is_empty() => {
                        let turned: Vec<_> = (0..plain.len() as u32).rev().skip(1).collect();
                        column.gather(&turned);
                        plain = turned.iter().map(|&i| plain[i as usize]).collect();
                    }
                    1 if plain.len() > 1 => {
                        let (a, b) = (0, plain.len() as u32 - 1);
                        column.rearrange(&[[a, b], [b, a]]);
                        plain.swap(a as usize, b as usize);
                    }
                    2..6 if !plain.is_empty() => {
                        let slot = random(plain.len() as u32) as usize;
                        column.set(slot, value);
                        plain[slot] = value;
                    }
                    _ => {
                        column.push(value);
                        plain.push(value);
                    }
                }
                assert!(plain.iter().copied().eq((0..plain.len()).map(|i| column.get(i))));
                assert!(column.each().map_or(plain.iter().all(|&v| v == 0), |each| each == plain));
            }
            assert_eq!(column.each().is_none(), values == 1);
        }
    }
}
