//! glTF and GLB.

use std::path::Path;

use crate::{ErrorKind, LoadOptions, Model};

/// Loads glTF or GLB.
pub(crate) fn load(
    _path: &Path,
    _bytes: &[u8],
    _options: &LoadOptions,
) -> Result<Model, ErrorKind> {
    Err(ErrorKind::Unsupported("glTF is not loaded by this build; convert it to OBJ".into()))
}
