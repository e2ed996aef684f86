//! Prepares meshes for culling: what is done once, so that every frame is cheaper.
//!
//! [`clusters`] cuts a mesh into clusters that are culled often; [`joint`] joins them into a hierarchy,
//! where that pays; [`levels`] makes it of fewer triangles, with errors that are measured; `merged` does so of groups of instances,
//! and [`stand_in`] makes one mesh of what both have made of many;
//! [`occluders`] finds boxes and
//! polygons that hide what the mesh hides; [`pvs`] finds which cells of a graph of portals see each other, [`sampled`] what
//! can be seen from anywhere in any scene; [`rooms`] finds the cells and portals of closed interiors; [`container`] is the file that such results are kept in,
//! and [`work`] how what takes long is shared between threads, processes and machines.
#![forbid(unsafe_code)]

pub mod clusters;
mod corners;
mod gather;
pub mod job;
pub mod levels;
#[cfg(feature = "meshopt")]
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
