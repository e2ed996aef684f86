//! A world of which what matters is loaded.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::mpsc::{Sender, channel};
use std::thread::JoinHandle;

use cullet::{Scene, prepared::Prepared};

use crate::built::{Loaded, scene_of};
use crate::choose::choose;
use crate::settings::Settings;
use crate::source::{TileError, TileId, TileSource};
use crate::status::Status;
use crate::worker::{Built, Shared, Worker};

/// A world of which what matters for the eye is loaded, by a thread of its own. See the
/// [crate](crate).
#[derive(Debug)]
pub struct World {
    settings: Settings,
    shared: Arc<Shared>,
    current: Arc<Built>,
    back: Sender<Arc<Built>>,
    thread: Option<JoinHandle<()>>,
    status: Status,
}

impl World {
    /// Opens a world: loads its coarsest tiles, and waits for them alone.
    ///
    /// # Errors
    /// If those exceed the budget or cannot be loaded, or no thread can be started.
    pub fn new<S: TileSource>(source: S, settings: &Settings) -> Result<Self, TileError> {
        // Where no eye is, nothing is near.
        let cut = choose(&source, &[], settings, &|_| true)?;
        let mut contents = BTreeMap::new();
        for &tile in &cut.tiles {
            contents.insert(tile, Loaded::of(source.load(tile)?, settings.preparation));
        }
        let meshes: Vec<_> = source
            .meshes()
            .iter()
            .map(|mesh| (mesh.clone(), Prepared::of(mesh, settings.preparation)))
            .collect();
        let scene = scene_of(&meshes, &contents, &cut.tiles);
        let current = Arc::new(Built { scene, cut: cut.clone() });
        let shared = Arc::new(Shared::default());
        let (back, returned) = channel();
        let worker = Worker {
            source: Arc::new(source),
            settings: *settings,
            meshes,
            shared: Arc::clone(&shared),
            returned,
            contents,
            failed: Default::default(),
            shown: cut,
        };
        let thread = std::thread::Builder::new().name("tiles".to_owned());
        let thread = thread.spawn(|| worker.run()).map_err(|e| TileError::Thread(e.to_string()))?;
        let mut world = Self {
            settings: *settings,
            shared,
            current,
            back,
            thread: Some(thread),
            status: Status::default(),
        };
        world.tell();
        Ok(world)
    }

    /// Says where the eye is and how it moves, in units of the world a second, and takes in what
    /// was loaded meanwhile. Never waits for a load, nor for a scene to be built or freed. Whether
    /// the scene is another one now.
    pub fn look(&mut self, eye: [f64; 3], velocity: [f64; 3]) -> bool {
        let at = |seconds: f64| std::array::from_fn(|a| eye[a] + velocity[a] * seconds);
        let ahead = self.settings.ahead;
        let mut eyes = vec![eye, at(ahead * 0.5), at(ahead)];
        eyes.retain(|eye| eye.iter().all(|v| v.is_finite()));
        // Where the worker holds it this moment, the next frame will do.
        let Ok(mut desk) = self.shared.desk.try_lock() else { return false };
        if !eyes.is_empty() && desk.eyes != eyes {
            desk.eyes = eyes;
            desk.asked += 1;
            self.shared.changed.notify_all();
        }
        let ready = desk.ready.take();
        self.status = desk.status.clone();
        if ready.is_some() {
            self.shared.changed.notify_all();
        }
        drop(desk);
        let is_new = ready.is_some();
        if let Some(new) = ready {
            let old = std::mem::replace(&mut self.current, new);
            // The worker frees it; without one it is freed here.
            let _ = self.back.send(old);
        }
        self.tell();
        is_new
    }

    /// Waits until what matters for the last [`look`](Self::look) is loaded, and takes it in: for
    /// tests and pictures, not for frames.
    pub fn settle(&mut self) {
        loop {
            {
                let mut desk = self.shared.lock();
                while desk.ready.is_none() && desk.asked != desk.answered {
                    desk = self.shared.wait(desk);
                }
                if desk.ready.is_none() {
                    self.status = desk.status.clone();
                    drop(desk);
                    self.tell();
                    return;
                }
                let new = desk.ready.take();
                self.shared.changed.notify_all();
                drop(desk);
                if let Some(new) = new {
                    let _ = self.back.send(std::mem::replace(&mut self.current, new));
                }
            }
        }
    }

    /// Tries tiles again that could not be loaded.
    pub fn forgive(&mut self) {
        let mut desk = self.shared.lock();
        desk.forgive = true;
        desk.status.failed.clear();
        desk.asked += 1;
        self.shared.changed.notify_all();
    }

    /// Returns the scene that is loaded now; it stays the same until [`look`](Self::look) reports
    /// another one.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.current.scene
    }

    /// The tiles that the scene is made of, ascending.
    #[must_use]
    pub fn tiles(&self) -> &[TileId] {
        &self.current.cut.tiles
    }

    /// Where it stood at the last [`look`](Self::look).
    #[must_use]
    pub fn status(&self) -> &Status {
        &self.status
    }

    fn tell(&mut self) {
        let cut = &self.current.cut;
        self.status.tiles = cut.tiles.len();
        self.status.bytes = cut.bytes;
        self.status.is_cut_short = cut.is_cut_short;
    }
}

impl Drop for World {
    fn drop(&mut self) {
        self.shared.lock().ended = true;
        self.shared.changed.notify_all();
        // A worker that waits for a scene to come back gets one.
        let _ = self.back.send(Arc::clone(&self.current));
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
