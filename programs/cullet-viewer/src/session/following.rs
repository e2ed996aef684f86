//! How a session follows a world in tiles: where its eye is goes out, and what is loaded for it
//! comes in.

use std::sync::Arc;

use super::Session;
use crate::camera::Rig;
use crate::cost::Measured;
use crate::cutaway::Cutting;
use crate::remaking::Remaking;
use crate::task::Progress;
use crate::tiles::{Look, TileFigures};

/// State of the tiles that follow the eye.
#[derive(Debug, Default)]
pub(super) struct Following {
    /// Look that they were told last.
    told: Option<Look>,
    /// The eye for which all of them are there that matter.
    settled: Option<[f64; 3]>,
    /// Whether the scene stays as it is.
    has_ended: bool,
}

impl Following {
    /// Leaves the scene as it is.
    pub(super) fn end(&mut self) {
        self.has_ended = true;
    }
}

/// An eye that goes farther than this share of the scene's radius from one picture to the next has
/// jumped: that is no motion to be followed.
const JUMP: f64 = 0.25;

impl Session {
    /// Figures of the tiles of the scene, if it is in tiles.
    #[must_use]
    pub fn tile_figures(&self) -> Option<TileFigures> {
        Some(self.whole()?.tiles.as_ref()?.figures())
    }

    /// Whether all tiles are there that matter for the eye that culls, or no more of them come.
    pub(super) fn has_its_tiles(&self) -> bool {
        let is_tiled = self.whole().is_some_and(|whole| whole.is_tiled());
        let eye = self.culling_rig().map(Rig::eye);
        !is_tiled || self.following.has_ended || eye.is_some() && self.following.settled == eye
    }

    /// Tells the tiles of the scene where the eye that culls is and how it moved in `dt` seconds,
    /// and takes in the scene that came of them, as one with other sides is taken in.
    pub(super) fn follow_tiles(&mut self, dt: f64) {
        let Some(whole) = self.whole().filter(|whole| whole.is_tiled()).cloned() else { return };
        let (Some(tiles), Some(rig)) = (&whole.tiles, self.culling_rig()) else { return };
        if self.following.has_ended {
            return;
        }
        let eye = rig.eye();
        let before = self.following.told.map_or(eye, |told| told.eye);
        let way: [f64; 3] = std::array::from_fn(|a| eye[a] - before[a]);
        let far = way.iter().map(|v| v * v).sum::<f64>().sqrt();
        let moves = far > 0.0 && far < whole.reach * JUMP && dt > 0.0 && !self.settles;
        let velocity = if moves { way.map(|v| v / dt) } else { [0.0; 3] };
        let look = Look { eye, velocity, sides: self.state.sides, settle: self.settles };
        if self.following.told != Some(look) {
            tiles.look(look);
            self.following.told = Some(look);
        }
        if moves {
            // Whether it has come to rest is known with the next picture.
            self.ctx.request_repaint();
        }
        match tiles.poll() {
            Progress::Working => {}
            Progress::Done(arrival) => {
                self.following.settled = arrival.settled.or(self.following.settled);
                if let Some(scene) = arrival.scene {
                    self.next = Some(Arc::new(whole.with_tiles(scene)));
                    // All of these are of the scene before.
                    self.remaking = Remaking::default();
                    self.cutting = Cutting::default();
                    self.measured = Measured::None;
                    self.asked = None;
                }
            }
            Progress::Lost => {
                self.following.end();
                let text = format!(
                    "{}: no more tiles come: a fault of cullet. Open it again to go on.",
                    whole.name
                );
                self.tell_of_scene(text, true);
            }
        }
    }
}
