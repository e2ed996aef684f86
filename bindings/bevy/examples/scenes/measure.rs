//! A frame and its parts, without a window: Bevy alone, with the plugin, and with occlusion, by turns.

use std::any::TypeId;
use std::path::Path;
use std::time::Duration;

use bevy::camera::RenderTarget;
use bevy::camera::visibility::VisibleEntities;
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::prelude::*;
use bevy_cullet::{
    CulletLight, CulletOcclusion, CulletOverlay, CulletOverlayPlugin, CulletPlugin, CulletPrepare,
};

use crate::build::{SCENES, Scene};
use crate::city;
use crate::picture::{Canvas, Picture, Studio};

pub(crate) const HEAD: &str = "\
| scene | | frame, ms | ratio | app, ms | encoding, ms | device, ms | meshes drawn | views of lamps | lights left out | pixels that differ |
|---|---|---|---|---|---|---|---|---|---|---|";

/// Small, for a renderer in software takes a hundred times as long for a pixel as a graphics card.
const SIZE: [u32; 2] = [320, 180];
const ROUNDS: usize = 5;
const FRAMES: usize = 6;

/// The scene with its camera; the plugin where there is a setting of occlusion.
fn studio(
    scene: &Scene,
    occlusion: Option<bool>,
    size: [u32; 2],
    more: impl FnOnce(&mut App),
) -> Studio {
    let mut studio = Studio::new(size, |app| {
        if occlusion.is_some() {
            app.add_plugins(CulletPlugin).insert_resource(CulletPrepare::AtOnce);
        }
        more(app);
        let world = app.world_mut();
        (scene.build)(world);
        let target = RenderTarget::Image(world.resource::<Canvas>().0.clone().into());
        let camera = (Camera3d::default(), target, Msaa::Off, Tonemapping::Reinhard);
        let mut camera = world.spawn((camera, (scene.camera)()));
        if occlusion == Some(true) {
            camera.insert(CulletOcclusion::default());
        }
    });
    studio.settle();
    studio
}

/// Turns the camera a little, there and back.
fn step(world: &mut World, n: usize) {
    let mut cameras = world.query_filtered::<&mut Transform, With<Camera3d>>();
    for mut at in cameras.iter_mut(world) {
        at.rotate_y(if n.is_multiple_of(2) { 0.02 } else { -0.02 });
    }
}

fn listed(world: &mut World) -> usize {
    let mut cameras = world.query_filtered::<&VisibleEntities, With<Camera3d>>();
    cameras.iter(world).map(|list| list.get(TypeId::of::<Mesh3d>()).len()).sum()
}

fn median(times: &mut [Duration]) -> f64 {
    times.sort_unstable();
    times[times.len() / 2].as_secs_f64() * 1e3
}

/// Measures a scene, and prints a row of the table for each way.
pub(crate) fn compare(scene: &Scene) {
    let kinds = [("Bevy alone", None), ("plugin", Some(false)), ("plugin, occlusion", Some(true))];
    let mut studios = kinds.map(|(_, occlusion)| studio(scene, occlusion, SIZE, |_| {}));
    let pictures: Vec<Picture> = studios.iter_mut().map(Studio::shoot).collect();
    let mut frames = vec![Vec::new(); kinds.len()];
    let mut parts = vec![[const { Vec::new() }; 3]; kinds.len()];
    // In turns, so that what else the machine does falls on all.
    for _ in 0..ROUNDS {
        for (i, studio) in studios.iter_mut().enumerate() {
            for n in 0..FRAMES {
                step(studio.world(), n);
                let times = studio.frame_parts();
                frames[i].push(times.iter().sum::<Duration>());
                parts[i].iter_mut().zip(times).for_each(|(all, time)| all.push(time));
            }
        }
    }
    let alone = median(&mut frames[0]);
    for (i, (kind, _)) in kinds.iter().enumerate() {
        let frame = median(&mut frames[i]);
        let [app, encoding, device] = parts[i].each_mut().map(|times| median(times));
        let views = studios[i].lamp_views();
        let world = studios[i].world();
        let mut lights = world.query::<&CulletLight>();
        let out = lights.iter(world).filter(|light| light.is_left_out).count();
        println!(
            "| {} | {kind} | {frame:.1} | {:.2} | {app:.1} | {encoding:.1} | {device:.1} | {} | {views} | {out} | {} |",
            scene.name,
            frame / alone,
            listed(world),
            pictures[i].differing(&pictures[0]),
        );
    }
}

/// Writes the overlay of the city from the street, and frozen and seen from above; and that of the rooms from inside.
pub(crate) fn pictures(folder: &Path) {
    let small = Scene {
        name: "small city",
        build: |world| city::spawn(world, city::SPEC),
        camera: city::street,
    };
    let overlay = |scene: &Scene| {
        studio(scene, Some(true), [640, 360], |app| {
            app.add_plugins(CulletOverlayPlugin);
        })
    };
    let mut of_city = overlay(&small);
    of_city.shoot().save(&folder.join("bevy-street.png"));
    of_city.world().resource_mut::<CulletOverlay>().frozen = true;
    of_city.settle();
    let mut cameras = of_city.world().query_filtered::<&mut Transform, With<Camera3d>>();
    for mut at in cameras.iter_mut(of_city.world()) {
        *at =
            Transform::from_xyz(110.0, 120.0, 150.0).looking_at(Vec3::new(0.0, 0.0, 10.0), Vec3::Y);
    }
    of_city.shoot().save(&folder.join("bevy-city.png"));
    for scene in SCENES.iter().filter(|scene| scene.name == "rooms") {
        overlay(scene).shoot().save(&folder.join("bevy-lights.png"));
    }
}
