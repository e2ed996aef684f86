//! Five baked files and what the engine answers on them: what every host is held against.

use std::path::PathBuf;

use crate::plain;
use crate::runner::{Ended, all};
use crate::tools::{cargo_program, command, run, target};

/// Where the files and the answers are: what hosts' tests find as `CULLET_GOLDEN`.
pub(crate) fn folder() -> PathBuf {
    target().join("golden")
}

/// Bakes the files, writes the answers, and holds them against those that are kept, by a test of
/// the baker.
pub(crate) fn test() -> Ended {
    // All packages, so that nothing is built that was not built before.
    let mut test = command(&cargo_program(), &plain::TEST);
    test.args(["--test", "golden", "answers_on_baked_files"]).env("CULLET_GOLDEN", folder());
    all(run(test))
}
