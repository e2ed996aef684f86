//! Content of a tile: glTF, or glTF within b3dm.

use std::path::{Path, PathBuf};

use glam::DMat4;

use super::files::{file, within};
use super::join::Joint;
use super::json;
use super::place::y_up_to_z_up;
use cullet_io::reader::Beside;
use cullet_io::reader::Source;
use cullet_io::reader::{Counts, counts as gltf_counts, load_gltf};
use cullet_io::{ErrorKind, LoadOptions};

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
    let model = load_gltf(path, glb, options, beside).map_err(at)?;
    let transform = *frame * *transform * moved * y_up_to_z_up();
    joint.add(&path.with_extension("").to_string_lossy(), model, &transform).map_err(at)
}

/// The glTF of a content, and by how much it is moved within its tile.
fn content(path: &Path, mut bytes: Vec<u8>) -> Result<(Vec<u8>, DMat4), ErrorKind> {
    match bytes.get(..4) {
        Some(b"b3dm") => {
            let Tables { features, end } = tables(&bytes, bytes.len() as u64)?;
            let moved = json::relative_to(&bytes[FIRST_TABLE..FIRST_TABLE + features]);
            Ok((bytes.split_off(end), moved))
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

/// Bytes before the tables of a b3dm.
const FIRST_TABLE: usize = 28;

/// Part of a b3dm before its glTF.
struct Tables {
    /// Bytes of the first table.
    features: usize,
    /// Where the last ends.
    end: usize,
}

/// The tables of a b3dm of so many bytes, by its first ones.
fn tables(head: &[u8], size: u64) -> Result<Tables, ErrorKind> {
    let word = |k: usize| {
        let bytes = head.get(4 * k..4 * k + 4)?;
        Some(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]) as usize)
    };
    let all = || {
        let lengths = [word(3)?, word(4)?, word(5)?, word(6)?];
        let end = lengths.iter().try_fold(FIRST_TABLE, |a, &b| a.checked_add(b))?;
        (end as u64 <= size).then_some(Tables { features: lengths[0], end })
    };
    all().ok_or_else(|| {
        let message = format!("its tables do not end within its {size} bytes");
        ErrorKind::invalid("b3dm header", message)
    })
}

/// How much a file takes at the most, by the counts in its header; `None` where that cannot be told
/// from them.
pub(super) fn counts(path: &Path) -> Result<Option<Counts>, ErrorKind> {
    let source = Source::open(path)?;
    let head = source.head(FIRST_TABLE)?;
    if !head.starts_with(b"b3dm") {
        return gltf_counts(&source);
    }
    let Tables { end, .. } = tables(&head, source.size())?;
    gltf_counts(&source.after(end as u64))
}
