//! Loads models and makes scenes.
#![forbid(unsafe_code)]

mod error;
mod gltf;
mod load;
mod model;
pub mod paths;
pub mod scenes;

pub use error::{ErrorKind, LoadError};
pub use gltf::load_gltf_from_memory;
pub use load::{LoadOptions, load};
pub use model::{CameraNode, Cell, CellGraph, Material, Model, Portal, Up, Warning};
