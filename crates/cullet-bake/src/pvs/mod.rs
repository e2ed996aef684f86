//! Potentially visible sets of cells joined by portals: who sees whom, known before a frame is
//! drawn.
//!
//! Each pair of cells ends in one of three states. *Visible*: a line of sight was found, and is
//! stored. *Hidden*: for every chain of portals between the two, planes part what a line would have
//! to pass. *Undecided*: neither was shown within the budget, and the pair is kept, so that the
//! sets are conservative and say themselves how much they may be too large by.
//!
//! The way there: floods through whole portals leave candidates; lines through the portals of each
//! cell prove most of what is visible; then, cell after cell, flow through chains of portals,
//! clipped ever smaller, decides what is left, one side of a pair for both. Lines come from a hash
//! of seed and cell, and cells work on what earlier rounds found, never on each other's half-done
//! work: so the bytes are the same for any number of threads and any split into units.
//!
//! ```
//! use cullet_cells::cell::{CellGraph, Portal};
//! use cullet_bake::pvs::{PairState, PvsSettings, bake};
//!
//! // Three rooms in a row; the second door is beside the first.
//! let door = |cells, x: f64, y: f64| Portal {
//!     cells,
//!     polygon: vec![[x, y, 0.0], [x, y, 2.0], [x, y + 1.0, 2.0], [x, y + 1.0, 0.0]],
//! };
//! let graph = CellGraph::new(3, vec![door([0, 1], 4.0, 0.0), door([1, 2], 8.0, 3.0)])?;
//! let pvs = bake(&graph, &PvsSettings::default(), 1);
//! assert_eq!(pvs.state(0, 2), PairState::Visible);
//! # Ok::<(), cullet_cells::cell::CellError>(())
//! ```

mod bake;
mod flood;
mod flow;
mod known;
mod lines;
mod openings;
mod polygon;
#[expect(clippy::module_inception, reason = "the type that the room is named for")]
mod pvs;
mod settings;
mod sight_ref;
mod unit;

pub use crate::rows::BitRows;
pub use bake::{Bake, bake};
pub use pvs::{PairState, Pvs, Witness};
pub use settings::{PvsPreset, PvsSettings};
pub use sight_ref::{MissedSight, SightCheck, check_sight_ref};
pub use unit::UnitResult;
