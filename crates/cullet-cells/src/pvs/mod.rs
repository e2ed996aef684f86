//! Potentially visible sets at run time: what may be seen from each cell, known before any frame,
//! and looked up.
//!
//! Which sets those are is found beforehand: from cells and portals (Teller & Séquin, *Visibility
//! Preprocessing for Interactive Walkthroughs*, 1991), by lines through a scene (Bittner et al.,
//! *Adaptive Global Visibility Sampling*, 2009), or by the compiler of a map, which stored them in
//! it. Here they are kept small, and asked.
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

mod bytes;
mod sets;

pub use bytes::SetsError;
pub use sets::VisibleSets;

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
