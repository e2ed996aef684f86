//! Loading of every format that is read.

use std::path::Path;

use cullet_io::reader::{self, Beside, Format, Source, recognise};
#[cfg(all(feature = "tiles", not(target_family = "wasm")))]
use cullet_io::reader::{JsonKind, json_kind, load_gltf};
use cullet_io::{ErrorKind, LoadError, LoadOptions, Model};

use crate::{bsp, occscn};

/// Loads a model of any format: 3D Tiles, a Quake or Quake 3 map, `OCCSCN01`, or one that
/// [`cullet_io::load`] reads; told by content first, then by ending.
///
/// A map has z up; its walls are one-sided, and a mesh is what is in one of its cells. All else is
/// said of [`cullet_io::load`].
///
/// # Errors
/// As [`cullet_io::load`].
pub fn load(path: &Path, options: &LoadOptions) -> Result<Model, LoadError> {
    reader::load_by(path, options, decode)
}

/// Loads a model of any format from memory, as [`cullet_io::load_bytes`] does.
///
/// # Errors
/// As [`cullet_io::load`].
pub fn load_bytes(name: &str, bytes: &[u8], options: &LoadOptions) -> Result<Model, LoadError> {
    load_bytes_with(name, bytes, &[], options)
}

/// Loads a model of any format from memory with the files that it names, as
/// [`cullet_io::load_bytes_with`] does.
///
/// # Errors
/// As [`cullet_io::load`].
pub fn load_bytes_with(
    name: &str,
    bytes: &[u8],
    beside: &[(String, Vec<u8>)],
    options: &LoadOptions,
) -> Result<Model, LoadError> {
    reader::load_bytes_by(name, bytes, beside, options, decode)
}

/// Endings of files that hold a scene and no cells.
const SCENES: [&str; 7] = ["glb", "gltf", "obj", "ply", "stl", "off", "occscn"];

/// Whether a path ends as files do that hold a scene rather than a map.
#[must_use]
pub fn has_scene_ending(path: &Path) -> bool {
    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
    SCENES.iter().any(|e| e.eq_ignore_ascii_case(ending))
}

/// Decodes a file of any format.
fn decode(
    path: &Path,
    source: Source<'_>,
    options: &LoadOptions,
    beside: Beside<'_>,
) -> Result<Model, ErrorKind> {
    let name = path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let head = source.head(Source::HEAD)?;
    let builder = match recognise(path, &head, source.size())? {
        // A page has no folder of tiles, and every kilobyte of it is waited for.
        #[cfg(not(all(feature = "tiles", not(target_family = "wasm"))))]
        Format::Tileset => {
            let why = match cfg!(target_family = "wasm") {
                true => "3D Tiles name other files, which a page does not have",
                false => "3D Tiles are left out of this build: it needs the feature tiles",
            };
            return Err(ErrorKind::Unsupported(why.into()));
        }
        #[cfg(all(feature = "tiles", not(target_family = "wasm")))]
        Format::Tileset => {
            return crate::tileset::load(path, &source.into_bytes()?, options, beside);
        }
        // The root of a tileset may stand behind any amount of its schema.
        #[cfg(all(feature = "tiles", not(target_family = "wasm")))]
        Format::Gltf if is_undecided(&head, source.size()) => {
            let bytes = source.into_bytes()?;
            return match json_kind(&bytes) {
                JsonKind::Tileset => crate::tileset::load(path, &bytes, options, beside),
                _ => load_gltf(path, bytes, options, beside),
            };
        }
        Format::Occscn => occscn::read(&name, &source.into_bytes()?, options)?,
        Format::Bsp => bsp::read(&name, &source.into_bytes()?, options)?,
        _ => return reader::decode(path, source, options, beside),
    };
    builder.finish()
}

/// Whether the head of a file is that of JSON of which it does not tell what it is.
#[cfg(all(feature = "tiles", not(target_family = "wasm")))]
fn is_undecided(head: &[u8], size: u64) -> bool {
    size > head.len() as u64 && !head.starts_with(b"glTF") && json_kind(head) == JsonKind::Unknown
}
