//! 3D Tiles (OGC, *3D Tiles Specification* 1.1, 2022; 1.0 too), as one model of what is finest.
//!
//! Tiles are z-up and their glTF contents y-up; a tileset on the globe is turned so that up, at the middle of its root, is +Y,
//! east +X and south +Z, and moved so that this middle is the origin.

mod join;
mod json;
mod place;

use std::path::{Path, PathBuf};

use glam::DMat4;

use crate::beside::{Beside, Missing};
use crate::gltf::uri::{self, UriSource};
use crate::{ErrorKind, LoadOptions, Model};
use join::Joint;
use json::{Refine, TileJson, TilesetJson};
use place::{frame, y_up_to_z_up};

/// The most tilesets that lie within each other.
const DEEPEST: usize = 32;
/// The most bytes of a tileset's JSON, or of a tile.
const LARGEST: u64 = 1 << 31;

/// A content that is drawn, and where.
#[derive(Debug)]
struct Piece {
    path: PathBuf,
    transform: DMat4,
}

/// Loads a tileset: of each branch the finest contents; of tiles that add to their parents, the parents' too.
pub(crate) fn load(
    path: &Path,
    bytes: &[u8],
    options: &LoadOptions,
    beside: Beside<'_>,
) -> Result<Model, ErrorKind> {
    let tileset = json::read(bytes)?;
    let frame = frame(&tileset.root)?;
    let mut walk = Walk { beside, within: Vec::new() };
    let own = PathBuf::from(path.file_name().unwrap_or_default());
    let pieces = walk.tileset(&own, &tileset, DMat4::IDENTITY)?;
    let name = own.to_string_lossy().into_owned();
    let mut joint = Joint::new(&name, options);
    for Piece { path, transform } in pieces {
        let bytes = walk.read(&path)?;
        let at = |error| within(&path, error);
        let (glb, moved) = content(&path, bytes).map_err(at)?;
        // What a content names is beside it.
        let folder = match beside {
            Beside::Folder(root) => Some(root.join(path.parent().unwrap_or(Path::new("")))),
            Beside::Given(_) => None,
        };
        let beside = folder.as_deref().map_or(beside, Beside::Folder);
        let model = crate::gltf::load(&path, glb, options, beside).map_err(at)?;
        let transform = frame * transform * moved * y_up_to_z_up();
        joint.add(&path.with_extension("").to_string_lossy(), model, &transform).map_err(at)?;
    }
    Ok(joint.finish())
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

/// The same error, with the file that it is in.
fn within(path: &Path, error: ErrorKind) -> ErrorKind {
    let path = path.display();
    match error {
        ErrorKind::Invalid { item, message } => {
            ErrorKind::Invalid { item: format!("{path}, {item}"), message }
        }
        ErrorKind::OverLimit { item, count, limit } => {
            ErrorKind::OverLimit { item: format!("{path}, {item}"), count, limit }
        }
        ErrorKind::Unsupported(message) => ErrorKind::Unsupported(format!("{path}: {message}")),
        ErrorKind::Io(error) => {
            ErrorKind::Io(std::io::Error::new(error.kind(), format!("{path}: {error}")))
        }
    }
}

struct Walk<'a> {
    beside: Beside<'a>,
    /// The tilesets that are being read, the outermost first.
    within: Vec<PathBuf>,
}

impl Walk<'_> {
    /// What is drawn of a tileset that is placed by a transform.
    fn tileset(
        &mut self,
        path: &Path,
        tileset: &TilesetJson,
        transform: DMat4,
    ) -> Result<Vec<Piece>, ErrorKind> {
        if self.within.iter().any(|p| p == path) {
            return Err(ErrorKind::invalid(
                path.display().to_string(),
                "this tileset is within itself, so that it never ends",
            ));
        }
        if self.within.len() == DEEPEST {
            let (item, count) = ("tilesets within each other".to_owned(), DEEPEST as u64 + 1);
            return Err(ErrorKind::OverLimit { item, count, limit: DEEPEST as u64 });
        }
        self.within.push(path.to_owned());
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let pieces = self.tile(&folder, &tileset.root, transform, Refine::Replace);
        self.within.pop();
        pieces.map_err(|error| if self.within.is_empty() { error } else { within(path, error) })
    }

    /// What is drawn of a tile. As deep as its JSON, which the reader limits.
    fn tile(
        &mut self,
        folder: &Path,
        tile: &TileJson,
        above: DMat4,
        refine: Refine,
    ) -> Result<Vec<Piece>, ErrorKind> {
        let transform = above * place::matrix(tile.transform.as_ref())?;
        let refine = tile.refine.unwrap_or(refine);
        if tile.implicit_tiling.is_some() {
            return Err(ErrorKind::Unsupported(
                "implicit tiling is not read yet; `npx 3d-tiles-tools convert` writes its tiles out".into(),
            ));
        }
        let mut pieces = Vec::new();
        for child in &tile.children {
            pieces.extend(self.tile(folder, child, transform, refine)?);
        }
        if refine == Refine::Replace && !pieces.is_empty() {
            return Ok(pieces);
        }
        for content in tile.content.iter().chain(&tile.contents) {
            let text = content.uri.as_deref().or(content.url.as_deref()).unwrap_or_default();
            let invalid = |message| ErrorKind::invalid(format!("content {text:?}"), message);
            // What follows a question mark is for servers.
            let plain = text.split('?').next().unwrap_or_default();
            let UriSource::File(path) = uri::read(plain).map_err(invalid)? else {
                return Err(invalid(
                    "data URIs are not read as tiles; write the tile to a file".into(),
                ));
            };
            let path = folder.join(path);
            if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json")) {
                let bytes = self.read(&path)?;
                let inner = json::read(&bytes).map_err(|e| within(&path, e))?;
                pieces.extend(self.tileset(&path, &inner, transform)?);
            } else {
                pieces.push(Piece { path, transform });
            }
        }
        Ok(pieces)
    }

    fn read(&self, path: &Path) -> Result<Vec<u8>, ErrorKind> {
        let item = || path.display().to_string();
        match self.beside.read(path, LARGEST) {
            Ok((bytes, size)) if size <= LARGEST => Ok(bytes.into_owned()),
            Ok((_, size)) => Err(ErrorKind::OverLimit {
                item: format!("bytes of {}", item()),
                count: size,
                limit: LARGEST,
            }),
            Err(Missing::Absent) => Err(ErrorKind::invalid(
                item(),
                "it is named by the tileset and is missing; put it beside the tileset",
            )),
            Err(Missing::NoFile) => Err(ErrorKind::invalid(item(), "it is no file")),
            Err(Missing::Unread(error)) => Err(within(path, ErrorKind::Io(error))),
        }
    }
}
