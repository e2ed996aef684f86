//! Baked visibility: which nodes may be seen from where, worked out once and looked up in each frame.
//!
//! | module | holds |
//! |---|---|
//! | [`baked`] | sets as plain data, and as bytes |
//! | [`resource`] | [`CulletPvs`](resource::CulletPvs), by which Godot saves them |
//! | [`sums`] | checksums of nodes: whether one is still what was baked |
//! | [`gather`], [`work`] | the nodes of a scene as the bakers of the engine take them, and the bake |
//! | [`baker`] | [`CulletPvsBaker`](baker::CulletPvsBaker), which bakes on a thread |
//! | [`live`], [`bound`] | sets in a frame: which nodes no camera's cell can see |

pub(crate) mod baked;
pub(crate) mod baker;
mod bound;
mod gather;
pub(crate) mod live;
pub(crate) mod resource;
mod sums;
mod work;
