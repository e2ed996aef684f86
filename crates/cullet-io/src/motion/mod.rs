//! How a model moves: what a file's animations, skins and morph targets say, or which built-in scene it is.

use crate::Model;

mod rig;
pub(crate) mod track;

pub(crate) use rig::{Bounds, Clip, Deformed, Follower, Rig, RigNode, SkinRig, transform};

/// How a model moves: the animations, skins and morph targets of a glTF, or a built-in scene's time.
#[derive(Debug)]
pub struct Motion {
    pub(crate) kind: MotionKind,
}

pub(crate) enum MotionKind {
    /// Of a file.
    Rig(Rig),
    /// A model that is made anew at each time.
    Made(Make),
}

/// Makes a model as it is at a number of seconds; an error is a sentence.
type Make = Box<dyn Fn(f64) -> Result<Model, String> + Send + Sync>;

impl std::fmt::Debug for MotionKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Rig(rig) => f.debug_tuple("Rig").field(rig).finish(),
            Self::Made(_) => f.write_str("Made"),
        }
    }
}

impl Motion {
    /// The motion of a model that is made by rule: `make` gives it as it is after a number of seconds, with the same
    /// instances and meshes.
    #[must_use]
    pub fn made(make: impl Fn(f64) -> Result<Model, String> + Send + Sync + 'static) -> Self {
        Self { kind: MotionKind::Made(Box::new(make)) }
    }

    /// For how many seconds it moves before it has shown everything: the longest animation. 0 where
    /// skins and morph targets stand still, `None` where it does not end.
    #[must_use]
    pub fn seconds(&self) -> Option<f64> {
        match &self.kind {
            MotionKind::Rig(rig) => Some(rig.clips.iter().map(Clip::seconds).fold(0.0, f64::max)),
            MotionKind::Made(_) => None,
        }
    }
}
