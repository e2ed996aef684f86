//! Loads and saves models, and makes scenes.
//!
//! Each layer knows those below it: the model and how it moves; the builder and what reads blocks and text; a file for
//! each format; which format a file has; loading, posing and saving. Built-in scenes are another way to a model, and
//! camera paths look at one. Adversaries are small scenes that are hard for occlusion culling.
#![forbid(unsafe_code)]

pub mod adversaries;
mod attributes;
pub mod baked;
mod baked_file;
mod beside;
mod blocks;
pub mod bsp;
mod builder;
mod cells;
mod compact;
mod convex;
pub mod deform;
mod error;
mod format;
mod gltf;
mod load;
mod model;
mod motion;
mod mtl;
mod named;
mod node_tree;
mod obj;
pub mod occscn;
mod off;
mod options;
pub mod paths;
mod ply;
mod polygon;
mod pose;
mod prt;
pub mod recording;
pub mod rooms;
mod save;
pub mod scenes;
mod stl;
mod text;
#[cfg(not(target_family = "wasm"))]
mod tileset;
mod weld;
mod winding;

pub use attributes::Attributes;
pub use baked_file::{
    BakedFile, BakedFileError, GroupSlices, ImpostorSlices, LevelSlices, ListedGroup,
    ListedImpostor, ListedLevels, ListedMesh, ListedTable, Mapping, OccluderSlices,
};
pub use cells::{Cell, CellGraph, Mirror, Portal};
pub use error::{ErrorKind, LoadError};
pub use load::{load, load_bytes, load_bytes_with};
pub use model::{CameraNode, Material, MatrixView, Model, Warning};
pub use motion::Motion;
pub use named::{files_named, files_named_in};
pub use node_tree::{NodeTree, NodeTreeStatistics};
pub use options::{LoadOptions, Up};
pub use pose::PoseError;
pub use prt::{Prt, PrtVariant, load_prt, load_prt_bytes};
pub use save::{SaveError, SaveErrorKind, SaveFormat, save, save_original};
#[cfg(not(target_family = "wasm"))]
pub use tileset::{
    StandInOf, TileInput, TileNode, TileSets, TileSight, TileSize, TileStandIn, TileTree,
    TilesWritten, WriteTiles, write_tiles, write_tiles_with,
};
