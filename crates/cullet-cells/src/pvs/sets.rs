//! Rows of bits, kept without the words that are zero.

use alloc::borrow::Cow;
use alloc::collections::BTreeMap;
use alloc::vec;
use alloc::vec::Vec;

use super::Targets;
use crate::bits;

/// Words of a row that one word of its index tells of.
const BLOCK: usize = 64;

/// Sets of the targets that may be seen from each cell, compressed.
///
/// A row keeps those of its words of 64 targets that are not zero. An index before them tells, for
/// each 64 words, which of the words are kept and how many come before. One lookup reads three
/// words, wherever the target is. Equal rows are kept once. At worst, where everything is seen from
/// everywhere, the sets take 3 % more than plain bits.
///
/// Sets may borrow from a file that is [mapped](Self::from_bytes) into memory. Parts that are never
/// asked for are then never read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VisibleSets<'a> {
    pub(super) targets: Targets,
    pub(super) target_count: u32,
    /// Where the row of each cell begins among the words.
    pub(super) starts: Cow<'a, [u32]>,
    /// Row after row: its index, two words for each 64, and its words that are not zero.
    pub(super) words: Cow<'a, [u64]>,
}

impl VisibleSets<'static> {
    /// Creates sets from one row for each cell. Bit t of a row is bit t mod 64 of its word t / 64.
    /// Words that are missing at the end of a row are zero. Bits from `target_count` on are
    /// ignored. O(words).
    ///
    /// # Panics
    /// If 2³² words, 32 GiB, are not enough.
    #[must_use]
    pub fn from_rows<'r>(
        targets: Targets,
        target_count: u32,
        rows: impl IntoIterator<Item = &'r [u64]>,
    ) -> Self {
        let width = (target_count as usize).div_ceil(64);
        let (mut starts, mut words) = (Vec::new(), Vec::new());
        let mut known: BTreeMap<Vec<u64>, u32> = BTreeMap::new();
        for row in rows {
            let mut row = row[..row.len().min(width)].to_vec();
            if let Some(last) = row.get_mut(width.wrapping_sub(1)) {
                *last &= last_word(target_count);
            }
            let start = *known.entry(row).or_insert_with_key(|row| {
                let start = u32::try_from(words.len()).expect("no more than 32 GiB of sets");
                pack(row, width, &mut words);
                start
            });
            starts.push(start);
        }
        Self { targets, target_count, starts: Cow::Owned(starts), words: Cow::Owned(words) }
    }
}

/// The bits of the last word of a row that are targets.
fn last_word(target_count: u32) -> u64 {
    match target_count % 64 {
        0 => u64::MAX,
        left => (1 << left) - 1,
    }
}

/// Appends a row.
fn pack(row: &[u64], width: usize, out: &mut Vec<u64>) {
    let mut before = 0_u64;
    for block in 0..width.div_ceil(BLOCK) {
        let of_block = row.get(block * BLOCK..).unwrap_or_default();
        let index = (0..).zip(of_block.iter().take(BLOCK));
        let index = index.fold(0, |index, (k, &word)| index | u64::from(word != 0) << k);
        out.extend([index, before]);
        before += u64::from(index.count_ones());
    }
    out.extend(row.iter().filter(|&&word| word != 0));
}

impl VisibleSets<'_> {
    /// Returns the kind of targets that the sets hold.
    #[must_use]
    pub fn targets(&self) -> Targets {
        self.targets
    }

    /// How many targets there are.
    #[must_use]
    pub fn target_count(&self) -> u32 {
        self.target_count
    }

    /// How many cells there are.
    #[must_use]
    pub fn cell_count(&self) -> u32 {
        self.starts.len() as u32
    }

    /// Bytes that the sets take.
    #[must_use]
    pub fn size(&self) -> usize {
        size_of_val(&*self.starts) + size_of_val(&*self.words)
    }

    /// How many words the index of a row has.
    pub(super) fn index_len(&self) -> usize {
        (self.target_count as usize).div_ceil(64 * BLOCK) * 2
    }

    /// Whether a target may be seen from a cell. What there is no row of may be seen: so says a
    /// cell that is not there; a target that is not there may not. O(1): three words are read.
    #[inline]
    #[must_use]
    pub fn sees(&self, cell: u32, target: u32) -> bool {
        if target >= self.target_count {
            return false;
        }
        let Some(&start) = self.starts.get(cell as usize) else { return true };
        let (word, bit) = (target as usize / 64, target % 64);
        let at = start as usize + word / BLOCK * 2;
        let Some(&[index, before]) = self.words.get(at..at + 2).and_then(|w| w.first_chunk())
        else {
            return true;
        };
        let mask = 1_u64 << (word % BLOCK);
        if index & mask == 0 {
            return false;
        }
        let rank = before.saturating_add(u64::from((index & (mask - 1)).count_ones())) as usize;
        let first = start as usize + self.index_len();
        let word = self.words.get(first.saturating_add(rank));
        word.is_none_or(|word| word >> bit & 1 == 1)
    }

    /// Visits the words of a cell's row that are not zero, ascending, with their numbers.
    pub(super) fn visit(&self, cell: u32, mut each: impl FnMut(usize, u64)) {
        let width = (self.target_count as usize).div_ceil(64);
        let row = self.starts.get(cell as usize).map(|&start| start as usize);
        let index = row.and_then(|start| self.words.get(start..start + self.index_len()));
        let rest = row.and_then(|start| self.words.get(start + self.index_len()..));
        let mut last = |word: usize, bits: u64| {
            let bits = if word + 1 == width { bits & last_word(self.target_count) } else { bits };
            if word < width {
                each(word, bits);
            }
        };
        // What there is no row of may be seen.
        let (Some(index), Some(mut rest)) = (index, rest) else {
            (0..width).for_each(|word| last(word, u64::MAX));
            return;
        };
        for (block, pair) in index.as_chunks::<2>().0.iter().enumerate() {
            for k in bits::ones(pair[0]) {
                let (first, left) = rest.split_first().map_or((u64::MAX, rest), |(w, r)| (*w, r));
                rest = left;
                last(block * BLOCK + k, first);
            }
        }
    }

    /// Sets the bits of all that may be seen from a cell. `row` is made as long as a row is; what
    /// is set in it stays. O(words).
    pub fn add_row_to(&self, cell: u32, row: &mut Vec<u64>) {
        row.resize((self.target_count as usize).div_ceil(64), 0);
        self.visit(cell, |word, bits| row[word] |= bits);
    }

    /// All that may be seen from any of some cells, as from all eyes of a region that
    /// [touches](crate::cell::CellLocator) them. O(words · cells).
    #[must_use]
    pub fn union(&self, cells: &[u32]) -> Vec<u64> {
        let mut row = vec![0; (self.target_count as usize).div_ceil(64)];
        cells.iter().for_each(|&cell| self.add_row_to(cell, &mut row));
        row
    }

    /// How many targets may be seen from a cell.
    #[must_use]
    pub fn count(&self, cell: u32) -> u32 {
        let mut count = 0;
        self.visit(cell, |_, bits| count += bits.count_ones());
        count
    }

    /// Targets that may be seen from a cell, ascending.
    pub fn seen_from(&self, cell: u32) -> impl Iterator<Item = u32> + use<> {
        targets_in(self.union(&[cell]))
    }

    /// Targets that may be seen from one cell and not from another, ascending: what must be there
    /// when the eye goes from the second, `from`, to the first, `to`. What may be dropped then is
    /// the same the other way round.
    pub fn arriving(&self, from: u32, to: u32) -> impl Iterator<Item = u32> + use<> {
        let mut row = self.union(&[to]);
        self.visit(from, |word, bits| row[word] &= !bits);
        targets_in(row)
    }

    /// Cells from which a target may be seen, ascending: who can see it. O(cells).
    pub fn seeing(&self, target: u32) -> impl Iterator<Item = u32> {
        (0..self.cell_count()).filter(move |&cell| self.sees(cell, target))
    }

    /// Whether anything of some targets may be seen from any of some cells: with
    /// [targets](Targets::Cells) that are cells, whether two regions may see each other. O(cells ·
    /// targets), until the first that may.
    #[must_use]
    pub fn any_sees(&self, cells: &[u32], targets: &[u32]) -> bool {
        cells.iter().any(|&cell| targets.iter().any(|&target| self.sees(cell, target)))
    }

    /// The same, holding all of it.
    #[must_use]
    pub fn into_owned(self) -> VisibleSets<'static> {
        VisibleSets {
            targets: self.targets,
            target_count: self.target_count,
            starts: Cow::Owned(self.starts.into_owned()),
            words: Cow::Owned(self.words.into_owned()),
        }
    }
}

/// The numbers of the bits of a row.
fn targets_in(row: Vec<u64>) -> impl Iterator<Item = u32> {
    let words = row.into_iter().enumerate();
    words.flat_map(|(word, value)| bits::ones(value).map(move |bit| (word * 64 + bit) as u32))
}
