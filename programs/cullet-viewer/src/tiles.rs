//! Worlds that do not fit in memory: their tiles are loaded by threads of their own, and what is
//! loaded comes as one scene after the other, each ready to be shown. No picture waits for any of
//! it.

use std::path::Path;
use std::sync::mpsc::{
    Receiver, RecvTimeoutError, Sender, SyncSender, TryRecvError, channel, sync_channel,
};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use cullet::{Instance, Scene, prepared::Preparation};
use cullet_draw::palette;
use cullet_io::{LoadOptions, Material, Model};
use cullet_scenes::CityName;
use cullet_scenes::{self, CityPlots};
use cullet_tiles::{CityTiles, FolderTiles, Settings, TileId, TileSource, World as TiledWorld};
use glam::DVec3;

use crate::draw::linear;
use crate::measures::Measures;
use crate::sides::{KeptBacks, declare, of_parts};
use crate::state::Sides;
use crate::task::Progress;

/// Bytes that the tiles of a world and the scenes made of them may take. A window has its own copy
/// of the scene beside them, or two while the next is taken in.
pub const BUDGET: u64 = 1 << 30;
/// Half of a side of what is around one in such a city: the part of it that is on the map, and one
/// flies through in some seconds.
const AROUND: f64 = 500.0;
/// Between two looks for what was loaded.
const PAUSE: Duration = Duration::from_millis(20);
/// The thread that loads holds what [`TiledWorld::look`] needs for moments only: of so many looks,
/// a pause apart, one is heard.
const LOOKS: u32 = 3;

/// Materials of a tile of a tileset that have colours of their own.
const MATERIALS: u32 = 256;

/// Wakes the window.
pub(crate) type Wake = Box<dyn Fn() + Send>;

/// Where the eye that culls is, and what is wanted of the scene that is made for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// The eye.
    pub eye: [f64; 3],
    /// Its motion, in units of the world a second.
    pub velocity: [f64; 3],
    /// The sides that triangles are taken to have.
    pub sides: Sides,
    /// Whether all that matters is waited for: for pictures and tests. Such a look is always
    /// answered, unless a newer one is there.
    pub settle: bool,
}

/// A scene of tiles, ready to be shown.
#[derive(Debug)]
pub struct TiledScene {
    /// The scene, with the sides that were wanted.
    pub model: Model,
    /// Its counts, and a place that is not only that of what happens to be loaded.
    pub measures: Measures,
    /// The sides that its triangles are taken to have.
    pub sides: Sides,
    /// Whether each part of its meshes is two-sided where no other sides are chosen.
    pub(crate) stored: Vec<bool>,
}

/// Result of a look.
#[derive(Debug)]
pub struct Arrival {
    /// The scene, if it is another one.
    pub scene: Option<TiledScene>,
    /// The eye, if all that matters for it is there.
    pub settled: Option<[f64; 3]>,
}

/// How much is loaded of a world, and how much is to be.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TileFigures {
    /// Tiles of the scene.
    pub tiles: usize,
    /// Upper bound of the bytes of tiles and scenes.
    pub bytes: u64,
    /// Bytes that they may take.
    pub budget: u64,
    /// Tiles that are to be loaded next.
    pub wanted: usize,
    /// Bytes that the wanted tiles will take.
    pub wanted_bytes: u64,
    /// Whether the budget ended before the error was small enough everywhere.
    pub is_cut_short: bool,
    /// Tiles that could not be loaded.
    pub failed: usize,
    /// Why the first of them could not.
    pub failure: Option<String>,
}

/// A world in tiles, followed by a thread that ends when this is dropped.
#[derive(Debug)]
pub struct Tiles {
    looks: Sender<Look>,
    arrivals: Mutex<Receiver<Arrival>>,
    figures: Arc<Mutex<TileFigures>>,
}

fn lock<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Tiles {
    /// Says where the eye is. Never waits.
    pub fn look(&self, look: Look) {
        // `poll` tells where nobody listens any more.
        let _ = self.looks.send(look);
    }

    /// Returns what came since the last call, one at a time. Never waits.
    pub fn poll(&self) -> Progress<Arrival> {
        match lock(&self.arrivals).try_recv() {
            Ok(arrival) => Progress::Done(arrival),
            Err(TryRecvError::Empty) => Progress::Working,
            Err(TryRecvError::Disconnected) => Progress::Lost,
        }
    }

    /// Its figures as they stand.
    #[must_use]
    pub fn figures(&self) -> TileFigures {
        lock(&self.figures).clone()
    }
}

/// Space that one flies about in, for the camera and the map.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Place {
    /// The world as a whole, low and high corner.
    Whole([[f64; 3]; 2]),
    /// Surroundings of the eye, in a city that ends at this distance from the middle.
    Around(f64),
    /// Loaded tiles: a world that does not say how large it is.
    Loaded,
}

impl Place {
    fn corners(self, [x, _, z]: [f64; 3]) -> Option<[[f64; 3]; 2]> {
        match self {
            Self::Whole(corners) => Some(corners),
            Self::Around(reach) => {
                let [x, z] = [x, z].map(|v| v.clamp(-reach, reach));
                let high = [x + AROUND, CityPlots::HIGHEST, z + AROUND];
                Some([[x - AROUND, 0.0, z - AROUND], high])
            }
            Self::Loaded => None,
        }
    }
}

/// Data that all scenes of a world have in common.
#[derive(Debug)]
struct Common {
    name: String,
    mesh_names: Vec<String>,
    materials: Vec<Material>,
    place: Place,
}

type Opened = Result<(Tiles, TiledScene), String>;

/// Opens a built-in city that is too large to be made whole; `None` where the text is of another
/// scene.
pub(crate) fn open_city(text: &str, wake: Wake) -> Option<Opened> {
    let open = |CityName { instances, seed }| {
        let tiles = CityTiles::new(instances, seed);
        // Its materials are those of any such city.
        let materials = cullet_scenes::build("city:n=1").map_err(|e| e.to_string())?.materials;
        let meshes = CityPlots::meshes().map_err(|e| e.to_string())?;
        let common = Common {
            name: text.to_owned(),
            mesh_names: meshes.into_iter().map(|(name, _)| name.to_owned()).collect(),
            materials,
            place: Place::Around(tiles.city().reach()),
        };
        follow(tiles, common, wake)
    };
    Some(large_city(text)?.and_then(open))
}

/// Opens a tileset, by its `tileset.json` or its folder; `None` where the path is of another file.
pub(crate) fn open_folder(path: &Path, wake: Wake) -> Option<Opened> {
    let is_json = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("json"));
    let tileset = if path.is_dir() { path.join("tileset.json") } else { path.to_owned() };
    if !is_json && !path.is_dir() {
        return None;
    }
    if !tileset.is_file() {
        return Some(Err(format!(
            "there is no tileset {}; `cullet tiles SCENE -o FOLDER` writes FOLDER/tileset.json, and city:n=1e8 is a world \
             that needs no files",
            tileset.display()
        )));
    }
    let options = LoadOptions { prepare: Preparation::NONE, ..LoadOptions::default() };
    let open = |tiles: FolderTiles| {
        let root = tiles.roots().first().map(|&root| tiles.info(root).bounds);
        let states_it = |corners: &[[f64; 3]; 2]| corners.iter().flatten().all(|v| v.is_finite());
        let common = Common {
            name: path.display().to_string(),
            mesh_names: Vec::new(),
            materials: (0..MATERIALS).map(stand_in).collect(),
            place: root.filter(states_it).map_or(Place::Loaded, Place::Whole),
        };
        follow(tiles, common, wake)
    };
    Some(FolderTiles::open(&tileset, &options).map_err(|e| e.to_string()).and_then(open))
}

/// A material in place of one of a tileset, whose tiles bring none: of a colour that depends on its
/// number in its tile alone, so that no mesh changes its colour when other tiles come.
fn stand_in(number: u32) -> Material {
    let [r, g, b] = palette::material_color(number).map(linear);
    Material { name: format!("material {number}"), color: [r, g, b, 1.0] }
}

/// A city that is loaded in tiles; `None` of a scene that is made whole, or that the words of all
/// built-in scenes refuse.
fn large_city(text: &str) -> Option<Result<CityName, String>> {
    match text.parse::<CityName>() {
        Ok(city) => city.needs_tiles().then_some(Ok(city)),
        Err(error) => {
            let is_large = error.instances.is_some_and(|n| n > CityName::MOST_WHOLE as f64);
            is_large.then(|| Err(error.to_string()))
        }
    }
}

/// Loads the coarsest tiles of a world, and begins to follow the eye through it.
fn follow<S: TileSource>(source: S, common: Common, wake: Wake) -> Opened {
    let mut settings = Settings::default().with_budget(BUDGET);
    settings.preparation = Preparation::default();
    let fail = |why: String| format!("{}: {why}", common.name);
    let world = TiledWorld::new(source, &settings).map_err(|e| fail(e.to_string()))?;
    let (looks, inbox) = channel();
    // One waits while the window takes in the one before.
    let (outbox, arrivals) = sync_channel(1);
    let figures = Arc::new(Mutex::new(TileFigures::default()));
    let follower = Follower {
        shown: world.tiles().to_vec(),
        world,
        common,
        looks: inbox,
        arrivals: outbox,
        figures: Arc::clone(&figures),
        wake,
    };
    follower.count();
    let first = follower.scene([0.0; 3], Sides::Automatic);
    let name = follower.common.name.clone();
    let thread = std::thread::Builder::new().name("cullet tiles".to_owned());
    thread
        .spawn(|| follower.run())
        .map_err(|e| format!("{name}: no thread can be started: {e}"))?;
    Ok((Tiles { looks, arrivals: Mutex::new(arrivals), figures }, first))
}

/// The thread.
struct Follower {
    world: TiledWorld,
    common: Common,
    /// The tiles of the scene that was handed over last.
    shown: Vec<TileId>,
    looks: Receiver<Look>,
    arrivals: SyncSender<Arrival>,
    figures: Arc<Mutex<TileFigures>>,
    wake: Wake,
}

impl Follower {
    /// Follows until the window has let go of the world.
    fn run(mut self) {
        let mut last: Option<Look> = None;
        loop {
            match self.looks.recv_timeout(PAUSE) {
                // Of those that wait, the newest.
                Ok(look) => last = self.looks.try_iter().last().or(Some(look)),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return,
            }
            let Some(look) = &mut last else { continue };
            let settled = std::mem::take(&mut look.settle).then_some(look.eye);
            match settled {
                Some(eye) => self.settle(eye),
                None => {
                    self.world.look(look.eye, look.velocity);
                }
            }
            let is_news = self.count();
            let scene = (self.world.tiles() != self.shown).then(|| {
                self.shown = self.world.tiles().to_vec();
                self.scene(look.eye, look.sides)
            });
            let has_arrived = scene.is_some() || settled.is_some();
            if has_arrived && self.arrivals.send(Arrival { scene, settled }).is_err() {
                return;
            }
            if has_arrived || is_news {
                (self.wake)();
            }
        }
    }

    fn settle(&mut self, eye: [f64; 3]) {
        for _ in 0..LOOKS {
            self.world.look(eye, [0.0; 3]);
            std::thread::sleep(PAUSE);
        }
        self.world.settle();
    }

    /// Tells the figures; true where they are others.
    fn count(&self) -> bool {
        let status = self.world.status();
        let now = TileFigures {
            tiles: status.tiles,
            bytes: status.bytes,
            budget: BUDGET,
            wanted: status.wanted.len(),
            wanted_bytes: status.wanted.iter().map(|want| want.bytes).sum(),
            is_cut_short: status.is_cut_short,
            failed: status.failed.len(),
            failure: status.failed.first().map(ToString::to_string),
        };
        let mut told = lock(&self.figures);
        let is_news = *told != now;
        *told = now;
        is_news
    }

    /// Returns the loaded tiles as a scene, to be shown around an eye. Copies all of them.
    fn scene(&self, eye: [f64; 3], sides: Sides) -> TiledScene {
        let Common { name, mesh_names, materials, place } = &self.common;
        let mut model = Model {
            name: name.clone(),
            scene: copy(self.world.scene()),
            mesh_names: mesh_names.clone(),
            materials: materials.clone(),
            ..Model::default()
        };
        let stored = of_parts(&model);
        let mut measures = Measures::of(&model);
        if let Some([low, high]) = place.corners(eye).map(|corners| corners.map(DVec3::from)) {
            let half = (high - low) * 0.5;
            measures.centre = (low + half).into();
            measures.half = half.into();
            measures.reach = half.length().max(f64::MIN_POSITIVE);
        }
        // The parts are its own. Were they not, the session would find that the sides are others
        // than are wanted.
        let is_other = sides != Sides::Automatic && declare(&mut model, sides, &stored).is_ok();
        let sides = if is_other { sides } else { Sides::Automatic };
        if is_other {
            measures.kept_backs = KeptBacks::of(&model, sides);
        }
        TiledScene { model, measures, sides, stored }
    }
}

/// A scene of tiles again, slot for slot, with all that is prepared of it: such a scene has no
/// cells, and no bounds but those of its meshes. Cost: that of adding all instances.
fn copy(of: &Scene) -> Scene {
    let mut scene = Scene::new();
    scene.rebase(of.origin());
    for (mesh, prepared) in of.meshes().iter().zip(of.prepared()) {
        scene.add_prepared_mesh(mesh.clone(), prepared.clone());
    }
    for mesh in 0..of.meshes().len() as u32 {
        for levels in of.levels(mesh) {
            // They fit there, and so they do here.
            let _ = scene.add_levels(mesh, levels.mesh, levels.levels.clone());
        }
    }
    for slot in of.slots() {
        // There is room, for there was there.
        let _ = scene.add(Instance {
            layers: of.layers(slot),
            flags: of.flags(slot),
            size_weight: of.size_weight(slot),
            user_data: of.user_data(slot),
            ..Instance::new(of.mesh_id(slot), *of.transform(slot))
        });
    }
    scene.commit_in_order();
    scene
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cities_that_are_not_made_whole_are_told_by_their_size() {
        let large = |text| large_city(text).map(|city| city.map(|city| city.instances));
        assert_eq!(large("city:n=1e8"), Some(Ok(100_000_000)));
        assert_eq!(large("city: seed=7, n=10_000_001"), Some(Ok(10_000_001)));
        for whole in ["city", "city:n=1e7", "city:cells=3", "city:n=many", "forest:n=1e8"] {
            assert_eq!(large_city(whole), None, "{whole}");
        }
        for wrong in ["city:n=1e10", "city:n=12345678.5", "city:n=1e8,sub=2", "city:n=1e8,seed=x"] {
            let told = large_city(wrong).expect("large").expect_err(wrong);
            assert!(told.contains(wrong) && told.contains("try city:n=1e8"), "{told}");
        }
    }

    #[test]
    fn a_copy_is_the_same_slot_for_slot() {
        let tiles = CityTiles::new(20_000, 3);
        let settings = Settings::default().with_pixels(0.0);
        let mut world = TiledWorld::new(tiles, &settings).expect("it fits");
        for _ in 0..LOOKS {
            world.look([0.0, 2.0, 0.0], [0.0; 3]);
            std::thread::sleep(PAUSE);
        }
        world.settle();
        let (own, copied) = (world.scene(), copy(world.scene()));
        assert!(own.instance_count() > 100 && own.slot_count() == copied.slot_count());
        for slot in own.slots() {
            let of = |s: &Scene| {
                let place = (s.mesh_id(slot), *s.transform(slot), s.bounds(slot));
                (place, s.layers(slot), s.flags(slot), s.user_data(slot), s.size_weight(slot))
            };
            assert_eq!(of(own), of(&copied), "slot {slot}");
        }
        assert_eq!(own.hierarchy().nodes().len(), copied.hierarchy().nodes().len());
    }

    #[test]
    fn in_a_city_the_place_is_that_around_the_eye_and_never_beyond_its_end() {
        let place = Place::Around(1e4);
        assert_eq!(place.corners([3.0, 7.0, -4.0]).map(|c| c[0]), Some([-497.0, 0.0, -504.0]));
        assert_eq!(place.corners([1e9, 0.0, 0.0]).map(|c| c[1][0]), Some(1e4 + AROUND));
        assert_eq!(Place::Loaded.corners([0.0; 3]), None);
    }
}
