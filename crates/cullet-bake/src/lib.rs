//! Prepares meshes for culling: what is done once, so that every frame is cheaper.
//!
//! [`clusters`] cuts a mesh into clusters that are culled often; [`joint`] joins them into a hierarchy,
//! where that pays; [`occluders`] finds boxes and polygons that hide what the mesh hides; [`pvs`] finds which cells of a
//! graph of portals see each other, [`sampled`] what can be seen from anywhere in any scene.
#![forbid(unsafe_code)]

pub mod clusters;
mod corners;
pub mod joint;
pub mod occluders;
pub mod pvs;
mod sample;
pub mod sampled;
