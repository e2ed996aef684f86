//! Prepares meshes for culling: what is done once, so that every frame is cheaper.
//!
//! [`clusters`] cuts a mesh into clusters that are culled often.
#![forbid(unsafe_code)]

pub mod clusters;
