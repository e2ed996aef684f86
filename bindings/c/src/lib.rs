//! The C interface of cullet. `include/cullet.h` is written from this crate, so that what a public
//! item says here is what a C programmer reads there; programs in Rust take the crate `cullet`
//! itself.
//!
//! Pointers are followed in [`memory`] and [`allocator`] alone, objects are found by [`registry`],
//! and no panic leaves a call ([`status::call`]).
#![allow(
    clippy::missing_safety_doc,
    reason = "the docs are the header's, which says what each pointer must have"
)]

pub mod allocator;
#[cfg(feature = "bake")]
pub mod bake;
#[cfg(feature = "bake")]
pub mod bake_meshes;
#[cfg(feature = "bake")]
pub mod bake_pvs;
pub mod boxes;
pub mod clip;
pub mod clip_occlusion;
#[cfg(feature = "scenes")]
pub mod cull;
#[cfg(feature = "scenes")]
pub mod cull_more;
#[cfg(feature = "scenes")]
pub mod explain;
#[cfg(feature = "files")]
pub mod files;
#[cfg(feature = "scenes")]
pub mod instance;
#[cfg(feature = "scenes")]
pub mod levels;
mod memory;
#[cfg(feature = "scenes")]
pub mod mesh;
#[cfg(feature = "files")]
pub mod occluders;
pub mod occlusion;
#[cfg(feature = "files")]
pub mod pvs;
#[cfg(feature = "queries")]
pub mod queries;
#[cfg(feature = "queries")]
pub mod region;
mod registry;
#[cfg(feature = "scenes")]
pub mod results;
#[cfg(feature = "bake")]
pub mod save;
#[cfg(feature = "scenes")]
pub mod scene;
#[cfg(feature = "scenes")]
pub mod settings;
#[cfg(feature = "scenes")]
pub mod shadow;
pub mod status;
pub mod transform;
pub mod view;
