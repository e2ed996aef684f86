//! What moves in a model of a file: its animations, skins and morph targets.

mod rig;
pub(crate) mod track;

pub(crate) use rig::{Bounds, Clip, Deformed, Follower, Rig, RigNode, SkinRig, transform};
