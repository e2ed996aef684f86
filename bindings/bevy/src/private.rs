//! Private parts of Bevy that the plugin knows, all of them in this file: systems without a public name, and fields that are there
//! with some features alone. A port to another version of Bevy begins here; the tests below name what moved.

use bevy_app::{App, PostUpdate};
use bevy_camera::visibility::VisibilitySystems::{
    CalculateBounds, CheckVisibility, MarkNewlyHiddenEntitiesInvisible, VisibilityPropagate,
};
use bevy_camera::visibility::{ViewVisibility, VisibilityPlugin, VisibilitySystems};
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{InternedSystemSet, ScheduleCleanupPolicy};
use bevy_reflect::structs::{GetField, Struct};

/// Whether a light has soft shadows: a field of point and spot lights by one name and of suns by another, with Bevy's feature
/// `experimental_pbr_pcss` alone.
pub(crate) fn has_soft_shadows(light: &dyn Struct) -> bool {
    let is_set = light.get_field::<bool>("soft_shadows_enabled") == Some(&true);
    let size = light.get_field::<Option<f32>>("soft_shadow_size");
    is_set || matches!(size, Some(Some(_)))
}

/// Bevy's private systems that [`reset`](crate::marks::reset), [`hide`](crate::marks::hide) and
/// [`inherit`](crate::inherit::inherit) stand for, by their types.
#[derive(Debug, Resource)]
pub(crate) struct Replaced {
    pub(crate) systems: Vec<InternedSystemSet>,
    /// Mark that Bevy gives a visible entity when a frame begins.
    pub(crate) was_visible: ViewVisibility,
}

impl Replaced {
    /// Found in an app of its own, where nobody else's systems are in the same sets.
    pub(crate) fn find() -> Self {
        let mut app = App::new();
        app.add_plugins(VisibilityPlugin);
        let mut systems = systems_of(&mut app, VisibilityPropagate);
        systems.append(&mut systems_of(&mut app, MarkNewlyHiddenEntitiesInvisible));
        // What the systems that begin a frame make of a mark, they are asked themselves.
        for set in [CalculateBounds, CheckVisibility, MarkNewlyHiddenEntitiesInvisible] {
            remove(&mut app, set);
        }
        let world = app.world_mut();
        let entity = world.spawn(ViewVisibility::VISIBLE).id();
        world.run_schedule(PostUpdate);
        let mark = world.get::<ViewVisibility>(entity).copied();
        Self { systems, was_visible: mark.unwrap_or(ViewVisibility::HIDDEN) }
    }
}

/// Takes systems out of the schedule after the frame's transforms. Not an error where there are
/// none: an app without Bevy's cameras has nothing to take out.
pub(crate) fn remove(app: &mut App, set: impl SystemSet) {
    let _ = app.remove_systems_in_set(PostUpdate, set, ScheduleCleanupPolicy::RemoveSystemsOnly);
}

/// The sets of one system each of those in a set.
fn systems_of(app: &mut App, set: VisibilitySystems) -> Vec<InternedSystemSet> {
    let found = app.world_mut().try_schedule_scope(PostUpdate, |world, schedule| {
        schedule.initialize(world).ok()?;
        let keys = schedule.graph().systems_in_set(set.intern()).ok()?;
        let of_set = schedule.systems().ok()?.filter(|(key, _)| keys.contains(key));
        let sets = of_set.flat_map(|(_, system)| system.default_system_sets());
        Some(sets.filter(|set| set.system_type().is_some()).collect())
    });
    found.ok().flatten().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy_light::{DirectionalLight, PointLight, SpotLight};

    #[test]
    fn the_systems_that_are_replaced_are_those_of_this_version() {
        let replaced = Replaced::find();
        assert_eq!(replaced.systems.len(), 3, "{:?}", replaced.systems);
        assert!(!replaced.was_visible.get());
        assert_ne!(replaced.was_visible, ViewVisibility::HIDDEN);
        let mut app = App::new();
        app.add_plugins(VisibilityPlugin);
        let known = [
            (CalculateBounds, 2),
            (VisibilityPropagate, 2),
            (CheckVisibility, 2),
            (MarkNewlyHiddenEntitiesInvisible, 1),
        ];
        for (set, count) in known {
            let found = systems_of(&mut app, set.clone()).len();
            assert_eq!(found, count, "the systems of Bevy in {set:?}: look at what they do");
        }
    }

    /// One that is new may say that light falls elsewhere than is known here.
    #[test]
    fn the_fields_of_lights_are_those_of_this_version() {
        let fields = |light: &dyn Struct| -> Vec<String> {
            let names = (0..light.field_len()).filter_map(|i| light.name_at(i).map(str::to_owned));
            names.filter(|name| !name.starts_with("soft_shadow")).collect()
        };
        let shared = ["color", "intensity", "range", "radius", "shadow_maps_enabled"];
        let more = ["contact_shadows_enabled", "affects_lightmapped_mesh_diffuse"];
        let biases = ["shadow_depth_bias", "shadow_normal_bias"];
        let point = [&shared[..], &more, &biases, &["shadow_map_near_z"]].concat();
        let spot = [&point[..], &["outer_angle", "inner_angle"]].concat();
        let sun = [&["color", "illuminance", "shadow_maps_enabled"][..], &more, &biases].concat();
        assert_eq!(fields(&PointLight::default()), point);
        assert_eq!(fields(&SpotLight::default()), spot);
        assert_eq!(fields(&DirectionalLight::default()), sun);
    }
}
