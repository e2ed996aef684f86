//! Worlds that are flown through, and the way.

use std::path::Path;

use cullet_command::exit::{Exit, Failure};
use cullet_io::LoadOptions;
use cullet_maps::TileSight;
use cullet_scenes::CityName;
use cullet_scenes::CityPlots;
use cullet_scenes::NoCityName;
use cullet_tiles::{CityTiles, FolderTiles, Settings, TileError, TileSource, World};

use cullet::prepared::Preparation;

/// A straight way through a world, first low, then high.
#[derive(Clone, Copy, Debug)]
pub(super) struct Route {
    /// Where the middle of the way is, above nothing.
    middle: [f64; 3],
    /// Its direction, of length 1.
    pub(super) direction: [f64; 3],
    /// How high it is.
    heights: [f64; 2],
    /// Units a second; none goes through all of it.
    speed: Option<f64>,
    length: f64,
    pub(super) near: f64,
    /// Instances of the whole world.
    pub(super) instances: u64,
    /// View cells whose rows say what is loaded first.
    pub(super) cells: u32,
}

impl Route {
    pub(super) fn speed(&self, seconds: f64) -> f64 {
        self.speed.unwrap_or_else(|| 2.0 * self.length / seconds.max(1e-3))
    }

    /// The eye and what it looks at, so many seconds after the start.
    pub(super) fn at(&self, seconds: f64, all: f64, speed: f64, high: bool) -> [[f64; 3]; 2] {
        // In a world that is flown through whole, each half of the way leads through all of it.
        let far = match self.speed {
            Some(_) => (seconds - all * 0.5) * speed,
            None => (seconds % (all * 0.5) - all * 0.25) * speed,
        };
        let mut eye: [f64; 3] = std::array::from_fn(|a| self.middle[a] + self.direction[a] * far);
        eye[1] = self.heights[usize::from(high)];
        let (sin, cos) = ((seconds * 0.3).sin() * 0.8).sin_cos();
        let [x, _, z] = self.direction;
        let down = if high { 0.2 } else { 0.0 };
        [eye, [eye[0] + x * cos - z * sin, eye[1] - down, eye[2] + z * cos + x * sin]]
    }
}

/// Opens a world, whose visible sets say what is loaded first if those are used.
pub(super) fn open(
    name: &str,
    settings: &Settings,
    uses_sets: bool,
) -> Result<(World, Route), Failure> {
    let path = Path::new(name);
    if path.exists() {
        let tileset = if path.is_dir() { path.join("tileset.json") } else { path.to_owned() };
        let options = LoadOptions { prepare: Preparation::NONE, ..LoadOptions::default() };
        let mut tiles = FolderTiles::open(&tileset, &options).map_err(Failure::input)?;
        let mut route = through(&tiles, name)?;
        if uses_sets {
            route.cells = tiles.tree().sight().map_or(0, TileSight::cell_count);
        } else {
            tiles = tiles.without_sight();
        }
        return Ok((world(tiles, settings, name)?, route));
    }
    let CityName { instances, seed } = name.parse().map_err(|e: NoCityName| {
        Failure::usage(format!("'{name}' is no tileset.json that exists, and {e}"))
    })?;
    let tiles = CityTiles::new(instances, seed);
    let instances = u64::from(tiles.city().side()).pow(2) * CityPlots::INSTANCES;
    let route = Route {
        middle: [0.0; 3],
        direction: [1.0, 0.0, 0.0],
        heights: [1.7, 80.0],
        speed: Some(100.0),
        length: 2.0 * tiles.city().reach(),
        near: 0.3,
        instances,
        cells: 0,
    };
    Ok((world(tiles, settings, name)?, route))
}

fn world<S: TileSource>(tiles: S, settings: &Settings, name: &str) -> Result<World, Failure> {
    World::new(tiles, settings).map_err(|error| {
        let exit =
            if matches!(error, TileError::Budget { .. }) { Exit::Limit } else { Exit::Input };
        Failure { exit, message: format!("{name}: {error}") }
    })
}

/// The way through a tileset, along its longest side.
fn through(tiles: &FolderTiles, name: &str) -> Result<Route, Failure> {
    let infos =
        || (0..tiles.tree().tiles().len()).map(|k| tiles.info(cullet_tiles::TileId(k as u64)));
    let [low, high] = infos().next().map_or([[0.0; 3]; 2], |root| root.bounds);
    if !low.iter().chain(&high).all(|v| v.is_finite()) {
        return Err(Failure::input(format!(
            "{name}: its root states no bounds, so there is no way through it"
        )));
    }
    let size: [f64; 3] = std::array::from_fn(|a| high[a] - low[a]);
    let along_x = size[0] >= size[2];
    let length = size[0].max(size[2]).max(1e-3);
    let (eye, tall) = (1.7_f64.min(size[1] * 0.5), size[1].max(length * 0.01));
    Ok(Route {
        middle: std::array::from_fn(|a| (low[a] + high[a]) * 0.5),
        direction: if along_x { [1.0, 0.0, 0.0] } else { [0.0, 0.0, 1.0] },
        heights: [low[1] + eye, low[1] + tall * 1.1],
        speed: None,
        length,
        near: length * 1e-4,
        instances: (0..)
            .zip(tiles.tree().tiles())
            .filter(|(_, node)| !node.is_stand_in())
            .map(|(tile, _)| u64::from(tiles.info(cullet_tiles::TileId(tile)).instances))
            .sum(),
        cells: 0,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_half_of_the_way_leads_through_all_of_a_tileset() {
        let route = Route {
            middle: [10.0, 5.0, 0.0],
            direction: [0.0, 0.0, 1.0],
            heights: [1.0, 9.0],
            speed: None,
            length: 40.0,
            near: 0.1,
            instances: 1,
            cells: 0,
        };
        let speed = route.speed(20.0);
        let eye = |seconds: f64, high| route.at(seconds, 20.0, speed, high)[0];
        let near = |a: [f64; 3], b: [f64; 3]| {
            assert!((0..3).all(|k| (a[k] - b[k]).abs() < 1e-9), "{a:?} {b:?}");
        };
        near(eye(0.0, false), [10.0, 1.0, -20.0]);
        near(eye(5.0, false), [10.0, 1.0, 0.0]);
        near(eye(10.0, true), [10.0, 9.0, -20.0]);
        near(eye(15.0, true), [10.0, 9.0, 0.0]);
    }
}
