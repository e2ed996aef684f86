//! The scenes, built of boxes.

use bevy::prelude::*;

use crate::city;

/// A scene, and where its camera stands.
pub(crate) struct Scene {
    pub(crate) name: &'static str,
    pub(crate) build: fn(&mut World),
    pub(crate) camera: fn() -> Transform,
}

pub(crate) const SCENES: &[Scene] = &[
    Scene { name: "nothing", build: sun, camera: || look([0.0, 0.0, 0.0], [0.0, 0.0, -1.0]) },
    Scene { name: "cubes", build: cubes, camera: || look([0.0, 0.0, 0.0], [0.0, 0.0, -1.0]) },
    Scene { name: "lamps", build: lamps, camera: || look([0.0, 6.0, 95.0], [0.0, 0.0, 0.0]) },
    Scene { name: "rooms", build: rooms, camera: || look([17.0, 1.7, 17.0], [0.0, 1.0, 0.0]) },
    Scene { name: "spots", build: spots, camera: || look([-96.0, 1.7, 0.0], [0.0, 1.7, 0.0]) },
    Scene { name: "city", build: |world| city::spawn(world, "city"), camera: city::street },
];

fn look(from: [f32; 3], at: [f32; 3]) -> Transform {
    Transform::from_translation(from.into()).looking_at(at.into(), Vec3::Y)
}

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

    fn put(&self, world: &mut World, paint: usize, center: [f32; 3], size: [f32; 3]) {
        let paint = self.paints[paint % self.paints.len()].clone();
        let at = Transform::from_translation(center.into()).with_scale(size.into());
        world.spawn((Mesh3d(self.cube.clone()), MeshMaterial3d(paint), at));
    }

    /// Floor, ceiling and four walls of a room whose floor has this centre, which run into each other as built ones
    /// do. The wall at +x has a doorway where one is wanted.
    fn room(&self, world: &mut World, paint: usize, [x, y, z]: [f32; 3], size: f32, door: bool) {
        let (half, long) = (size * 0.5, size + 0.4);
        let mut put = |center: [f32; 3], size: [f32; 3]| {
            self.put(world, paint, [x + center[0], y + center[1], z + center[2]], size);
        };
        put([0.0, -0.1, 0.0], [long, 0.2, long]);
        put([0.0, 3.6, 0.0], [long, 0.2, long]);
        put([-half, 1.75, 0.0], [0.2, 3.9, long]);
        put([0.0, 1.75, -half], [long, 3.9, 0.2]);
        put([0.0, 1.75, half], [long, 3.9, 0.2]);
        if !door {
            return put([half, 1.75, 0.0], [0.2, 3.9, long]);
        }
        let beside = half - 0.4;
        for side in [-1.0, 1.0] {
            put([half, 1.75, side * (0.6 + beside * 0.5)], [0.2, 3.9, beside]);
        }
        put([half, 2.9, 0.0], [0.2, 1.6, 1.6]);
    }
}

/// A sun alone: what a frame takes without a mesh.
fn sun(world: &mut World) {
    let sun = DirectionalLight { illuminance: 6000.0, ..default() };
    world.spawn((sun, Transform::default().looking_to(Vec3::new(-0.5, -1.0, -0.7), Vec3::Y)));
}

/// 160,000 cubes on a sphere around the camera, as Bevy's own stress test has them, and within it.
fn cubes(world: &mut World) {
    let parts = Parts::new(world);
    let count = 160_000;
    for i in 0..count {
        // A spiral from pole to pole, whose points lie evenly.
        let up = 1.0 - 2.0 * (i as f32 + 0.5) / count as f32;
        let turn = i as f32 * 2.399_963;
        let across = (1.0 - up * up).sqrt();
        let at = Vec3::new(across * turn.cos(), up, across * turn.sin())
            * (40.0 + (i % 7) as f32 * 20.0);
        parts.put(world, i, at.to_array(), [0.6; 3]);
    }
    sun(world);
}

/// A yard with a thousand lamps without shadows, between walls.
fn lamps(world: &mut World) {
    let parts = Parts::new(world);
    parts.put(world, 7, [0.0, -0.5, 0.0], [220.0, 1.0, 220.0]);
    for i in 0..1000 {
        let [x, z] = [i % 32, i / 32].map(|k| k as f32 * 6.5 - 100.0);
        parts.put(world, i, [x, 1.0, z], [4.0, 2.0, 0.3]);
        let lamp = PointLight { intensity: 2e4, range: 3.0, ..default() };
        world.spawn((lamp, Transform::from_xyz(x, 1.5, z - 1.5)));
    }
}

/// Three by three rooms along corridors, each with forty boxes and a lamp that reaches its walls. The camera stands
/// in one corner and looks towards the others, so that all nine lamps are in its frustum.
fn rooms(world: &mut World) {
    let parts = Parts::new(world);
    for room in 0..9 {
        let at = [(room % 3) as f32 * 14.0 - 14.0, 0.0, (room / 3) as f32 * 14.0 - 14.0];
        parts.room(world, room, at, 10.0, false);
        for i in 0..40 {
            let place = |k: usize| ((i * i * 7 + i * k * 13 + k * 5) % 40) as f32 / 40.0 - 0.5;
            let center = [at[0] + place(1) * 8.0, 0.3 + place(2).abs(), at[2] + place(3) * 8.0];
            parts.put(world, i, center, [0.4 + place(4).abs(); 3]);
        }
        let lamp =
            PointLight { intensity: 3e5, range: 7.0, shadow_maps_enabled: true, ..default() };
        world.spawn((lamp, Transform::from_xyz(at[0], 3.0, at[2])));
    }
}

/// The numbers of bevyengine/bevy#25576: 50,000 meshes and twelve spot lights with shadows, all of them in the
/// frustum. The camera is inside a house and sees a street through its door.
fn spots(world: &mut World) {
    let parts = Parts::new(world);
    parts.put(world, 7, [0.0, -0.7, 0.0], [460.0, 1.0, 460.0]);
    parts.room(world, 3, [-95.0, 0.0, 0.0], 10.0, true);
    for i in 0..50_000 {
        let [x, z] = [i % 224, i / 224].map(|k| k as f32 * 2.0 - 224.0);
        let is_house = (x + 95.0).abs() < 6.0 && z.abs() < 6.0;
        let is_street = z.abs() < 2.0;
        if !is_house && !is_street {
            let tall = 0.5 + (i * 37 % 11) as f32 * 0.15;
            parts.put(world, i, [x, tall * 0.5 - 0.2, z], [0.8, tall, 0.8]);
        }
    }
    for i in 0..12 {
        // A row along the street, and one on either side of it.
        let at = Vec3::new((i % 4) as f32 * 50.0 - 30.0, 18.0, (i / 4) as f32 * 50.0 - 50.0);
        let spot = SpotLight {
            intensity: 5e7,
            range: 40.0,
            outer_angle: 0.7,
            shadow_maps_enabled: true,
            ..default()
        };
        world.spawn((spot, Transform::from_translation(at).looking_at(at - Vec3::Y, Vec3::Z)));
    }
}
