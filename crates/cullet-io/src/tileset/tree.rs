//! Tilesets as a tree of tiles, each of which may be loaded by itself.

use std::path::{Path, PathBuf};

use glam::DMat4;

use super::join::Joint;
use super::json::{self, Extras, Refine, TileJson, TileSize, TilesetJson};
use super::{add, place, within};
use crate::beside::{Beside, Missing};
use crate::gltf::uri::{self, UriSource};
use crate::{ErrorKind, LoadError, LoadOptions, Model};

/// The most tilesets that lie within each other.
const DEEPEST: usize = 32;
/// The most bytes of a tileset's JSON, or of a tile.
const LARGEST: u64 = 1 << 31;
/// The most tiles of a tree.
const MOST: usize = 1 << 24;

/// A content that is drawn, and where.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    pub(super) path: PathBuf,
    pub(super) transform: DMat4,
}

/// What is known of a tile before it is loaded.
#[derive(Clone, Debug)]
pub struct TileNode {
    /// A box around it and all below it, as its tileset states, in the space of the scene; infinite where it states none.
    pub bounds: [[f64; 3]; 2],
    /// How far what it shows is off while nothing below it is shown, as its tileset states, in units of the scene.
    pub error: f64,
    /// Whether the tiles below it are shown beside it, and not in its place.
    pub adds: bool,
    /// The tiles below it.
    pub children: Vec<u32>,
    /// What it takes, where the tileset was written by [`write_tiles`](super::write_tiles).
    pub size: Option<TileSize>,
    contents: Vec<Piece>,
}

impl TileNode {
    /// Whether it shows anything itself.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.contents.is_empty()
    }
}

/// The tiles of a tileset, those of tilesets within it too. The first is the root.
#[derive(Debug)]
pub(super) struct Tree {
    pub(super) frame: DMat4,
    pub(super) tiles: Vec<TileNode>,
}

impl Tree {
    /// Contents of what is finest below a tile. As deep as the tree, which the reader limits.
    pub(super) fn finest(&self, tile: u32) -> Vec<&Piece> {
        let node = &self.tiles[tile as usize];
        let below: Vec<&Piece> =
            node.children.iter().flat_map(|&child| self.finest(child)).collect();
        match node.adds || below.is_empty() {
            true => below.into_iter().chain(&node.contents).collect(),
            false => below,
        }
    }
}

/// A tileset whose tiles are loaded one by one. Its JSON is in memory, and that of all tilesets within it.
#[derive(Debug)]
pub struct TileTree {
    folder: PathBuf,
    tree: Tree,
    options: LoadOptions,
}

impl TileTree {
    /// Opens a `tileset.json`.
    ///
    /// # Errors
    /// If it, or a tileset within it, cannot be read or is invalid.
    pub fn open(path: &Path, options: &LoadOptions) -> Result<Self, LoadError> {
        let fail = |kind| LoadError { path: path.to_owned(), kind };
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let own = PathBuf::from(path.file_name().unwrap_or_default());
        let beside = Beside::Folder(&folder);
        let tree = file(&own, beside).and_then(|bytes| read(&own, &bytes, beside));
        let tree = tree.map_err(fail)?;
        Ok(Self { folder, tree, options: options.clone() })
    }

    /// The tiles; the first is the root.
    #[must_use]
    pub fn tiles(&self) -> &[TileNode] {
        &self.tree.tiles
    }

    /// Bytes of the files that a tile shows; of those that are missing none.
    #[must_use]
    pub fn file_bytes(&self, tile: u32) -> u64 {
        let contents = self.tree.tiles.get(tile as usize).map_or(&[][..], |node| &node.contents);
        let size =
            |piece: &Piece| std::fs::metadata(self.folder.join(&piece.path)).map_or(0, |m| m.len());
        contents.iter().map(size).sum()
    }

    /// Loads what a tile shows itself. A tile that there is not shows nothing.
    ///
    /// # Errors
    /// If one of its files cannot be loaded.
    pub fn load(&self, tile: u32) -> Result<Model, LoadError> {
        let contents = self.tree.tiles.get(tile as usize).map_or(&[][..], |node| &node.contents);
        let mut joint = Joint::new(&format!("tile {tile}"), &self.options);
        for piece in contents {
            let beside = Beside::Folder(&self.folder);
            add(&mut joint, piece, &self.tree.frame, &self.options, beside)
                .map_err(|kind| LoadError { path: self.folder.join(&piece.path), kind })?;
        }
        Ok(joint.finish())
    }
}

/// Reads the tree of a tileset.
pub(super) fn read(own: &Path, bytes: &[u8], beside: Beside<'_>) -> Result<Tree, ErrorKind> {
    let tileset = json::read(bytes)?;
    let frame = place::frame(&tileset.root)?;
    let mut walk = Walk { beside, frame, within: Vec::new(), tiles: Vec::new() };
    walk.tileset(own, &tileset, DMat4::IDENTITY)?;
    Ok(Tree { frame, tiles: walk.tiles })
}

struct Walk<'a> {
    beside: Beside<'a>,
    frame: DMat4,
    /// The tilesets that are being read, the outermost first.
    within: Vec<PathBuf>,
    tiles: Vec<TileNode>,
}

impl Walk<'_> {
    /// Adds the tiles of a tileset that is placed by a transform; its root.
    fn tileset(
        &mut self,
        path: &Path,
        tileset: &TilesetJson,
        transform: DMat4,
    ) -> Result<u32, ErrorKind> {
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
        let root = self.tile(&folder, &tileset.root, transform, Refine::Replace);
        self.within.pop();
        root.map_err(|error| if self.within.is_empty() { error } else { within(path, error) })
    }

    /// Adds a tile and those below it. As deep as its JSON, which the reader limits.
    fn tile(
        &mut self,
        folder: &Path,
        tile: &TileJson,
        above: DMat4,
        refine: Refine,
    ) -> Result<u32, ErrorKind> {
        let transform = above * place::matrix(tile.transform.as_ref())?;
        let refine = tile.refine.unwrap_or(refine);
        if tile.implicit_tiling.is_some() {
            return Err(ErrorKind::Unsupported(
                "implicit tiling is not read yet; `npx 3d-tiles-tools convert` writes its tiles out".into(),
            ));
        }
        if self.tiles.len() == MOST {
            let (item, count) = ("tiles".to_owned(), MOST as u64 + 1);
            return Err(ErrorKind::OverLimit { item, count, limit: MOST as u64 });
        }
        let number = self.tiles.len() as u32;
        let error = tile.geometric_error * place::scale(&(self.frame * transform));
        self.tiles.push(TileNode {
            bounds: place::bounds(&tile.bounding_volume, &(self.frame * transform), &self.frame),
            // What is no number might be anything.
            error: if error >= 0.0 { error } else { f64::INFINITY },
            adds: refine == Refine::Add,
            children: Vec::new(),
            size: match tile.extras {
                Some(Extras::Ours { cullet }) => Some(cullet),
                _ => None,
            },
            contents: Vec::new(),
        });
        let mut children = Vec::new();
        for child in &tile.children {
            children.push(self.tile(folder, child, transform, refine)?);
        }
        let (mut contents, mut inner) = (Vec::new(), Vec::new());
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
            if !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json")) {
                contents.push(Piece { path, transform });
            } else if children.is_empty() || refine == Refine::Add {
                let bytes = file(&path, self.beside)?;
                let tileset = json::read(&bytes).map_err(|e| within(&path, e))?;
                inner.push(self.tileset(&path, &tileset, transform)?);
            }
        }
        let node = &mut self.tiles[number as usize];
        // A tileset within is content of this tile, and stands beside what else is.
        node.adds |= !inner.is_empty();
        children.extend(inner);
        (node.children, node.contents) = (children, contents);
        Ok(number)
    }
}

/// The bytes of a file that a tileset names.
pub(super) fn file(path: &Path, beside: Beside<'_>) -> Result<Vec<u8>, ErrorKind> {
    let item = || path.display().to_string();
    match beside.read(path, LARGEST) {
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
