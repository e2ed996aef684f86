//! 3D Tiles (OGC, *3D Tiles Specification* 1.1, 2022; 1.0 too), as one model of what is finest.
//!
//! Tiles are z-up and their glTF contents y-up, unless `gltfUpAxis` says otherwise; a tileset on
//! the globe is turned so that up, at the middle of its root, is +Y, east +X and south +Z, and moved
//! so that this middle is the origin. One is on the globe if its root has a `region`, or its middle
//! is near the ellipsoid; [`LoadOptions::up`] says that it is not.

mod content;
mod cut;
mod files;
mod globe;
mod globe_place;
mod implicit;
mod join;
mod json;
mod options;
mod packed;
mod part;
mod place;
mod sight;
mod tree;
mod write;

use std::path::{Path, PathBuf};

use cullet_io::reader::Beside;
use cullet_io::{ErrorKind, LoadOptions, Model};
pub use globe_place::GlobePlace;
use join::Joint;
pub use json::TileSize;
pub use options::{StandInOf, TileInput, TileStandIn, TilesWritten, WriteTiles};
pub use sight::{TileSets, TileSight};
pub use tree::{TileNode, TileTree};
pub use write::{write_tiles, write_tiles_with};

/// Loads a tileset: of each branch the finest contents; of tiles that add to their parents, the
/// parents' too.
pub(crate) fn load(
    path: &Path,
    bytes: &[u8],
    options: &LoadOptions,
    beside: Beside<'_>,
) -> Result<Model, ErrorKind> {
    let own = PathBuf::from(path.file_name().unwrap_or_default());
    let tree = tree::read(&own, bytes, options, beside)?;
    let mut joint = Joint::new(&own.to_string_lossy(), options);
    for message in &tree.notes {
        joint.warn("tileset", message.clone());
    }
    joint.unread.clone_from(&tree.unread);
    for piece in tree.finest(0) {
        content::add(&mut joint, piece, &tree.frame, options, beside)?;
    }
    joint.check()?;
    Ok(joint.finish())
}
