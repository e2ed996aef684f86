//! The systems that list shadow casters: twelve spot lights and a sun of four cascades.

use std::time::Instant;

use bevy_app::prelude::*;
use bevy_camera::visibility::VisibilitySystems::{
    CheckVisibility, MarkNewlyHiddenEntitiesInvisible,
};
use bevy_camera::visibility::{CascadesVisibleEntities, VisibleMeshEntities};
use bevy_cullet::CulletLights;
use bevy_ecs::prelude::*;
use bevy_light::{
    CascadeShadowConfigBuilder, DirectionalLight, LightPlugin, SimulationLightSystems, SpotLight,
};
use bevy_math::{Quat, Vec3};
use bevy_transform::components::Transform;

use crate::{Motion, Number, app, quantile};

/// Milliseconds in the systems that list casters, in the last frame.
#[derive(Resource)]
struct Lap(Instant, f64);

/// Whose systems run.
#[derive(Clone, Copy, PartialEq)]
enum Whose {
    Bevy,
    Plugin,
    /// The plugin, which leaves out what shades nothing that is drawn.
    PluginByReceivers,
}

fn lit(count: usize, motion: Motion, whose: Whose) -> App {
    app(count, motion, whose != Whose::Bevy, |app| {
        app.add_plugins(LightPlugin);
        app.insert_resource(CulletLights { receivers: whose == Whose::PluginByReceivers });
        app.insert_resource(Lap(Instant::now(), 0.0));
        let start = |mut lap: ResMut<Lap>| lap.0 = Instant::now();
        let end = |mut lap: ResMut<Lap>| lap.1 = lap.0.elapsed().as_secs_f64() * 1e3;
        let start = start
            .after(CheckVisibility)
            .after(SimulationLightSystems::UpdateLightFrusta)
            .before(SimulationLightSystems::CheckLightVisibility);
        let end = end
            .after(SimulationLightSystems::CheckLightVisibility)
            .before(MarkNewlyHiddenEntitiesInvisible);
        app.add_systems(PostUpdate, (start, end));
        let world = app.world_mut();
        let side = (count as f32).cbrt() * 2.0;
        for i in 0..12 {
            let angle = i as f32 * 0.52;
            let at = Vec3::new(angle.cos(), 0.2, -angle.sin()) * side * 0.5;
            let spot = SpotLight {
                range: side * 0.6,
                outer_angle: 0.6,
                shadow_maps_enabled: true,
                ..Default::default()
            };
            let turned = Quat::from_euler(bevy_math::EulerRot::YXZ, angle, -0.5, 0.0);
            world.spawn((spot, Transform::from_translation(at).with_rotation(turned)));
        }
        let sun = DirectionalLight { shadow_maps_enabled: true, ..Default::default() };
        let cascades = CascadeShadowConfigBuilder { num_cascades: 4, ..Default::default() };
        let from = Transform::from_xyz(1.0, 3.0, 2.0).looking_at(Vec3::ZERO, Vec3::Y);
        world.spawn((sun, cascades.build(), from));
    })
}

/// How many casters all maps list, and the sum of their numbers.
fn casters(app: &mut App) -> [u64; 2] {
    let world = app.world_mut();
    let mut spots = world.query_filtered::<&VisibleMeshEntities, With<SpotLight>>();
    let mut lists: Vec<Vec<Entity>> = spots.iter(world).map(|list| list.entities.clone()).collect();
    let mut suns = world.query::<&CascadesVisibleEntities>();
    let of_suns = suns.iter(world).flat_map(|sun| sun.entities.values().flatten());
    lists.extend(of_suns.map(|list| list.entities.clone()));
    let numbers: Vec<u64> = lists
        .iter()
        .flatten()
        .filter_map(|&entity| world.get::<Number>(entity))
        .map(|number| u64::from(number.0))
        .collect();
    [numbers.len() as u64, numbers.iter().sum()]
}

pub(crate) fn table(counts: &[usize], motions: &[Motion]) {
    println!(
        "| entities | motion | casters listed | of them by receivers | Bevy, ms | plugin, ms | ratio | by receivers, ms | ratio |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for &count in counts {
        motions.iter().for_each(|&motion| measure(count, motion));
    }
    println!(
        "\nMedians of the systems that list casters, for twelve spot lights and four cascades."
    );
}

fn measure(count: usize, motion: Motion) {
    let all = [Whose::Bevy, Whose::Plugin, Whose::PluginByReceivers];
    let mut apps = all.map(|whose| lit(count, motion, whose));
    let mut times = [const { Vec::new() }; 3];
    for round in 0..100 {
        for (app, times) in apps.iter_mut().zip(&mut times) {
            app.update();
            if round >= 10 {
                times.push(app.world().resource::<Lap>().1);
            }
        }
    }
    let [bevy, ours, fewer] = apps.each_mut().map(casters);
    // Some lie where f32 cannot tell them from a half-space.
    let differ = bevy[0].abs_diff(ours[0]);
    assert!(differ * 10_000 < bevy[0], "{bevy:?} {ours:?}");
    let [a, b, c] = times.map(|times| quantile(times.into_iter(), 0.5));
    println!(
        "| {count} | {} | {} | {} | {a:.3} | {b:.3} | {:.3} | {c:.3} | {:.3} |",
        motion.words()[1],
        bevy[0],
        fewer[0],
        b / a,
        c / a
    );
}
