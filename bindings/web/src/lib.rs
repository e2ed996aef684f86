//! The engine behind the npm package `cullet`: boxes against planes, scenes with all stages, and
//! model files.
//!
//! Three modules for the web are built of it, by features: none, `scene`, `files`. A page holds
//! objects by number, writes into memory at addresses that it is told, and reads answers where they
//! lie; nothing here follows an address that came from outside, so no argument can make it read or
//! write where it must not. What can be wrong of a call is a [`Fault`], whose code and message the
//! page throws.

mod boxes;
#[cfg(target_arch = "wasm32")]
mod exports;
mod fault;
#[cfg(feature = "files")]
mod files;
mod listing;
#[cfg(feature = "scene")]
mod scene;
#[cfg(feature = "scene")]
mod view;

pub use boxes::BoxSet;
pub use fault::{Code, Fault};
#[cfg(feature = "files")]
pub use files::open;
#[cfg(feature = "scene")]
pub use scene::{Kind, SceneSet};
#[cfg(feature = "scene")]
pub use view::{SceneView, Settings};
