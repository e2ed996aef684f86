//! Columns: what an instance mostly has as its default, by slot.

use super::order;

/// One value a slot. As long as every slot has the default no memory is taken: of ten million instances few scenes give one
/// bounds, flags or a number of its own, and those that they might have are a third of what an instance takes.
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

    /// Returns the value of a slot. Panics if there is no such slot, whether values are stored or not.
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

    /// Replaces the value of a slot. O(slots) for the first that is not the default. Panics if there
    /// is no such slot.
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

    /// Puts the value of slot `from[i]` into slot i, and forgets all others.
    pub(super) fn gather(&mut self, from: &[u32]) {
        self.len = from.len();
        if !self.each.is_empty() {
            order::gather(&mut self.each, from);
        }
    }

    /// Moves values from old slots to new ones, all at once.
    pub(super) fn rearrange(&mut self, moves: &[[u32; 2]]) {
        if !self.each.is_empty() {
            order::rearrange(&mut self.each, moves);
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
