//! The plugin: what is put in the place of Bevy's own systems.

use bevy_app::{App, Plugin, PostUpdate};
use bevy_camera::Camera;
use bevy_camera::visibility::{
    VisibilitySystems, check_visibility_cpu_culling, check_visibility_ranges,
};
use bevy_ecs::prelude::*;
use bevy_light::{
    DirectionalLight, PointLight, SimulationLightSystems, SpotLight,
    check_dir_light_mesh_visibility, check_point_light_mesh_visibility,
};
use bevy_transform::TransformSystems;

use crate::casters::cast;
use crate::check::{check_meshes, check_others};
use crate::follow::follow;
use crate::inherit::inherit;
use crate::lights::{CulletLight, leave_out};
use crate::marks::{Marks, hide, is_any_leaving, reset};
use crate::mirror::CulletScene;
use crate::occluder::{CulletPrepare, OccluderMeshes, prepare};
use crate::private::{Replaced, remove};
use crate::receivers::{CulletLights, Receivers, Transmits};
use crate::view::CulletView;

/// Steps of the plugin, in [`PostUpdate`], within [`VisibilitySystems::CheckVisibility`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, SystemSet)]
pub enum CulletSystems {
    /// The engine's scene takes over what changed.
    Follow,
    /// Each camera gets its visible entities.
    Check,
}

/// Takes visibility over from Bevy, for all cameras of the app.
///
/// Add it anywhere among the plugins; Bevy's own check is taken out when the app is finished. It
/// keeps all its state in the app's world, so that any number of apps can run in one process.
#[derive(Clone, Copy, Debug, Default)]
pub struct CulletPlugin;

impl Plugin for CulletPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<CulletScene>();
        app.init_resource::<OccluderMeshes>();
        app.init_resource::<CulletPrepare>();
        let replaced = Replaced::find();
        app.insert_resource(Marks::new(replaced.was_visible));
        app.insert_resource(replaced);
        app.init_resource::<CulletLights>()
            .init_resource::<Receivers>()
            .init_resource::<Transmits>();
        app.register_required_components::<Camera, CulletView>();
        app.register_required_components::<PointLight, CulletLight>();
        app.register_required_components::<SpotLight, CulletLight>();
        app.register_required_components::<DirectionalLight, CulletLight>();
        app.configure_sets(
            PostUpdate,
            (CulletSystems::Follow, CulletSystems::Check)
                .chain()
                .in_set(VisibilitySystems::CheckVisibility)
                .after(check_visibility_ranges),
        );
        app.add_systems(
            PostUpdate,
            (
                // One system of several: to start one takes as long as to look at thousands of
                // entities.
                follow.pipe(prepare).in_set(CulletSystems::Follow),
                check_others.pipe(check_meshes).pipe(leave_out).in_set(CulletSystems::Check),
            ),
        );
        #[cfg(feature = "pbr")]
        app.add_systems(
            PostUpdate,
            crate::pbr::by_material
                .pipe(crate::pbr::transmits)
                .after(bevy_asset::AssetEventSystems)
                .before(CulletSystems::Follow),
        );
    }

    fn finish(&self, app: &mut App) {
        let Some(replaced) = app.world_mut().remove_resource::<Replaced>() else { return };
        remove(app, check_visibility_cpu_culling.into_system_set());
        remove(app, check_dir_light_mesh_visibility.into_system_set());
        remove(app, check_point_light_mesh_visibility.into_system_set());
        replaced.systems.iter().for_each(|&set| remove(app, set));
        #[cfg(feature = "pbr")]
        crate::render::build(app);
        app.add_systems(
            PostUpdate,
            (
                inherit.pipe(reset).in_set(VisibilitySystems::VisibilityPropagate),
                // In the order of those that it stands for.
                cast.in_set(SimulationLightSystems::CheckLightVisibility)
                    .after(VisibilitySystems::CalculateBounds)
                    .after(TransformSystems::Propagate)
                    .after(SimulationLightSystems::UpdateLightFrusta)
                    .after(VisibilitySystems::CheckVisibility)
                    .before(VisibilitySystems::MarkNewlyHiddenEntitiesInvisible),
                hide.run_if(is_any_leaving)
                    .in_set(VisibilitySystems::MarkNewlyHiddenEntitiesInvisible),
            ),
        );
    }
}
