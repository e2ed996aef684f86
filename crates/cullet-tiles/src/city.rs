//! The built-in city of plots, tile by tile, never whole.

use cullet::{Instance, InstanceFlags, Mesh};
use cullet_scenes::{CityPlots, Placed};

use crate::source::{TileContent, TileError, TileId, TileInfo, TileSource};

/// Plots along a side of a tile with everything in it.
const LEAF: u32 = 32;

/// How far from its plot's building a small object may be: what is left out where they are, and
/// across one.
const OBJECT: f64 = 3.5;

/// [`CityPlots`] as tiles: the finest have all; those above them buildings alone; those above these
/// a block for each 2 × 2, 4 × 4 … plots, as high as the highest building in it.
#[derive(Debug)]
pub struct CityTiles {
    city: CityPlots,
    meshes: Vec<Mesh>,
    /// Levels above the finest.
    top: u32,
}

impl CityTiles {
    /// A city of at least so many instances, 1 to 1e9.
    #[must_use]
    pub fn new(instances: u64, seed: u64) -> Self {
        let city = CityPlots::new(instances, seed);
        let tiles = city.side().div_ceil(LEAF);
        let top = tiles.next_power_of_two().trailing_zeros();
        // They are checked meshes: nothing is lost.
        let meshes = CityPlots::meshes().unwrap_or_default();
        Self { city, meshes: meshes.into_iter().map(|(_, mesh)| mesh).collect(), top }
    }

    /// The city.
    #[must_use]
    pub fn city(&self) -> &CityPlots {
        &self.city
    }

    /// A tile: how many levels above the finest, and where among those of its level.
    #[must_use]
    pub fn tile(level: u32, x: u32, z: u32) -> TileId {
        TileId(u64::from(level) << 48 | u64::from(x) << 24 | u64::from(z))
    }

    fn parts(TileId(id): TileId) -> (u32, u32, u32) {
        let low = |v: u64| (v & 0xff_ffff) as u32;
        ((id >> 48) as u32, low(id >> 24), low(id))
    }

    /// The plots of a tile that there are: first, and one after the last, along x and z.
    fn plots(&self, tile: TileId) -> [[u32; 2]; 2] {
        let (level, x, z) = Self::parts(tile);
        let size = u64::from(LEAF) << level;
        let clamp = |v: u64| v.min(u64::from(self.city.side())) as u32;
        [
            [x, z].map(|v| clamp(u64::from(v) * size)),
            [x, z].map(|v| clamp((u64::from(v) + 1) * size)),
        ]
    }

    /// Plots along a side of a block of a level.
    fn block(level: u32) -> u32 {
        1 << (level.max(1) - 1)
    }

    /// The highest building of some plots, or one that is as high, where they are many: of a grid
    /// of 16 × 16 of them, and the height that none exceeds.
    fn height(&self, low: [u32; 2], high: [u32; 2]) -> f64 {
        if high[0] - low[0] > 16 {
            return CityPlots::HIGHEST - 3.0;
        }
        let plots = (low[1]..high[1]).flat_map(|z| (low[0]..high[0]).map(move |x| (x, z)));
        plots.map(|(x, z)| self.city.plot(x, z).height).fold(0.0, f64::max)
    }
}

impl TileSource for CityTiles {
    fn meshes(&self) -> &[Mesh] {
        &self.meshes
    }

    fn roots(&self) -> Vec<TileId> {
        vec![Self::tile(self.top, 0, 0)]
    }

    fn info(&self, tile: TileId) -> TileInfo {
        let (level, ..) = Self::parts(tile);
        let [low, high] = self.plots(tile);
        let at = |v: u32| f64::from(v) * CityPlots::PITCH - self.city.reach();
        // Small objects may stand out of their plot, and balloons rise and hang.
        let bounds = [
            [at(low[0]) - 1.0, 0.0, at(low[1]) - 1.0],
            [at(high[0]) + 1.0, CityPlots::HIGHEST, at(high[1]) + 1.0],
        ];
        let block = Self::block(level);
        let [x, z] = [0, 1].map(|a| (high[a] - low[a]).div_ceil(block));
        let (error, each) = match level {
            0 => (0.0, CityPlots::INSTANCES as u32),
            1 => (OBJECT, 1),
            _ => (CityPlots::PITCH * f64::from(block), 1),
        };
        TileInfo { bounds, error, instances: x * z * each, meshes: [0; 2], adds: false }
    }

    fn children(&self, tile: TileId, out: &mut Vec<TileId>) {
        let (level, x, z) = Self::parts(tile);
        if level == 0 {
            return;
        }
        for (dx, dz) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let child = Self::tile(level - 1, 2 * x + dx, 2 * z + dz);
            let [low, high] = self.plots(child);
            if low[0] < high[0] && low[1] < high[1] {
                out.push(child);
            }
        }
    }

    fn load(&self, tile: TileId) -> Result<TileContent, TileError> {
        let (level, ..) = Self::parts(tile);
        let [low, high] = self.plots(tile);
        let block = Self::block(level);
        let mut content = TileContent::default();
        let mut placed: Vec<Placed> = Vec::new();
        let name = |k: usize| tile.0 << 14 ^ k as u64;
        for z in (low[1]..high[1]).step_by(block as usize) {
            for x in (low[0]..high[0]).step_by(block as usize) {
                let end = [(x + block).min(high[0]), (z + block).min(high[1])];
                match level {
                    0 => self.city.add_all(x, z, &mut placed),
                    1 => placed.push(self.city.plot(x, z).building),
                    _ => {
                        let at = |v: u32| f64::from(v) * CityPlots::PITCH - self.city.reach();
                        let top = self.height([x, z], end);
                        let low = [at(x) + 3.0, 0.0, at(z) + 3.0];
                        placed.push(CityPlots::block_at(
                            low,
                            [at(end[0]) - 3.0, top, at(end[1]) - 3.0],
                        ));
                    }
                }
            }
        }
        content.instances = placed
            .into_iter()
            .enumerate()
            .map(|(k, Placed { mesh, transform })| {
                // A block covers streets through which more is seen.
                let flags = InstanceFlags { no_occlusion: level > 1, ..InstanceFlags::default() };
                Instance { flags, user_data: name(k), ..Instance::new(mesh, transform) }
            })
            .collect();
        Ok(content)
    }
}
