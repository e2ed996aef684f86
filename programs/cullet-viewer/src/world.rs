//! The scene that is shown, and how it is loaded.

use std::path::{Path, PathBuf};

use cullet::Output;
use cullet_io::{LoadOptions, Model};
use cullet_maps::load;
use cullet_maps::load_bytes_with;
use cullet_scenes::paths::{self, Overrides, PathSpec};
use glam::DVec3;

use crate::camera::Rig;
use crate::examples;
use crate::measures::{Counts, Measures, at_rest};
use crate::packed::{Unpacker, pack};
use crate::sides::{self, KeptBacks};
use crate::state::{Colour, Layout, Look, Manner, Sides, Stages};
#[cfg(not(target_arch = "wasm32"))]
use crate::tiles::{self, TiledScene, Tiles};

/// Natively with impostors; on a page without levels of detail, which do not go from the worker to
/// the page.
fn options() -> LoadOptions {
    let is_native = cfg!(not(target_arch = "wasm32"));
    LoadOptions { levels: is_native, impostors: is_native, ..LoadOptions::default() }
}

/// A scene of so many instances is large.
const MANY: u64 = 200;

/// Where a scene comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    /// A built-in scene by its text.
    Builtin(String),
    /// A file of the machine.
    File(PathBuf),
    /// A file's bytes, as a browser gives them, and those of the files that it may name.
    Bytes {
        /// Its name.
        name: String,
        /// Its content.
        bytes: Vec<u8>,
        /// Names and contents of what was given along with it.
        beside: Vec<(String, Vec<u8>)>,
    },
}

impl Source {
    /// Parses a user's input: a built-in scene's text, or else a path.
    #[must_use]
    pub fn of_text(text: &str) -> Self {
        let text = text.trim();
        let is_builtin = cullet_scenes::is_builtin(text) && !Path::new(text).is_file();
        if is_builtin || examples::is_example(text) {
            Self::Builtin(text.to_owned())
        } else {
            Self::File(PathBuf::from(text))
        }
    }

    /// Its name while it is loaded, and in a link.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Self::Builtin(text) | Self::Bytes { name: text, .. } => text.clone(),
            Self::File(path) => path.display().to_string(),
        }
    }
}

/// A loaded scene, with what the viewer needs of it at every frame.
#[derive(Debug)]
pub struct World {
    /// The scene.
    pub model: Model,
    /// Where it came from.
    pub name: String,
    /// How much there is of it.
    pub counts: Counts,
    /// The radius of the scene, but for a ground or sky that reaches far beyond all else.
    pub reach: f64,
    /// The middle of that.
    pub centre: [f64; 3],
    /// Half its extent along each axis.
    pub half: [f64; 3],
    /// The triangles that back-face culling cannot test, and why.
    pub kept_backs: KeptBacks,
    /// Sides that its triangles are taken to have.
    pub sides: Sides,
    /// Portals, ascending, that are shut though the file has them open, or the other way around.
    pub doors: Vec<u32>,
    /// Whether each part of its meshes is two-sided where no other sides are chosen.
    pub(crate) stored: Vec<bool>,
    /// Where more of it comes from; none of a scene that is here as a whole.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) tiles: Option<std::sync::Arc<Tiles>>,
    /// The worker that made it and answers requests about it; none of a scene that was made here.
    #[cfg(target_arch = "wasm32")]
    pub(crate) keeper: Option<std::sync::Arc<crate::web::Keeper>>,
}

impl World {
    /// Opens a scene as a window shows it: a world that does not fit in memory as a whole by its
    /// coarsest tiles, and all else [whole](Self::load). `wake` is called whenever there is
    /// something new of its tiles.
    ///
    /// # Errors
    /// As [`load`](Self::load).
    #[cfg(not(target_arch = "wasm32"))]
    pub fn open(source: &Source, wake: impl Fn() + Send + 'static) -> Result<Self, String> {
        let wake = Box::new(wake);
        let opened = match source {
            Source::Builtin(text) => tiles::open_city(text, wake),
            Source::File(path) => tiles::open_folder(path, wake),
            Source::Bytes { .. } => None,
        };
        let Some(opened) = opened else { return Self::load(source) };
        let (tiles, scene) = opened?;
        let coarsest = Self::of_tiles(scene, source.name());
        Ok(Self { tiles: Some(std::sync::Arc::new(tiles)), ..coarsest })
    }

    #[cfg(not(target_arch = "wasm32"))]
    fn of_tiles(scene: TiledScene, name: String) -> Self {
        let TiledScene { model, measures, sides, stored } = scene;
        Self { sides, stored, ..Self::measured(model, name, measures) }
    }

    /// The same world, of which this is loaded now.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn with_tiles(&self, scene: TiledScene) -> Self {
        Self { tiles: self.tiles.clone(), ..Self::of_tiles(scene, self.name.clone()) }
    }

    /// Whether it is loaded tile by tile.
    #[cfg(not(target_arch = "wasm32"))]
    #[must_use]
    pub fn is_tiled(&self) -> bool {
        self.tiles.is_some()
    }

    /// Never: a page has no tiles.
    #[cfg(target_arch = "wasm32")]
    #[must_use]
    pub fn is_tiled(&self) -> bool {
        false
    }

    /// Loads a scene whole, and prepares what the first cull would else have to wait for.
    ///
    /// # Errors
    /// The text of what is wrong with it, for the user.
    pub fn load(source: &Source) -> Result<Self, String> {
        let mut model = match source {
            Source::Builtin(text) => match examples::build(text) {
                Some(example) => example?,
                None => cullet_scenes::build(text).map_err(|e| e.to_string())?,
            },
            Source::File(path) if !path.exists() => {
                return Err(cullet_scenes::no_such_file(&path.to_string_lossy()));
            }
            Source::File(path) => load(path, &options()).map_err(|e| e.to_string())?,
            Source::Bytes { name, bytes, beside } => {
                load_bytes_with(name, bytes, beside, &options()).map_err(|e| e.to_string())?
            }
        };
        // First, for only the first warnings are shown.
        let rest = at_rest(&model);
        model.warnings.splice(0..0, rest);
        Ok(Self::new(model, source.name()))
    }

    /// The world of a model.
    #[must_use]
    pub fn new(model: Model, name: String) -> Self {
        let measures = Measures::of(&model);
        Self::measured(model, name, measures)
    }

    /// The world of a model that was measured before.
    #[must_use]
    pub fn measured(model: Model, name: String, measures: Measures) -> Self {
        let Measures { counts, reach, centre, half, kept_backs } = measures;
        Self {
            name,
            counts,
            reach,
            centre,
            half,
            kept_backs,
            sides: Sides::Automatic,
            doors: Vec::new(),
            stored: sides::of_parts(&model),
            model,
            #[cfg(not(target_arch = "wasm32"))]
            tiles: None,
            #[cfg(target_arch = "wasm32")]
            keeper: None,
        }
    }

    /// Takes its triangles to have these sides from now on. Costs what
    /// [`Scene::prepare`](cullet::Scene::prepare) costs for meshes that change.
    ///
    /// # Errors
    /// In words for the user; only of a scene that was not made by this program.
    pub fn set_sides(&mut self, sides: Sides) -> Result<(), String> {
        if self.sides == sides {
            return Ok(());
        }
        sides::declare(&mut self.model, sides, &self.stored).map_err(|e| e.to_string())?;
        self.sides = sides;
        self.kept_backs = KeptBacks::of(&self.model, sides);
        Ok(())
    }

    /// Opens and shuts portals, so that these are not as the file has them.
    pub fn set_doors(&mut self, doors: &[u32]) {
        if let Some(cells) = &mut self.model.placed {
            for &portal in self.doors.iter().chain(doors) {
                let graph = cells.graph();
                let is_open = (portal as usize) < graph.portals().len() && graph.is_open(portal);
                cells.set_portal_open(portal, !is_open);
            }
        }
        self.doors = doors.to_vec();
    }

    /// The same scene with these sides, slot for slot. Costs a copy of everything.
    ///
    /// # Errors
    /// As [`set_sides`](Self::set_sides).
    pub fn with_sides(&self, sides: Sides) -> Result<Self, String> {
        self.altered(sides, &self.doors)
    }

    /// The same scene with these sides and doors, slot for slot. Costs a copy of everything.
    ///
    /// # Errors
    /// As [`set_sides`](Self::set_sides).
    pub fn altered(&self, sides: Sides, doors: &[u32]) -> Result<Self, String> {
        let unpacker = Unpacker::new(pack(&self.model)).map_err(|e| e.to_string())?;
        self.again(unpacker.finish().map_err(|e| e.to_string())?, sides, doors)
    }

    /// The world of a copy of its model, with these sides and doors.
    ///
    /// # Errors
    /// As [`set_sides`](Self::set_sides).
    pub(crate) fn again(&self, model: Model, sides: Sides, doors: &[u32]) -> Result<Self, String> {
        let mut again = Self {
            model,
            name: self.name.clone(),
            // A copy has its portals as the file has them.
            doors: Vec::new(),
            stored: self.stored.clone(),
            kept_backs: self.kept_backs.clone(),
            #[cfg(not(target_arch = "wasm32"))]
            tiles: self.tiles.clone(),
            #[cfg(target_arch = "wasm32")]
            keeper: self.keeper.clone(),
            ..*self
        };
        again.set_sides(sides)?;
        again.set_doors(doors);
        Ok(again)
    }

    /// The cameras of one of the scene's own paths, as `cullet report` has them; none where the
    /// scene leaves no room for such a path.
    #[must_use]
    pub fn path(&self, path: &PathSpec, count: usize, size: [u32; 2]) -> Vec<Rig> {
        let size = size.map(|v| v.clamp(1, 65_536));
        let cameras = paths::cameras(&self.model, path, count, size, &Overrides::default());
        let rig = |c: &cullet::Camera| {
            let to_centre = DVec3::from(self.centre) - DVec3::from(c.eye);
            let direction = DVec3::from(c.direction).normalize_or(DVec3::NEG_Z);
            let ahead = to_centre.dot(direction);
            // One that looks past the scene turns around what is before it.
            let distance = if ahead > 0.05 * self.reach { ahead } else { 0.2 * self.reach };
            Rig::of(c, distance)
        };
        cameras.map(|all| all.iter().map(rig).collect()).unwrap_or_default()
    }

    /// A camera that shows the whole scene: the first of `cullet report`'s.
    #[must_use]
    pub fn overview(&self, size: [u32; 2]) -> Rig {
        let first = self.path(&PathSpec::Orbit, 8, size).into_iter().next();
        first.unwrap_or_else(|| Rig {
            target: self.centre,
            distance: self.reach * 2.5,
            ..Rig::default()
        })
    }

    /// Whether one begins in the midst of it.
    #[must_use]
    pub fn is_large(&self) -> bool {
        self.is_tiled() || self.counts.instances >= MANY
    }

    /// How a user begins: of a small scene the frustum drops nothing, so that its back faces are to
    /// be seen to go, one by one, in a view from aside. What such a view shows of the inside of a
    /// shell has a colour of its own, but where materials tell parts apart.
    #[must_use]
    pub fn manner(&self) -> Manner {
        if self.is_large() {
            return Manner::default();
        }
        let colour = if self.model.materials.len() > 1 { Colour::Material } else { Colour::Sides };
        Manner {
            layout: Layout::Split,
            map: false,
            stages: Stages { depth: Output::Triangles, ..Stages::default() },
            look: Look { colour, ..Look::default() },
        }
    }

    /// Where a user begins: before the whole of a small scene, and in the midst of a large one,
    /// where there is something to cull.
    #[must_use]
    pub fn first_sight(&self, size: [u32; 2]) -> Rig {
        let all = self.overview(size);
        if !self.is_large() {
            return all;
        }
        let near = all.near.min(self.reach * 1e-3);
        Rig { target: self.centre, distance: self.reach * 0.3, pitch: -17.0, near, ..all }
    }

    /// A camera from above that shows what is around a point.
    #[must_use]
    pub fn top(&self, around: &Rig) -> Rig {
        Rig {
            mode: crate::camera::Mode::Top,
            target: around.eye(),
            distance: self.reach * 1.6,
            ..*around
        }
    }
}
