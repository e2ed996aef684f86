//! Visibility for [Bevy](https://bevy.org) by [cullet](https://docs.rs/cullet): the hierarchy of a culling engine in
//! place of a sweep over all entities, occlusion for the cameras that ask for it, and a reason for each entity that is
//! not drawn.
//!
//! ```
//! # use bevy::prelude::*;
//! use bevy_cullet::CulletPlugin;
//!
//! # fn run() {
//! App::new().add_plugins((DefaultPlugins, CulletPlugin)).run();
//! # }
//! ```
//!
//! What is drawn stays the same to the pixel: [`CulletPlugin`] takes [`check_visibility_cpu_culling`] out of the
//! schedule and fills the lists of [`VisibleEntities`](bevy_camera::visibility::VisibleEntities) itself, with what Bevy
//! would list or less. `Visibility`, `RenderLayers`, `NoFrustumCulling`, `NoCpuCulling`, `VisibilityRange` and a
//! `Frustum` of the user's own mean what they mean in Bevy.
//!
//! | item | for |
//! |---|---|
//! | [`CulletPlugin`] | the whole |
//! | [`CulletView`] | a camera, added by itself: its funnel, and what was culled and why |
//! | [`CulletScene`] | the resource that holds the engine's scene |
//! | [`CulletSystems`] | the set to order systems against |
#![forbid(unsafe_code)]

mod check;
mod mirror;
mod plugin;
mod view;

pub use engine;

pub use mirror::CulletScene;
pub use plugin::{CulletPlugin, CulletSystems};
pub use view::{CulletFunnel, CulletView};
#[cfg(doc)]
use bevy_camera::visibility::check_visibility_cpu_culling;
