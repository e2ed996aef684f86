//! A scene in a window.

use bevy::prelude::*;
use bevy_cullet::{
    CulletLight, CulletLights, CulletOcclusion, CulletOverlay, CulletOverlayPlugin, CulletPlugin,
    CulletView,
};

use crate::build::Scene;

pub(crate) fn open(scene: &Scene) {
    let mut app = App::new();
    app.add_plugins((DefaultPlugins, CulletPlugin, CulletOverlayPlugin));
    app.insert_resource(CulletOverlay { bounds: false, ..default() });
    (scene.build)(app.world_mut());
    app.world_mut().spawn((Camera3d::default(), (scene.camera)(), CulletOcclusion::default()));
    app.add_systems(Update, (walk, switch, tell)).run();
}

fn walk(
    keys: Res<ButtonInput<KeyCode>>,
    time: Res<Time>,
    mut camera: Single<&mut Transform, With<Camera3d>>,
) {
    let axis = |more, less| f32::from(i8::from(keys.pressed(more)) - i8::from(keys.pressed(less)));
    let seconds = time.delta_secs();
    camera.rotate_y(axis(KeyCode::ArrowLeft, KeyCode::ArrowRight) * seconds);
    let ahead = camera.forward() * axis(KeyCode::ArrowUp, KeyCode::ArrowDown);
    let up = Vec3::Y * axis(KeyCode::PageUp, KeyCode::PageDown);
    camera.translation += (ahead + up) * 15.0 * seconds;
}

fn switch(
    keys: Res<ButtonInput<KeyCode>>,
    mut commands: Commands,
    mut lights: ResMut<CulletLights>,
    camera: Single<(Entity, Has<CulletOcclusion>), With<Camera3d>>,
) {
    if keys.just_pressed(KeyCode::KeyO) {
        let (camera, is_on) = *camera;
        match is_on {
            true => commands.entity(camera).remove::<CulletOcclusion>(),
            false => commands.entity(camera).insert(CulletOcclusion::default()),
        };
    }
    if keys.just_pressed(KeyCode::KeyL) {
        lights.receivers = !lights.receivers;
    }
}

/// The frame time and the funnel in the window's title.
fn tell(
    time: Res<Time>,
    view: Single<(&CulletView, Has<CulletOcclusion>)>,
    lights: Query<&CulletLight>,
    settings: Res<CulletLights>,
    mut window: Single<&mut Window>,
    mut ms: Local<f32>,
) {
    *ms = *ms * 0.95 + time.delta_secs() * 1e3 * 0.05;
    let (funnel, is_on) = (view.0.funnel, view.1);
    let out = lights.iter().filter(|light| light.is_left_out).count();
    let word = |is_on| if is_on { "on" } else { "off" };
    window.title = format!(
        "{:.1} ms, {} of {} meshes drawn, {out} of {} lights left out; occlusion {}, lights by receivers {}",
        *ms,
        funnel.visible,
        funnel.entities,
        lights.iter().len(),
        word(is_on),
        word(settings.receivers),
    );
}
