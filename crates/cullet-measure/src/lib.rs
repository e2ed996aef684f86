//! Measures the time of `cullet` and the gain of its methods: workloads against this machine's streaming rate,
//! costs for reports, and the figures of published work.
//!
//! Each command is a module with its arguments and its `run`: [`mod@bench`], [`calibrate`], [`reproduce`]. The workloads are
//! there for other programs too:
//!
//! ```
//! use cullet_measure::bench::{BenchOptions, run_all};
//!
//! let options = BenchOptions {
//!     filter: Some("frustum/boxes".to_owned()),
//!     seconds: 0.0,
//!     sizes: vec![1000],
//!     ..BenchOptions::default()
//! };
//! assert!(run_all(&options).results.iter().all(|measured| measured.checked));
//! ```
#![forbid(unsafe_code)]

pub mod bench;
pub mod calibrate;
pub mod deviation;
pub mod machine;
pub mod occscn;
pub mod process;
pub mod reproduce;
mod stopwatch;

/// What a scene is loaded with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// Levels of its meshes.
    Levels,
    /// Those, and its instances merged in groups.
    Groups,
}

/// Loads a scene with levels of detail, wherever these come from.
pub type LoadLevels<'a> = &'a dyn Fn(
    &cullet_command::args::SceneArgs,
    Wanted,
    &cullet_command::console::Console,
) -> Result<cullet_io::Model, cullet_command::exit::Failure>;
