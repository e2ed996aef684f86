//! What the tests of cullet's crates share: where the test data lies, how often a property is tried, and how a
//! test says that it was skipped.
//!
//! Four variables of the environment steer it:
//!
//! | variable | meaning |
//! |---|---|
//! | `CULLET_DATA` | the folder of test data; unset or empty: `../shared/data` beside the repository |
//! | `CULLET_REQUIRE_DATA` | `1`: data that is not there fails the test instead of skipping it |
//! | `CULLET_CASES` | how often properties are tried, in percent of what their tests say; 100 where unset |
//! | `CULLET_SKIPPED` | a file to which every skipped test appends a line |
#![forbid(unsafe_code)]

mod cases;
mod data;
mod skip;

pub use cases::cases;
pub use data::data;
pub use skip::skip;
