//! Plugins that lose what they must not: each is noticed, or the pictures would prove nothing.

use std::any::TypeId;

use bevy::camera::visibility::{
    CascadesVisibleEntities, CubemapVisibleEntities, VisibilitySystems, VisibleEntities,
    VisibleMeshEntities,
};
use bevy::light::SimulationLightSystems;
use bevy::prelude::*;

use crate::kit::{CasterProbe, Probe};
use crate::{Scene, deformed, has_device, moving, ours, scenes, shoot};

/// Takes the probe from the lists of the cameras.
fn lose_mesh(app: &mut App) {
    ours(app);
    let lose = |mut views: Query<&mut VisibleEntities>, probes: Query<(), With<Probe>>| {
        for mut view in &mut views {
            view.get_mut(TypeId::of::<Mesh3d>()).retain(|&e| !probes.contains(e));
        }
    };
    let lose = lose
        .after(VisibilitySystems::CheckVisibility)
        .before(VisibilitySystems::MarkNewlyHiddenEntitiesInvisible);
    app.add_systems(PostUpdate, lose);
}

/// Takes the caster from the lists of the lights.
fn lose_caster(app: &mut App) {
    ours(app);
    let lose = |mut points: Query<&mut CubemapVisibleEntities>,
                mut spots: Query<&mut VisibleMeshEntities>,
                mut suns: Query<&mut CascadesVisibleEntities>,
                probes: Query<(), With<CasterProbe>>| {
        let keep = |list: &mut VisibleMeshEntities| list.entities.retain(|&e| !probes.contains(e));
        points.iter_mut().for_each(|mut faces| faces.iter_mut().for_each(keep));
        spots.iter_mut().for_each(|mut list| keep(&mut list));
        for mut views in &mut suns {
            views.entities.values_mut().flatten().for_each(keep);
        }
    };
    app.add_systems(PostUpdate, lose.after(SimulationLightSystems::CheckLightVisibility));
}

/// Lists what the first frame with anything listed did, for ever: changes are not seen.
fn see_no_change(app: &mut App) {
    ours(app);
    let keep = |mut views: Query<&mut VisibleEntities>, mut first: Local<Vec<Entity>>| {
        for mut view in &mut views {
            let list = view.get_mut(TypeId::of::<Mesh3d>());
            if first.is_empty() {
                first.clone_from(list);
            }
            list.clone_from(&first);
        }
    };
    let keep = keep
        .after(VisibilitySystems::CheckVisibility)
        .before(VisibilitySystems::MarkNewlyHiddenEntitiesInvisible);
    app.add_systems(PostUpdate, keep);
}

/// Pixels in which the last pictures differ.
fn noticed(scene: Scene, mutant: fn(&mut App)) -> usize {
    let [sound, mutant] = [shoot(scene, ours), shoot(scene, mutant)];
    sound.pictures.last().unwrap().differing(mutant.pictures.last().unwrap())
}

#[test]
fn a_lost_mesh_is_noticed_in_every_scene() {
    if !has_device() {
        return;
    }
    let still = [
        scenes::plain,
        scenes::sun,
        scenes::lamps,
        scenes::layers,
        scenes::orthographic,
        scenes::ranges,
        scenes::transparent,
        scenes::odd,
        scenes::city,
        moving::build,
    ];
    let deformed = Scene { build: deformed::build, step: deformed::step, steps: 2 };
    for (i, scene) in [deformed].into_iter().chain(still.into_iter().map(Scene::still)).enumerate()
    {
        let differing = noticed(scene, lose_mesh);
        println!("scene {i}: {differing} pixels");
        assert!(differing > 20, "scene {i}: {differing} pixels");
    }
}

#[test]
fn a_missed_change_is_noticed() {
    if !has_device() {
        return;
    }
    let scene = Scene { build: moving::build, step: moving::step, steps: moving::STEPS };
    let differing = noticed(scene, see_no_change);
    println!("{differing} pixels");
    assert!(differing > 20, "{differing} pixels");
}

#[test]
fn a_lost_caster_is_noticed_with_every_light() {
    if !has_device() {
        return;
    }
    for (i, build) in [scenes::sun, scenes::lamps, scenes::orthographic].into_iter().enumerate() {
        let differing = noticed(Scene::still(build), lose_caster);
        println!("scene {i}: {differing} pixels");
        assert!(differing > 20, "scene {i}: {differing} pixels");
    }
}
