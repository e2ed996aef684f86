//! Worlds that do not fit in memory: a hierarchy of tiles, which loads the tiles that matter for
//! the eye.
//!
//! ```text
//!  eye, motion ──> choose ──> a cut of the hierarchy: coarse far away, fine nearby, within a budget of bytes
//!                               │            (worker thread)
//!                               ├──> load what of it is missing, what matters most first
//!                               └──> build a Scene of it ──> handed over whole; frames go on with the one before
//!  frame ──> World::look: never waits ──> World::scene ──> Culler, as of any scene
//! ```
//!
//! A [`World`] presents one [`Scene`](cullet::Scene) at any time, so every stage works on it as on
//! a scene that was never cut: occluders of one tile hide instances of another, and nothing visible
//! among the loaded tiles is dropped. The scene depends only on the cut, not on the order in which
//! tiles arrived. Every place of the world is in exactly one tile of a cut, and in the tiles above
//! it to which that tile adds. Coarse tiles stand in for tiles that are not loaded. They are drawn
//! and never hide anything. If a world [knows](TileSource::is_seen) what can be seen from where,
//! visible tiles are loaded first.
//!
//! ```
//! use cullet::{Culler, ViewState, Visible};
//! use cullet_tiles::{CityTiles, Settings, World};
//!
//! let mut world = World::new(CityTiles::new(1_000_000, 1), &Settings::default())?;
//! // Each frame:
//! world.look([0.0, 2.0, 0.0], [0.0, 0.0, -10.0]);
//! assert!(world.scene().instance_count() > 0);
//! # Ok::<(), cullet_tiles::TileError>(())
//! ```
#![forbid(unsafe_code)]

mod built;
mod choose;
mod city;
mod settings;
mod source;
mod status;
mod tileset;
mod worker;
mod world;

pub use built::{Loaded, scene_of};
pub use choose::{Cut, choose};
pub use city::CityTiles;
pub use settings::Settings;
pub use source::{TileContent, TileError, TileId, TileInfo, TileSource};
pub use status::{Status, Want};
pub use tileset::FolderTiles;
pub use world::World;

/// The last doc test that `cargo test` runs, for cargo takes packages in the order of their names:
/// it tells what tests of all packages skipped, where that is read, at the very end.
///
/// ```
/// cullet_testkit::tell_skipped();
/// ```
#[cfg(doctest)]
struct Skipped;
