//! Prepares meshes and scenes for culling. The work is done once, offline, so that every frame is
//! cheaper.
//!
//! | module | makes |
//! |---|---|
//! | [`clusters`] | clusters of a mesh that are culled often |
//! | [`levels`] | levels of detail with measured errors |
//! | `merged` | one mesh of a group of instances, simplified |
//! | [`stand_in`] | one coarse mesh of many levels and merged groups |
//! | [`occluders`] | boxes and polygons that hide what the mesh hides |
//! | [`rooms`], [`room_volumes`] | cells and portals of closed interiors, from triangles or from volumes of rooms |
//! | [`pvs`] | which cells of a graph of portals see each other |
//! | [`sampled`] | what can be seen from the view cells of any scene, by sampled lines |
//! | [`work`], [`job`] | units of long work, for threads, processes and machines |
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod clusters;
mod corners;
mod gather;
pub mod job;
pub mod levels;
pub mod merged;
pub mod occluders;
pub mod pvs;
pub mod room_volumes;
pub mod rooms;
mod rows;
pub mod sample;
pub mod sampled;
pub mod stand_in;
mod threads;
pub mod work;
