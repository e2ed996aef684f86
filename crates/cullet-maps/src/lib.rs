//! Maps and tiles: Quake and Quake 3 with their cells and visible sets ([`bsp`]), portal graphs
//! ([`Prt`]), 3D Tiles, and `OCCSCN01` ([`occscn`]) with [recordings](recording) of occlusion
//! culling. Tiles are left out on pages, and without the feature `tiles`.
//!
//! [`load()`] loads every file that the programs of `cullet` read: these, and those of
//! [`cullet_io`].
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod bsp;
mod load;
pub mod occscn;
mod prt;
pub mod recording;
#[cfg(all(feature = "tiles", not(target_family = "wasm")))]
mod tileset;

pub use load::{has_scene_ending, load, load_bytes, load_bytes_with};
pub use prt::{Prt, PrtVariant, load_prt, load_prt_bytes};
#[cfg(all(feature = "tiles", not(target_family = "wasm")))]
pub use tileset::{
    GlobePlace, StandInOf, TileInput, TileNode, TileSets, TileSight, TileSize, TileStandIn,
    TileTree, TilesWritten, WriteTiles, write_tiles, write_tiles_with,
};
