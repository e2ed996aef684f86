//! Rows of stored visibility as bits over cells.

use super::lumps::Version;
use super::visibility::{Visibility, bit};

/// Which cells of a map can be seen from which, as its visibility lump says. It is kept as the file has it, packed, so that
/// many rows take little memory.
#[derive(Clone, Debug)]
pub struct CellRows {
    version: Version,
    cell_count: u32,
    /// The cell of each leaf; of Quake, whose rows are of leafs.
    leafs: Vec<Option<u32>>,
    visibility: Visibility,
}

impl CellRows {
    pub(crate) fn new(
        version: Version,
        cell_count: u32,
        leafs: Vec<Option<u32>>,
        visibility: Visibility,
    ) -> Self {
        Self { version, cell_count, leafs, visibility }
    }

    /// How many cells there are: rows, and bits of each.
    #[must_use]
    pub fn cell_count(&self) -> u32 {
        self.cell_count
    }

    /// Appends the row of a cell to `out`: bit j of it (byte j/8, bit j%8) says whether the file has cell j, or a leaf of it,
    /// seen from there. All are, from a cell that is not there, or to which the file gives no row (`vis` does that to leafs of
    /// a leak). A row has [`cell_count`](Self::cell_count) / 8 bytes, rounded up. Cost: linear in the leafs.
    pub fn row_into(&self, cell: u32, out: &mut Vec<u8>) {
        let Some(row) = self.visibility.row(cell) else { return all_into(self.cell_count, out) };
        let start = out.len();
        out.resize(start + (self.cell_count as usize).div_ceil(8), 0);
        let mut set = |cell: u32| out[start + cell as usize / 8] |= 1 << (cell % 8);
        match self.version {
            Version::Quake3 => {
                (0..self.cell_count).filter(|c| bit(&row, *c as usize)).for_each(set);
            }
            Version::Quake | Version::Bsp2 => {
                // Leaf 0 has no bit.
                for (at, cell) in self.leafs.iter().skip(1).enumerate() {
                    if let Some(cell) = cell.filter(|_| bit(&row, at)) {
                        set(cell);
                    }
                }
            }
        }
    }
}

/// Appends a row of which every bit is set.
pub(super) fn all_into(cell_count: u32, out: &mut Vec<u8>) {
    let start = out.len();
    out.resize(start + (cell_count as usize).div_ceil(8), 0);
    (0..cell_count as usize).for_each(|cell| out[start + cell / 8] |= 1 << (cell % 8));
}
