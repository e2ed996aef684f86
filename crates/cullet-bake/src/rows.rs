//! Rows of bits.

/// The first bytes of rows as tools exchange them.
const EXCHANGE: &[u8] = b"PVSROWS1";

/// Rows of bits of equal length, in words of 64.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BitRows {
    words: Vec<u64>,
    columns: u32,
    width: usize,
}

impl BitRows {
    /// So many rows, all bits 0.
    #[must_use]
    pub fn new(rows: u32, columns: u32) -> Self {
        let width = (columns as usize).div_ceil(64);
        Self { words: vec![0; width * rows as usize], columns, width }
    }

    /// Reads the bytes of [`Pvs::rows_bytes`](crate::pvs::Pvs::rows_bytes), as other tools write
    /// them too; `None` where they are not that.
    #[must_use]
    pub fn from_exchange(bytes: &[u8]) -> Option<Self> {
        let rest = bytes.strip_prefix(EXCHANGE)?;
        let (count, rest) = rest.split_first_chunk::<4>()?;
        let (stride, rest) = rest.split_first_chunk::<4>()?;
        let (count, stride) = (u32::from_le_bytes(*count), u32::from_le_bytes(*stride) as usize);
        let fits = stride == (count as usize).div_ceil(8)
            && rest.len() as u64 == u64::from(count) * stride as u64;
        if !fits {
            return None;
        }
        let mut rows = Self::new(count, count);
        for (row, bytes) in (0..count).zip(rest.chunks(stride.max(1))) {
            for (k, &byte) in bytes.iter().enumerate() {
                // Bits beyond the last are nobody's.
                let left = count - k as u32 * 8;
                let byte = if left < 8 { byte & ((1 << left) - 1) } else { byte };
                rows.row_mut(row)[k / 8] |= u64::from(byte) << (k % 8 * 8);
            }
        }
        Some(rows)
    }

    /// The bytes of these rows as tools exchange them.
    pub(crate) fn to_exchange(&self) -> Vec<u8> {
        let stride = (self.columns as usize).div_ceil(8);
        let mut out = EXCHANGE.to_vec();
        out.extend(self.columns.to_le_bytes());
        out.extend((stride as u32).to_le_bytes());
        for row in 0..self.rows() {
            let bytes = self.row(row).iter().flat_map(|w| w.to_le_bytes());
            out.extend(bytes.take(stride));
        }
        out
    }

    /// How many rows there are; 0 where they have no columns.
    #[must_use]
    pub fn rows(&self) -> u32 {
        self.words.len().checked_div(self.width).unwrap_or(0) as u32
    }

    /// How many bits a row has.
    #[must_use]
    pub fn columns(&self) -> u32 {
        self.columns
    }

    /// How many words a row has.
    pub(crate) fn width(&self) -> usize {
        self.width
    }

    /// The words of a row; bits beyond the last column are 0.
    #[inline]
    #[must_use]
    pub fn row(&self, row: u32) -> &[u64] {
        &self.words[row as usize * self.width..][..self.width]
    }

    /// The words of a row, to be changed.
    #[inline]
    pub(crate) fn row_mut(&mut self, row: u32) -> &mut [u64] {
        &mut self.words[row as usize * self.width..][..self.width]
    }

    /// All words, row after row.
    pub(crate) fn words(&self) -> &[u64] {
        &self.words
    }

    /// All words, to be changed.
    pub(crate) fn words_mut(&mut self) -> &mut [u64] {
        &mut self.words
    }

    /// A bit.
    #[inline]
    #[must_use]
    pub fn has(&self, row: u32, column: u32) -> bool {
        has(self.row(row), column)
    }

    /// Sets a bit.
    #[inline]
    pub(crate) fn set(&mut self, row: u32, column: u32) {
        set(self.row_mut(row), column);
    }

    /// Clears a bit.
    #[inline]
    pub(crate) fn clear(&mut self, row: u32, column: u32) {
        clear(self.row_mut(row), column);
    }

    /// How many bits are 1.
    #[must_use]
    pub fn count(&self) -> u64 {
        count(&self.words)
    }

    /// Bytes in memory.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.words.len() as u64 * 8
    }

    /// Clears each bit of a square whose mirror image is 0.
    pub(crate) fn keep_symmetric(&mut self) {
        for row in 0..self.rows() {
            for column in 0..row {
                if self.has(row, column) != self.has(column, row) {
                    self.clear(row, column);
                    self.clear(column, row);
                }
            }
        }
    }
}

#[inline]
pub(crate) fn has(row: &[u64], at: u32) -> bool {
    row[at as usize / 64] >> (at % 64) & 1 != 0
}

#[inline]
pub(crate) fn set(row: &mut [u64], at: u32) {
    row[at as usize / 64] |= 1 << (at % 64);
}

#[inline]
pub(crate) fn clear(row: &mut [u64], at: u32) {
    row[at as usize / 64] &= !(1 << (at % 64));
}

pub(crate) fn count(row: &[u64]) -> u64 {
    row.iter().map(|w| u64::from(w.count_ones())).sum()
}

/// Whether the two have a bit in common.
#[inline]
pub(crate) fn meet(a: &[u64], b: &[u64]) -> bool {
    a.iter().zip(b).any(|(a, b)| a & b != 0)
}

/// The numbers of the bits that are 1.
pub(crate) fn ones(row: &[u64]) -> impl Iterator<Item = u32> + '_ {
    row.iter().enumerate().flat_map(|(at, &word)| {
        std::iter::successors(Some(word), |w| Some(w & w.wrapping_sub(1)))
            .take_while(|&w| w != 0)
            .map(move |w| at as u32 * 64 + w.trailing_zeros())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_come_back_from_what_tools_exchange() {
        for cells in [0, 1, 7, 8, 63, 64, 65, 130] {
            let mut rows = BitRows::new(cells, cells);
            (0..cells).for_each(|k| rows.set(k, k * 7 % cells));
            let bytes = rows.to_exchange();
            assert_eq!(BitRows::from_exchange(&bytes), Some(rows), "{cells} cells");
            assert_eq!(BitRows::from_exchange(&bytes[..bytes.len() - 1]), None);
            assert_eq!(BitRows::from_exchange(&[&bytes[..], b"x"].concat()), None);
        }
    }

    #[test]
    fn ones_are_named_in_order() {
        let row = [1 << 63 | 2, 0, 5];
        assert_eq!(ones(&row).collect::<Vec<_>>(), [1, 63, 128, 130]);
        assert_eq!(count(&row), 4);
    }

    #[test]
    fn only_what_is_mirrored_stays() {
        let mut rows = BitRows::new(3, 3);
        [(0, 1), (1, 0), (0, 2), (2, 2)].iter().for_each(|&(a, b)| rows.set(a, b));
        rows.keep_symmetric();
        assert!(rows.has(0, 1) && rows.has(1, 0) && rows.has(2, 2) && rows.count() == 3);
    }
}
