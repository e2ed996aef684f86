//! Parts of a model of a file that move: its animations, skins and morph targets.

mod rig;
pub(crate) mod track;

pub(crate) use rig::{Bounds, Clip, Deformed, Follower, Rig, RigNode, SkinRig, transform};
