//! Where tiles come from.

use cullet::cull::occlusion::Occluder;
use cullet::lod::Levels;
use cullet::{Instance, Mesh};
use thiserror::Error;

/// The name of a tile in its source.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TileId(pub u64);

/// Facts about a tile that are known before it is loaded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TileInfo {
    /// A box that contains all of its instances and those of all tiles below it, low and high
    /// corner, in the world.
    pub bounds: [[f64; 3]; 2],
    /// How far what it shows may be from what is there, in units of the world; 0 of a tile that
    /// shows all there is.
    pub error: f64,
    /// Its instances; of those that are its own alone.
    pub instances: u32,
    /// Vertices and triangles of its own meshes.
    pub meshes: [u64; 2],
    /// Whether the tiles below it are shown beside it, and not in its place.
    pub adds: bool,
}

/// Contents of a tile.
#[derive(Clone, Debug, Default)]
pub struct TileContent {
    /// Its instances; their meshes are numbers of [`TileSource::meshes`], and above those of
    /// `meshes`. What stands in for something else must have
    /// [`no_occlusion`](cullet::InstanceFlags::no_occlusion).
    pub instances: Vec<Instance>,
    /// Meshes that it alone has.
    pub meshes: Vec<Mesh>,
    /// Levels of detail of its own meshes: of which, which holds them, both by their numbers among
    /// `meshes`, and what they are.
    pub levels: Vec<([u32; 2], Levels)>,
    /// Occluders of its own meshes, by their numbers among `meshes`: shapes that lie within what a
    /// mesh hides. Where one costs less than half of what the mesh's own triangles do, it is drawn
    /// in their place.
    pub occluders: Vec<(u32, Occluder)>,
}

impl TileContent {
    /// Returns the size of the contents: instances, and vertices and triangles of the meshes.
    pub(crate) fn size(&self) -> (u32, [u64; 2]) {
        let instances = u32::try_from(self.instances.len()).unwrap_or(u32::MAX);
        let vertices = self.meshes.iter().map(|m| m.positions().len() as u64).sum();
        let triangles = self.meshes.iter().map(|m| u64::from(m.triangle_count())).sum();
        (instances, [vertices, triangles])
    }
}

/// Why a tile is not there.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum TileError {
    /// It cannot be loaded.
    #[error("tile {tile:#x}: {reason}; what is coarser is shown in its place")]
    Load {
        /// Which.
        tile: u64,
        /// Why not.
        reason: String,
    },
    /// The coarsest tiles alone exceed the budget.
    #[error("the coarsest tiles need {bytes} bytes, above the budget of {budget}: allow more")]
    Budget {
        /// Bytes that they need.
        bytes: u64,
        /// Bytes of the budget.
        budget: u64,
    },
    /// A mesh of the source cannot be used.
    #[error("the meshes of the world: {0}")]
    Meshes(String),
    /// No thread could be started to load tiles.
    #[error("no thread can be started: {0}")]
    Thread(String),
}

/// A world as a hierarchy of tiles. All is a function of the tile alone; any thread may ask at any
/// time.
pub trait TileSource: Send + Sync + 'static {
    /// The meshes that instances of any tile name. Always in memory.
    fn meshes(&self) -> &[Mesh];

    /// The coarsest tiles, which together are the whole world. They are always loaded.
    fn roots(&self) -> Vec<TileId>;

    /// Returns the facts that are known of a tile.
    fn info(&self, tile: TileId) -> TileInfo;

    /// Adds the tiles that together show the place of this one with less error; none for the
    /// finest.
    fn children(&self, tile: TileId, out: &mut Vec<TileId>);

    /// Loads a tile. May take long.
    ///
    /// # Errors
    /// If it cannot be loaded.
    fn load(&self, tile: TileId) -> Result<TileContent, TileError>;

    /// Bytes that the source takes itself, whatever is loaded; they are of the budget. Default:
    /// none.
    fn bytes(&self) -> u64 {
        0
    }

    /// The cells that some points are in, of those for which it is known which tiles can be seen
    /// from them; none where one of the points is in no such cell, so that nothing is known.
    /// Default: none.
    fn cells_of(&self, _points: &[[f64; 3]]) -> Vec<u32> {
        Vec::new()
    }

    /// Whether anything of a tile, or of those below it, can be seen from one of some cells, as far
    /// as is known. Says what is loaded first and never what is drawn, so that an answer may be
    /// wrong. Default: yes.
    fn is_seen(&self, _tile: TileId, _cells: &[u32]) -> bool {
        true
    }
}
