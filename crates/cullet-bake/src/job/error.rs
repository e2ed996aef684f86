//! Why work cannot be planned, opened or ended.

use std::path::PathBuf;

use crate::sampled::SampledError;
use cullet_io::LoadError;
use cullet_scenes::SceneSpecError;
use thiserror::Error;

/// Why work cannot be planned, opened or ended.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum WorkError {
    /// The file cannot be loaded.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// There is no such built-in scene.
    #[error(transparent)]
    Scene(#[from] SceneSpecError),
    /// The scene cannot be baked with these settings.
    #[error("{scene}: {error}")]
    Sampled {
        /// Name of the scene.
        scene: String,
        /// Why not.
        error: SampledError,
    },
    /// A text that is no plan.
    #[error("this is no plan: {0}; make one of the file anew")]
    Plan(#[from] serde_json::Error),
    /// A plan of another version.
    #[error("a plan of version {found}, but only version {expected} is known: make it anew")]
    Version {
        /// Its own.
        found: u32,
        /// The one that is known.
        expected: u32,
    },
    /// A file of another content than the plan was made for.
    #[error(
        "{path} has the content {found:016x}, but the plan was made of {expected:016x}: give the same file, or plan anew"
    )]
    OtherContent {
        /// The file.
        path: PathBuf,
        /// Hash of its content.
        found: u64,
        /// Content of the plan.
        expected: u64,
    },
    /// The same file and settings make other work here.
    #[error(
        "{scene} makes the work {found:016x} here, but {expected:016x} where it was planned: another version of cullet, or other files beside it"
    )]
    OtherWork {
        /// The scene.
        scene: String,
        /// Key of the work here.
        found: u64,
        /// Work of the plan.
        expected: u64,
    },
    /// Items that the round does not have.
    #[error("items {start} to {end} of a round of {count}: run what `missing` lists")]
    Items {
        /// The first.
        start: u32,
        /// The one after the last.
        end: u32,
        /// How many there are.
        count: u32,
    },
    /// A unit whose bytes are not whole.
    #[error(
        "the unit of items {start} to {end} in round {round} is damaged or of other work: run it again"
    )]
    Damaged {
        /// The round.
        round: u32,
        /// Its first item.
        start: u32,
        /// The one after its last.
        end: u32,
    },
    /// Units that do not make up the round.
    #[error("round {round} cannot end: {missing} of its {count} items are in no unit, or in two")]
    Incomplete {
        /// The round.
        round: u32,
        /// How many items.
        missing: u32,
        /// Count of all items.
        count: u32,
    },
    /// Rounds are left.
    #[error("the work is not done: round {round} is next")]
    Unfinished {
        /// The round.
        round: u32,
    },
    /// The job's thread ended, or could not be started.
    #[error("the job ended with a fault of its own; please report it")]
    Gone,
}
