//! A house on a wide floor, lamps all around it, and a camera inside that sees some of the floor through a door: of
//! the floor's lit parts most are hidden.

use std::collections::BTreeSet;

use bevy::light::{DirectionalLightShadowMap, PointLightShadowMap};
use bevy::prelude::*;

use crate::cells::Part;
use crate::has_device;
use crate::kit::{Dice, Kit};
use crate::lights::same;

const STEPS: u32 = 24;

/// The door's leaf, which opens and shuts.
#[derive(Component)]
struct Leaf;

fn build(kit: &mut Kit) {
    kit.world.insert_resource(PointLightShadowMap { size: 128 });
    kit.world.insert_resource(DirectionalLightShadowMap { size: 128 });
    kit.put(7, [0.0, -0.5, 0.0], [120.0, 1.0, 120.0]);
    for (center, size) in [
        ([0.0, 3.1, 0.0], [8.4, 0.2, 8.4]),
        ([-4.0, 1.5, 0.0], [0.2, 3.6, 8.4]),
        ([4.0, 1.5, 0.0], [0.2, 3.6, 8.4]),
        ([0.0, 1.5, 4.0], [8.4, 3.6, 0.2]),
        ([-2.4, 1.5, -4.0], [3.6, 3.6, 0.2]),
        ([2.4, 1.5, -4.0], [3.6, 3.6, 0.2]),
        ([0.0, 2.7, -4.0], [2.0, 1.2, 0.2]),
    ] {
        kit.put(3, center, size);
    }
    let leaf = kit.put(5, [0.0, 1.2, -4.3], [2.0, 3.0, 0.1]);
    kit.world.entity_mut(leaf).insert(Leaf);
    kit.heap(150, Vec3::new(-30.0, 0.0, -40.0), Vec3::new(30.0, 2.0, -6.0));
    let mut dice = Dice(11);
    for number in 0..14 {
        let at = Vec3::new(dice.roll() * 44.0 - 22.0, 2.0, dice.roll() * -40.0 + 2.0);
        let range = 3.0 + dice.roll() * 6.0;
        let part = Part { cell: 0, number };
        if number % 2 == 0 {
            let lamp = PointLight {
                intensity: 4e5,
                range,
                shadow_maps_enabled: number % 4 == 0,
                ..default()
            };
            kit.world.spawn((lamp, Transform::from_translation(at), part));
        } else {
            let lamp = SpotLight {
                intensity: 2e6,
                range,
                outer_angle: 0.3 + dice.roll(),
                shadow_maps_enabled: true,
                ..default()
            };
            let to = at + Vec3::new(dice.roll() - 0.5, -1.0, dice.roll() - 0.5);
            kit.world.spawn((lamp, Transform::from_translation(at).looking_at(to, Vec3::X), part));
        }
    }
    kit.camera(Transform::from_xyz(0.0, 1.6, 2.0));
}

/// Walks and turns the camera, moves the lamps and the leaf.
fn step(world: &mut World, number: u32) {
    let mut dice = Dice(u64::from(number) + 100);
    let mut roll = || dice.roll() - 0.5;
    let eye = Vec3::new(roll() * 3.0, 1.6 + roll(), roll() * 4.0 - 1.4);
    let at = Vec3::new(roll() * 4.0, 0.5, -14.0);
    let mut cameras = world.query_filtered::<&mut Transform, With<Camera3d>>();
    cameras
        .iter_mut(world)
        .for_each(|mut c| *c = Transform::from_translation(eye).looking_at(at, Vec3::Y));
    let shift = Vec3::new(roll(), 0.0, roll()) * 6.0;
    let mut lamps = world.query::<(&Part, &mut Transform)>();
    for (part, mut lamp) in lamps.iter_mut(world) {
        if part.number % 3 == number % 3 {
            lamp.translation += shift;
        }
    }
    let open = [0.0, 1.2, 2.0][number as usize % 3];
    let mut leaves = world.query_filtered::<&mut Transform, With<Leaf>>();
    leaves.iter_mut(world).for_each(|mut leaf| leaf.translation.x = open);
}

#[test]
fn lamps_behind_the_walls_of_a_house_are_left_out_and_change_no_picture() {
    if !has_device() {
        return;
    }
    let [without, with] = same(build, step, 0..STEPS, 0.15);
    let out: usize = with.out.0.values().map(BTreeSet::len).sum();
    println!("lamps left out: {out} of {}; views: {}, {}", 14 * STEPS, without.views, with.views);
    // Where the door is shut there is none to be seen, and many where it is open.
    assert!(out > 5 * STEPS as usize && with.views * 3 < without.views, "{out}");
    assert!(with.views > 0);
}
