//! The plugin changes no picture: each scene is drawn by Bevy with and without it and compared pixel for pixel. A
//! plugin that loses one mesh or one caster of a shadow is noticed in each.
//!
//! `cargo test --test pictures`. Needs a driver of Vulkan, which may be software (`apt install mesa-vulkan-drivers`).

#[path = "../../examples/first.rs"]
#[expect(dead_code, unreachable_pub, reason = "an example that runs by itself")]
mod first;
#[path = "../common/picture.rs"]
mod picture;

mod cells;
mod deformed;
mod door;
mod kit;
mod lights;
mod moving;
mod mutants;
mod overlay;
mod ranges;
mod scenes;

use std::collections::BTreeSet;
use std::path::Path;

use bevy::camera::visibility::VisibleEntities;
use bevy::prelude::*;
use bevy_cullet::{CulletOcclusion, CulletPlugin, CulletPrepare};

use kit::Kit;
use picture::{Picture, Studio};

/// Pixels of every picture.
const SIZE: [u32; 2] = [320, 180];

/// A scene, and what changes in it.
#[derive(Clone, Copy)]
struct Scene {
    build: fn(&mut Kit),
    /// Called before each picture but the first, with its number.
    step: fn(&mut World, u32),
    steps: u32,
}

impl Scene {
    const fn still(build: fn(&mut Kit)) -> Self {
        Self { build, step: |_, _| {}, steps: 0 }
    }
}

/// Pictures of a scene, and how many entities its cameras listed for each.
struct Shots {
    pictures: Vec<Picture>,
    listed: Vec<usize>,
}

fn shoot(scene: Scene, plugins: impl FnOnce(&mut App)) -> Shots {
    let mut studio = Studio::new(SIZE, |app| {
        plugins(app);
        (scene.build)(&mut Kit::new(app.world_mut()));
    });
    studio.settle();
    let mut shots = Shots { pictures: Vec::new(), listed: Vec::new() };
    for step in 0..=scene.steps {
        if step > 0 {
            (scene.step)(studio.world(), step);
        }
        shots.pictures.push(studio.shoot());
        shots.listed.push(listed(studio.world()));
    }
    shots
}

fn listed(world: &mut World) -> usize {
    let mut cameras = world.query_filtered::<&VisibleEntities, With<Camera3d>>();
    cameras.iter(world).map(|list| list.get(std::any::TypeId::of::<Mesh3d>()).len()).sum()
}

/// The plugin, and occlusion for every camera.
fn ours(app: &mut App) {
    app.add_plugins(CulletPlugin);
    app.register_required_components::<Camera3d, CulletOcclusion>();
    // Else the first pictures would be of scenes in which nothing hides yet.
    app.insert_resource(CulletPrepare::AtOnce);
}

/// Whether this machine has a graphics device, in hardware or in software; without one Bevy panics when its plugins are
/// added. With `CULLET_REQUIRE_GPU=1` it must have one.
fn has_device() -> bool {
    static ANSWER: std::sync::OnceLock<bool> = std::sync::OnceLock::new();
    *ANSWER.get_or_init(|| {
        let is_there = std::panic::catch_unwind(|| Studio::new([16, 16], |_| {})).is_ok();
        let required = std::env::var("CULLET_REQUIRE_GPU").is_ok_and(|v| v == "1");
        assert!(is_there || !required, "CULLET_REQUIRE_GPU=1, and there is no graphics device");
        if !is_there {
            println!("skipped: no graphics device (apt install mesa-vulkan-drivers libvulkan1)");
        }
        is_there
    })
}

/// Draws a scene without and with the plugin: the same pictures, of something, and with occlusion at most `most` of the
/// entities that Bevy lists.
fn same(scene: Scene, most: f64) {
    if !has_device() {
        return;
    }
    let without = shoot(scene, |_| {});
    let with = shoot(scene, ours);
    for (step, (a, b)) in without.pictures.iter().zip(&with.pictures).enumerate() {
        let colours: BTreeSet<_> = a.pixels.iter().collect();
        assert!(colours.len() > 20, "picture {step} is of nothing");
        let differing = a.differing(b);
        if differing > 0 {
            let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
            a.save(&folder.join("without.png"));
            b.save(&folder.join("with.png"));
            panic!("{differing} pixels of picture {step} differ: see {}", folder.display());
        }
    }
    for pair in without.pictures.windows(2) {
        assert!(pair[0] != pair[1], "a step changes nothing that is seen");
    }
    let [all, kept] = [&without, &with].map(|shots| shots.listed.iter().sum::<usize>());
    println!("entities listed: {all} without, {kept} with");
    assert!(kept as f64 <= all as f64 * most, "{kept} of {all} entities are kept");
}

/// The first program of the readme: its camera has what it asks for.
#[test]
fn first_use() {
    if !has_device() {
        return;
    }
    let mut studio = Studio::new([16, 16], |app| {
        app.add_plugins(CulletPlugin).add_systems(Startup, first::setup);
    });
    studio.settle();
    let mut cameras =
        studio.world().query_filtered::<(), (With<Camera3d>, With<CulletOcclusion>)>();
    assert_eq!(cameras.iter(studio.world()).count(), 1);
}

#[test]
fn plain() {
    same(Scene::still(scenes::plain), 0.9);
}

#[test]
fn sun() {
    same(Scene::still(scenes::sun), 0.9);
}

#[test]
fn lamps() {
    same(Scene::still(scenes::lamps), 0.9);
}

#[test]
fn layers_and_two_cameras() {
    same(Scene::still(scenes::layers), 0.95);
}

#[test]
fn orthographic() {
    same(Scene::still(scenes::orthographic), 0.95);
}

#[test]
fn skinned_and_morphed() {
    same(Scene { build: deformed::build, step: deformed::step, steps: 2 }, 0.9);
}

#[test]
fn ranges() {
    same(Scene::still(scenes::ranges), 1.0);
}

#[test]
fn ranges_that_fade_in_shadows() {
    same(Scene { build: ranges::build, step: ranges::step, steps: ranges::STEPS }, 1.0);
}

#[test]
fn transparent() {
    same(Scene::still(scenes::transparent), 1.0);
}

#[test]
fn walls_that_are_not_drawn() {
    same(Scene::still(scenes::not_drawn), 1.0);
}

#[test]
fn odd() {
    same(Scene::still(scenes::odd), 1.0);
}

#[test]
fn city() {
    same(Scene::still(scenes::city), 1.0 / 3.0);
}

#[test]
fn moving() {
    same(Scene { build: moving::build, step: moving::step, steps: moving::STEPS }, 0.95);
}
