//! The built-in city, seen from the street: `cargo run --release --example city`.
//!
//! | key | does |
//! |---|---|
//! | arrows | walk and turn |
//! | page up, page down | rise and sink |
//! | O | occlusion on and off |
//! | F3 | overlay on and off |
//! | F4 | freeze what is drawn, and walk on to see it from elsewhere |

mod scene;

use bevy::prelude::*;
use bevy_cullet::{CulletOcclusion, CulletOverlayPlugin, CulletPlugin, CulletView};

fn main() {
    let mut app = App::new();
    app.add_plugins((DefaultPlugins, CulletPlugin, CulletOverlayPlugin));
    scene::spawn(app.world_mut(), scene::SPEC);
    app.world_mut().spawn((Camera3d::default(), scene::street(), CulletOcclusion::default()));
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
    camera: Single<(Entity, Has<CulletOcclusion>), With<Camera3d>>,
) {
    if keys.just_pressed(KeyCode::KeyO) {
        let (camera, is_on) = *camera;
        match is_on {
            true => commands.entity(camera).remove::<CulletOcclusion>(),
            false => commands.entity(camera).insert(CulletOcclusion::default()),
        };
    }
}

/// The frame time and the funnel in the window's title.
fn tell(
    time: Res<Time>,
    view: Single<&CulletView>,
    mut window: Single<&mut Window>,
    mut ms: Local<f32>,
) {
    *ms = *ms * 0.95 + time.delta_secs() * 1e3 * 0.05;
    let funnel = view.funnel;
    window.title = format!("{:.1} ms, {} of {} meshes drawn", *ms, funnel.visible, funnel.entities);
}
