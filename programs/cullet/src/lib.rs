//! The commands of the program `cullet`, as a library for the programs beside it.
//!
//! `cullet-baker` runs these commands too, with what bakes at hand (see
//! [`cullet_command::bakery`]); `cullet-lab` takes parts of them. A command is a module: its
//! arguments and its `run`.
#![forbid(unsafe_code)]

mod args;
pub mod baked;
pub mod entry;
mod explain;
mod info;
pub mod levels;
mod meshes;
pub mod names;
pub mod neighbours;
mod opening;
pub mod picture;
mod record;
mod recording;
mod report;
mod scenes;
pub mod shape;
mod survey;
mod verify;

pub use args::Command;
pub use record::SCHEMA;

/// Style of the pages of reports.
pub const STYLE: &str = include_str!("report/style.css");
