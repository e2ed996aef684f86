//! Bits of what Godot's server was told: one a node, so that a frame that changes little costs
//! little.

/// Sets of items.
#[derive(Debug, Default)]
pub(crate) struct Told {
    /// Items that can be hidden.
    pub(crate) here: Vec<u64>,
    /// Items that were told to be seen by no camera, and those whose shadow is not seen either.
    pub(crate) unseen: Vec<u64>,
    pub(crate) gone: Vec<u64>,
}

impl Told {
    /// Takes an item in, or out, as one that nothing was told of yet.
    pub(crate) fn put(&mut self, index: usize, is_here: bool) {
        let words = (index / 64 + 1).max(self.here.len());
        for bits in [&mut self.here, &mut self.unseen, &mut self.gone] {
            bits.resize(words, 0);
        }
        set(&mut self.here, index, is_here);
        self.forget(index);
    }

    /// Forgets what was told of an item.
    pub(crate) fn forget(&mut self, index: usize) {
        set(&mut self.unseen, index, false);
        set(&mut self.gone, index, false);
    }

    /// Forgets what was told of all.
    pub(crate) fn forget_all(&mut self) {
        self.unseen.fill(0);
        self.gone.fill(0);
    }

    /// Takes over what is told of a word of items. Returns those of which something else is.
    pub(crate) fn change(&mut self, word: usize, unseen: u64, gone: u64) -> u64 {
        let here = self.here[word];
        let differs = here & ((unseen ^ self.unseen[word]) | (gone ^ self.gone[word]));
        (self.unseen[word], self.gone[word]) = (unseen & here, gone & here);
        differs
    }
}

/// Sets one bit.
pub(crate) fn set(bits: &mut [u64], index: usize, on: bool) {
    if let Some(word) = bits.get_mut(index / 64) {
        let one = 1 << (index % 64);
        *word = if on { *word | one } else { *word & !one };
    }
}

/// Returns one bit.
pub(crate) fn has(bits: &[u64], index: usize) -> bool {
    bits.get(index / 64).is_some_and(|word| word & (1 << (index % 64)) != 0)
}

/// Returns how many bits are set.
pub(crate) fn count(bits: &[u64]) -> usize {
    bits.iter().map(|word| word.count_ones() as usize).sum()
}

/// Calls `visit` with the number of each bit of a word.
pub(crate) fn each(word: usize, mut bits: u64, mut visit: impl FnMut(usize)) {
    while bits != 0 {
        visit(word * 64 + bits.trailing_zeros() as usize);
        bits &= bits - 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_differs_is_told() {
        let mut told = Told::default();
        (0..3).for_each(|index| told.put(index, index != 1));
        assert_eq!(told.change(0, u64::MAX, 0b100), 0b101);
        assert_eq!(told.change(0, u64::MAX, 0b100), 0);
        told.forget(2);
        assert_eq!(told.change(0, u64::MAX, 0b100), 0b100);
        assert_eq!((count(&told.unseen), count(&told.gone)), (2, 1));
    }
}
