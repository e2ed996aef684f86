//! Scenes that stand still.

use bevy::camera::visibility::{NoFrustumCulling, VisibilityRange};
use bevy::camera::{CameraOutputMode, ScalingMode, Viewport};
use bevy::light::NotShadowCaster;
use bevy::material::OpaqueRendererMethod;
use bevy::prelude::*;

use crate::kit::{Dice, Kit};

pub(crate) fn plain(kit: &mut Kit) {
    kit.yard();
    kit.probe();
    kit.daylight(false);
    kit.eye();
}

/// Four cascades, casters behind the camera and above the picture.
pub(crate) fn sun(kit: &mut Kit) {
    let walls = kit.yard();
    kit.world.entity_mut(walls[1]).insert(NotShadowCaster);
    kit.probe();
    kit.caster_probe([1.0, 9.0, -3.0]);
    kit.daylight(true);
    kit.eye();
}

/// A point light between the walls, a spot light from above, each with casters that no camera sees.
pub(crate) fn lamps(kit: &mut Kit) {
    kit.yard();
    kit.probe();
    kit.caster_probe([2.0, 9.0, -8.0]);
    let lamp = PointLight { intensity: 4e6, range: 60.0, shadow_maps_enabled: true, ..default() };
    kit.world.spawn((lamp, Transform::from_xyz(5.0, 7.0, -15.0)));
    let spot = SpotLight {
        intensity: 3e7,
        range: 80.0,
        outer_angle: 0.9,
        shadow_maps_enabled: true,
        ..default()
    };
    let at = Transform::from_xyz(2.0, 16.0, -6.0).looking_at(Vec3::new(0.0, 0.0, -12.0), Vec3::Y);
    kit.world.spawn((spot, at));
    kit.eye();
}

/// Two cameras side by side; the wall before the left one is on a layer that only the right one sees, and must hide
/// nothing from the left.
pub(crate) fn layers(kit: &mut Kit) {
    let walls = kit.yard();
    kit.probe();
    kit.daylight(false);
    kit.layer(walls[0], &[1]);
    kit.layer(walls[2], &[0, 1]);
    let others = kit.heap(60, Vec3::new(-20.0, 0.0, -60.0), Vec3::new(20.0, 9.0, -8.0));
    others.into_iter().for_each(|e| kit.layer(e, &[2]));
    let half = |x| Viewport {
        physical_position: UVec2::new(x, 0),
        physical_size: UVec2::new(160, 180),
        ..default()
    };
    let left = kit.eye();
    let mut left = kit.world.entity_mut(left);
    left.get_mut::<Camera>().expect("of the camera").viewport = Some(half(0));
    let right = kit.camera(Transform::from_xyz(-4.0, 4.0, 6.0));
    kit.layer(right, &[0, 1, 2]);
    let mut right = kit.world.entity_mut(right);
    let mut camera = right.get_mut::<Camera>().expect("of the camera");
    (camera.viewport, camera.order) = (Some(half(160)), 1);
    camera.clear_color = ClearColorConfig::None;
    camera.output_mode = CameraOutputMode::default();
}

pub(crate) fn orthographic(kit: &mut Kit) {
    kit.yard();
    kit.probe();
    kit.caster_probe([1.0, 9.0, -3.0]);
    kit.daylight(true);
    let eye = kit.eye();
    let projection = OrthographicProjection {
        scaling_mode: ScalingMode::FixedVertical { viewport_height: 11.0 },
        ..OrthographicProjection::default_3d()
    };
    kit.world.entity_mut(eye).insert(Projection::Orthographic(projection));
}

/// Three rows of boxes that fade and go at a distance, before and behind walls that are half gone or wholly gone and
/// must hide nothing.
pub(crate) fn ranges(kit: &mut Kit) {
    let walls = kit.yard();
    kit.probe();
    kit.daylight(true);
    let mut range = |e: Entity, near: f32, far: f32, margin: f32| {
        kit.world.entity_mut(e).insert(VisibilityRange {
            start_margin: near..near + margin,
            end_margin: far..far + margin,
            use_aabb: false,
        });
    };
    range(walls[0], 0.0, 10.0, 0.0);
    range(walls[1], 0.0, 15.0, 15.0);
    for e in [walls[2], walls[3]] {
        range(e, 20.0, 200.0, 1.0);
    }
    for (near, e) in kit
        .heap(120, Vec3::new(-20.0, 0.0, -50.0), Vec3::new(20.0, 9.0, -6.0))
        .into_iter()
        .enumerate()
    {
        kit.world.entity_mut(e).insert(VisibilityRange::abrupt(
            (near % 3) as f32 * 15.0,
            30.0 + (near % 3) as f32 * 5.0,
        ));
    }
    kit.eye();
}

/// Walls of glass, of leaves and of light, through which the boxes behind them are seen.
pub(crate) fn transparent(kit: &mut Kit) {
    let walls = kit.yard();
    kit.probe();
    kit.daylight(true);
    let modes = [AlphaMode::Blend, AlphaMode::Add, AlphaMode::Mask(0.6), AlphaMode::Multiply];
    for (wall, alpha_mode) in walls.into_iter().zip(modes) {
        let base_color = Color::srgba(0.9, 0.8, 0.3, 0.5);
        let glass = kit.material(StandardMaterial { base_color, alpha_mode, ..default() });
        kit.world.entity_mut(wall).insert(MeshMaterial3d(glass));
    }
    kit.eye();
}

/// Walls that Bevy does not draw where an opaque one would be: without its texture, deferred without
/// the prepass, glass, farther than it lies. A box behind them is drawn nearer than it lies.
pub(crate) fn not_drawn(kit: &mut Kit) {
    let walls = kit.yard();
    kit.probe();
    kit.daylight(false);
    let image = kit.world.resource::<Assets<Image>>().reserve_handle();
    let materials = [
        StandardMaterial { base_color_texture: Some(image), ..default() },
        StandardMaterial { opaque_render_method: OpaqueRendererMethod::Deferred, ..default() },
        StandardMaterial { specular_transmission: 0.5, ..default() },
        StandardMaterial { depth_bias: -1e6, ..default() },
    ];
    for (wall, material) in walls.into_iter().zip(materials) {
        let material = kit.material(material);
        kit.world.entity_mut(wall).insert(MeshMaterial3d(material));
    }
    kit.put(1, [4.0, 3.0, -6.0], [3.0, 4.0, 0.5]);
    let near = kit.put(2, [4.0, 3.0, -7.0], [1.0, 1.0, 0.5]);
    let near_paint = kit.material(StandardMaterial { depth_bias: 1e7, ..default() });
    kit.world.entity_mut(near).insert(MeshMaterial3d(near_paint));
    kit.eye();
}

/// Builds boxes with everything that may be done to them beside turning: mirrored, flat, huge,
/// hidden with their parent, never tested.
pub(crate) fn odd(kit: &mut Kit) {
    let walls = kit.yard();
    kit.probe();
    kit.daylight(true);
    kit.world.entity_mut(walls[0]).insert(Visibility::Hidden);
    let mirrored = Transform::from_xyz(-3.0, 2.0, -7.0).with_scale(Vec3::new(-2.0, 1.0, 0.5));
    let flat = Transform::from_xyz(4.0, 2.0, -9.0).with_scale(Vec3::new(2.0, 3.0, 0.0));
    for (i, at) in [mirrored, flat].into_iter().enumerate() {
        let parts = kit.box_parts(i, at);
        kit.world.spawn(parts);
    }
    let hill = kit.put(2, [0.0, -500.0, -500.0], [3000.0, 950.0, 300.0]);
    kit.world.entity_mut(hill).insert(NoFrustumCulling);
    let parent = kit.world.spawn((Transform::from_xyz(0.0, 1.0, -10.0), Visibility::Hidden)).id();
    for (i, visibility) in [Visibility::Inherited, Visibility::Visible].into_iter().enumerate() {
        let at = Transform::from_xyz(i as f32 * 3.0 - 4.0, 3.0, 3.0);
        let parts = (kit.box_parts(i, at), visibility, ChildOf(parent));
        kit.world.spawn(parts);
    }
    kit.eye();
}

/// Streets between 144 houses, 1,500 boxes in them, seen from the pavement.
pub(crate) fn city(kit: &mut Kit) {
    let mut dice = Dice(7);
    kit.put(7, [0.0, -0.5, 0.0], [400.0, 1.0, 400.0]);
    for i in 0..144 {
        let place = |n: i32| n as f32 * 24.0 - 132.0;
        let height = 8.0 + dice.roll() * 22.0;
        let center = [place(i % 12), height * 0.5, place(i / 12)];
        kit.put(i as usize, center, [14.0 + dice.roll() * 4.0, height, 14.0 + dice.roll() * 4.0]);
    }
    kit.heap(1500, Vec3::new(-140.0, 0.3, -140.0), Vec3::new(140.0, 1.5, 140.0));
    let probe = kit.put(5, [1.0, 1.8, 110.0], [0.5, 0.5, 0.5]);
    kit.world.entity_mut(probe).insert(crate::kit::Probe);
    kit.daylight(true);
    kit.camera(Transform::from_xyz(0.3, 1.8, 116.0));
}
