//! What a tile shows: glTF, or glTF within b3dm.

use std::path::{Path, PathBuf};

use glam::DMat4;

use super::files::{file, within};
use super::join::Joint;
use super::json;
use super::place::y_up_to_z_up;
use crate::beside::Beside;
use crate::{ErrorKind, LoadOptions};

/// A content that is drawn, and where.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    pub(super) path: PathBuf,
    pub(super) transform: DMat4,
}

/// Adds a content to those that are joined.
pub(super) fn add(
    joint: &mut Joint<'_>,
    Piece { path, transform }: &Piece,
    frame: &DMat4,
    options: &LoadOptions,
    beside: Beside<'_>,
) -> Result<(), ErrorKind> {
    let bytes = file(path, beside)?;
    let at = |error| within(path, error);
    let (glb, moved) = content(path, bytes).map_err(at)?;
    // What a content names is beside it.
    let folder = match beside {
        Beside::Folder(root) => Some(root.join(path.parent().unwrap_or(Path::new("")))),
        Beside::Given(_) => None,
    };
    let beside = folder.as_deref().map_or(beside, Beside::Folder);
    let model = crate::gltf::load(path, glb, options, beside).map_err(at)?;
    let transform = *frame * *transform * moved * y_up_to_z_up();
    joint.add(&path.with_extension("").to_string_lossy(), model, &transform).map_err(at)
}

/// The glTF of a content, and by how much it is moved within its tile.
fn content(path: &Path, mut bytes: Vec<u8>) -> Result<(Vec<u8>, DMat4), ErrorKind> {
    match bytes.get(..4) {
        Some(b"b3dm") => {
            let invalid = || {
                let size = bytes.len();
                ErrorKind::invalid(
                    "b3dm header",
                    format!("its tables do not end within its {size} bytes"),
                )
            };
            let word = |k: usize| {
                let bytes = bytes.get(4 * k..4 * k + 4)?;
                Some(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]) as usize)
            };
            let [Some(features), Some(more), Some(batches), Some(last)] = [3, 4, 5, 6].map(word)
            else {
                return Err(invalid());
            };
            let begin =
                [features, more, batches, last].iter().try_fold(28_usize, |a, &b| a.checked_add(b));
            let begin = begin.filter(|&b| b <= bytes.len()).ok_or_else(invalid)?;
            let moved = json::relative_to(&bytes[28..28 + features]);
            Ok((bytes.split_off(begin), moved))
        }
        Some(kind @ (b"i3dm" | b"pnts" | b"cmpt")) => {
            let kind = String::from_utf8_lossy(kind);
            Err(ErrorKind::Unsupported(format!(
                "a tile of the kind {kind} is not read; `npx 3d-tiles-tools upgrade -i {} -o upgraded` makes glTF of it",
                path.display()
            )))
        }
        _ => Ok((bytes, DMat4::IDENTITY)),
    }
}
