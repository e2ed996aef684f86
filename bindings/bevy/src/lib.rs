//! Visibility for [Bevy](https://bevy.org) by [cullet](https://docs.rs/cullet): the hierarchy of a
//! culling engine in place of a sweep over all entities, occlusion for the cameras that ask for it,
//! and a reason for each entity that is not drawn.
//!
//! ```
//! # use bevy::prelude::*;
//! use bevy_cullet::{CulletOcclusion, CulletPlugin};
//!
//! fn setup(mut commands: Commands) {
//!     commands.spawn((Camera3d::default(), CulletOcclusion::default()));
//! }
//!
//! # fn run() {
//! App::new().add_plugins((DefaultPlugins, CulletPlugin)).add_systems(Startup, setup).run();
//! # }
//! ```
//!
//! What is drawn stays the same to the pixel: [`CulletPlugin`] takes
//! [`check_visibility_cpu_culling`] and what belongs to it out of the schedule and fills the lists
//! of [`VisibleEntities`](bevy_camera::visibility::VisibleEntities) itself, with what Bevy would
//! list or less. `Visibility`, `RenderLayers`, `NoFrustumCulling`, `NoCpuCulling`,
//! `VisibilityRange` and a `Frustum` of the user's own mean what they mean in Bevy.
//!
//! | item | for |
//! |---|---|
//! | [`CulletPlugin`] | the whole |
//! | [`CulletOcclusion`] | a camera: what lies behind other meshes is not drawn |
//! | [`CulletOccluder`], [`NoCulletOccluder`] | an entity: what hides, and what never does |
//! | [`NoCulletOcclusion`] | an entity: what is never hidden |
//! | [`CulletCandidates`] | a camera: what it leaves out, as the app knows from elsewhere |
//! | [`CulletLights`] | settings of what is left out of lights and their shadows |
//! | [`CulletLight`] | a light, added by itself: whether it was left out, and how much it draws |
//! | [`NoCulletLight`] | a light: it is drawn as Bevy draws it |
//! | [`CulletPrepare`] | when occluders are made |
//! | [`CulletExplain`] | why an entity is drawn or not |
//! | [`CulletDiagnosticsPlugin`] | the funnel as diagnostics |
//! | `CulletBaked` | baked files as assets (feature `baked`) |
//! | `CulletOverlayPlugin` | what was culled, drawn (feature `gizmos`) |
//! | [`CulletView`] | a camera, added by itself: its funnel, and what was culled and why |
//! | [`CulletScene`] | the resource that holds the engine's scene |
//! | [`CulletSystems`] | the set to order systems against |
#![forbid(unsafe_code)]

#[cfg(feature = "baked")]
mod baked;
mod bits;
mod candidates;
mod casters;
mod check;
mod diagnostics;
mod explain;
mod follow;
mod inherit;
mod lights;
mod list;
mod map;
mod marks;
mod mirror;
mod occluder;
mod occlusion;
#[cfg(feature = "gizmos")]
mod overlay;
#[cfg(feature = "pbr")]
mod pbr;
mod plugin;
mod private;
mod receivers;
#[cfg(feature = "pbr")]
mod render;
mod seen;
mod ticks;
mod view;
mod volume;
mod without;

pub use engine;

#[cfg(feature = "baked")]
pub use baked::{CulletBaked, CulletBakedError, CulletBakedLoader, CulletBakedPlugin};
#[cfg(doc)]
use bevy_camera::visibility::check_visibility_cpu_culling;
pub use candidates::CulletCandidates;
pub use diagnostics::CulletDiagnosticsPlugin;
pub use explain::{CulletExplain, CulletReason};
pub use lights::{CulletLight, NoCulletLight};
pub use mirror::CulletScene;
pub use occluder::{CulletOccluder, CulletPrepare, NoCulletOccluder};
pub use occlusion::CulletOcclusion;
#[cfg(feature = "gizmos")]
pub use overlay::*;
pub use plugin::{CulletPlugin, CulletSystems};
pub use receivers::CulletLights;
pub use seen::NoCulletOcclusion;
pub use view::{CulletFunnel, CulletView};
