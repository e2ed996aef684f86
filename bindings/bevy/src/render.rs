//! Views that Bevy's renderer does not run: of shadow maps that nothing is lit by.
//!
//! Each face of a lamp's map is a view that Bevy runs its whole schedule for, also where the face
//! lists nothing, and also after the lamp went out of all cameras' lists. Views of faces that no
//! receiver is lit by, and of lamps that are not drawn, are no views any more here: their part of the
//! texture keeps what it had, and nobody reads it.

use std::collections::HashSet;

use bevy_app::App;
use bevy_core_pipeline::schedule::RootNonCameraView;
use bevy_ecs::prelude::*;
use bevy_light::{PointLight, SpotLight};
use bevy_pbr::LightEntity;
use bevy_render::sync_world::MainEntity;
use bevy_render::view::ExtractedView;
use bevy_render::{Extract, ExtractSchedule, Render, RenderApp, RenderSystems};

use crate::CulletLight;

/// Faces that something that is drawn may receive a shadow by: of lamps that are drawn.
#[derive(Debug, Default, Resource)]
struct Faces(HashSet<(Entity, u32)>);

pub(crate) fn build(app: &mut App) {
    // An app without a renderer has nothing to leave out.
    let Some(render) = app.get_sub_app_mut(RenderApp) else { return };
    render.init_resource::<Faces>();
    render.add_systems(ExtractSchedule, extract);
    render.add_systems(
        Render,
        leave_out.after(RenderSystems::CreateViews).before(RenderSystems::Specialize),
    );
}

fn extract(
    mut faces: ResMut<Faces>,
    lights: Extract<
        Query<
            (Entity, &CulletLight, &bevy_camera::visibility::ViewVisibility),
            Or<(With<PointLight>, With<SpotLight>)>,
        >,
    >,
) {
    faces.0.clear();
    for (entity, light, mark) in &lights {
        if mark.get() {
            let has = |face: &u32| light.faces >> face & 1 == 1;
            faces.0.extend((0..6).filter(has).map(|face| (entity, face)));
        }
    }
}

fn leave_out(
    mut commands: Commands,
    faces: Res<Faces>,
    views: Query<(Entity, &ExtractedView), (With<LightEntity>, With<RootNonCameraView>)>,
) {
    for (entity, view) in &views {
        let view = view.retained_view_entity;
        let main: MainEntity = view.main_entity;
        if !faces.0.contains(&(main.entity(), view.subview_index)) {
            commands.entity(entity).remove::<RootNonCameraView>();
        }
    }
}
