//! Milliseconds a frame in the systems of visibility, Bevy's own and the plugin's, in turn in one run:
//! `cargo run --release -p bevy_cullet_timing -- 10000 100000 1000000`.
#![forbid(unsafe_code)]

use std::any::TypeId;
use std::time::Instant;

use bevy_app::prelude::*;
use bevy_asset::{AssetApp, AssetPlugin};
use bevy_camera::primitives::Aabb;
use bevy_camera::visibility::VisibilitySystems::{
    CalculateBounds, CheckVisibility, MarkNewlyHiddenEntitiesInvisible, UpdateFrusta,
    VisibilityPropagate,
};
use bevy_camera::visibility::{NoAutoAabb, VisibleEntities};
use bevy_camera::{Camera3d, CameraPlugin, PerspectiveProjection, Projection};
use bevy_cullet::CulletPlugin;
use bevy_ecs::prelude::*;
use bevy_math::{Quat, Vec3, Vec3A};
use bevy_mesh::{Mesh3d, MeshPlugin};
use bevy_transform::components::Transform;
use bevy_transform::{TransformPlugin, TransformSystems};

/// Parts of a frame, in their order.
const PARTS: [&str; 4] = ["propagate", "check", "mark hidden", "frame"];

#[derive(Resource)]
struct Clock {
    at: Instant,
    laps: [f64; 4],
}

#[derive(Component)]
struct Mover;

#[derive(Component)]
struct Turning;

/// Ends a part; all that ran since the end of the one before counts.
fn lap<const PART: usize>(mut clock: ResMut<Clock>) {
    let now = Instant::now();
    let passed = (now - clock.at).as_secs_f64() * 1e3;
    clock.laps[PART] += passed;
    clock.at = now;
}

/// How a scene changes from frame to frame.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Motion {
    Standing,
    TenthMoving,
    CameraTurning,
}

/// A cube of boxes around a camera that sees about `share` of them.
fn app(count: usize, motion: Motion, share: f32, with_plugin: bool) -> App {
    let mut app = App::new();
    let parts = (TaskPoolPlugin::default(), TransformPlugin, AssetPlugin::default(), MeshPlugin);
    app.add_plugins((parts, CameraPlugin));
    app.init_asset::<bevy_image::Image>();
    if with_plugin {
        app.add_plugins(CulletPlugin);
    }
    app.insert_resource(Clock { at: Instant::now(), laps: [0.0; 4] });
    app.add_systems(Update, |mut movers: Query<&mut Transform, With<Mover>>| {
        movers.par_iter_mut().for_each(|mut at| at.translation.y += 0.01);
    });
    app.add_systems(Update, |mut cameras: Query<&mut Transform, With<Turning>>| {
        cameras.iter_mut().for_each(|mut at| at.rotate_y(0.002));
    });
    let start = |mut clock: ResMut<Clock>| clock.at = Instant::now();
    let early = start
        .after(TransformSystems::Propagate)
        .before(CalculateBounds)
        .before(UpdateFrusta)
        .before(VisibilityPropagate);
    let first = lap::<0>.after(CalculateBounds).after(UpdateFrusta).after(VisibilityPropagate);
    app.add_systems(
        PostUpdate,
        (
            early,
            first.before(CheckVisibility),
            lap::<1>.after(CheckVisibility).before(MarkNewlyHiddenEntitiesInvisible),
            lap::<2>.after(MarkNewlyHiddenEntitiesInvisible),
        ),
    );
    let world = app.world_mut();
    // A square pyramid of the whole sphere: 3 % at 45 degrees.
    let fov = if share > 0.05 { 1.4 } else { std::f32::consts::FRAC_PI_4 };
    let projection = PerspectiveProjection { fov, aspect_ratio: 1.0, ..Default::default() };
    let mut camera = world.spawn((Camera3d::default(), Projection::Perspective(projection)));
    if motion == Motion::CameraTurning {
        camera.insert(Turning);
    }
    let side = (count as f64).cbrt().ceil() as usize;
    for i in 0..count {
        let at = |k: usize| (k % side) as f32 * 4.0 - side as f32 * 2.0;
        let place = Vec3::new(at(i), at(i / side), at(i / side / side));
        let turned = Quat::from_rotation_y(i as f32);
        let aabb = Aabb { center: Vec3A::ZERO, half_extents: Vec3A::splat(0.5) };
        let transform = Transform::from_translation(place).with_rotation(turned);
        let mut entity = world.spawn((transform, Mesh3d::default(), NoAutoAabb, aabb));
        if motion == Motion::TenthMoving && i % 10 == 0 {
            entity.insert(Mover);
        }
    }
    app.finish();
    app.cleanup();
    app
}

fn frame(app: &mut App) -> [f64; 4] {
    app.world_mut().resource_mut::<Clock>().laps = [0.0; 4];
    let start = Instant::now();
    app.update();
    let mut laps = app.world().resource::<Clock>().laps;
    laps[3] = start.elapsed().as_secs_f64() * 1e3;
    laps
}

fn visible(app: &mut App) -> usize {
    let mut views = app.world_mut().query::<&VisibleEntities>();
    views.iter(app.world()).map(|v| v.get(TypeId::of::<Mesh3d>()).len()).sum()
}

fn main() {
    let counts = std::env::args().skip(1).map(|arg| arg.parse::<usize>());
    let Ok(counts) = counts.collect::<Result<Vec<_>, _>>() else {
        eprintln!("timing COUNT...: how many entities, such as 10000 100000 1000000");
        std::process::exit(2);
    };
    for count in counts {
        for share in [0.03, 0.1] {
            for motion in [Motion::Standing, Motion::TenthMoving, Motion::CameraTurning] {
                measure(count, motion, share);
            }
        }
    }
}

fn measure(count: usize, motion: Motion, share: f32) {
    let mut apps = [false, true].map(|with_plugin| app(count, motion, share, with_plugin));
    let rounds = (2_000_000 / count).clamp(20, 200);
    let mut all = [Vec::new(), Vec::new()];
    for round in 0..rounds + 6 {
        for (app, times) in apps.iter_mut().zip(&mut all) {
            let laps = frame(app);
            if round >= 6 {
                times.push(laps);
            }
        }
    }
    let seen = apps.each_mut().map(visible);
    assert_eq!(seen[0], seen[1], "the plugin lists others");
    let median = |times: &[[f64; 4]], of: &dyn Fn(&[f64; 4]) -> f64| {
        let mut values: Vec<f64> = times.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let sum = |laps: &[f64; 4]| laps[..3].iter().sum();
    let sums = all.each_ref().map(|times| median(times, &sum));
    let share = seen[0] as f64 / count as f64 * 100.0;
    println!(
        "{count:8} {motion:?}, {share:.1} % visible: Bevy {:.3} ms, cullet {:.3} ms, ratio {:.3}",
        sums[0],
        sums[1],
        sums[1] / sums[0]
    );
    for (name, times) in ["Bevy", "cullet"].iter().zip(&all) {
        let parts = PARTS.iter().enumerate().map(|(part, label)| {
            let ms = median(times, &|laps: &[f64; 4]| laps[part]);
            format!("{label} {ms:.3}")
        });
        println!("         {name:7} {}", parts.collect::<Vec<_>>().join(", "));
    }
}
