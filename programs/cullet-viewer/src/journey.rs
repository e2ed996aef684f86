//! Camera paths: recorded or the scene's own, played, scrubbed, and written as the JSON that
//! `cullet report` reads.

use std::sync::Arc;

use cullet_scenes::paths::{PathError, PathSpec, to_json};

use crate::camera::Rig;
use crate::task::{Progress, Task};
use crate::world::World;

/// Cameras a second, recorded and played.
pub const RATE: f64 = 12.0;
/// The most cameras that are recorded: ten minutes.
const MOST: usize = 7_200;
/// Cameras of a path of the scene's own: fifteen seconds.
const OWN: usize = 180;

/// A camera path and where on it one is.
#[derive(Debug, Default)]
pub struct Journey {
    /// Its cameras, [`RATE`] a second.
    pub rigs: Vec<Rig>,
    /// Its name.
    pub name: String,
    /// Seconds from its start.
    pub at: f64,
    /// Whether it is played; it begins again at its end.
    pub playing: bool,
    /// Whether the flown camera is recorded.
    pub recording: bool,
    since: f64,
    making: Option<Task<(String, Vec<Rig>)>>,
}

impl Journey {
    /// Its length in seconds.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        self.rigs.len().saturating_sub(1) as f64 / RATE
    }

    /// Begins to record, in place of what there is.
    pub fn record(&mut self) {
        *self = Self { recording: true, name: "recorded".to_owned(), ..Self::default() };
    }

    /// Begins to record, or ends it.
    pub fn toggle_recording(&mut self) {
        if self.recording {
            self.recording = false;
        } else {
            self.record();
        }
    }

    /// Goes by so many cameras along the path, to its ends at most, and stops there: the camera of
    /// that place. `None` without a path, and while one is recorded.
    pub fn step(&mut self, by: f64) -> Option<Rig> {
        if self.recording {
            return None;
        }
        self.playing = false;
        let place = ((self.at * RATE).round() + by).max(0.0);
        self.at = (place / RATE).min(self.seconds());
        self.rig()
    }

    /// Begins to make one of the scene's own paths; it is played when it is there.
    pub fn make(
        &mut self,
        world: Arc<World>,
        path: PathSpec,
        wake: impl FnOnce() + Send + 'static,
    ) {
        *self = Self::default();
        let work = move || (path.to_string(), world.path(&path, OWN, [960, 600]));
        self.making = Some(Task::start(work, wake));
    }

    /// Whether a path is being made.
    #[must_use]
    pub fn is_making(&self) -> bool {
        self.making.is_some()
    }

    /// Lets `dt` seconds pass for the flown camera: it is recorded, or moved where the path is
    /// played. Returns what went wrong, for the user.
    pub fn advance(&mut self, dt: f64, flown: &mut Rig) -> Option<String> {
        let mut trouble = None;
        match self.making.as_ref().map(Task::poll) {
            Some(Progress::Done((name, rigs))) => {
                self.making = None;
                if rigs.is_empty() {
                    trouble = Some(format!("The scene leaves no room for the path '{name}'."));
                } else {
                    *self = Self { rigs, name, playing: true, ..Self::default() };
                }
            }
            Some(Progress::Lost) => {
                self.making = None;
                trouble = Some("The path could not be made.".to_owned());
            }
            _ => {}
        }
        if self.recording {
            self.since += dt;
            if self.rigs.is_empty() || self.since >= 1.0 / RATE {
                self.since = 0.0;
                self.rigs.push(*flown);
                self.at = self.seconds();
                self.recording = self.rigs.len() < MOST;
            }
        } else if self.playing {
            self.at += dt;
            if self.at > self.seconds() {
                self.at = 0.0;
            }
            if let Some(rig) = self.rig() {
                *flown = rig;
            }
        }
        trouble
    }

    /// The camera at the present place.
    #[must_use]
    pub fn rig(&self) -> Option<Rig> {
        let place = (self.at * RATE).max(0.0);
        let i = (place as usize).min(self.rigs.len().checked_sub(1)?);
        let next = self.rigs[(i + 1).min(self.rigs.len() - 1)];
        Some(between(&self.rigs[i], &next, (place - i as f64).clamp(0.0, 1.0)))
    }

    /// The text of the file.
    ///
    /// # Errors
    /// None that a rig gives rise to.
    pub fn json(&self, aspect: f64) -> Result<String, PathError> {
        json(&self.rigs, aspect)
    }
}

/// The text of a path file of these cameras.
///
/// # Errors
/// None that a rig gives rise to.
pub fn json(rigs: &[Rig], aspect: f64) -> Result<String, PathError> {
    let cameras: Vec<_> = rigs.iter().map(|r| r.camera(aspect)).collect();
    to_json(&cameras)
}

/// The rig a part `t` of the way from `a` to `b`; its turns go the short way round.
#[must_use]
pub fn between(a: &Rig, b: &Rig, t: f64) -> Rig {
    let mix = |x: f64, y: f64| x + (y - x) * t;
    let turn = (b.yaw - a.yaw + 180.0).rem_euclid(360.0) - 180.0;
    // Eyes go straight; targets may lie at quite different distances.
    let eye: [f64; 3] = std::array::from_fn(|k| mix(a.eye()[k], b.eye()[k]));
    let mut rig = Rig {
        yaw: a.yaw + turn * t,
        pitch: mix(a.pitch, b.pitch),
        distance: mix(a.distance, b.distance),
        fov: mix(a.fov, b.fov),
        near: a.near.min(b.near),
        ..*a
    };
    let forward = rig.forward();
    rig.target = std::array::from_fn(|k| eye[k] + forward[k] * rig.distance);
    rig
}
