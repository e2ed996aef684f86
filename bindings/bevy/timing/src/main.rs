//! Milliseconds a frame in the systems of visibility, Bevy's own and the plugin's, in turn in one run, as a table:
//! `cargo run --release -p bevy_cullet_timing`. Words narrow it: numbers of entities, `standing`, `moving`, `turning`, and
//! `parts` for the parts of each frame. `lights` measures the lists of shadow casters instead.
#![forbid(unsafe_code)]

mod lights;

use std::any::TypeId;
use std::process::ExitCode;
use std::time::Instant;

use bevy_app::prelude::*;
use bevy_asset::{AssetApp, AssetPlugin};
use bevy_camera::primitives::{Aabb, Frustum};
use bevy_camera::visibility::VisibilitySystems::{
    CalculateBounds, CheckVisibility, MarkNewlyHiddenEntitiesInvisible, UpdateFrusta,
    VisibilityPropagate,
};
use bevy_camera::visibility::{NoAutoAabb, VisibleEntities};
use bevy_camera::{Camera3d, CameraPlugin, PerspectiveProjection, Projection};
use bevy_cullet::CulletPlugin;
use bevy_ecs::prelude::*;
use bevy_math::{DVec3, Quat, Vec3, Vec3A};
use bevy_mesh::{Mesh3d, MeshPlugin};
use bevy_transform::components::{GlobalTransform, Transform};
use bevy_transform::{TransformPlugin, TransformSystems};

/// Parts of a frame, in their order.
const PARTS: [&str; 4] = ["propagate", "check", "mark hidden", "frame"];

#[derive(Resource)]
struct Clock {
    at: Instant,
    laps: [f64; 4],
}

/// The place of an entity in the order in which they were made: ids differ from app to app.
#[derive(Component)]
struct Number(u32);

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

/// A pyramid that holds about a tenth of what is around its tip.
const FOV: f32 = 1.22;

/// Frames that do not count: what is new is sorted, and memory is taken.
const WARM_UP: usize = 8;

/// How a scene changes from frame to frame.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Motion {
    Standing,
    TenthMoving,
    CameraTurning,
}

impl Motion {
    const ALL: [Self; 3] = [Self::Standing, Self::TenthMoving, Self::CameraTurning];

    /// Returns the word that a person types for it, and the one that the table prints.
    fn words(self) -> [&'static str; 2] {
        match self {
            Self::Standing => ["standing", "standing"],
            Self::TenthMoving => ["moving", "a tenth moving"],
            Self::CameraTurning => ["turning", "camera turning"],
        }
    }
}

/// A cube of boxes around a camera that sees about a tenth of them.
fn app(count: usize, motion: Motion, with_plugin: bool, more: impl FnOnce(&mut App)) -> App {
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
    more(&mut app);
    let world = app.world_mut();
    let projection = PerspectiveProjection { fov: FOV, aspect_ratio: 1.0, ..Default::default() };
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
        let mut entity =
            world.spawn((transform, Mesh3d::default(), NoAutoAabb, aabb, Number(i as u32)));
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

/// The numbers of the entities that the camera lists, in the order of the list.
fn visible(app: &mut App) -> Vec<u32> {
    let world = app.world_mut();
    let mut views = world.query::<&VisibleEntities>();
    let of_mesh = |view: &VisibleEntities| view.get(TypeId::of::<Mesh3d>()).to_vec();
    let listed: Vec<Entity> = views.iter(world).flat_map(of_mesh).collect();
    let number = |entity: &Entity| world.get::<Number>(*entity).map(|number| number.0);
    let mut numbers: Vec<u32> = listed.iter().filter_map(number).collect();
    numbers.sort_unstable();
    numbers
}

/// How near a box comes to a half-space of the frustum, relative to the sizes that were summed: Bevy tests in f32, the plugin
/// in f64, and where f32 cannot tell they may differ.
fn margin(app: &mut App, number: u32) -> f64 {
    let world = app.world_mut();
    let mut frusta = world.query::<&Frustum>();
    let planes: Vec<[f64; 4]> = frusta
        .iter(world)
        .flat_map(|frustum| frustum.half_spaces[..5].iter())
        .map(|plane| plane.normal_d().as_dvec4().to_array())
        .collect();
    let mut all = world.query::<(&Number, &Aabb, &GlobalTransform)>();
    let Some((_, aabb, at)) = all.iter(world).find(|(own, ..)| own.0 == number) else { return 1.0 };
    let m = at.affine().matrix3.as_dmat3();
    let center = m * aabb.center.as_dvec3() + at.affine().translation.as_dvec3();
    let of = |[x, y, z, d]: [f64; 4]| {
        let n = DVec3::new(x, y, z);
        let radius = (m.transpose() * n).abs().dot(aabb.half_extents.as_dvec3());
        ((n.dot(center) + d + radius) / (center.length() + d.abs() + radius)).abs()
    };
    planes.into_iter().map(of).fold(f64::INFINITY, f64::min)
}

fn main() -> ExitCode {
    let (mut counts, mut motions, mut parts, mut of_lights) =
        (Vec::new(), Vec::new(), false, false);
    for word in std::env::args().skip(1) {
        if let Ok(count @ 1..) = word.parse::<usize>() {
            counts.push(count);
        } else if let Some(motion) = Motion::ALL.into_iter().find(|m| m.words()[0] == word) {
            motions.push(motion);
        } else if word == "parts" {
            parts = true;
        } else if word == "lights" {
            of_lights = true;
        } else {
            eprintln!(
                "{word}: numbers of entities, standing, moving, turning, parts and lights are known"
            );
            return ExitCode::from(2);
        }
    }
    if motions.is_empty() {
        motions = Motion::ALL.to_vec();
    }
    if of_lights {
        counts.is_empty().then(|| counts.push(50_000));
        lights::table(&counts, &motions);
        return ExitCode::SUCCESS;
    }
    if counts.is_empty() {
        counts = vec![10_000, 100_000, 1_000_000];
    }
    println!("| entities | motion | visible | Bevy, ms | plugin, ms | ratio | its spread |");
    println!("|---|---|---|---|---|---|---|");
    for &count in &counts {
        motions.iter().for_each(|&motion| measure(count, motion, parts));
    }
    println!(
        "\nMedians of whole frames' visibility systems; spread: quartiles of the ratio, frame by frame."
    );
    ExitCode::SUCCESS
}

/// The value that a share of all is below.
fn quantile(values: impl Iterator<Item = f64>, share: f64) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values[((values.len() - 1) as f64 * share).round() as usize]
}

fn measure(count: usize, motion: Motion, parts: bool) {
    let mut apps = [false, true].map(|with_plugin| app(count, motion, with_plugin, |_| {}));
    let rounds = (60_000_000 / count).clamp(60, 600);
    let mut all = [Vec::new(), Vec::new()];
    for round in 0..rounds + WARM_UP {
        for (app, times) in apps.iter_mut().zip(&mut all) {
            let laps = frame(app);
            if round >= WARM_UP {
                times.push(laps);
            }
        }
        if round % (rounds / 4) == 0 {
            let [bevy, ours] = apps.each_mut().map(visible);
            let differ = bevy.iter().filter(|n| ours.binary_search(n).is_err());
            let differ = differ.chain(ours.iter().filter(|n| bevy.binary_search(n).is_err()));
            for &number in differ {
                let margin = margin(&mut apps[0], number);
                assert!(
                    margin < 1e-5,
                    "{number} is in one list only, and no rounding explains it: {margin}"
                );
            }
        }
    }
    let share = visible(&mut apps[0]).len() as f64 / count as f64 * 100.0;
    let sum = |laps: &[f64; 4]| laps[..3].iter().sum::<f64>();
    let [bevy, ours] = all.each_ref().map(|times| quantile(times.iter().map(sum), 0.5));
    let pairs = || all[0].iter().zip(&all[1]).map(|(bevy, ours)| sum(ours) / sum(bevy));
    let [low, high] = [0.25, 0.75].map(|at| quantile(pairs(), at));
    println!(
        "| {count} | {} | {share:.1} % | {bevy:.3} | {ours:.3} | {:.3} | {low:.3} to {high:.3} |",
        motion.words()[1],
        ours / bevy
    );
    for (name, times) in ["Bevy", "plugin"].iter().zip(&all).filter(|_| parts) {
        let of = |part: usize| quantile(times.iter().map(|laps| laps[part]), 0.5);
        let words = PARTS.iter().enumerate().map(|(part, word)| format!("{word} {:.3}", of(part)));
        println!("    {name}: {}", words.collect::<Vec<_>>().join(", "));
    }
}
