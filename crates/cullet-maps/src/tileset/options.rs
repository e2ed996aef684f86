//! How models are written as tiles, and what is given for it.

use cullet::Mesh;

use super::globe_place::GlobePlace;
use super::sight::TileSets;
use cullet_io::{Attributes, Warning};

/// How a model is cut into tiles.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct WriteTiles {
    /// A tile is cut while it has more triangles than this, each instance counted. Default: 65,536.
    pub triangles: u64,
    /// Or more instances than this. Default: 4,096.
    pub instances: u32,
    /// Place of the scene's origin on the globe, with +X to the east, +Y up and +Z to the south; the
    /// scene's units are metres. The root then has this place as its transform, and every tile has a
    /// horizon occlusion point (`3DTILES_horizon_occlusion_point`). Default: none; tiles lie as the
    /// scene does.
    pub place: Option<GlobePlace>,
}

impl Default for WriteTiles {
    fn default() -> Self {
        Self { triangles: 1 << 16, instances: 4096, place: None }
    }
}

/// One mesh in the place of many instances.
#[derive(Clone, Debug)]
pub struct TileStandIn {
    /// The mesh. Its materials are the model's.
    pub mesh: Mesh,
    /// Attributes of its vertices, where there are any.
    pub attributes: Attributes,
    /// Where its origin is in the world.
    pub origin: [f64; 3],
    /// How far it is off at the most, in units of the world.
    pub error: f64,
}

/// Makes a stand-in of the instances of some slots whose error is not below a number; `None` where
/// there is none.
pub type StandInOf<'a> = &'a dyn Fn(&[u32], f64) -> Option<TileStandIn>;

/// Input of a tileset beside the instances of the model.
#[derive(Clone, Copy, Default)]
#[non_exhaustive]
pub struct TileInput<'a> {
    /// Maker of stand-ins. With it, tiles replace those above them, and each tile that has others
    /// below it shows a stand-in of all of their instances. Without it, tiles add to those above
    /// them.
    pub stand_in: Option<StandInOf<'a>>,
    /// Visible sets, to be written for each tile.
    pub sets: Option<TileSets<'a>>,
}

impl<'a> TileInput<'a> {
    /// Returns a copy with `stand_in`, a maker of stand-ins.
    #[must_use]
    pub fn with_stand_ins(self, stand_in: StandInOf<'a>) -> Self {
        Self { stand_in: Some(stand_in), ..self }
    }

    /// Returns a copy with `sets`.
    #[must_use]
    pub fn with_sets(self, sets: TileSets<'a>) -> Self {
        Self { sets: Some(sets), ..self }
    }
}

impl std::fmt::Debug for TileInput<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (stand_ins, sets) = (self.stand_in.is_some(), self.sets.is_some());
        f.debug_struct("TileInput").field("stand_ins", &stand_ins).field("sets", &sets).finish()
    }
}

/// Summary of the files that were written.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct TilesWritten {
    /// Tiles, and those of them that show something.
    pub tiles: [u32; 2],
    /// Instances in the files, without stand-ins.
    pub instances: u64,
    /// Their triangles, those of each instance.
    pub triangles: u64,
    /// Tiles that show a stand-in.
    pub stand_ins: u32,
    /// Triangles of all stand-ins.
    pub stand_in_triangles: u64,
    /// The largest error of a stand-in, in units of the world.
    pub stand_in_error: f64,
    /// Cells whose rows were written.
    pub cells: u32,
    /// Tiles with a horizon occlusion point.
    pub horizon_points: u32,
    /// How often a tile is cut at the most.
    pub depth: u32,
    /// Bytes of all files.
    pub bytes: u64,
    /// Notes about everything that was left out, and why.
    pub notes: Vec<Warning>,
}
