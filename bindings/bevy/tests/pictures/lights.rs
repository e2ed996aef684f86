//! Lights and their shadows change no picture, wherever lights come and go; what would be wrong is noticed.

use std::any::TypeId;
use std::collections::{BTreeMap, BTreeSet};

use bevy::camera::visibility::{
    CubemapVisibleEntities, ViewVisibility, VisibilitySystems, VisibleEntities, VisibleMeshEntities,
};
use bevy::light::cluster::ClusterVisibilityClass;
use bevy::light::{
    FogVolume, PointLightShadowMap, SimulationLightSystems, VolumetricFog, VolumetricLight,
};
use bevy::prelude::*;
use bevy_cullet::{CulletLight, CulletSystems};

use crate::cells::{self, CELLS, Doomed, Part, STEPS};
use crate::kit::{Dice, Kit};
use crate::picture::{Picture, Studio};
use crate::{has_device, ours};

/// Pixels of every picture.
const SIZE: [u32; 2] = [160, 120];

/// Number of the picture that is taken.
#[derive(Resource, Default, Clone, Copy)]
struct Number(u32);

/// Lamps that are left out, by picture.
#[derive(Resource, Default, Clone)]
pub(crate) struct Out(pub(crate) BTreeMap<u32, BTreeSet<(u32, u32)>>);

fn left_out(world: &mut World) -> BTreeSet<(u32, u32)> {
    let mut lamps = world.query::<(&Part, &CulletLight)>();
    let lamps = lamps.iter(world).filter(|(_, light)| light.is_left_out);
    lamps.map(|(part, _)| (part.cell, part.number)).collect()
}

pub(crate) struct Shots {
    pictures: Vec<Picture>,
    pub(crate) out: Out,
    /// Casters of all maps, and faces without a receiver.
    casters: usize,
    faces_out: u32,
    /// Views that the renderer ran its schedule for.
    pub(crate) views: usize,
}

/// Pictures of the scenes of [`cells`], by their numbers.
fn shoot(pictures: impl Iterator<Item = u32>, plugins: impl FnOnce(&mut App)) -> Shots {
    shoot_with(cells::build, cells::step, pictures, plugins)
}

fn shoot_with(
    build: fn(&mut Kit),
    step: fn(&mut World, u32),
    pictures: impl Iterator<Item = u32>,
    plugins: impl FnOnce(&mut App),
) -> Shots {
    let mut studio = Studio::new(SIZE, |app| {
        app.init_resource::<Number>().init_resource::<Out>();
        plugins(app);
        let doom = |mut commands: Commands, doomed: Query<Entity, With<Doomed>>| {
            doomed.iter().for_each(|entity| commands.entity(entity).despawn());
        };
        let doom = doom
            .after(VisibilitySystems::CheckVisibility)
            .before(SimulationLightSystems::UpdateLightFrusta);
        app.add_systems(PostUpdate, doom);
        build(&mut Kit::new(app.world_mut()));
    });
    studio.settle();
    let mut shots =
        Shots { pictures: Vec::new(), out: Out::default(), casters: 0, faces_out: 0, views: 0 };
    for number in pictures {
        studio.world().insert_resource(Number(number));
        step(studio.world(), number);
        shots.pictures.push(studio.shoot());
        shots.views += studio.lamp_views();
        let world = studio.world();
        shots.out.0.insert(number, left_out(world));
        let mut points = world.query::<(
            &PointLight,
            &ViewVisibility,
            &CubemapVisibleEntities,
            Option<&CulletLight>,
        )>();
        for (light, mark, faces, state) in points.iter(world) {
            if mark.get() && light.shadow_maps_enabled {
                shots.casters += faces.iter().map(|face| face.entities.len()).sum::<usize>();
                shots.faces_out += state.map_or(0, |state| (!state.faces & 0x3f).count_ones());
            }
        }
        let mut spots = world.query::<(&SpotLight, &ViewVisibility, &VisibleMeshEntities)>();
        for (light, mark, list) in spots.iter(world) {
            if mark.get() && light.shadow_maps_enabled {
                shots.casters += list.entities.len();
            }
        }
    }
    shots
}

fn all() -> std::ops::Range<u32> {
    0..CELLS * STEPS
}

/// Compares pictures with the plugin with those of Bevy alone.
pub(crate) fn same(
    build: fn(&mut Kit),
    step: fn(&mut World, u32),
    pictures: std::ops::Range<u32>,
    least: f64,
) -> [Shots; 2] {
    let [without, with] = [
        shoot_with(build, step, pictures.clone(), |_| {}),
        shoot_with(build, step, pictures, ours),
    ];
    let mut of_something = 0;
    for (number, (a, b)) in without.pictures.iter().zip(&with.pictures).enumerate() {
        let colours: BTreeSet<_> = a.pixels.iter().collect();
        of_something += usize::from(colours.len() > 100);
        let differing = a.differing(b);
        if differing > 0 {
            let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR"));
            a.save(&folder.join("without.png"));
            b.save(&folder.join("with.png"));
            panic!(
                "{differing} pixels of picture {number} differ, {:?} out: see {}",
                with.out.0[&(number as u32)],
                folder.display()
            );
        }
    }
    let share = of_something as f64 / without.pictures.len() as f64;
    assert!(share >= least, "{of_something} pictures show something");
    [without, with]
}

#[test]
fn lights_that_come_and_go_change_no_picture() {
    if !has_device() {
        return;
    }
    let [without, with] = same(cells::build, cells::step, all(), 0.9);
    let out: usize = with.out.0.values().map(BTreeSet::len).sum();
    println!(
        "lamps left out: {out}; faces: {}; casters: {} without, {} with; views: {}, {}",
        with.faces_out, without.casters, with.casters, without.views, with.views
    );
    assert!(with.views > 0 && with.views * 2 < without.views);
    assert!(out > 20 && with.faces_out > 50 && with.casters * 10 < without.casters * 9);
}

/// Takes one caster from each list that has some.
fn lose_casters(app: &mut App) {
    ours(app);
    let lose = |mut points: Query<&mut CubemapVisibleEntities>,
                mut spots: Query<&mut VisibleMeshEntities>| {
        for list in points.iter_mut().flat_map(|faces| faces.into_inner().iter_mut()) {
            list.entities.pop();
        }
        spots.iter_mut().for_each(|mut list| {
            list.entities.pop();
        });
    };
    app.add_systems(PostUpdate, lose.after(SimulationLightSystems::CheckLightVisibility));
}

/// Empties one face of each point light's map that something receives a shadow by.
fn lose_face(app: &mut App) {
    ours(app);
    let lose = |mut points: Query<(&mut CubemapVisibleEntities, &CulletLight)>| {
        for (mut faces, state) in &mut points {
            let last = (0..6).filter(|face| state.faces >> face & 1 == 1).next_back();
            if let Some(face) = last {
                faces.get_mut(face).entities.clear();
            }
        }
    };
    app.add_systems(PostUpdate, lose.after(SimulationLightSystems::CheckLightVisibility));
}

/// Leaves out what is left out in the next picture.
fn lose_early(app: &mut App, out: Out) {
    ours(app);
    app.insert_resource(out);
    let lose =
        |number: Res<Number>,
         out: Res<Out>,
         mut views: Query<&mut VisibleEntities>,
         mut lamps: Query<(Entity, &Part, &mut ViewVisibility), With<CulletLight>>| {
            let next = out.0.get(&(number.0 + 1)).cloned().unwrap_or_default();
            for (entity, part, mut mark) in &mut lamps {
                if next.contains(&(part.cell, part.number)) && part.cell == number.0 / STEPS {
                    *mark = ViewVisibility::HIDDEN;
                    for mut view in &mut views {
                        view.get_mut(TypeId::of::<ClusterVisibilityClass>())
                            .retain(|&e| e != entity);
                    }
                }
            }
        };
    let lose = lose.in_set(VisibilitySystems::CheckVisibility).after(CulletSystems::Check);
    app.add_systems(PostUpdate, lose);
}

#[test]
fn a_lost_caster_a_lost_face_and_a_light_that_goes_early_are_noticed() {
    if !has_device() {
        return;
    }
    // The first few scenes are enough, and take a fraction of the time.
    let some = || 0..8 * STEPS;
    let sound = shoot(some(), ours);
    let out = sound.out.clone();
    let mutants: [(&str, Box<dyn FnOnce(&mut App)>); 3] = [
        ("caster", Box::new(lose_casters)),
        ("face", Box::new(lose_face)),
        ("early", Box::new(move |app: &mut App| lose_early(app, out))),
    ];
    for (name, mutant) in mutants {
        let wrong = shoot(some(), mutant);
        let pairs = sound.pictures.iter().zip(&wrong.pictures);
        let pixels: Vec<usize> = pairs.map(|(a, b)| a.differing(b)).collect();
        println!("{name}: {pixels:?}");
        assert!(pixels.iter().any(|&pixels| pixels > 20), "{name}: {pixels:?}");
    }
}

/// Numbers of lamps that make no light, or an endless one, and what else goes wrong with lights: after `step` of them.
fn spoil(world: &mut World, step: u32) {
    let mut lamps =
        world.query::<(Entity, &Part, &mut Transform, AnyOf<(&mut PointLight, &mut SpotLight)>)>();
    let mut lamps: Vec<_> = lamps.iter_mut(world).filter(|(_, part, ..)| part.cell < 4).collect();
    lamps.sort_by_key(|(_, part, ..)| (part.cell, part.number));
    // A number that is not one, or infinite, may make the whole picture black: those come last.
    let numbers = match step {
        0..6 => &[0.0, -3.0, 1e-30, 1e6][..],
        _ => &[f32::INFINITY, f32::NAN, f32::MAX],
    };
    let mut gone = Vec::new();
    for (i, (entity, _, mut at, (point, spot))) in lamps.into_iter().enumerate() {
        let number = numbers[i % numbers.len()];
        let kind = (i / 2 + step as usize) % 9;
        if let Some(mut light) = point {
            match kind {
                0 | 1 => light.range = number,
                2 => light.shadow_depth_bias = number,
                3 => light.shadow_normal_bias = number,
                4 => light.shadow_map_near_z = number.abs(),
                5 => at.translation.x = number,
                6 | 7 => light.shadow_maps_enabled ^= true,
                _ => gone.push(entity),
            }
        } else if let Some(mut light) = spot {
            match kind {
                0 | 1 => light.range = number,
                2 => light.outer_angle = number,
                3 => (light.outer_angle, light.inner_angle) = (0.4, 0.9),
                4 => light.shadow_normal_bias = number,
                5 => at.scale = Vec3::splat(1e-12),
                6 => light.shadow_maps_enabled ^= true,
                7 => light.outer_angle = std::f32::consts::FRAC_PI_2,
                _ => gone.push(entity),
            }
        }
    }
    for entity in gone {
        world.entity_mut(entity).insert(Doomed);
    }
}

#[test]
fn numbers_that_make_no_light_are_as_bevy_has_them() {
    if !has_device() {
        return;
    }
    let step = |world: &mut World, number: u32| {
        cells::look(world, number % 4, number);
        spoil(world, number);
    };
    same(cells::build, step, 0..9, 0.5);
}

/// A thousand lamps over a plain, of which more have shadow maps than every device has room for.
fn crowd(kit: &mut Kit) {
    kit.world.insert_resource(PointLightShadowMap { size: 32 });
    kit.put(7, [0.0, -0.5, 0.0], [200.0, 1.0, 200.0]);
    kit.heap(200, Vec3::new(-40.0, 0.0, -40.0), Vec3::new(40.0, 2.0, 40.0));
    let mut dice = Dice(3);
    for i in 0..1000 {
        let place = Vec3::new(dice.roll() * 80.0 - 40.0, 1.5, dice.roll() * 80.0 - 40.0);
        let range = 1.0 + dice.roll() * 3.0;
        let lamp =
            PointLight { intensity: 5e4, range, shadow_maps_enabled: i % 8 == 0, ..default() };
        kit.world.spawn((lamp, Transform::from_translation(place), Part { cell: 0, number: i }));
    }
    kit.camera(Transform::from_xyz(0.0, 4.0, 30.0).looking_at(Vec3::ZERO, Vec3::Y));
}

#[test]
fn a_thousand_lights_and_none_are_as_bevy_has_them() {
    if !has_device() {
        return;
    }
    let step = |world: &mut World, number: u32| {
        let mut cameras = world.query_filtered::<&mut Transform, With<Camera3d>>();
        cameras.iter_mut(world).for_each(|mut at| at.rotate_y(0.3));
        if number == 3 {
            let mut lamps = world.query_filtered::<Entity, With<PointLight>>();
            for lamp in lamps.iter(world).collect::<Vec<_>>() {
                world.despawn(lamp);
            }
        }
    };
    let [_, with] = same(crowd, step, 0..3, 1.0);
    let out: usize = with.out.0.values().map(BTreeSet::len).sum();
    println!("lamps left out: {out}");
}

/// Something that receives light where no mesh is: a sheet that is lit at a depth behind it, and fog.
fn beside(kit: &mut Kit) {
    kit.world.insert_resource(PointLightShadowMap { size: 64 });
    let leaf =
        kit.material(StandardMaterial { diffuse_transmission: 1.0, thickness: 60.0, ..default() });
    let sheet = kit.put(1, [3.0, 0.0, -10.0], [3.0, 3.0, 0.1]);
    kit.world.entity_mut(sheet).insert(MeshMaterial3d(leaf.clone()));
    kit.world.insert_resource(Leaf(leaf));
    let lamp = PointLight { intensity: 3e5, range: 6.5, shadow_maps_enabled: true, ..default() };
    kit.world.spawn((lamp, Transform::from_xyz(3.0, 0.0, -17.0), Part { cell: 0, number: 0 }));
    // The lamp that reaches farthest stays: this one.
    let beyond = PointLight { range: 5.0, ..default() };
    kit.world.spawn((beyond, Transform::from_xyz(3.0, 0.0, -90.0), Part { cell: 0, number: 2 }));
    let shines = SpotLight {
        intensity: 1e7,
        range: 5.0,
        outer_angle: 0.5,
        shadow_maps_enabled: true,
        ..default()
    };
    let at = Transform::from_xyz(-3.0, 2.5, -8.0).looking_at(Vec3::new(-3.0, -3.0, -8.1), Vec3::Y);
    kit.world.spawn((shines, VolumetricLight, at, Part { cell: 0, number: 1 }));
    let volume = FogVolume { density_factor: 0.3, ..default() };
    kit.world.spawn((volume, Transform::from_xyz(-3.0, 0.0, -8.0).with_scale(Vec3::splat(6.0))));
    let camera = kit.camera(Transform::default());
    kit.world.entity_mut(camera).insert(VolumetricFog { ambient_intensity: 0.0, ..default() });
}

#[derive(Resource)]
struct Leaf(Handle<StandardMaterial>);

#[test]
fn lamps_are_drawn_while_fog_or_a_deep_sheet_may_be_lit_by_them() {
    if !has_device() {
        return;
    }
    let step = |world: &mut World, number: u32| {
        let leaf = world.resource::<Leaf>().0.clone();
        let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
        materials.get_mut(&leaf).expect("of the sheet").thickness =
            if number == 1 { 0.0 } else { 60.0 };
        let shows = if number == 1 { Visibility::Hidden } else { Visibility::Inherited };
        let mut fogs = world.query_filtered::<&mut Visibility, With<FogVolume>>();
        fogs.iter_mut(world).for_each(|mut fog| *fog = shows);
    };
    let [_, with] = same(beside, step, 0..3, 0.0);
    // Of the two the one that only a mesh could be lit by, and none where there is fog.
    let lamp_alone = BTreeSet::from([(0, 0)]);
    assert_eq!(
        with.out.0,
        BTreeMap::from([(0, BTreeSet::new()), (1, lamp_alone), (2, BTreeSet::new())])
    );
}
