//! Sets as bytes, which may stay where they are.

use alloc::borrow::Cow;
use alloc::vec::Vec;

use thiserror::Error;

use super::{Targets, VisibleSets};

/// Kind of targets, targets, cells and words, each as u32, little-endian; then where each row
/// begins, as u32, filled up to eight bytes; then the words.
const HEADER: usize = 16;

/// Reason for which bytes are no sets, or sets are not those of a scene's cells.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum SetsError {
    /// There are too few bytes, or too many.
    #[error("{found} bytes of visible sets, but their header says {expected}: cut short?")]
    Size {
        /// How many there are.
        found: u64,
        /// How many there should be.
        expected: u64,
    },
    /// They are of something else than cells or instances.
    #[error("visible sets of kind {0}, but there are only kinds 0 (cells) and 1 (instances)")]
    Targets(u32),
    /// A row begins where it cannot.
    #[error("the row of cell {cell} begins at word {start}, but there are {words} words")]
    Row {
        /// The cell.
        cell: u32,
        /// Where its row begins.
        start: u32,
        /// How many words there are.
        words: u32,
    },
    /// A part that cannot be joined with others.
    #[error("part {part} of sets to be joined: {problem}")]
    Part {
        /// Number of the part, from 0.
        part: u32,
        /// The fault.
        problem: &'static str,
    },
    /// They are of more or fewer cells than the scene has.
    #[error("visible sets of {sets} cells, but the scene has {cells}: of another scene?")]
    Cells {
        /// How many cells the sets are of.
        sets: u32,
        /// How many the scene has.
        cells: u32,
    },
}

impl VisibleSets<'_> {
    /// The bytes of the sets: for a file, from which [`from_bytes`](VisibleSets::from_bytes) takes
    /// them as they lie.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let numbers = [
            self.targets as u32,
            self.target_count,
            self.cell_count(),
            // `from_rows` and `from_bytes` make no more.
            self.words.len() as u32,
        ];
        let mut out = Vec::with_capacity(HEADER + self.size() + 4);
        numbers.iter().chain(&*self.starts).for_each(|v| out.extend(v.to_le_bytes()));
        out.resize(out.len().next_multiple_of(8), 0);
        self.words.iter().for_each(|v| out.extend(v.to_le_bytes()));
        out
    }
}

impl<'a> VisibleSets<'a> {
    /// Sets from their bytes, which are not copied where they begin at an address that is a
    /// multiple of eight on a little-endian machine, as those of a file that is mapped into memory
    /// do. O(cells): rows are not looked at, for no row can do harm. One that is nonsense says
    /// nonsense, so check the sum of a file that may be damaged.
    ///
    /// # Errors
    /// If the bytes are not as many as they say, are of no known kind, or a row begins beyond their
    /// end.
    pub fn from_bytes(bytes: &'a [u8]) -> Result<Self, SetsError> {
        let found = bytes.len() as u64;
        let (header, rest) = bytes
            .split_first_chunk::<HEADER>()
            .ok_or(SetsError::Size { found, expected: HEADER as u64 })?;
        let number = |k: usize| u32::from_le_bytes(core::array::from_fn(|i| header[k * 4 + i]));
        let [kind, target_count, cells, count] = core::array::from_fn(number);
        let starts_len = (u64::from(cells) * 4).next_multiple_of(8);
        let expected = HEADER as u64 + starts_len + u64::from(count) * 8;
        if found != expected {
            return Err(SetsError::Size { found, expected });
        }
        let targets = match kind {
            0 => Targets::Cells,
            1 => Targets::Instances,
            kind => return Err(SetsError::Targets(kind)),
        };
        let (starts, words) = rest.split_at(starts_len as usize);
        let starts = numbers(&starts[..cells as usize * 4], u32::from_le_bytes);
        let words = numbers(words, u64::from_le_bytes);
        let sets = Self { targets, target_count, starts, words };
        let index = sets.index_len() as u64;
        for (cell, &start) in (0..).zip(&*sets.starts) {
            if u64::from(start) + index > u64::from(count) {
                return Err(SetsError::Row { cell, start, words: count });
            }
        }
        Ok(sets)
    }
}

/// Numbers that lie in bytes, copied only where they cannot stay.
fn numbers<T: bytemuck::Pod, const N: usize>(bytes: &[u8], read: fn([u8; N]) -> T) -> Cow<'_, [T]> {
    match bytemuck::try_cast_slice(bytes) {
        Ok(numbers) if cfg!(target_endian = "little") => Cow::Borrowed(numbers),
        _ => Cow::Owned(bytes.as_chunks::<N>().0.iter().map(|b| read(*b)).collect()),
    }
}
