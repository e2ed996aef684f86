//! Rows of stored visibility as bits over cells.

use cullet_cells::pvs::{Targets, VisibleSets};

use super::map::Bsp;
use super::visibility::bit;

impl Bsp {
    /// Appends the row of a cell to `out`: bit j of it (byte j/8, bit j%8) says whether the file
    /// has cell j, or a leaf of it, seen from there. All are, from a cell that is not there, or to
    /// which the file gives no row (`vis` does that to leafs of a leak). A row has `cell_count` / 8
    /// bytes, rounded up. Cost: linear in the leafs.
    pub fn cell_row_into(&self, cell: u32, out: &mut Vec<u8>) {
        let start = out.len();
        let cell_count = self.cell_count();
        out.resize(start + (cell_count as usize).div_ceil(8), 0);
        let mut set = |cell: u32| out[start + cell as usize / 8] |= 1 << (cell % 8);
        let Some(row) = self.row_of(Some(cell)) else { return (0..cell_count).for_each(set) };
        if self.version().has_clusters() {
            return (0..cell_count).filter(|c| bit(&row, *c as usize)).for_each(set);
        }
        // Leaf 0 has no bit.
        for (at, leaf) in self.leafs().iter().skip(1).enumerate() {
            if let Some(cell) = leaf.cell.filter(|_| bit(&row, at)) {
                set(cell);
            }
        }
    }

    /// Visible sets of the cells, as the visibility lump has them; `None` where the map has none.
    /// Cost: linear in cells times leafs.
    #[must_use]
    pub fn cell_sets(&self) -> Option<VisibleSets<'static>> {
        if !self.has_visibility() {
            return None;
        }
        let count = self.cell_count();
        let row = |cell| {
            let mut bytes = Vec::new();
            self.cell_row_into(cell, &mut bytes);
            bytes.resize(bytes.len().next_multiple_of(8), 0);
            bytes.as_chunks().0.iter().map(|word| u64::from_le_bytes(*word)).collect::<Vec<_>>()
        };
        let rows: Vec<Vec<u64>> = (0..count).map(row).collect();
        Some(VisibleSets::from_rows(Targets::Cells, count, rows.iter().map(Vec::as_slice)))
    }
}
