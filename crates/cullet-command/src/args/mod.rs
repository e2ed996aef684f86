//! Groups of arguments that several commands take: which scene, which views, which kinds of
//! culling, which share of the work.

mod cull;
mod scene;
mod units;
mod view;

pub use cull::{CullArgs, OccluderKind, PRESETS, Preset};
pub use scene::SceneArgs;
pub use units::UnitArgs;
pub use view::{PictureViewArgs, ViewArgs};

use clap::Args;

/// Inputs of culling: a scene, views of it, and the stages to run.
#[derive(Clone, Debug, Args)]
pub struct InputArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The views of it.
    #[command(flatten)]
    pub view: ViewArgs,
    /// The kinds of culling.
    #[command(flatten)]
    pub cull: CullArgs,
}

impl InputArgs {
    /// Puts what depends on the scene where nothing was given.
    pub fn settle(&mut self) {
        self.view.settle(&self.scene);
    }
}
