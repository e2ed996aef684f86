//! Content of a tile: glTF, or glTF within b3dm, i3dm or cmpt.

use std::path::{Path, PathBuf};

use glam::DMat4;

use super::files::{file, local, within};
use super::join::Joint;
use super::json::GltfUp;
use super::packed::{self, FIRST_TABLE, Gltf, Part};
use super::place::gltf_to_z_up;
use cullet_io::reader::Beside;
use cullet_io::reader::{Counts, JsonKind, Source, counts as gltf_counts, json_kind, load_tile};
use cullet_io::{ErrorKind, LoadOptions};

/// A content that is drawn, and where.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    /// From the folder of the outermost tileset.
    pub(super) path: PathBuf,
    pub(super) transform: DMat4,
    pub(super) up: GltfUp,
}

/// Adds a content to those that are joined.
pub(super) fn add(
    joint: &mut Joint<'_>,
    Piece { path, transform, up }: &Piece,
    frame: &DMat4,
    options: &LoadOptions,
    beside: Beside<'_>,
) -> Result<(), ErrorKind> {
    let at = |error| within(path, error);
    let parts = packed::parts(file(path, beside)?, transform).map_err(at)?;
    // The axis that the options name is the tileset's.
    let options = LoadOptions { up: None, ..options.clone() };
    for part in parts {
        let (path, bytes, places) = match part {
            Part::Points => {
                joint.points.push(path.clone());
                continue;
            }
            Part::Drawn { gltf: Gltf::Inside(bytes), places } => (path.clone(), bytes, places),
            Part::Drawn { gltf: Gltf::Named(uri), places } => {
                let path = local(path.parent().unwrap_or(Path::new("")), &uri).map_err(at)?;
                let bytes = file(&path, beside)?;
                (path, bytes, places)
            }
        };
        let at = |error| within(&path, error);
        if json_kind(&bytes) == JsonKind::Tileset {
            let message = "it is a tileset, and within another the names of those end in .json";
            return Err(at(ErrorKind::Unsupported(message.to_owned())));
        }
        // What a content names is beside it.
        let beside = match beside {
            Beside::Folder(root) => Beside::Below(root, path.parent().unwrap_or(Path::new(""))),
            given => given,
        };
        let (model, centre) = load_tile(&path, bytes, &options, beside).map_err(at)?;
        let outer = *frame * *transform;
        let inner = DMat4::from_translation(centre.into()) * gltf_to_z_up(*up);
        let places: Vec<DMat4> = places.iter().map(|p| outer * *p * inner).collect();
        joint.add(&path.with_extension("").to_string_lossy(), model, &places).map_err(at)?;
    }
    Ok(())
}

/// How much a file takes at the most, by the counts in its header; `None` where that cannot be told
/// from them.
pub(super) fn counts(path: &Path) -> Result<Option<Counts>, ErrorKind> {
    let source = Source::open(path)?;
    let head = source.head(FIRST_TABLE)?;
    if !head.starts_with(b"b3dm") {
        return gltf_counts(&source);
    }
    let end = packed::end_of_b3dm_tables(&head, source.size())?;
    gltf_counts(&source.after(end as u64))
}
