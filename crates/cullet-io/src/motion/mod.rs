//! How a model moves: what a file's animations, skins and morph targets say, or which built-in scene it is.

mod rig;
pub(crate) mod track;

pub(crate) use rig::{Bounds, Clip, Deformed, Follower, Rig, RigNode, SkinRig, transform};

/// How a model moves: the animations, skins and morph targets of a glTF, or a built-in scene's time.
#[derive(Debug)]
pub struct Motion {
    pub(crate) kind: MotionKind,
}

#[derive(Debug)]
pub(crate) enum MotionKind {
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
            MotionKind::Rig(rig) => Some(rig.clips.iter().map(Clip::seconds).fold(0.0, f64::max)),
            MotionKind::Scene(_) => None,
        }
    }
}
