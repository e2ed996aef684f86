//! Tilesets as a tree of tiles, each of which may be loaded by itself.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use glam::DMat4;

use super::content::{Piece, add, counts};
use super::files::{file, local, within};
use super::implicit::{Place, Subtree};
use super::join::Joint;
use super::json::{self, GltfUp, ImplicitJson, Refine, TileJson, TileSize, TilesetJson, Volume};
use super::place::{self, Frame};
use super::sight::TileSight;
use cullet_io::reader::{Beside, FromJson, JsonKind, json_kind};
use cullet_io::{ErrorKind, LoadError, LoadOptions, Model};

/// The most tilesets that lie within each other.
const DEEPEST: usize = 32;
/// The most tiles above a tile of the same tileset: as many as a parser of JSON goes down, and no
/// stack is too small for.
const LOWEST: usize = 61;

/// The most tiles of a tree.
const MOST: usize = 1 << 24;

/// Facts about a tile that are known before it is loaded.
#[derive(Clone, Debug)]
pub struct TileNode {
    /// A box around it and all below it, as its tileset states, in the space of the scene; infinite
    /// where it states none.
    pub bounds: [[f64; 3]; 2],
    /// How far what it shows is off while nothing below it is shown, as its tileset states, in
    /// units of the scene.
    pub error: f64,
    /// Whether the tiles below it are shown beside it, and not in its place.
    pub adds: bool,
    /// The tiles below it.
    pub children: Vec<u32>,
    /// Size of the tile, where the tileset was written by [`write_tiles`](super::write_tiles).
    pub size: Option<TileSize>,
    /// Its number in the rows of [visible sets](TileTree::sight), where it has one.
    pub number: Option<u32>,
    contents: Vec<Piece>,
}

impl TileNode {
    /// Whether it shows anything itself.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.contents.is_empty()
    }

    /// Whether what it shows stands in for what is finer: tiles below it are shown in its place.
    #[must_use]
    pub fn is_stand_in(&self) -> bool {
        !self.adds && !self.children.is_empty()
    }
}

/// The tiles of a tileset, those of tilesets within it too. The first is the root.
#[derive(Debug)]
pub(super) struct Tree {
    pub(super) frame: DMat4,
    pub(super) tiles: Vec<TileNode>,
    /// The file of its visible sets, where it is in the space of the scene.
    sight: Option<String>,
    /// Notes for the user about how it was read.
    pub(super) notes: Vec<String>,
    /// Extensions that are not read.
    pub(super) unread: Vec<String>,
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

/// A tileset whose tiles are loaded one by one. Its JSON is in memory, and that of all tilesets
/// within it.
#[derive(Debug)]
pub struct TileTree {
    folder: PathBuf,
    tree: Tree,
    sight: Option<TileSight>,
    options: LoadOptions,
}

impl TileTree {
    /// Opens a `tileset.json`.
    ///
    /// # Errors
    /// If it, a tileset within it or its visible sets cannot be read or are invalid.
    pub fn open(path: &Path, options: &LoadOptions) -> Result<Self, LoadError> {
        let fail = |kind| LoadError { path: path.to_owned(), kind };
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let own = PathBuf::from(path.file_name().unwrap_or_default());
        let beside = Beside::Folder(&folder);
        let bytes = file(&own, beside).map_err(fail)?;
        let tree = read(&own, &bytes, options, beside).map_err(fail)?;
        let sight = tree.sight.as_deref().map(|name| {
            let path = local(Path::new(""), name)?;
            let bytes = file(&path, beside)?;
            TileSight::from_bytes(&bytes).map_err(|e| within(&path, e))
        });
        let sight = sight.transpose().map_err(fail)?;
        Ok(Self { folder, tree, sight, options: options.clone() })
    }

    /// Returns which tiles can be seen from each place, if the tileset says that.
    #[must_use]
    pub fn sight(&self) -> Option<&TileSight> {
        self.sight.as_ref()
    }

    /// Bytes that the tree itself takes in memory, near enough: its tiles, the names of their
    /// files, and its visible sets.
    #[must_use]
    pub fn size(&self) -> u64 {
        let name = |piece: &Piece| size_of::<Piece>() + piece.path.as_os_str().len();
        let tile = |node: &TileNode| {
            size_of::<TileNode>()
                + size_of_val(&node.children[..])
                + node.contents.iter().map(name).sum::<usize>()
        };
        let sight = self.sight.as_ref().map_or(0, TileSight::size);
        (self.tree.tiles.iter().map(tile).sum::<usize>() + sight) as u64
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

    /// Returns an upper bound of a tile's size: as its tileset states, else by the counts in the
    /// headers of its files, which are all that is read. `None` where they do not tell: where
    /// meshes deform, or have levels of detail, or a file cannot be read.
    #[must_use]
    pub fn counted(&self, tile: u32) -> Option<TileSize> {
        let node = self.tree.tiles.get(tile as usize)?;
        if node.size.is_some() {
            return node.size;
        }
        node.contents.iter().try_fold(TileSize::default(), |sum, piece| {
            let own = counts(&self.folder.join(&piece.path)).ok()??;
            Some(TileSize {
                instances: sum.instances.checked_add(u32::try_from(own.instances).ok()?)?,
                vertices: sum.vertices.checked_add(own.vertices)?,
                triangles: sum.triangles.checked_add(own.triangles)?,
            })
        })
    }

    /// Loads what a tile shows itself, with what was baked of its meshes where it has one content.
    /// A tile that there is not shows nothing.
    ///
    /// # Errors
    /// If one of its files cannot be loaded.
    pub fn load(&self, tile: u32) -> Result<Model, LoadError> {
        let contents = self.tree.tiles.get(tile as usize).map_or(&[][..], |node| &node.contents);
        let mut joint = Joint::with_levels(&format!("tile {tile}"), &self.options);
        for piece in contents {
            let beside = Beside::Folder(&self.folder);
            add(&mut joint, piece, &self.tree.frame, &self.options, beside)
                .map_err(|kind| LoadError { path: self.folder.join(&piece.path), kind })?;
        }
        Ok(joint.finish())
    }
}

/// Reads the tree of a tileset.
pub(super) fn read(
    own: &Path,
    bytes: &[u8],
    options: &LoadOptions,
    beside: Beside<'_>,
) -> Result<Tree, ErrorKind> {
    let tileset = json::read(bytes)?;
    let Frame { frame, note, is_ours } = place::frame(&tileset.root, options.up)?;
    let mut walk = Walk {
        beside,
        frame,
        within: Vec::new(),
        depth: 0,
        up: GltfUp::default(),
        requests: 0,
        unread: BTreeSet::new(),
        tiles: Vec::new(),
    };
    walk.tileset(own, &tileset, DMat4::IDENTITY)?;
    let ours = tileset.root.extras.0.filter(|_| is_ours);
    let sight = ours.and_then(|ours| ours.cells);
    let requests = (walk.requests > 0).then(|| {
        format!(
            "viewerRequestVolume is ignored: tiles are read as seen from everywhere; {} of them have one",
            walk.requests
        )
    });
    let notes = note.into_iter().chain(requests).collect();
    Ok(Tree { frame, tiles: walk.tiles, sight, notes, unread: walk.unread.into_iter().collect() })
}

struct Walk<'a> {
    beside: Beside<'a>,
    frame: DMat4,
    /// The tilesets that are being read, the outermost first.
    within: Vec<PathBuf>,
    /// How many tiles of a tileset are above the one that is being read.
    depth: usize,
    /// The axis of glTF contents that points up in the tileset that is being read.
    up: GltfUp,
    /// How many tiles have a `viewerRequestVolume`.
    requests: usize,
    /// Extensions that are not read.
    unread: BTreeSet<String>,
    tiles: Vec<TileNode>,
}

impl Walk<'_> {
    /// Adds the tiles of a tileset that is placed by a transform; its root.
    fn tileset(
        &mut self,
        path: &Path,
        tileset: &TilesetJson<'_>,
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
        self.unread.extend(tileset.unread().map(str::to_owned));
        let above = std::mem::take(&mut self.depth);
        let own = tileset.asset.gltf_up.unwrap_or(self.up);
        let outer = std::mem::replace(&mut self.up, own);
        let root = self.tile(&folder, &tileset.root, transform, Refine::Replace);
        (self.depth, self.up) = (above, outer);
        self.within.pop();
        root.map_err(|error| if self.within.is_empty() { error } else { within(path, error) })
    }

    /// Adds a tile and those below it, at most [`LOWEST`] deep.
    fn tile(
        &mut self,
        folder: &Path,
        tile: &TileJson<'_>,
        above: DMat4,
        refine: Refine,
    ) -> Result<u32, ErrorKind> {
        let transform = above * place::matrix(tile.transform.as_ref())?;
        let refine = tile.refine.unwrap_or(refine);
        self.requests += usize::from(tile.request_volume.is_some());
        if let Some(implicit) = tile.implicit() {
            implicit.check()?;
            let tiles = Implicit { folder, root: tile, implicit, transform, refine };
            return self.subtree(&tiles, Place::ROOT);
        }
        let number = self.push(tile, &tile.bounding_volume, 0, transform, refine)?;
        let mut children = Vec::new();
        if self.depth == LOWEST && !tile.children.is_empty() {
            let (item, count) = ("tiles below each other".to_owned(), LOWEST as u64 + 2);
            return Err(ErrorKind::OverLimit { item, count, limit: LOWEST as u64 + 1 });
        }
        self.depth += 1;
        for json in &tile.children {
            let child = TileJson::from_json(*json).map_err(|m| ErrorKind::invalid("tileset", m))?;
            children.push(self.tile(folder, &child, transform, refine)?);
        }
        self.depth -= 1;
        let (mut contents, mut inner) = (Vec::new(), Vec::new());
        for content in tile.all_contents() {
            let path = local(folder, content.text())?;
            if !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json")) {
                contents.push(Piece { path, transform, up: self.up });
            } else if children.is_empty() || refine == Refine::Add {
                let bytes = file(&path, self.beside)?;
                if json_kind(&bytes) == JsonKind::Gltf {
                    contents.push(Piece { path, transform, up: self.up });
                    continue;
                }
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

impl Walk<'_> {
    /// Adds a tile without children and contents, so many levels below the one that states its
    /// error.
    fn push(
        &mut self,
        tile: &TileJson<'_>,
        volume: &Volume,
        level: u32,
        transform: DMat4,
        refine: Refine,
    ) -> Result<u32, ErrorKind> {
        if self.tiles.len() == MOST {
            let (item, count) = ("tiles".to_owned(), MOST as u64 + 1);
            return Err(ErrorKind::OverLimit { item, count, limit: MOST as u64 });
        }
        let number = self.tiles.len() as u32;
        let ours = tile.extras.0.as_ref().filter(|_| level == 0);
        let to_scene = self.frame * transform;
        // Of implicit tiles it is half of that above.
        let error = tile.geometric_error * place::scale(&to_scene) * 0.5_f64.powi(level as i32);
        self.tiles.push(TileNode {
            bounds: place::bounds(volume, &to_scene, &self.frame),
            // What is no number might be anything.
            error: if error >= 0.0 { error } else { f64::INFINITY },
            adds: refine == Refine::Add,
            children: Vec::new(),
            size: ours.map(|ours| ours.size),
            number: ours.and_then(|ours| ours.number),
            contents: Vec::new(),
        });
        Ok(number)
    }

    /// Adds the tiles of the subtree that begins at a place, and those below; its root.
    fn subtree(&mut self, tiles: &Implicit<'_>, root: Place) -> Result<u32, ErrorKind> {
        let path = local(tiles.folder, &tiles.implicit.subtree_of(root).to_string_lossy())?;
        let bytes = file(&path, self.beside)?;
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let beside = self.beside;
        let buffer = |name: &Path| file(&local(&folder, &name.to_string_lossy())?, beside);
        let subtree =
            Subtree::read(&bytes, tiles.implicit, buffer).map_err(|e| within(&path, e))?;
        self.implicit(tiles, &subtree, root, Place::ROOT)
    }

    /// Adds a tile of a subtree, by its place in that, and those below it.
    fn implicit(
        &mut self,
        tiles: &Implicit<'_>,
        subtree: &Subtree,
        root: Place,
        at: Place,
    ) -> Result<u32, ErrorKind> {
        let Implicit { root: json, implicit, transform, refine, .. } = *tiles;
        let place = Place {
            level: root.level + at.level,
            at: std::array::from_fn(|a| (root.at[a] << at.level) + at.at[a]),
        };
        let volume = place.volume(&json.bounding_volume, implicit.axes());
        let number = self.push(json, &volume, place.level, transform, refine)?;
        let mut contents = Vec::new();
        for (k, content) in json.all_contents().enumerate() {
            if subtree.has_content(at, k) {
                let path = local(tiles.folder, &place.fill(content.text()))?;
                contents.push(Piece { path, transform, up: self.up });
            }
        }
        let mut children = Vec::new();
        for child in 0..1_u32 << implicit.axes() {
            let below = Place {
                level: at.level + 1,
                at: std::array::from_fn(|a| 2 * at.at[a] + (child >> a & 1)),
            };
            if place.level + 1 >= implicit.levels() {
                break;
            }
            if below.level < implicit.subtree_levels() {
                if subtree.has_tile(below) {
                    children.push(self.implicit(tiles, subtree, root, below)?);
                }
            } else if subtree.has_subtree(below) {
                let next = Place {
                    level: place.level + 1,
                    at: std::array::from_fn(|a| 2 * place.at[a] + (child >> a & 1)),
                };
                children.push(self.subtree(tiles, next)?);
            }
        }
        let node = &mut self.tiles[number as usize];
        (node.children, node.contents) = (children, contents);
        Ok(number)
    }
}

/// Implicit tiles: the folder that names are below, the tile that states them, and where that is.
struct Implicit<'a> {
    folder: &'a Path,
    root: &'a TileJson<'a>,
    implicit: &'a ImplicitJson,
    transform: DMat4,
    refine: Refine,
}
