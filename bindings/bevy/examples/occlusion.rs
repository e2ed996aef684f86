//! Bevy's own occlusion culling beside this plugin's, on one scene: `cargo run --release --example occlusion [FILE]`
//! counts the pixels that differ from the picture that nothing was culled for, and writes the three pictures into `FILE`,
//! side by side, wrong pixels in crimson.

#[path = "../tests/common/picture.rs"]
mod picture;

use std::path::Path;

use bevy::camera::RenderTarget;
use bevy::core_pipeline::prepass::DepthPrepass;
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::prelude::*;
use bevy::render::occlusion_culling::OcclusionCulling;
use bevy::render::view::NoIndirectDrawing;
use bevy_cullet::{CulletOcclusion, CulletPlugin, CulletPrepare};

use picture::{Canvas, Picture, Studio};

const SIZE: [u32; 2] = [400, 200];
const WRONG: [u8; 4] = [0xFF, 0x00, 0x3C, 0xFF];

/// Who culls.
#[derive(Clone, Copy, Debug, PartialEq)]
enum By {
    /// Drawn directly, so that the device culls nothing.
    Nobody,
    Bevy,
    Cullet,
}

/// 2,000 boxes among four walls.
fn draw(by: By) -> Picture {
    let mut studio = Studio::new(SIZE, |app| {
        if by == By::Cullet {
            app.add_plugins(CulletPlugin).insert_resource(CulletPrepare::AtOnce);
        }
        spawn(app.world_mut());
        let world = app.world_mut();
        let target = RenderTarget::Image(world.resource::<Canvas>().0.clone().into());
        let camera = (Camera3d::default(), target, Msaa::Off, Tonemapping::Reinhard);
        let mut camera = world.spawn((camera, Transform::from_xyz(0.0, 3.0, 2.0)));
        match by {
            By::Nobody => camera.insert(NoIndirectDrawing),
            By::Bevy => camera.insert((DepthPrepass, OcclusionCulling)),
            By::Cullet => camera.insert(CulletOcclusion::default()),
        };
    });
    studio.settle();
    studio.shoot()
}

fn spawn(world: &mut World) {
    let cube = world.resource_mut::<Assets<Mesh>>().add(Cuboid::new(1.0, 1.0, 1.0));
    let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
    let paints: Vec<_> = (0..8)
        .map(|i| {
            let base_color = Color::hsl(i as f32 * 45.0, 0.7, 0.5);
            materials.add(StandardMaterial { base_color, perceptual_roughness: 0.9, ..default() })
        })
        .collect();
    let mut put = |i: usize, at| {
        world.spawn((Mesh3d(cube.clone()), MeshMaterial3d(paints[i % 8].clone()), at));
    };
    let mut seed = 1_u64;
    let mut roll = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 40) as f32 / (1 << 24) as f32
    };
    for i in 0..2000 {
        let at = Vec3::new(roll() * 80.0 - 40.0, roll() * 12.0, -roll() * 100.0 - 4.0);
        let turn = Quat::from_euler(EulerRot::XYZ, roll() * 6.0, roll() * 6.0, roll() * 6.0);
        let at = Transform::from_translation(at).with_rotation(turn);
        put(i, at.with_scale(Vec3::splat(0.4 + roll())));
    }
    let walls = [(-6.0, -12.0, 9.0), (9.0, -20.0, 14.0), (-20.0, -40.0, 30.0), (18.0, -55.0, 30.0)];
    for (x, z, wide) in walls {
        put(0, Transform::from_xyz(x, 5.0, z).with_scale(Vec3::new(wide, 10.0, 0.5)));
    }
    put(3, Transform::from_xyz(0.0, -1.0, -50.0).with_scale(Vec3::new(120.0, 1.0, 140.0)));
    let sun = DirectionalLight { illuminance: 3000.0, shadow_maps_enabled: true, ..default() };
    let from = Transform::from_xyz(5.0, 9.0, -5.0);
    world.spawn((sun, from.looking_at(Vec3::new(-3.0, 0.0, -30.0), Vec3::Y)));
}

/// A picture in grey, wrong pixels and their neighbours in crimson.
fn marked(picture: &Picture, truth: &Picture) -> Vec<[u8; 4]> {
    let [w, h] = SIZE.map(|n| n as usize);
    let is_wrong = |x: usize, y: usize| picture.pixels[y * w + x] != truth.pixels[y * w + x];
    let pixel = |at: usize| {
        let (x, y) = (at % w, at / w);
        let mut near = (y.saturating_sub(1)..h.min(y + 2))
            .flat_map(|y| (x.saturating_sub(1)..w.min(x + 2)).map(move |x| (x, y)));
        if near.any(|(x, y)| is_wrong(x, y)) {
            return WRONG;
        }
        let [r, g, b, a] = picture.pixels[at].map(u32::from);
        let grey = (2 * r + 5 * g + b) / 8;
        let [r, g, b] = [r, g, b].map(|v| ((v + grey * 2) / 3) as u8);
        [r, g, b, a as u8]
    };
    (0..w * h).map(pixel).collect()
}

fn main() {
    let [truth, bevy, cullet] = [By::Nobody, By::Bevy, By::Cullet].map(draw);
    println!("Bevy's OcclusionCulling: {} pixels differ", bevy.differing(&truth));
    println!("CulletOcclusion: {} pixels differ", cullet.differing(&truth));
    let Some(file) = std::env::args().nth(1) else { return };
    let panels = [truth.pixels.clone(), marked(&bevy, &truth), marked(&cullet, &truth)];
    let [w, h] = SIZE.map(|n| n as usize);
    let gap = [[255; 4]; 6];
    let row = |y: usize| panels.each_ref().map(|panel| &panel[y * w..][..w]).join(&gap[..]);
    let pixels = (0..h).flat_map(row).collect();
    Picture { size: [SIZE[0] * 3 + 12, SIZE[1]], pixels }.save(Path::new(&file));
}
