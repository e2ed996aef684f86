//! The plugin lists the casters that Bevy's own systems list, or less where nothing is drawn that they could shade.
mod common;

use std::collections::BTreeSet;

use bevy::camera::primitives::{Aabb, CascadesFrusta, CubemapFrusta, Frustum, Sphere};
use bevy::camera::visibility::{
    CascadesVisibleEntities, CubemapVisibleEntities, NoAutoAabb, NoCpuCulling, NoFrustumCulling,
    RenderLayers, ViewVisibility, VisibilityRange, VisibleMeshEntities,
};
use bevy::light::{
    CascadeShadowConfigBuilder, DirectionalLightShadowMap, LightPlugin, NotShadowCaster,
    PointLightShadowMap,
};
use bevy::math::Vec3A;
use bevy::prelude::*;
use bevy_cullet::{CulletLight, CulletLights};
use common::{Headless, Random};

/// An app with lights, and everything that throws shadows.
fn app(with_plugin: bool, receivers: bool, seed: u64) -> (Headless, Vec<Entity>) {
    let mut app = if with_plugin { Headless::with_plugin() } else { Headless::without_plugin() };
    app.app.add_plugins((bevy::time::TimePlugin, bevy::gizmos::GizmoPlugin, LightPlugin));
    app.app.insert_resource(CulletLights { receivers });
    app.app.init_resource::<Heard>();
    app.app.add_systems(
        Last,
        |marks: Query<Entity, Changed<ViewVisibility>>, mut heard: ResMut<Heard>| {
            heard.0 = marks.iter().collect();
        },
    );
    let all = spawn(app.world(), seed);
    (app, all)
}

/// Entities whose marks changed in the last frame.
#[derive(Resource, Default)]
struct Heard(BTreeSet<Entity>);

/// Puts the same things into each app for the same seed: lights first, then meshes, then cameras.
fn spawn(world: &mut World, seed: u64) -> Vec<Entity> {
    let mut random = Random(seed);
    let mut all = Vec::new();
    for i in 0..12 {
        let at =
            Transform { translation: random.vec(20.0), rotation: turn(&mut random), ..default() };
        let range = 2.0 + random.unit() * 20.0;
        let mut light = match i % 3 {
            0 => world.spawn((PointLight { range, shadow_maps_enabled: true, ..default() }, at)),
            1 => {
                let outer_angle = 0.2 + random.unit();
                world.spawn((
                    SpotLight { range, outer_angle, shadow_maps_enabled: true, ..default() },
                    at,
                ))
            }
            _ => {
                let cascades = CascadeShadowConfigBuilder { num_cascades: 1 + i / 3, ..default() };
                let sun = DirectionalLight { shadow_maps_enabled: true, ..default() };
                world.spawn((sun, cascades.build(), at))
            }
        };
        match (random.unit() * 8.0) as u32 {
            0 => drop(light.insert(RenderLayers::from_layers(&[1, 40]))),
            1 => drop(light.insert(RenderLayers::from_layers(&[0, 33]))),
            _ => {}
        }
        all.push(light.id());
    }
    for _ in 0..250 {
        let at =
            Transform { translation: random.vec(30.0), rotation: turn(&mut random), ..default() };
        let aabb = Aabb {
            center: Vec3A::from(random.vec(0.5)),
            half_extents: Vec3A::from(random.vec(2.0).abs()),
        };
        let mut mesh = world.spawn((Mesh3d::default(), NoAutoAabb, at));
        if !random.one_in(16) {
            mesh.insert(aabb);
        } else if random.one_in(2) {
            mesh.insert(Sphere { center: at.translation.into(), radius: 1.0 });
        }
        all.push(mesh.id());
        change(world, *all.last().expect("one"), &mut random, 24);
    }
    for _ in 0..2 {
        let at =
            Transform { translation: random.vec(15.0), rotation: turn(&mut random), ..default() };
        all.push(world.spawn((Camera3d::default(), at)).id());
    }
    all
}

fn turn(random: &mut Random) -> Quat {
    Quat::from_euler(EulerRot::XYZ, random.within(3.0), random.within(3.0), random.within(3.0))
}

/// Does to a mesh what may be done to one, in one of `n` cases something.
fn change(world: &mut World, entity: Entity, random: &mut Random, n: u32) {
    let Ok(mut mesh) = world.get_entity_mut(entity) else { return };
    match (random.unit() * n as f32) as u32 {
        0 => drop(mesh.insert(NotShadowCaster)),
        1 => drop(mesh.remove::<NotShadowCaster>()),
        2 => drop(mesh.insert(RenderLayers::from_layers(&[1]))),
        3 => drop(mesh.insert(RenderLayers::from_layers(&[0, 40]))),
        4 => drop(mesh.insert(RenderLayers::from_layers(&[33]))),
        5 => drop(mesh.insert(NoFrustumCulling)),
        6 => drop(mesh.insert(VisibilityRange::abrupt(5.0, 25.0))),
        7 => drop(mesh.insert(Visibility::Hidden)),
        8 => drop(mesh.insert(Visibility::Inherited)),
        9 => drop(mesh.insert(NoCpuCulling)),
        10 => drop(mesh.remove::<(NoCpuCulling, NoFrustumCulling)>()),
        11 => mesh.get_mut::<Transform>().expect("placed").translation += Vec3::new(1.0, -2.0, 3.0),
        12 => drop(mesh.remove::<Aabb>()),
        13 => mesh.despawn(),
        _ => {}
    }
}

/// Changes some of everything.
fn play(world: &mut World, all: &[Entity], random: &mut Random) {
    for &entity in all {
        let Ok(mut of) = world.get_entity_mut(entity) else { continue };
        if of.contains::<Mesh3d>() {
            change(world, entity, random, 60);
            continue;
        }
        let is_moved = random.one_in(3);
        let (shift, turned) = (random.vec(4.0), turn(random));
        let switches = random.one_in(6);
        if let (true, Some(mut at)) = (is_moved, of.get_mut::<Transform>()) {
            at.translation += shift;
            at.rotation = turned;
        }
        if switches {
            if let Some(mut light) = of.get_mut::<PointLight>() {
                light.shadow_maps_enabled ^= true;
            } else if let Some(mut light) = of.get_mut::<DirectionalLight>() {
                light.shadow_maps_enabled ^= true;
            } else if of.contains::<SpotLight>() {
                of.insert(Visibility::Hidden);
            }
        }
    }
}

/// The lists of all maps of a light that is drawn, by places in `all`; `None` where it is not.
fn lists(app: &Headless, all: &[Entity], light: Entity) -> Option<Vec<(Frustum, BTreeSet<usize>)>> {
    let world = app.app.world();
    let of = world.get_entity(light).ok()?;
    if !of.get::<ViewVisibility>()?.get() {
        return None;
    }
    let places = |list: &VisibleMeshEntities| -> BTreeSet<usize> {
        assert!(list.entities.is_sorted());
        let place = |e: &Entity| all.iter().position(|own| own == e).expect("one of ours");
        list.entities.iter().map(place).collect()
    };
    let mut found = Vec::new();
    if of.get::<PointLight>().is_some_and(|light| light.shadow_maps_enabled) {
        let (frusta, lists) = (of.get::<CubemapFrusta>()?, of.get::<CubemapVisibleEntities>()?);
        found.extend(frusta.iter().copied().zip(lists.iter().map(places)));
    } else if of.get::<SpotLight>().is_some_and(|light| light.shadow_maps_enabled) {
        found.push((*of.get::<Frustum>()?, places(of.get::<VisibleMeshEntities>()?)));
    } else if of.get::<DirectionalLight>().is_some_and(|light| light.shadow_maps_enabled) {
        let (frusta, lists) = (of.get::<CascadesFrusta>()?, of.get::<CascadesVisibleEntities>()?);
        for &camera in &all[all.len() - 2..] {
            let (Some(frusta), Some(lists)) =
                (frusta.frusta.get(&camera), lists.entities.get(&camera))
            else {
                continue;
            };
            assert_eq!(frusta.len(), lists.len());
            found.extend(frusta.iter().copied().zip(lists.iter().map(places)));
        }
    }
    Some(found)
}

/// Whether f32 cannot tell an entity from one of the half-spaces or from the light's reach.
fn is_doubtful(app: &Headless, frustum: &Frustum, light: Entity, entity: Entity) -> bool {
    let world = app.app.world();
    let Some(aabb) = world.get::<Aabb>(entity) else { return false };
    let at = world.get::<GlobalTransform>(entity).expect("placed").affine();
    let grown = |by: f32| {
        let aabb =
            Aabb { half_extents: aabb.half_extents * (1.0 + by) + Vec3A::splat(by), ..*aabb };
        let center = world.get::<GlobalTransform>(light).expect("placed").translation_vec3a();
        let range = world.get::<PointLight>(light).map(|light| light.range);
        let range = range.or_else(|| world.get::<SpotLight>(light).map(|light| light.range));
        let is_sun = range.is_none();
        range.is_none_or(|radius| Sphere { center, radius: radius + by }.intersects_obb(&aabb, &at))
            && frustum.intersects_obb(&aabb, &at, !is_sun, true)
    };
    grown(1e-4) && !grown(-1e-4)
}

#[test]
fn the_same_casters_as_bevy_in_random_scenes_that_change() {
    let (mut compared, mut marked) = (0, 0);
    for seed in 1..60 {
        let mut apps = [app(false, false, seed), app(true, false, seed)];
        for frame in 0..5 {
            for (app, _) in &mut apps {
                app.frames(1);
            }
            let [(bevy, all), (ours, own)] = &apps;
            let mut doubtful = BTreeSet::new();
            for place in 0..12 {
                let theirs = lists(bevy, all, all[place]);
                let found = lists(ours, own, own[place]);
                assert_eq!(
                    theirs.is_some(),
                    found.is_some(),
                    "seed {seed} frame {frame} light {place}"
                );
                let (Some(theirs), Some(found)) = (theirs, found) else { continue };
                assert_eq!(theirs.len(), found.len(), "seed {seed} frame {frame} light {place}");
                for (number, ((frustum, theirs), (_, found))) in
                    theirs.iter().zip(&found).enumerate()
                {
                    compared += theirs.len();
                    for &caster in theirs.symmetric_difference(found) {
                        doubtful.insert(caster);
                        assert!(
                            is_doubtful(bevy, frustum, all[place], all[caster]),
                            "seed {seed} frame {frame} light {place} map {number} caster {caster}: {}",
                            theirs.contains(&caster)
                        );
                    }
                }
            }
            for place in (0..all.len()).filter(|place| !doubtful.contains(place)) {
                let mark = |app: &Headless, entity: Entity| {
                    let is_heard = app.app.world().resource::<Heard>().0.contains(&entity);
                    Some((app.app.world().get::<ViewVisibility>(entity)?.get(), is_heard))
                };
                let [theirs, found] = [mark(bevy, all[place]), mark(ours, own[place])];
                assert_eq!(theirs, found, "seed {seed} frame {frame}: marks of {place}");
                marked += usize::from(theirs.is_some_and(|mark| mark.1));
            }
            for (app, all) in &mut apps {
                play(app.world(), all, &mut Random(seed * 1000 + frame));
            }
        }
    }
    println!("{compared} casters, {marked} marks that changed");
    assert!(compared > 100_000 && marked > 3_000, "{compared} {marked}");
}

/// Effect of a lamp of this range at a place, in a room with a floor that the camera sees a part of.
fn left_out(at: Vec3, more: impl Fn(&mut Headless, Entity)) -> bool {
    let mut app = Headless::with_plugin();
    app.app.add_plugins((bevy::time::TimePlugin, bevy::gizmos::GizmoPlugin, LightPlugin));
    app.app.insert_resource(PointLightShadowMap { size: 256 });
    app.app.insert_resource(DirectionalLightShadowMap { size: 256 });
    app.camera();
    common::cube(&mut app, [0.0, 0.0, -10.0]);
    let lamp = PointLight { range: 5.0, shadow_maps_enabled: true, ..default() };
    let lamp = app.world().spawn((lamp, Transform::from_translation(at))).id();
    // The lamp that reaches farthest stays: this one.
    let beyond = PointLight { range: 5.0, ..default() };
    app.world().spawn((beyond, Transform::from_xyz(0.0, 0.0, -300.0)));
    more(&mut app, lamp);
    app.frames(2);
    let is_left_out = app.world().get::<CulletLight>(lamp).expect("of a light").is_left_out;
    let is_visible = app.world().get::<ViewVisibility>(lamp).expect("of a light").get();
    assert!(!(is_left_out && is_visible));
    is_left_out
}

#[test]
fn a_light_is_left_out_only_where_it_is_known_to_reach_nothing() {
    let near = Vec3::new(0.0, 2.0, -10.0);
    let far = Vec3::new(0.0, 0.0, -30.0);
    assert!(!left_out(near, |_, _| {}));
    assert!(left_out(far, |_, _| {}));
    assert!(!left_out(Vec3::new(0.0, 0.0, -310.0), |_, _| {}), "none reaches farther");
    // What may be lit anywhere.
    assert!(!left_out(far, |app, _| {
        let cube = common::cube(app, [3.0, 0.0, -10.0]);
        app.world().entity_mut(cube).insert(NoFrustumCulling);
    }));
    assert!(!left_out(far, |app, _| {
        let cube = common::cube(app, [3.0, 0.0, -10.0]);
        app.world().entity_mut(cube).insert(NoCpuCulling);
    }));
    assert!(!left_out(far, |app, lamp| {
        app.world().entity_mut(lamp).insert(bevy::light::VolumetricLight);
    }));
    assert!(!left_out(far, |app, lamp| {
        app.world().entity_mut(lamp).insert(bevy_cullet::NoCulletLight);
    }));
    assert!(!left_out(far, |app, _| {
        let mut cameras = app.world().query_filtered::<Entity, With<Camera3d>>();
        let camera = cameras.single(app.world()).expect("one camera");
        app.world().entity_mut(camera).insert(bevy::core_pipeline::prepass::DeferredPrepass);
    }));
    assert!(!left_out(far, |app, _| {
        app.world().resource_mut::<CulletLights>().receivers = false;
    }));
    assert!(!left_out(far, |app, lamp| {
        app.world().get_mut::<PointLight>(lamp).expect("a lamp").range = 30.0;
    }));
    for range in [f32::INFINITY, f32::NAN, 0.0, -1.0] {
        // A light without a reach is none of Bevy's cameras', or as Bevy says.
        assert!(!left_out(far, |app, lamp| {
            app.world().get_mut::<PointLight>(lamp).expect("a lamp").range = range;
        }));
    }
}
