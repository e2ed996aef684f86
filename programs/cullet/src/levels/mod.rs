//! Levels of detail as commands use them: from the file or from the baker, measured, and counted
//! for reports.

mod baked;
mod cache;
mod ladder;
mod record;

pub use baked::{Wanted, file, load, load_with};
pub use cullet_io::level_holders as holders;
pub(crate) use ladder::Ladder;
pub(crate) use record::{DeviationRecord, LadderRecord, LevelsRecord, LevelsSummary};

/// Counted up whenever the same mesh and options give other levels: neither the baker, which keeps
/// what is finished, nor who keeps whole baked files, takes those of before for them.
pub const LEVELS_VERSION: u32 = 4;
