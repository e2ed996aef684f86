//! Ranges that fade, in shadows too: of a sun and of lamps, while a camera walks through where they fade.

use bevy::prelude::*;

use crate::kit::Kit;
use crate::scenes;

pub(crate) const STEPS: u32 = 8;

/// The rows of boxes and walls that fade, with lamps among them.
pub(crate) fn build(kit: &mut Kit) {
    scenes::ranges(kit);
    for (i, at) in
        [[-3.0, 6.0, -9.0], [6.0, 7.0, -16.0], [-12.0, 8.0, -30.0]].into_iter().enumerate()
    {
        let at = Transform::from_translation(at.into());
        if i == 1 {
            let spot = SpotLight {
                intensity: 4e6,
                range: 25.0,
                outer_angle: 1.0,
                shadow_maps_enabled: true,
                ..default()
            };
            kit.world.spawn((spot, at.looking_at(Vec3::new(0.0, 0.0, -20.0), Vec3::Y)));
        } else {
            let lamp =
                PointLight { intensity: 2e6, range: 14.0, shadow_maps_enabled: true, ..default() };
            kit.world.spawn((lamp, at));
        }
    }
}

/// Walks the camera ahead, so that each step fades something in and something out.
pub(crate) fn step(world: &mut World, number: u32) {
    let mut cameras = world.query_filtered::<&mut Transform, With<Camera3d>>();
    for mut at in cameras.iter_mut(world) {
        at.translation = Vec3::new(0.4 * number as f32, 3.0, 2.0 - 2.7 * number as f32);
    }
}
