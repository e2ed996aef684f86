//! A scene that changes from frame to frame: each picture is of the first frame after the change.

use bevy::prelude::*;

use crate::kit::{Kit, Probe};

/// Entity that moves, and how far in each step.
#[derive(Component)]
struct Moves(Vec3);

/// The walls, which are hidden, moved, shrunk and taken away.
#[derive(Resource)]
struct Walls([Entity; 4]);

/// The mesh of the first wall alone.
#[derive(Resource)]
struct OwnMesh(Handle<Mesh>);

pub(crate) fn build(kit: &mut Kit) {
    let walls = kit.yard();
    kit.probe();
    kit.daylight(true);
    let crowd = kit.heap(120, Vec3::new(-12.0, 0.0, -40.0), Vec3::new(-4.0, 8.0, -13.0));
    for (i, e) in crowd.into_iter().enumerate() {
        kit.world.entity_mut(e).insert(Moves(Vec3::new(1.0 + (i % 3) as f32, 0.0, 0.5)));
    }
    let own = kit.world.resource_mut::<Assets<Mesh>>().add(Cuboid::new(1.0, 1.0, 1.0));
    kit.world.entity_mut(walls[0]).insert(Mesh3d(own.clone()));
    kit.world.insert_resource(OwnMesh(own));
    kit.world.insert_resource(Walls(walls));
    kit.eye();
}

/// One kind of change a step, and the crowd always moves.
pub(crate) fn step(world: &mut World, step: u32) {
    let mut crowd = world.query::<(&Moves, &mut Transform)>();
    for (moves, mut at) in crowd.iter_mut(world) {
        at.translation += moves.0;
    }
    let walls = world.resource::<Walls>().0;
    match step {
        // The wall's mesh is changed behind the plugin's back: half as wide.
        1 => {
            let own = world.resource::<OwnMesh>().0.clone();
            let mut meshes = world.resource_mut::<Assets<Mesh>>();
            meshes.insert(own.id(), Cuboid::new(0.4, 1.0, 1.0).into()).expect("of the wall");
        }
        2 => {
            world.entity_mut(walls[1]).insert(Visibility::Hidden);
        }
        3 => {
            world.get_mut::<Transform>(walls[0]).expect("of the wall").translation.x -= 6.0;
            world.entity_mut(walls[1]).insert(Visibility::Inherited);
        }
        4 => {
            world.despawn(walls[0]);
            world.get_mut::<Transform>(walls[2]).expect("of the wall").rotation =
                Quat::from_rotation_y(0.7);
        }
        // The camera jumps: what was hidden from the old place is not from the new one.
        5 => {
            let mut cameras = world.query_filtered::<&mut Transform, With<Camera3d>>();
            for mut at in cameras.iter_mut(world) {
                *at = Transform::from_xyz(14.0, 4.0, -12.0)
                    .looking_at(Vec3::new(-10.0, 2.0, -40.0), Vec3::Y);
            }
        }
        _ => {
            let mut kit = Kit::new(world);
            kit.heap(50, Vec3::new(-10.0, 0.0, -40.0), Vec3::new(5.0, 6.0, -20.0));
            let mut probes = world.query_filtered::<Entity, With<Probe>>();
            let probes: Vec<_> = probes.iter(world).collect();
            probes.into_iter().for_each(|e| {
                world.despawn(e);
            });
        }
    }
}

/// Number of steps.
pub(crate) const STEPS: u32 = 6;
