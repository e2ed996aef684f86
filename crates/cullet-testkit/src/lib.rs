//! Shared parts of the tests and benches of cullet's crates: random numbers, shapes, scenes and views, slow oracles,
//! the test data, and every SIMD level.
//!
//! | module | holds |
//! |---|---|
//! | [`random`] | one generator of numbers, the same on every machine |
//! | [`vectors`] | products, and directions that cover the sphere |
//! | [`soups`] | shapes as plain positions and indices, and what can be measured of them |
//! | [`models`] | shapes read from the test data |
//! | [`meshes`], [`scenes`] | meshes and scenes of the engine |
//! | [`views`] | views, frusta, boxes and cullers of any kind |
//! | [`strategies`] | the same for proptest |
//! | [`answers`] | what a `Visible` says, as sets |
//! | [`oracles`] | what must come out, by slow and plain means |
//! | [`memory`] | an allocator that counts |
//!
//! The root has [`at_every_level!`], a [`Folder`] that is removed with its test, and [`data`], [`cases`] and
//! [`skip`], which read four environment variables:
//!
//! | variable | meaning |
//! |---|---|
//! | `CULLET_DATA` | the folder of test data; unset or empty: `../shared/data` beside the repository |
//! | `CULLET_REQUIRE_DATA` | `1`: data that is not there fails the test instead of skipping it |
//! | `CULLET_CASES` | how often properties are tried, in percent of what their tests say; 25 where unset |
//! | `CULLET_SKIPPED` | the file to which every skipped test appends a line; unset: `target/skipped-tests.txt` |
//!
//! The tests of `cullet`, `cullet-cells`, `cullet-draw`, `cullet-io`, `cullet-maps`, `cullet-scenes` and
//! `cullet-tiles` are in the folders of those crates, but are programs of this one, which `Cargo.toml` lists. Here
//! they are built unoptimised, and the code that they call is optimised.
//!
//! # Why the circle of dependencies works
//!
//! This crate depends on `cullet`, and the tests of `cullet` depend on this crate. Cargo allows that, because
//! dependencies of tests do not count. Two rules follow:
//!
//! - Programs in `cullet/tests` see one `cullet`. Unit tests within `cullet/src` are compiled into a second one,
//!   whose types are different. They may use the plain data of this crate ([`random`], [`vectors`], [`soups`],
//!   [`models`], [`data`], [`cases`], [`skip`]). A test that needs a mesh, a view or a SIMD level from here tests the
//!   public API, and belongs in `tests`.
//! - Published crates name this one without a version, so `cargo package` leaves it out and it need not be published.
//!   Their tests run from the repository.
#![deny(unsafe_code)]

pub mod answers;
pub mod buildings;
mod cases;
mod data;
mod folder;
mod levels;
pub mod memory;
pub mod meshes;
pub mod models;
pub mod oracles;
pub mod random;
pub mod scenes;
mod skip;
pub mod soups;
pub mod steps;
pub mod strategies;
pub mod vectors;
pub mod views;

pub use cases::cases;
pub use data::data;
pub use folder::Folder;
#[doc(hidden)]
pub use levels::{At, levels};
pub use random::Rng;
pub use skip::{skip, tell_skipped};
