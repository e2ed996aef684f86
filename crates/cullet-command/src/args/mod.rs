//! Groups of arguments that several commands take: which scene, which views, which kinds of culling.

mod cull;
mod scene;
mod view;

pub use cull::{CullArgs, DetailMeasure, OccluderKind, OnlyStage};
pub use scene::{SceneArgs, UpAxis};
pub use view::ViewArgs;
