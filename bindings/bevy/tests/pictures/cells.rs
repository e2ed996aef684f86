//! Many small scenes in one world, far above each other: each has floor, walls, boxes and lamps of its own, and the
//! camera goes from one to the next. What a scene has in it follows from its number.

use bevy::camera::Viewport;
use bevy::camera::visibility::{NoFrustumCulling, RenderLayers, VisibilityRange};
use bevy::light::{
    CascadeShadowConfigBuilder, DirectionalLightShadowMap, NotShadowCaster, NotShadowReceiver,
    PointLightShadowMap,
};
use bevy::prelude::*;

use crate::kit::{Dice, Kit};

/// Number of scenes.
pub(crate) const CELLS: u32 = 32;
/// Pictures of each.
pub(crate) const STEPS: u32 = 3;
/// How far a scene is above the one before.
const ABOVE: f32 = 120.0;

/// A part of a scene: which, and its number among those.
#[derive(Component, Clone, Copy)]
pub(crate) struct Part {
    pub(crate) cell: u32,
    pub(crate) number: u32,
}

/// A lamp that goes while the frame is made.
#[derive(Component)]
pub(crate) struct Doomed;

fn above(cell: u32) -> Vec3 {
    Vec3::Y * (cell as f32 * ABOVE)
}

pub(crate) fn build(kit: &mut Kit) {
    kit.world.insert_resource(PointLightShadowMap { size: 128 });
    kit.world.insert_resource(DirectionalLightShadowMap { size: 256 });
    let sun = DirectionalLight { illuminance: 900.0, shadow_maps_enabled: true, ..default() };
    let cascades = CascadeShadowConfigBuilder {
        num_cascades: 2,
        maximum_distance: 40.0,
        first_cascade_far_bound: 8.0,
        ..default()
    };
    let from = Transform::from_xyz(2.0, 5.0, 3.0).looking_at(Vec3::ZERO, Vec3::Y);
    kit.world.spawn((sun, cascades.build(), from));
    for _ in 0..2 {
        kit.camera(Transform::default());
    }
    (0..CELLS).for_each(|cell| build_cell(kit, cell));
    look(kit.world, 0, 0);
}

fn build_cell(kit: &mut Kit, cell: u32) {
    let mut dice = Dice(u64::from(cell) * 977 + 5);
    let mut place = |low: Vec3, high: Vec3| {
        low + (high - low) * Vec3::new(dice.roll(), dice.roll(), dice.roll())
    };
    let at = above(cell);
    let mut parts = vec![kit.put(7, (at - Vec3::Y * 0.5).into(), [24.0, 1.0, 24.0])];
    // Two walls that part the place into rooms.
    parts.push(kit.put(1, (at + Vec3::new(1.0, 1.5, -1.0)).into(), [7.0, 3.0, 0.3]));
    parts.push(kit.put(2, (at + Vec3::new(-3.0, 1.5, 1.0)).into(), [0.3, 3.0, 6.0]));
    for i in 0..18 {
        let center = place(Vec3::new(-9.0, 0.3, -9.0), Vec3::new(9.0, 3.5, 9.0));
        let size = place(Vec3::splat(0.3), Vec3::splat(1.6));
        parts.push(kit.put(i, (at + center).into(), size.into()));
    }
    for (number, &part) in parts.iter().enumerate() {
        let number = number as u32;
        let mut part = kit.world.entity_mut(part);
        part.insert(Part { cell, number });
        match number {
            4 => drop(part.insert(NotShadowCaster)),
            5 => drop(part.insert(NotShadowReceiver)),
            6 => drop(part.insert(RenderLayers::from_layers(&[0, 1]))),
            7 => drop(part.insert(RenderLayers::layer(1))),
            9 => drop(part.insert(VisibilityRange::abrupt(0.0, 9.0))),
            10 => drop(part.insert(RenderLayers::from_layers(&[0, 40]))),
            11 => drop(part.insert(Visibility::Hidden)),
            _ => {}
        }
    }
    for number in 0..9 {
        let center = at + place(Vec3::new(-11.0, 0.8, -11.0), Vec3::new(11.0, 5.0, 11.0));
        let [range, kind, turn] = place(Vec3::ZERO, Vec3::ONE).to_array();
        let at = Transform::from_translation(center);
        let shadow_maps_enabled = number != 3;
        let range = 2.5 + range * 7.0;
        let mut lamp = if kind < 0.5 {
            let lamp = PointLight { intensity: 3e5, range, shadow_maps_enabled, ..default() };
            kit.world.spawn((lamp, at))
        } else {
            let outer_angle = 0.3 + kind * 0.8;
            let lamp =
                SpotLight { intensity: 1e6, range, outer_angle, shadow_maps_enabled, ..default() };
            let aim = Quat::from_euler(EulerRot::YXZ, turn * 6.3, -0.3 - turn, 0.0);
            kit.world.spawn((lamp, at.with_rotation(aim)))
        };
        lamp.insert(Part { cell, number: 100 + number });
        match number {
            4 => drop(lamp.insert(RenderLayers::from_layers(&[0, 1]))),
            5 if cell % 4 == 1 => drop(lamp.insert(RenderLayers::layer(1))),
            _ => {}
        }
    }
}

/// Puts the cameras where picture `step` of a scene is taken from.
pub(crate) fn look(world: &mut World, cell: u32, step: u32) {
    let at = above(cell);
    let angle = cell as f32 * 2.1 + step as f32 * if cell % 2 == 0 { 0.35 } else { 1.7 };
    let eye = at + Vec3::new(angle.sin() * 9.0, 2.5 + (cell % 3) as f32 * 1.5, angle.cos() * 9.0);
    let eyes = [
        Transform::from_translation(eye).looking_at(at + Vec3::new(0.0, 1.0, 0.0), Vec3::Y),
        Transform::from_translation(at + Vec3::new(-9.0, 6.0, 8.0)).looking_at(at, Vec3::Y),
    ];
    let fog = DistanceFog {
        color: Color::srgb(0.4, 0.4, 0.5),
        directional_light_color: Color::srgb(1.0, 0.8, 0.5),
        falloff: FogFalloff::from_visibility(90.0),
        ..default()
    };
    let has_two = cell % 4 == 1;
    let mut cameras = world.query_filtered::<Entity, With<Camera3d>>();
    let mut cameras: Vec<_> = cameras.iter(world).collect();
    cameras.sort_unstable();
    for (number, (&camera, eye)) in cameras.iter().zip(eyes).enumerate() {
        let mut entity = world.entity_mut(camera);
        entity.insert(eye);
        let mut camera = entity.get_mut::<Camera>().expect("of the camera");
        camera.order = number as isize;
        camera.is_active = number == 0 || has_two;
        camera.viewport = has_two.then(|| Viewport {
            physical_position: UVec2::new(number as u32 * 80, 0),
            physical_size: UVec2::new(80, 120),
            ..default()
        });
        if number == 1 {
            camera.clear_color = ClearColorConfig::None;
            entity.insert(RenderLayers::from_layers(&[0, 1, 40]));
        }
        if cell % 5 == 2 {
            entity.insert(fog.clone());
        } else {
            entity.remove::<DistanceFog>();
        }
    }
    let shows = if cell % 3 == 0 { Visibility::Inherited } else { Visibility::Hidden };
    let mut suns = world.query_filtered::<&mut Visibility, With<DirectionalLight>>();
    suns.iter_mut(world).for_each(|mut sun| *sun = shows);
}

/// Makes the world that of picture `picture`, from that of the one before.
pub(crate) fn step(world: &mut World, picture: u32) {
    let (cell, step) = (picture / STEPS, picture % STEPS);
    look(world, cell, step);
    let mut parts = world.query::<(Entity, &Part)>();
    let eighths: Vec<_> =
        parts.iter(world).filter(|(_, part)| part.number == 8).map(|(e, p)| (e, p.cell)).collect();
    for (entity, own) in eighths {
        // Listed wherever cameras look, so that receivers may be anywhere.
        match own == cell && cell % 8 == 3 {
            true => drop(world.entity_mut(entity).insert(NoFrustumCulling)),
            false => drop(world.entity_mut(entity).remove::<NoFrustumCulling>()),
        }
    }
    if step == 0 {
        return;
    }
    let mut parts = world.query::<(Entity, &Part)>();
    let mut parts: Vec<_> = parts
        .iter(world)
        .filter(|(_, part)| part.cell == cell)
        .map(|(e, part)| (part.number, e))
        .collect();
    parts.sort_unstable();
    for (number, entity) in parts {
        let mut entity = world.entity_mut(entity);
        let kind = number + cell + step;
        if number >= 100 {
            change_lamp(&mut entity, kind);
        } else if number > 2 && kind % 4 == 0 {
            let mut at = entity.get_mut::<Transform>().expect("placed");
            at.translation += Vec3::new(0.9, 0.1, -0.7);
            at.rotate_y(0.4);
        } else if number > 2 && kind % 9 == 0 {
            match entity.contains::<NotShadowCaster>() {
                true => drop(entity.remove::<NotShadowCaster>()),
                false => drop(entity.insert(NotShadowCaster)),
            }
        }
    }
}

fn change_lamp(lamp: &mut EntityWorldMut<'_>, kind: u32) {
    match kind % 9 {
        0 | 1 => {
            let mut at = lamp.get_mut::<Transform>().expect("placed");
            at.translation += Vec3::new(-1.3, 0.2, 1.1);
            at.rotate_y(0.7);
        }
        2 => drop(lamp.insert(Visibility::Hidden)),
        3 => drop(lamp.insert(Visibility::Inherited)),
        4 | 5 => {
            let switch = |on: &mut bool, range: &mut f32, by: f32| match kind % 9 {
                4 => *on = !*on,
                _ => *range *= by,
            };
            if let Some(mut light) = lamp.get_mut::<PointLight>() {
                let PointLight { shadow_maps_enabled, range, .. } = &mut *light;
                switch(shadow_maps_enabled, range, 0.4);
            } else if let Some(mut light) = lamp.get_mut::<SpotLight>() {
                let SpotLight { shadow_maps_enabled, range, .. } = &mut *light;
                switch(shadow_maps_enabled, range, 1.7);
            }
        }
        6 => drop(lamp.insert(Doomed)),
        _ => {}
    }
}
