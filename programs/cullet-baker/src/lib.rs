//! The commands of `cullet` that write files, as a library for the programs beside it.
//!
//! A command is a module: its arguments and its `run`. [`bakery()`] is what the commands of
//! [`cullet_cli`] need of it.
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod args;
mod auto_cells;
mod bake;
mod bake_args;
pub mod baked_occluders;
mod cells;
mod cut;
pub mod occluders;
pub mod pvs;
mod pvs_scene;
mod simplify;
mod simplify_args;
mod tiles;
pub mod units;

use cullet_command::bakery::Bakery;

pub use args::Command;

/// Returns what this program adds to the commands of `cullet`.
#[must_use]
pub fn bakery() -> Bakery {
    Bakery { cells: auto_cells::give, occluders: baked_occluders::give, units: units::run_items }
}
