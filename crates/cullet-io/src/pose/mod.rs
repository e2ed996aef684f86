//! Models that move: posed at a time, with bounds that hold the pose.

mod rig;
pub(crate) mod track;

pub(crate) use rig::{Bounds, Clip, Deformed, Follower, Rig, RigNode, SkinRig, transform};

use cullet::mesh::MeshError;
use cullet::{BoundsOverride, SceneError};
use thiserror::Error;

use crate::Model;
use crate::scenes::{self, SceneSpecError};

/// How a model moves: the animations, skins and morph targets of a glTF, or a built-in scene's time.
#[derive(Debug)]
pub struct Motion {
    pub(crate) kind: Kind,
}

#[derive(Debug)]
pub(crate) enum Kind {
    /// Of a file.
    Rig(Rig),
    /// The text of a built-in scene, made anew at each time.
    Scene(String),
}

impl Motion {
    /// For how many seconds it moves before it has shown everything: the longest animation. 0 where
    /// skins and morph targets stand still, `None` where it does not end.
    #[must_use]
    pub fn seconds(&self) -> Option<f64> {
        match &self.kind {
            Kind::Rig(rig) => Some(rig.clips.iter().map(Clip::seconds).fold(0.0, f64::max)),
            Kind::Scene(_) => None,
        }
    }
}

/// Why a model cannot be posed.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PoseError {
    /// The time is no number of seconds.
    #[error("{0} is no time: give finite seconds")]
    Time(f64),
    /// A vertex is nowhere.
    #[error(
        "{instance} at {seconds} s: {error}; a joint, a morph weight or a scale that moves it is not \
         finite or overflows"
    )]
    NotFinite {
        /// The name of the instance.
        instance: String,
        /// The time.
        seconds: f64,
        /// Which vertex.
        error: MeshError,
    },
    /// The built-in scene has no such time.
    #[error("{0}")]
    Scene(#[from] SceneSpecError),
    /// The scene was changed since the model was loaded: an instance that moves was removed.
    #[error("the scene is no longer that of the model: {0}")]
    Changed(#[from] SceneError),
}

impl Model {
    /// Poses the model at a time: every instance that moves is put where it is then, and every mesh that
    /// deforms gets the positions that it has then, under bounds from its joints and morph targets
    /// (prepared at loading, so that they know nothing of those positions). Handles and slots stay; the
    /// nodes of the hierarchy are fitted again. A model without [`motion`](Self::motion) is left as it is.
    ///
    /// Of a glTF, every animation is played and starts again at its end, but not one that moves what an
    /// earlier one of the file moves. Skins blend in f64. What is both morphed and skinned is morphed
    /// first. The built-in `moving` is taken at that many seconds after the `t` of its text, to the
    /// millisecond.
    ///
    /// Costs O(nodes) for what is rigid; O(vertices × (joints + targets)), and a new [`Mesh`](cullet::Mesh),
    /// for what deforms. A built-in scene is made anew.
    ///
    /// # Errors
    /// If `seconds` is not finite, a deformed vertex is nowhere, a built-in scene has no such time, or an
    /// instance that moves was removed. The model may then be posed in part; posing it again at another
    /// time makes it whole.
    pub fn pose(&mut self, seconds: f64) -> Result<(), PoseError> {
        if !seconds.is_finite() {
            return Err(PoseError::Time(seconds));
        }
        // Put back whatever comes, so that an error leaves a model that can be posed again.
        let Some(motion) = self.motion.take() else { return Ok(()) };
        let posed = match &motion.kind {
            Kind::Rig(rig) => rig.pose(self, seconds),
            Kind::Scene(text) => scenes::build_at(text, seconds)
                .map_err(PoseError::from)
                .and_then(|now| take_pose(self, &now)),
        };
        self.motion = Some(motion);
        self.scene.refit();
        posed
    }
}

/// Takes the places, shapes and bounds of a model with the same meshes and instances.
fn take_pose(model: &mut Model, now: &Model) -> Result<(), PoseError> {
    let scene = &mut model.scene;
    scene.edit_meshes(|id, old| {
        let new = now.scene.meshes().get(id as usize);
        if let Some(new) = new.filter(|new| new.is_deformable()) {
            // Sides are the caller's to set, and stay.
            let two_sided = old.is_two_sided();
            *old = new.clone();
            old.set_two_sided(two_sided);
        }
    });
    for slot in now.scene.slots() {
        let Some(handle) = now.scene.handle(slot) else { continue };
        let at = scene.slot(handle)?;
        let transform = *now.scene.transform(slot);
        if *scene.transform(at) != transform {
            scene.set_transform(handle, transform)?;
        }
        if now.scene.mesh(slot).is_deformable() {
            scene.set_bounds(handle, BoundsOverride::World(now.scene.bounds(slot)))?;
        }
    }
    Ok(())
}
