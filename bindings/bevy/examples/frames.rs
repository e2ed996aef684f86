//! Cost of a frame of the city without the plugin, with it, and with occlusion, drawn without a
//! window: `cargo run --release --example frames`. With a folder it writes pictures of the overlay
//! there, and measures nothing.

#[path = "../tests/common/picture.rs"]
mod picture;
#[path = "city/scene.rs"]
mod scene;

use std::any::TypeId;
use std::path::Path;
use std::time::Duration;

use bevy::camera::RenderTarget;
use bevy::camera::visibility::VisibleEntities;
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::prelude::*;
use bevy_cullet::{
    CulletOcclusion, CulletOverlay, CulletOverlayPlugin, CulletPlugin, CulletPrepare,
};

use picture::{Canvas, Picture, Studio};

const SIZE: [u32; 2] = [640, 360];
/// The built-in city whole: 10,000 buildings and 100,000 objects.
const LARGE: &str = "city";
const ROUNDS: usize = 5;
const FRAMES: usize = 8;

/// The city with a camera in the street.
fn city(spec: &str, plugin: bool, occlusion: bool, overlay: bool) -> Studio {
    let mut studio = Studio::new(SIZE, |app| {
        if plugin {
            app.add_plugins(CulletPlugin).insert_resource(CulletPrepare::AtOnce);
        }
        if overlay {
            app.add_plugins(CulletOverlayPlugin);
        }
        let world = app.world_mut();
        scene::spawn(world, spec);
        let target = RenderTarget::Image(world.resource::<Canvas>().0.clone().into());
        let camera = (Camera3d::default(), target, Msaa::Off, Tonemapping::Reinhard);
        let mut camera = world.spawn((camera, scene::street()));
        if occlusion {
            camera.insert(CulletOcclusion::default());
        }
    });
    studio.settle();
    studio
}

fn listed(world: &mut World) -> usize {
    let mut cameras = world.query::<&VisibleEntities>();
    cameras.iter(world).map(|list| list.get(TypeId::of::<Mesh3d>()).len()).sum()
}

/// Moves the camera by a step, or with 0 puts it back.
fn step(world: &mut World, n: usize) {
    let mut cameras = world.query_filtered::<&mut Transform, With<Camera3d>>();
    for mut at in cameras.iter_mut(world) {
        *at = scene::street();
        let ahead = at.forward() * n as f32 * 0.3;
        at.translation += ahead;
    }
}

/// The overlay from the street, and what it shows frozen and seen from above.
fn overlay(folder: &Path) {
    let mut studio = city(scene::SPEC, true, true, true);
    studio.shoot().save(&folder.join("bevy-street.png"));
    studio.world().resource_mut::<CulletOverlay>().frozen = true;
    studio.settle();
    let mut cameras = studio.world().query_filtered::<&mut Transform, With<Camera3d>>();
    for mut at in cameras.iter_mut(studio.world()) {
        *at =
            Transform::from_xyz(110.0, 120.0, 150.0).looking_at(Vec3::new(0.0, 0.0, 10.0), Vec3::Y);
    }
    studio.shoot().save(&folder.join("bevy-city.png"));
}

fn main() {
    if let Some(folder) = std::env::args().nth(1) {
        return overlay(Path::new(&folder));
    }
    let kinds =
        [("Bevy alone", false, false), ("plugin", true, false), ("plugin, occlusion", true, true)];
    let mut studios = kinds.map(|(_, plugin, occlusion)| city(LARGE, plugin, occlusion, false));
    let pictures: Vec<Picture> = studios.iter_mut().map(Studio::shoot).collect();
    let mut times = vec![Vec::<Duration>::new(); kinds.len()];
    // In turns, so that what else the machine does falls on all.
    for _ in 0..ROUNDS {
        for (studio, times) in studios.iter_mut().zip(&mut times) {
            for n in 0..FRAMES {
                step(studio.world(), n);
                times.push(studio.frame());
            }
        }
    }
    for (i, (name, ..)) in kinds.iter().enumerate() {
        step(studios[i].world(), 0);
        studios[i].frame();
        times[i].sort_unstable();
        println!(
            "{name:18} {:7.1} ms a frame (least {:.1}), {} entities drawn, {} pixels differ from Bevy's",
            times[i][times[i].len() / 2].as_secs_f64() * 1e3,
            times[i][0].as_secs_f64() * 1e3,
            listed(studios[i].world()),
            pictures[i].differing(&pictures[0]),
        );
    }
}
