//! The least that there is to do: add the plugin, and mark the cameras that are to have occlusion.

use bevy::prelude::*;
use bevy_cullet::{CulletOcclusion, CulletPlugin};

fn main() {
    App::new().add_plugins((DefaultPlugins, CulletPlugin)).add_systems(Startup, setup).run();
}

/// Spawns the app's entities, with occlusion for its camera.
pub fn setup(mut commands: Commands) {
    commands.spawn((Camera3d::default(), CulletOcclusion::default()));
    // And the meshes and lights that the app has anyway.
}
