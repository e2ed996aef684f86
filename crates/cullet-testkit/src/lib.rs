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
//! At the root stand [`at_every_level!`], and what four variables of the environment steer ([`data`], [`cases`],
//! [`skip`]), and a [`Folder`] that goes with its test:
//!
//! | variable | meaning |
//! |---|---|
//! | `CULLET_DATA` | the folder of test data; unset or empty: `../shared/data` beside the repository |
//! | `CULLET_REQUIRE_DATA` | `1`: data that is not there fails the test instead of skipping it |
//! | `CULLET_CASES` | how often properties are tried, in percent of what their tests say; 25 where unset |
//! | `CULLET_SKIPPED` | the file to which every skipped test appends a line; unset: `target/skipped-tests.txt` |
//!
//! The tests of `cullet`, `cullet-cells`, `cullet-draw`, `cullet-io`, `cullet-maps`, `cullet-scenes` and `cullet-tiles` lie in the
//! folders of those crates and are programs of this one, which `Cargo.toml` lists: here they are built unoptimised, and
//! what they call is not.
//!
//! # A circle that is none
//!
//! This crate depends on `cullet`, whose tests depend on this crate. Cargo allows that, for what only tests need does
//! not count. Two rules follow:
//!
//! - Programs in `cullet/tests` see one `cullet`. Unit tests within `cullet/src` are compiled into
//!   a second one, whose types are others: they may use what is plain data here ([`random`], [`vectors`], [`soups`],
//!   [`models`], [`data`], [`cases`], [`skip`]). What needs a mesh, a view or a SIMD level from here is a test of the
//!   public API, and stands in `tests`.
//! - Crates that are published name this one without a version, so that `cargo package` leaves it out of what it
//!   writes, and nobody has to publish it. Their tests run from the repository.
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
