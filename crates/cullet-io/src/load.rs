//! Loading a file by its content and ending.

use std::borrow::Cow;
use std::path::Path;

use crate::format::{Format, recognise};
use crate::{ErrorKind, LoadError, Model, Up, gltf, obj, occscn, off, ply, stl};

/// How to load.
#[derive(Clone, Debug)]
pub struct LoadOptions {
    /// Which axis of the file points up; `None` takes what the format says, or Y. It turns the instances;
    /// vertices stay as the file has them.
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

/// Loads a model: GLB, glTF, OBJ, PLY, STL, OFF or `OCCSCN01`, told by content first, then by ending.
///
/// OBJ, PLY, STL, OFF and `OCCSCN01` say nothing of sides: their solids are one-sided, all else is
/// two-sided. Every vertex of the model is finite and every index in range; a file without triangles
/// loads as an empty scene with a warning. Memory stays within a small multiple of the file's size:
/// counts that a file claims are held against the bytes it has before anything is allocated.
///
/// # Errors
/// If the file cannot be read, is of no known kind, is invalid, or exceeds a limit of `options`. The
/// error names the file, the item (a line, a vertex, a face), the value and what would be right.
pub fn load(path: &Path, options: &LoadOptions) -> Result<Model, LoadError> {
    let read = || -> Result<Model, ErrorKind> {
        // A device or a pipe may never end.
        if !std::fs::metadata(path)?.is_file() {
            return Err(ErrorKind::Unsupported("it is not a regular file".into()));
        }
        decode(
            path,
            std::fs::read(path)?.into(),
            options,
            Some(path.parent().unwrap_or(Path::new(""))),
        )
    };
    read().map_err(|kind| kind.at(path))
}

/// Loads a model from memory. `name` stands for the file's name in messages, and its ending helps to
/// recognise formats without a signature (OBJ). No other file is opened: the materials of an OBJ stay
/// grey, with a warning, and a glTF with external buffers is an error.
///
/// # Errors
/// As [`load`].
pub fn load_bytes(name: &str, bytes: &[u8], options: &LoadOptions) -> Result<Model, LoadError> {
    let path = Path::new(name);
    decode(path, bytes.into(), options, None).map_err(|kind| kind.at(path))
}

/// `folder` is where files named by the model are looked for; `None` opens no file.
fn decode(
    path: &Path,
    bytes: Cow<'_, [u8]>,
    options: &LoadOptions,
    folder: Option<&Path>,
) -> Result<Model, ErrorKind> {
    let name = path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let builder = match recognise(path, &bytes)? {
        // Owned, so that it can be freed once it is decoded.
        Format::Gltf => return gltf::load(path, bytes.into_owned(), options, folder),
        Format::Obj => obj::read(&name, &bytes, options, folder)?,
        Format::Ply => ply::read(&name, &bytes, options)?,
        Format::Stl => stl::read(&name, &bytes, options)?,
        Format::Off => off::read(&name, &bytes, options)?,
        Format::Occscn => occscn::read(&name, &bytes, options)?,
    };
    // Freed before meshes are made: the peak is the greater of the two halves, not their sum.
    drop(bytes);
    builder.finish()
}
