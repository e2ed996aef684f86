//! Potentially visible sets at run time: what may be seen from each cell, known before any frame,
//! and looked up.
//!
//! Which sets those are is found beforehand: from cells and portals (Teller & Séquin, *Visibility
//! Preprocessing for Interactive Walkthroughs*, 1991), by lines through a scene (Bittner et al.,
//! *Adaptive Global Visibility Sampling*, 2009), or by the compiler of a map, which stored them in
//! it. Here they are kept small, and asked.
//!
//! Sets that were baked apart are joined when they are loaded together: those of
//! [levels](join_levels) with openings between their cells, and those of [tiles](join_tiles) side by
//! side. What a line of sight passes from one part into the other, it passes through cells on the
//! border of both, so what those see is all that can be seen across it. Where that is not known to
//! hold everything is kept, and counted.
//!
//! ```
//! use cullet_cells::pvs::{Targets, VisibleSets};
//!
//! // Three rooms in a row: the outer two do not see each other.
//! let rows = [0b011, 0b111, 0b110].map(|row| vec![row]);
//! let sets = VisibleSets::from_rows(Targets::Cells, 3, rows.iter().map(Vec::as_slice));
//! assert!(!sets.sees(0, 2));
//! // What to fetch when the eye goes from the first into the second.
//! assert!(sets.arriving(0, 1).eq([2]));
//! assert!(sets.seeing(0).eq([0, 1]));
//! ```

use alloc::vec::Vec;

mod bytes;
mod levels;
mod sets;
mod tiles;

pub use bytes::SetsError;
pub use levels::{LevelCell, join_levels};
pub use sets::VisibleSets;
pub use tiles::{Tile, join_tiles};

/// The kind of targets that the sets of cells hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
#[repr(u32)]
pub enum Targets {
    /// Cells. An instance may be seen where one of its cells may.
    Cells = 0,
    /// Instances, by the [index](cullet::Handle::index) of their handles. Instances that came or
    /// moved since the sets were given to a scene count as seen from everywhere.
    Instances = 1,
}

/// Sets of several parts, in one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JoinedSets {
    /// The sets of all cells: those of the first part, then those of the next.
    pub sets: VisibleSets<'static>,
    /// Number of the first cell of each part.
    pub first_cells: Vec<u32>,
    /// Pairs of a cell and a target that are kept for one reason alone: nobody knows whether the
    /// one sees the other. 0 where all is known.
    pub unknown: u64,
}

#[cfg(test)]
mod testing {
    use alloc::vec;
    use alloc::vec::Vec;

    use super::{Targets, VisibleSets};
    use crate::bits;

    pub(super) fn sets_of(
        rows: &[Vec<bool>],
        targets: Targets,
        count: usize,
    ) -> VisibleSets<'static> {
        let packed: Vec<Vec<u64>> = rows
            .iter()
            .map(|row| {
                let mut words = vec![0; count.div_ceil(64)];
                (0..count).filter(|&k| row[k]).for_each(|k| bits::set(&mut words, k, true));
                words
            })
            .collect();
        VisibleSets::from_rows(targets, count as u32, packed.iter().map(Vec::as_slice))
    }
}
