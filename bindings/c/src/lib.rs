//! The C interface of cullet. `include/cullet.h` is written from this crate, so that what a public
//! item says here is what a C programmer reads there; programs in Rust take the crate `cullet`
//! itself.
//!
//! Pointers are followed in [`memory`] alone, objects are found by [`registry`], and no panic
//! leaves a call ([`status::call`]).
#![allow(
    clippy::missing_safety_doc,
    reason = "the docs are the header's, which says what each pointer must have"
)]

pub mod boxes;
pub mod clip;
pub mod clip_occlusion;
pub mod cull;
pub mod cull_more;
pub mod explain;
mod memory;
pub mod mesh;
pub mod occlusion;
pub mod queries;
pub mod region;
mod registry;
pub mod results;
pub mod scene;
pub mod settings;
pub mod shadow;
pub mod status;
pub mod view;
