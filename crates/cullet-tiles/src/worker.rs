//! The thread that loads tiles and builds scenes, so that no frame does.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::mpsc::Receiver;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use cullet::{Mesh, Scene, prepared::Prepared};

use crate::built::{Loaded, scene_of};
use crate::choose::{Cut, choose, want};
use crate::settings::{Settings, bytes_of};
use crate::source::{TileError, TileId, TileSource};
use crate::status::{Status, Want};

/// A scene and the cut that it is of.
#[derive(Debug)]
pub(crate) struct Built {
    pub(crate) scene: Scene,
    pub(crate) cut: Cut,
}

/// State that the frame and the worker share. Held for moments only.
#[derive(Debug, Default)]
pub(crate) struct Desk {
    /// Where the eye is and is going to be; with a number that grows.
    pub(crate) eyes: Vec<[f64; 3]>,
    pub(crate) asked: u64,
    /// The number whose cut is in the scene that was handed over last.
    pub(crate) answered: u64,
    pub(crate) ready: Option<Arc<Built>>,
    pub(crate) status: Status,
    /// Failures are to be tried again.
    pub(crate) forgive: bool,
    pub(crate) ended: bool,
}

#[derive(Debug, Default)]
pub(crate) struct Shared {
    pub(crate) desk: Mutex<Desk>,
    pub(crate) changed: Condvar,
}

impl Shared {
    pub(crate) fn lock(&self) -> MutexGuard<'_, Desk> {
        self.desk.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn wait<'a>(&self, desk: MutexGuard<'a, Desk>) -> MutexGuard<'a, Desk> {
        self.changed.wait(desk).unwrap_or_else(PoisonError::into_inner)
    }
}

/// While so many tiles or more are missing, a coarser scene is shown first.
const MANY: usize = 64;
/// Factors by which errors are coarser, in steps.
const COARSER: [f64; 3] = [16.0, 4.0, 1.0];

pub(crate) struct Worker<S> {
    pub(crate) source: Arc<S>,
    pub(crate) settings: Settings,
    pub(crate) meshes: Vec<(Mesh, Prepared)>,
    pub(crate) shared: Arc<Shared>,
    /// Scenes that are no longer in use come back, so that no frame takes the time to free them.
    pub(crate) returned: Receiver<Arc<Built>>,
    pub(crate) contents: BTreeMap<TileId, Loaded>,
    pub(crate) failed: BTreeSet<TileId>,
    pub(crate) shown: Cut,
}

impl<S: TileSource> Worker<S> {
    pub(crate) fn run(mut self) {
        loop {
            let (eyes, asked) = {
                let mut desk = self.shared.lock();
                while !desk.ended && desk.asked == desk.answered {
                    desk = self.shared.wait(desk);
                }
                if desk.ended {
                    return;
                }
                if std::mem::take(&mut desk.forgive) {
                    self.failed.clear();
                }
                (desk.eyes.clone(), desk.asked)
            };
            for coarser in COARSER {
                match self.step(&eyes, coarser) {
                    Step::Ended => return,
                    // Another cut, for a tile is missing for good.
                    Step::Failed => break,
                    Step::Passed => {}
                    Step::Settled => {
                        let mut desk = self.shared.lock();
                        desk.answered = asked;
                        self.shared.changed.notify_all();
                    }
                }
            }
        }
    }

    /// Shows the cut for some eyes, so many times coarser than wanted.
    fn step(&mut self, eyes: &[[f64; 3]], coarser: f64) -> Step {
        let settings = self.settings.with_pixels(self.settings.pixels * coarser);
        let (source, failed) = (Arc::clone(&self.source), self.failed.clone());
        // The coarsest tiles were in the budget when the world was made.
        let Ok(cut) = choose(&*source, eyes, &settings, &|tile| failed.contains(&tile)) else {
            return Step::Settled;
        };
        let missing: Vec<TileId> =
            cut.tiles.iter().copied().filter(|t| !self.contents.contains_key(t)).collect();
        let is_last = coarser == 1.0;
        if !is_last && missing.len() < MANY {
            return Step::Passed;
        }
        if cut.tiles != self.shown.tiles {
            // What is not in the cut is still in the scene that is in use.
            let keep = |tile: &TileId| cut.tiles.binary_search(tile).is_ok();
            self.contents.retain(|tile, _| keep(tile));
            if let Some(end) = self.load(missing, eyes) {
                return end;
            }
            if self.build(cut) == Step::Ended {
                return Step::Ended;
            }
        }
        if is_last { Step::Settled } else { Step::Passed }
    }

    /// Loads tiles, those first that matter most.
    fn load(&mut self, missing: Vec<TileId>, eyes: &[[f64; 3]]) -> Option<Step> {
        let cells = self.source.cells_of(eyes);
        let want = |tile| want(&*self.source, tile, eyes, &cells, &self.settings);
        let mut wanted: Vec<Want> = missing.into_iter().map(want).collect();
        wanted.sort_by(Want::order);
        self.shared.lock().status.wanted = wanted.clone();
        for want in wanted {
            let loaded = self.source.load(want.tile);
            let mut desk = self.shared.lock();
            desk.status.wanted.retain(|w| w.tile != want.tile);
            if desk.ended {
                return Some(Step::Ended);
            }
            let info = self.source.info(want.tile);
            let loaded = loaded.and_then(|content| {
                let (instances, [vertices, triangles]) = content.size();
                let takes = bytes_of(instances, [vertices, triangles]);
                let fits = takes <= bytes_of(info.instances, info.meshes);
                let reason = || {
                    format!(
                        "its {instances} instances, {vertices} vertices and {triangles} triangles are more than was said"
                    )
                };
                let error = || TileError::Load { tile: want.tile.0, reason: reason() };
                fits.then_some(content).ok_or_else(error)
            });
            match loaded {
                Ok(content) => {
                    desk.status.loaded += 1;
                    drop(desk);
                    let loaded = Loaded::of(content, self.settings.preparation);
                    self.contents.insert(want.tile, loaded);
                }
                Err(error) => {
                    desk.status.failed.push(error);
                    self.failed.insert(want.tile);
                    return Some(Step::Failed);
                }
            }
        }
        None
    }

    /// Builds the scene of a cut whose tiles are loaded, and hands it over.
    fn build(&mut self, cut: Cut) -> Step {
        let begin = Instant::now();
        let scene = scene_of(&self.meshes, &self.contents, &cut.tiles);
        let seconds = begin.elapsed().as_secs_f64();
        self.shown = cut.clone();
        let mut desk = self.shared.lock();
        desk.status.built += 1;
        desk.status.build_seconds = seconds;
        desk.ready = Some(Arc::new(Built { scene, cut }));
        self.shared.changed.notify_all();
        // No third scene is begun before the frame has taken this one and given the last back.
        while desk.ready.is_some() && !desk.ended {
            desk = self.shared.wait(desk);
        }
        if desk.ended {
            return Step::Ended;
        }
        drop(desk);
        match self.returned.recv() {
            Ok(old) => {
                drop(old);
                Step::Passed
            }
            Err(_) => Step::Ended,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    Passed,
    Settled,
    Failed,
    Ended,
}
