//! The engine behind the npm package `cullet`: boxes against planes, scenes with all stages, and
//! model files.
//!
//! Six modules for the web are built of it, by features: none, `occluders`, `scene`, `clusters`, `queries`,
//! `files`. A page holds
//! objects by number, writes into memory at addresses that it is told, and reads answers where they
//! lie; nothing here follows an address that came from outside, so no argument can make it read or
//! write where it must not. What can be wrong of a call is a [`Fault`], whose code and message the
//! page throws.
//!
//! For the web all but `files` is without the standard library: what that brings to tell of panics,
//! which nobody would see, is a fifth of the smallest module.
#![cfg_attr(all(target_arch = "wasm32", not(feature = "files")), no_std)]

extern crate alloc;

mod boxes;
#[cfg(any(feature = "occluders", feature = "scene"))]
mod camera;
#[cfg(feature = "scene")]
mod cells;
#[cfg(target_arch = "wasm32")]
mod exports;
mod fault;
#[cfg(feature = "files")]
mod files;
#[cfg(feature = "files")]
mod info;
mod listing;
#[cfg(feature = "occluders")]
mod occluders;
#[cfg(feature = "queries")]
mod queries;
#[cfg(all(target_arch = "wasm32", not(feature = "files")))]
mod runtime;
#[cfg(feature = "scene")]
mod scene;
#[cfg(feature = "scene")]
mod view;

pub use boxes::BoxSet;
pub use fault::{Code, Fault};
#[cfg(feature = "files")]
pub use files::{beside, open};
#[cfg(feature = "files")]
pub use info::info;
#[cfg(feature = "occluders")]
pub use occluders::{Occluders, Refusal};
#[cfg(feature = "queries")]
pub use queries::{LineSettings, NONE, Queries, REGION_NUMBERS, VolumeSettings};
#[cfg(feature = "scene")]
pub use scene::{Kind, SceneSet};
#[cfg(feature = "queries")]
pub use view::lights::Lights;
#[cfg(feature = "scene")]
pub use view::{SceneView, Settings};
