//! Loads and saves models: glTF and GLB, OBJ, PLY, STL, OFF, and baked files.
//!
//! The modules form layers, and each uses only those below it. From the bottom they are: the model
//! and its motion; the builder, and readers of blocks and text; one file for each format; the
//! recognition of formats; loading, posing and saving. [`reader`] exports the parts of which
//! readers of other formats are made; `cullet-maps` and `cullet-scenes` use them.
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod attributes;
pub mod baked;
mod baked_file;
mod beside;
mod blocks;
mod builder;
mod bytes;
mod cells;
mod compact;
mod convex;
pub mod deform;
mod error;
mod extent;
mod facts;
mod format;
mod gltf;
mod json;
mod load;
mod model;
mod motion;
mod mtl;
mod named;
mod node_tree;
mod obj;
mod off;
mod options;
mod place;
mod ply;
mod polygon;
mod pose;
mod positions;
pub mod reader;
mod save;
mod shell;
mod stl;
mod text;
mod weld;
mod winding;

pub use attributes::Attributes;
pub use baked_file::{
    BakedFile, BakedFileError, GroupSlices, ImpostorSlices, LevelSlices, ListedGroup,
    ListedImpostor, ListedLevels, ListedMesh, ListedTable, Mapping, OccluderSlices,
};
pub use cells::{Cell, CellGraph, Mirror, Portal};
pub use error::{ErrorKind, LoadError};
pub use extent::extent;
pub use facts::{InstanceFacts, MeshFacts, instance_facts, level_holders, mesh_facts, mesh_name};
pub use load::{load, load_bytes, load_bytes_with};
pub use model::{CameraNode, Material, MatrixView, Model, Motion, Unread, Warning};
pub use named::{files_named, files_named_in};
pub use node_tree::{NodeTree, NodeTreeStatistics};
pub use options::{LoadOptions, Up};
pub use place::{WorldBox, local_origin, world, world_box};
pub use pose::PoseError;
pub use save::{SaveError, SaveErrorKind, SaveFormat, Saved, save, save_original};
pub use shell::shell_word;
