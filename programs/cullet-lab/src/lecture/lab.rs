//! What checks work with.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use cullet::{Depth, View};
use cullet_io::{LoadOptions, Model};
use cullet_scenes::paths::{self, Overrides, PathSpec};
use thiserror::Error;

/// Why a check could not be made.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LabError {
    /// A built-in scene was not made.
    #[error(transparent)]
    Scene(#[from] cullet_scenes::SceneSpecError),
    /// A model was not loaded.
    #[error(transparent)]
    Load(#[from] cullet_io::LoadError),
    /// There is no such camera path.
    #[error(transparent)]
    Path(#[from] paths::PathError),
    /// A view was not made.
    #[error(transparent)]
    View(#[from] cullet::view::ViewError),
    /// Something else that was made for the check is invalid.
    #[error("{0}")]
    Other(String),
}

/// Models that `cullet fetch` gets: their paths in a folder of data with a folder for each, and its own names.
const FETCHED: [(&str, &str); 2] =
    [("stanford-bunny/bun_zipper.ply", "bunny.ply"), ("armadillo/armadillo.obj", "armadillo.ply")];

/// What checks work with: scenes, made or loaded once; where models lie that everybody knows; the profiler.
#[derive(Debug, Default)]
pub struct Lab {
    /// Where real models lie, if they do.
    pub data: Option<PathBuf>,
    /// The program that finds the slowest link on a graphics device, if there is one.
    pub profiler: Option<PathBuf>,
    scenes: RefCell<BTreeMap<String, Rc<Model>>>,
}

impl Lab {
    /// A lab with models from a folder, and the profiler.
    #[must_use]
    pub fn new(data: Option<PathBuf>, profiler: Option<PathBuf>) -> Self {
        Self { data, profiler, scenes: RefCell::default() }
    }

    /// A built-in scene by its words, as on the command line.
    ///
    /// # Errors
    /// If there is none.
    pub fn scene(&self, words: &str) -> Result<Rc<Model>, LabError> {
        self.once(words, || {
            let mut model = cullet_scenes::build(words)?;
            model.scene.commit();
            Ok(model)
        })
    }

    /// A model of the data folder, by its path in it, or as `cullet fetch` names it; `None` where it is not there.
    ///
    /// # Errors
    /// If it is there and cannot be read.
    pub fn model(&self, file: &str) -> Result<Option<Rc<Model>>, LabError> {
        let Some(folder) = &self.data else { return Ok(None) };
        let fetched = FETCHED.iter().find(|(name, _)| *name == file).map(|(_, fetched)| *fetched);
        let mut places = [Some(file), fetched].into_iter().flatten().map(|file| folder.join(file));
        let Some(path) = places.find(|path| path.exists()) else {
            return Ok(None);
        };
        let load = |path: &Path| cullet_maps::load(path, &LoadOptions::default());
        self.once(file, || Ok(load(&path)?)).map(Some)
    }

    /// Views of a scene along a path: `walk`, `orbit`, `fly` or `camera:NAME`.
    ///
    /// # Errors
    /// If the path is none.
    pub fn views(
        &self,
        model: &Model,
        path: &str,
        count: usize,
        viewport: [u32; 2],
    ) -> Result<Vec<View>, LabError> {
        let path: PathSpec = path.parse()?;
        let overrides = Overrides { depth: Depth::Reversed, ..Overrides::default() };
        Ok(paths::views(model, &path, count, viewport, &overrides)?)
    }

    fn once(
        &self,
        key: &str,
        make: impl FnOnce() -> Result<Model, LabError>,
    ) -> Result<Rc<Model>, LabError> {
        if let Some(model) = self.scenes.borrow().get(key) {
            return Ok(Rc::clone(model));
        }
        let model = Rc::new(make()?);
        self.scenes.borrow_mut().insert(key.to_owned(), Rc::clone(&model));
        Ok(model)
    }
}
