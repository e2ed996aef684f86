//! The plugin lists what Bevy's own check lists, or less where that is right.
mod common;

use std::any::TypeId;

use bevy::camera::primitives::{Aabb, Frustum, Sphere};
use bevy::camera::visibility::{
    InheritedVisibility, NoAutoAabb, NoCpuCulling, NoFrustumCulling, RenderLayers,
    SetViewVisibility, ViewVisibility, VisibilityRange, VisibilitySystems, VisibleEntities,
};
use bevy::ecs::entity::EntityHashSet;
use bevy::math::{Affine3A, DVec3, Vec3A};
use bevy::prelude::*;
use common::{Headless, Random, cube, solid};

fn transform(random: &mut Random, size: f32) -> Transform {
    let turned =
        Quat::from_euler(EulerRot::XYZ, random.within(3.0), random.within(3.0), random.within(3.0));
    let scale = Vec3::new(0.2 + random.unit(), 0.2 + random.unit(), 0.2 + random.unit());
    let mirrored = if random.one_in(8) { Vec3::new(-1.0, 1.0, 1.0) } else { Vec3::ONE };
    Transform { translation: random.vec(size), rotation: turned, scale: scale * mirrored }
}

/// Puts the same entities into an app for the same seed: ids are the same in both.
fn spawn(world: &mut World, seed: u64) -> (Vec<Entity>, Vec<Entity>) {
    let mut random = Random(seed);
    let size = 10.0 + random.unit() * 90.0;
    let mut cameras = Vec::new();
    for i in 0..3 {
        let projection = match i {
            2 => Projection::Orthographic(OrthographicProjection {
                scale: 0.05 + random.unit() * 0.1,
                ..OrthographicProjection::default_3d()
            }),
            _ => Projection::Perspective(PerspectiveProjection {
                fov: 0.3 + random.unit(),
                ..default()
            }),
        };
        let mut at = transform(&mut random, size * 0.3);
        at.scale = Vec3::ONE;
        let mut camera = world.spawn((Camera3d::default(), projection, at));
        if random.one_in(2) {
            camera.insert(RenderLayers::from_layers(&[random.unit() as usize, 1, 40]));
        }
        if random.one_in(8) {
            camera.insert(NoCpuCulling);
        }
        camera.get_mut::<Camera>().expect("a camera").is_active = !random.one_in(8);
        cameras.push(camera.id());
    }
    let entities: Vec<Entity> = (0..300)
        .map(|_| {
            let at = transform(&mut random, size);
            let half_extents = Vec3A::from(random.vec(2.0).abs());
            let aabb = Aabb { center: Vec3A::from(random.vec(1.0)), half_extents };
            let mut entity = world.spawn((Mesh3d::default(), NoAutoAabb, at));
            if !random.one_in(20) {
                entity.insert(aabb);
            } else if random.one_in(2) {
                entity
                    .insert(Sphere { center: at.translation.into(), radius: random.unit() * 3.0 });
            }
            match (random.unit() * 20.0) as u32 {
                0 => drop(entity.insert(NoFrustumCulling)),
                1 => drop(entity.insert(NoCpuCulling)),
                2 => drop(entity.insert(Visibility::Hidden)),
                3 => drop(entity.insert(RenderLayers::layer(1))),
                4 => drop(entity.insert(RenderLayers::layer(40))),
                5 => drop(entity.insert(RenderLayers::none())),
                6 | 7 => drop(entity.insert(VisibilityRange::abrupt(size * 0.2, size * 0.8))),
                8 => drop(entity.insert(RenderLayers::layer(33))),
                _ => {}
            }
            entity.id()
        })
        .collect();
    let lights =
        (0..10).map(|_| world.spawn((PointLight::default(), transform(&mut random, size))).id());
    lights.for_each(drop);
    for child in 0..20 {
        let (parent, child) = (entities[child], entities[100 + child]);
        world.entity_mut(parent).add_child(child);
    }
    (cameras, entities)
}

/// Changes things as a game does.
fn play(world: &mut World, entities: &[Entity], random: &mut Random) {
    for &entity in entities {
        let Ok(mut entity) = world.get_entity_mut(entity) else { continue };
        match (random.unit() * 60.0) as u32 {
            0..6 => entity.get_mut::<Transform>().expect("placed").translation += random.vec(5.0),
            6 => drop(entity.insert(Visibility::Hidden)),
            7 => drop(entity.insert(Visibility::Inherited)),
            8 => drop(entity.remove::<Aabb>()),
            9 => {
                let half_extents = Vec3A::splat(random.unit());
                entity.insert(Aabb { center: Vec3A::ZERO, half_extents });
            }
            10 => drop(entity.insert(NoFrustumCulling)),
            11 => drop(entity.remove::<NoFrustumCulling>()),
            12 => drop(entity.insert(NoCpuCulling)),
            13 => drop(entity.remove::<NoCpuCulling>()),
            14 => drop(entity.remove::<RenderLayers>()),
            15 => drop(entity.insert(RenderLayers::layer(random.one_in(2).into()))),
            16 => drop(entity.remove::<VisibilityRange>()),
            17 => drop(entity.remove::<Mesh3d>()),
            18 => drop(entity.insert(Mesh3d::default())),
            19 if random.one_in(3) => entity.despawn(),
            20 => drop(entity.insert(ViewVisibility::HIDDEN)),
            21 => drop(entity.remove::<ViewVisibility>()),
            22 => drop(entity.insert(ViewVisibility::VISIBLE)),
            23 => drop(entity.insert(Visibility::Visible)),
            24 => drop(entity.remove::<ChildOf>()),
            25 => {
                entity.remove::<ViewVisibility>();
                entity.insert(ViewVisibility::HIDDEN);
            }
            _ => {}
        }
    }
}

/// Returns the distance by which a box is inside (or outside, below zero) of the half-space that it
/// is farthest from, relative to the sizes.
fn margin(frustum: &Frustum, aabb: &Aabb, at: &Affine3A) -> f64 {
    let m = at.matrix3.as_dmat3();
    let center = m * aabb.center.as_dvec3() + at.translation.as_dvec3();
    let of = |plane: &[f32; 4]| {
        let [x, y, z, d] = plane.map(f64::from);
        let n = DVec3::new(x, y, z);
        let radius = (m.transpose() * n).abs().dot(aabb.half_extents.as_dvec3());
        (n.dot(center) + d + radius) / (center.length() + d.abs() + radius)
    };
    frustum.half_spaces[..5]
        .iter()
        .map(|plane| of(&plane.normal_d().to_array()))
        .fold(f64::INFINITY, f64::min)
}

/// Marks that systems other than cameras set, and the changes that are noticed.
#[derive(Resource, Default)]
struct Ear {
    casters: Vec<Entity>,
    marks: EntityHashSet,
    inherited: EntityHashSet,
}

fn listen(app: &mut Headless) {
    app.app.init_resource::<Ear>();
    // Without those that the GPU culls: Bevy sets their marks in a system of no known order to this.
    type Marks<'w, 's> = Query<'w, 's, &'static mut ViewVisibility, Without<NoCpuCulling>>;
    let cast = |ear: Res<Ear>, mut marks: Marks| {
        for &caster in ear.casters.iter().take(20) {
            if let Ok(mut mark) = marks.get_mut(caster) {
                mark.set_visible();
            }
        }
    };
    // Wherever in the frame: as custom checks, and as the shadows of lights.
    app.app.add_systems(PostUpdate, cast.in_set(VisibilitySystems::CheckVisibility));
    let late = |ear: Res<Ear>, mut marks: Marks| {
        for &caster in ear.casters.iter().rev().take(10) {
            if let Ok(mut mark) = marks.get_mut(caster) {
                mark.set_visible();
            }
        }
    };
    app.app.add_systems(
        PostUpdate,
        late.after(VisibilitySystems::CheckVisibility)
            .before(VisibilitySystems::MarkNewlyHiddenEntitiesInvisible),
    );
    app.app.add_systems(
        Last,
        |marks: Query<Entity, Changed<ViewVisibility>>,
         inherited: Query<Entity, Changed<InheritedVisibility>>,
         mut ear: ResMut<Ear>| {
            ear.marks = marks.iter().collect();
            ear.inherited = inherited.iter().collect();
        },
    );
}

/// Returns what Bevy and the plugin say of an entity's marks.
fn marks(app: &Headless, entity: Entity) -> Option<[bool; 4]> {
    let world = app.app.world();
    let ear = world.resource::<Ear>();
    let mark = world.get::<ViewVisibility>(entity)?.get();
    let inherited = world.get::<InheritedVisibility>(entity)?.get();
    let heard = [&ear.marks, &ear.inherited].map(|set| set.contains(&entity));
    Some([mark, inherited, heard[0], heard[1]])
}

#[test]
fn the_same_entities_as_bevy_in_random_scenes_that_change() {
    let (mut compared, mut marked) = (0, 0);
    for seed in 1..150 {
        let mut apps = [Headless::without_plugin(), Headless::with_plugin()];
        let spawned = apps.each_mut().map(|app| spawn(app.world(), seed));
        apps.iter_mut().for_each(listen);
        let mut differed = Vec::new();
        let (cameras, entities) = &spawned[0];
        // Ids differ, for resources are entities too: entities are compared by their place.
        let places = |app: &Headless, which: usize, camera: usize| -> Vec<usize> {
            let (cameras, entities) = &spawned[which];
            let seen = app.seen(cameras[camera]);
            assert!(seen.is_sorted());
            let of = |e: &Entity| entities.iter().position(|own| own == e).expect("one of ours");
            seen.iter().map(of).collect()
        };
        for frame in 0..6 {
            for app in &mut apps {
                app.frames(1);
            }
            let [bevy, ours] = &apps;
            let before = std::mem::take(&mut differed);
            for (number, &camera) in cameras.iter().enumerate() {
                let frustum = bevy.app.world().get::<Frustum>(camera).expect("a camera");
                let (theirs, own) = (places(bevy, 0, number), places(ours, 1, number));
                compared += theirs.len();
                let differ = theirs
                    .iter()
                    .filter(|e| !own.contains(e))
                    .chain(own.iter().filter(|e| !theirs.contains(e)));
                for &place in differ {
                    differed.push(place);
                    let entity = entities[place];
                    let of = bevy.app.world().entity(entity);
                    let margin = margin(
                        frustum,
                        of.get::<Aabb>()
                            .unwrap_or_else(|| panic!("seed {seed}, {entity} in one list only")),
                        &of.get::<GlobalTransform>().expect("placed").affine(),
                    );
                    // Only where f32 cannot tell, or where Bevy's ball of a sheared box is too small.
                    let sheared = of.contains::<ChildOf>() && own.contains(&place) && margin > 0.0;
                    assert!(
                        margin.abs() < 1e-5 || sheared,
                        "seed {seed} frame {frame} {entity}: {margin}"
                    );
                }
                let lights = |app: &Headless, camera: Entity| {
                    let visible = app.app.world().get::<VisibleEntities>(camera).expect("a camera");
                    let others = visible
                        .entities
                        .iter()
                        .filter(|(class, _)| **class != TypeId::of::<Mesh3d>());
                    others.map(|(_, list)| list.len()).sum::<usize>()
                };
                assert_eq!(lights(bevy, camera), lights(ours, spawned[1].0[number]));
            }
            for place in
                (0..entities.len()).filter(|p| !differed.contains(p) && !before.contains(p))
            {
                let [theirs, own] =
                    [(bevy, 0), (ours, 1)].map(|(app, which)| marks(app, spawned[which].1[place]));
                assert_eq!(theirs, own, "seed {seed} frame {frame}: marks of {place}");
                marked += usize::from(theirs.is_some_and(|of| of[2]));
            }
            for (app, (_, entities)) in apps.iter_mut().zip(&spawned) {
                let mut random = Random(seed * 1000 + frame);
                play(app.world(), entities, &mut random);
                let casters = entities.iter().copied().filter(|_| random.one_in(10)).collect();
                app.world().resource_mut::<Ear>().casters = casters;
            }
        }
    }
    assert!(compared > 40_000, "{compared}");
    assert!(marked > 10_000, "{marked}");
}

#[test]
fn view_visibility_changes_with_what_is_seen_and_not_else() {
    #[derive(Resource, Default)]
    struct Changes(Vec<usize>);
    let mut app = Headless::with_plugin();
    app.app.init_resource::<Changes>();
    app.app.add_systems(
        Last,
        |all: Query<(), (Changed<ViewVisibility>, With<Mesh3d>)>, mut changes: ResMut<Changes>| {
            changes.0.push(all.iter().count());
        },
    );
    app.camera();
    let seen = cube(&mut app, [0.0, 0.0, -5.0]);
    let behind = cube(&mut app, [0.0, 0.0, 5.0]);
    app.frames(4);
    assert!(app.world().get::<ViewVisibility>(seen).unwrap().get());
    assert!(!app.world().get::<ViewVisibility>(behind).unwrap().get());
    assert_eq!(app.world().resource::<Changes>().0[1..], [0, 0, 0]);
    app.world().get_mut::<Transform>(seen).unwrap().translation.z = 5.0;
    app.frames(2);
    assert!(!app.world().get::<ViewVisibility>(seen).unwrap().get());
    assert_eq!(app.world().resource::<Changes>().0[4..], [1, 0]);
}

#[test]
fn a_transform_that_is_not_finite_is_kept_as_bevy_keeps_it() {
    let mut app = Headless::with_plugin();
    let camera = app.camera();
    let nan = cube(&mut app, [f32::NAN, 0.0, 5.0]);
    let far = cube(&mut app, [0.0, f32::INFINITY, 5.0]);
    let seen = cube(&mut app, [0.0, 0.0, -5.0]);
    app.frames(2);
    let list = app.seen(camera);
    assert!(list.contains(&nan) && list.contains(&far) && list.contains(&seen), "{list:?}");
}

#[test]
fn entities_that_went_while_listed_are_listed_no_more() {
    let mut app = Headless::with_plugin();
    let camera = app.camera();
    let all: Vec<_> = (0..200).map(|i| cube(&mut app, [0.0, 0.0, -2.0 - i as f32])).collect();
    app.frames(1);
    assert_eq!(app.seen(camera).len(), 200);
    all[50..].iter().for_each(|&entity| assert!(app.world().despawn(entity)));
    app.frames(1);
    assert_eq!(app.seen(camera).len(), 50);
    // Their indices are used again.
    let again: Vec<_> = (0..100).map(|_| cube(&mut app, [0.0, 0.0, 5.0])).collect();
    app.frames(1);
    assert_eq!(app.seen(camera).len(), 50);
    assert!(again.iter().all(|entity| !app.seen(camera).contains(entity)));
}

#[test]
fn a_frustum_of_the_users_own_decides() {
    let mut app = Headless::with_plugin();
    let camera = app.camera();
    let before = cube(&mut app, [0.0, 0.0, -5.0]);
    let behind = cube(&mut app, [0.0, 0.0, 5.0]);
    app.frames(2);
    assert_eq!(app.seen(camera), [before]);
    let at = GlobalTransform::from(Transform::from_xyz(0.0, 0.0, 0.0).looking_to(Vec3::Z, Vec3::Y));
    let turned = Projection::default().compute_frustum(&at);
    *app.world().get_mut::<Frustum>(camera).unwrap() = turned;
    app.frames(1);
    assert_eq!(app.seen(camera), [behind]);
}

#[test]
fn many_at_once_and_moving_ones_are_sorted_and_stay_right() {
    let mut app = Headless::with_plugin();
    let camera = app.camera();
    let side = 20;
    let all: Vec<_> = (0..side * side * side)
        .map(|i| {
            let at = |k: i32| (k % side) as f32 * 4.0 - 40.0;
            let place = Vec3::new(at(i), at(i / side), at(i / side / side));
            app.world().spawn((Transform::from_translation(place), solid([0.5; 3]))).id()
        })
        .collect();
    for _ in 0..8 {
        app.frames(1);
        let frustum = *app.app.world().get::<Frustum>(camera).unwrap();
        let mut expected: Vec<_> = all
            .iter()
            .copied()
            .filter(|&e| {
                let world = app.app.world();
                let at = world.get::<GlobalTransform>(e).unwrap().affine();
                frustum.intersects_obb(world.get::<Aabb>(e).unwrap(), &at, true, false)
            })
            .collect();
        expected.sort_unstable();
        assert_eq!(app.seen(camera), expected);
        for &entity in all.iter().step_by(5) {
            app.world().get_mut::<Transform>(entity).unwrap().translation.y += 1.37;
        }
    }
}
