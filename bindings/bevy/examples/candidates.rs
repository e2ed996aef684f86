//! Stages of your own: rooms, distance and a fog of war, each a system that says what the camera leaves out before
//! anything is taken for an occluder. `cargo run --release --example candidates`; keys 1, 2 and 3 switch them, the arrows
//! move the camera.

use bevy::prelude::*;
use bevy_cullet::{CulletCandidates, CulletOcclusion, CulletPlugin, CulletView};

/// The room that an entity stands in.
#[derive(Component)]
struct Room(IVec2);

/// Something that the player has come near to.
#[derive(Component)]
struct Explored;

/// Stages that run.
#[derive(Resource)]
struct Stages([bool; 3]);

const ROOM: f32 = 20.0;

fn room(at: Vec3) -> IVec2 {
    (at.xz() / ROOM).floor().as_ivec2()
}

fn main() {
    App::new()
        .add_plugins((DefaultPlugins, CulletPlugin))
        .insert_resource(Stages([true, true, false]))
        .add_systems(Startup, setup)
        .add_systems(Update, (walk, switch, explore, leave_out, tell).chain())
        .run();
}

fn setup(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let cube = meshes.add(Cuboid::new(1.0, 1.0, 1.0));
    let paint = materials.add(Color::srgb(0.8, 0.5, 0.3));
    for i in 0..20_000 {
        let at = Vec3::new((i % 141) as f32 * 2.0 - 141.0, 0.5, (i / 141) as f32 * 2.0 - 141.0);
        let cube = (Mesh3d(cube.clone()), MeshMaterial3d(paint.clone()));
        commands.spawn((cube, Transform::from_translation(at), Room(room(at))));
    }
    let at = Transform::from_xyz(1.0, 3.0, 1.0).looking_to(Vec3::new(1.0, -0.1, 1.0), Vec3::Y);
    commands.spawn((
        Camera3d::default(),
        at,
        CulletOcclusion::default(),
        CulletCandidates::default(),
    ));
    commands
        .spawn((DirectionalLight::default(), Transform::default().looking_to(-Vec3::ONE, Vec3::Y)));
}

/// Runs in `Update`, and so before the plugin's own stages in the same frame.
fn leave_out(
    stages: Res<Stages>,
    camera: Single<(&GlobalTransform, &mut CulletCandidates)>,
    all: Query<(Entity, &GlobalTransform, &Room, Has<Explored>)>,
) {
    let (eye, mut candidates) = camera.into_inner();
    let (eye, own) = (eye.translation(), room(eye.translation()));
    let [by_room, by_distance, by_fog] = stages.0;
    candidates.clear();
    for (entity, at, room, is_explored) in &all {
        // Doors lead to the rooms beside one's own.
        let is_elsewhere = by_room && (room.0 - own).abs().max_element() > 1;
        let is_far = by_distance && at.translation().distance(eye) > 30.0;
        if is_elsewhere || is_far || by_fog && !is_explored {
            candidates.leave_out(entity);
        }
    }
}

fn explore(
    mut commands: Commands,
    camera: Single<&GlobalTransform, With<Camera3d>>,
    new: Query<(Entity, &GlobalTransform), (With<Room>, Without<Explored>)>,
) {
    for (entity, at) in &new {
        if at.translation().distance(camera.translation()) < 12.0 {
            commands.entity(entity).insert(Explored);
        }
    }
}

fn walk(
    keys: Res<ButtonInput<KeyCode>>,
    time: Res<Time>,
    mut camera: Single<&mut Transform, With<Camera3d>>,
) {
    let axis = |more, less| f32::from(i8::from(keys.pressed(more)) - i8::from(keys.pressed(less)));
    camera.rotate_y(axis(KeyCode::ArrowLeft, KeyCode::ArrowRight) * time.delta_secs());
    let ahead = camera.forward() * axis(KeyCode::ArrowUp, KeyCode::ArrowDown);
    camera.translation += ahead * 15.0 * time.delta_secs();
}

fn switch(keys: Res<ButtonInput<KeyCode>>, mut stages: ResMut<Stages>) {
    for (stage, key) in [KeyCode::Digit1, KeyCode::Digit2, KeyCode::Digit3].into_iter().enumerate()
    {
        stages.0[stage] ^= keys.just_pressed(key);
    }
}

fn tell(view: Single<&CulletView>, stages: Res<Stages>, mut window: Single<&mut Window>) {
    let funnel = view.funnel;
    let on = |stage: usize| if stages.0[stage] { "on" } else { "off" };
    window.title = format!(
        "{} in the frustum, {} candidates, {} drawn; rooms {}, distance {}, fog {}",
        funnel.in_frustum,
        funnel.in_range,
        funnel.visible,
        on(0),
        on(1),
        on(2),
    );
}
