//! Loads and saves models, and makes scenes.
#![forbid(unsafe_code)]

mod attributes;
mod beside;
mod blocks;
mod builder;
mod error;
mod format;
mod gltf;
mod load;
mod model;
mod mtl;
mod named;
mod node_tree;
mod obj;
pub mod occscn;
mod off;
pub mod paths;
mod ply;
mod polygon;
mod pose;
pub mod recording;
mod save;
pub mod scenes;
mod stl;
mod text;
mod weld;

pub use attributes::Attributes;
pub use error::{ErrorKind, LoadError};
pub use load::{LoadOptions, load, load_bytes, load_bytes_with};
pub use model::{CameraNode, Cell, CellGraph, Material, MatrixView, Model, Portal, Up, Warning};
pub use named::{files_named, files_named_in};
pub use node_tree::{NodeTree, NodeTreeStatistics};
pub use pose::{Motion, PoseError};
pub use save::{SaveError, SaveErrorKind, SaveFormat, save};
