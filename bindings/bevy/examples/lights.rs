//! Cost of a frame where lamps throw shadows, without the plugin, with it, and with occlusion, drawn
//! without a window: nine rooms with a lamp each, of which the camera sees one, and twelve spot
//! lights over 50,000 boxes. `cargo run --release --example lights`; a word, `rooms` or `spots`,
//! chooses one.

#[path = "../tests/common/picture.rs"]
mod picture;

use std::time::Duration;

use bevy::camera::RenderTarget;
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::prelude::*;
use bevy_cullet::{CulletLight, CulletOcclusion, CulletPlugin, CulletPrepare};

use picture::{Canvas, Picture, Studio};

const SIZE: [u32; 2] = [640, 360];
const ROUNDS: usize = 5;
const FRAMES: usize = 6;

/// Meshes and materials that scenes are built of.
struct Parts {
    cube: Handle<Mesh>,
    paints: Vec<Handle<StandardMaterial>>,
}

impl Parts {
    fn new(world: &mut World) -> Self {
        let cube = world.resource_mut::<Assets<Mesh>>().add(Cuboid::new(1.0, 1.0, 1.0));
        let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
        let paint = |i: usize| StandardMaterial {
            base_color: Color::hsl(i as f32 * 45.0, 0.4, 0.6),
            perceptual_roughness: 0.9,
            ..default()
        };
        let paints = (0..8).map(|i| materials.add(paint(i))).collect();
        Self { cube, paints }
    }

    fn put(&self, world: &mut World, paint: usize, center: Vec3, size: Vec3) {
        let paint = self.paints[paint % self.paints.len()].clone();
        let at = Transform::from_translation(center).with_scale(size);
        world.spawn((Mesh3d(self.cube.clone()), MeshMaterial3d(paint), at));
    }
}

fn camera(world: &mut World, at: Transform, occlusion: bool) {
    let target = RenderTarget::Image(world.resource::<Canvas>().0.clone().into());
    let mut camera =
        world.spawn((Camera3d::default(), target, Msaa::Off, Tonemapping::Reinhard, at));
    if occlusion {
        camera.insert(CulletOcclusion::default());
    }
}

/// Three by three rooms of ten metres, each with its floor, walls, ceiling, forty boxes and a lamp
/// that reaches six metres; the camera stands in the middle one.
fn rooms(world: &mut World, occlusion: bool) {
    let parts = Parts::new(world);
    for room in 0..9 {
        let at = Vec3::new((room % 3) as f32 * 10.0 - 10.0, 0.0, (room / 3) as f32 * 10.0 - 10.0);
        for (center, size) in [
            ([0.0, -0.1, 0.0], [10.0, 0.2, 10.0]),
            ([0.0, 3.6, 0.0], [10.0, 0.2, 10.0]),
            ([-4.95, 1.75, 0.0], [0.1, 3.5, 10.0]),
            ([4.95, 1.75, 0.0], [0.1, 3.5, 10.0]),
            ([0.0, 1.75, -4.95], [10.0, 3.5, 0.1]),
            ([0.0, 1.75, 4.95], [10.0, 3.5, 0.1]),
        ] {
            parts.put(world, room, at + Vec3::from_array(center), Vec3::from_array(size));
        }
        for i in 0..40 {
            let place = |k: usize| ((i * 7 + k * 5) % 40) as f32 / 40.0 - 0.5;
            let center = at + Vec3::new(place(1) * 8.0, 0.3 + place(2).abs(), place(3) * 8.0);
            parts.put(world, i, center, Vec3::splat(0.4 + place(4).abs()));
        }
        let lamp =
            PointLight { intensity: 3e5, range: 6.0, shadow_maps_enabled: true, ..default() };
        world.spawn((lamp, Transform::from_translation(at + Vec3::Y * 3.0)));
    }
    let at = Transform::from_xyz(-4.0, 1.7, 4.0).looking_at(Vec3::new(2.0, 1.0, -2.0), Vec3::Y);
    camera(world, at, occlusion);
}

/// The scene of bevyengine/bevy#25576, by our own hand: 50,000 boxes over a plain, and twelve spot
/// lights with shadows all over it; the camera stands among them.
fn spots(world: &mut World, occlusion: bool) {
    let parts = Parts::new(world);
    parts.put(world, 7, Vec3::new(0.0, -0.5, 0.0), Vec3::new(460.0, 1.0, 460.0));
    for i in 0..50_000 {
        let [x, z] = [i % 224, i / 224].map(|k| k as f32 * 2.0 - 224.0);
        let tall = 0.5 + (i * 37 % 11) as f32 * 0.15;
        parts.put(world, i, Vec3::new(x, tall * 0.5, z), Vec3::new(0.8, tall, 0.8));
    }
    for i in 0..12 {
        let at = Vec3::new((i % 4) as f32 * 100.0 - 150.0, 25.0, (i / 4) as f32 * 120.0 - 120.0);
        let spot = SpotLight {
            intensity: 5e7,
            range: 60.0,
            outer_angle: 0.8,
            shadow_maps_enabled: true,
            ..default()
        };
        world.spawn((spot, Transform::from_translation(at).looking_at(at - Vec3::Y, Vec3::Z)));
    }
    let at = Transform::from_xyz(10.0, 3.0, 20.0).looking_at(Vec3::new(60.0, 0.0, -20.0), Vec3::Y);
    camera(world, at, occlusion);
}

/// Moves the camera by a step, or with 0 puts it back.
fn step(world: &mut World, n: usize) {
    let mut cameras = world.query_filtered::<&mut Transform, With<Camera3d>>();
    for mut at in cameras.iter_mut(world) {
        at.rotate_y(if n % 2 == 0 { 0.02 } else { -0.02 });
    }
}

fn measure(name: &str, build: fn(&mut World, bool)) {
    let kinds =
        [("Bevy alone", false, false), ("plugin", true, false), ("plugin, occlusion", true, true)];
    let mut studios = kinds.map(|(_, plugin, occlusion)| {
        let mut studio = Studio::new(SIZE, |app| {
            if plugin {
                app.add_plugins(CulletPlugin).insert_resource(CulletPrepare::AtOnce);
            }
            build(app.world_mut(), occlusion);
        });
        studio.settle();
        studio
    });
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
    for (i, (kind, ..)) in kinds.iter().enumerate() {
        times[i].sort_unstable();
        let views = studios[i].lamp_views();
        let world = studios[i].world();
        let mut lights = world.query::<&CulletLight>();
        let out = lights.iter(world).filter(|light| light.is_left_out).count();
        println!(
            "{name:6} {kind:18} {:7.1} ms a frame (least {:.1}), {views} views of lamps, {out} lights left out, {} pixels differ from Bevy's",
            times[i][times[i].len() / 2].as_secs_f64() * 1e3,
            times[i][0].as_secs_f64() * 1e3,
            pictures[i].differing(&pictures[0]),
        );
    }
}

fn main() {
    let word = std::env::args().nth(1);
    let scenes: [(&str, fn(&mut World, bool)); 2] = [("rooms", rooms), ("spots", spots)];
    for (name, build) in scenes {
        if word.as_deref().is_none_or(|word| word == name) {
            measure(name, build);
        }
    }
}
