//! Occluders by material: what is drawn with an opaque `StandardMaterial` hides what is behind it.

use bevy_asset::{AssetEvent, AssetId, Assets};
use bevy_ecs::prelude::*;
use bevy_material::AlphaMode;
use bevy_mesh::Mesh3d;
use bevy_pbr::{MeshMaterial3d, StandardMaterial};
use bevy_render::render_resource::Face;

use crate::{CulletOccluder, CulletOcclusion, NoCulletOccluder};

/// Marker of entities that got their [`CulletOccluder`] here.
#[derive(Component)]
pub(crate) struct ByMaterial;

type Meshes<'w, 's, F> = Query<
    'w,
    's,
    (
        Entity,
        &'static MeshMaterial3d<StandardMaterial>,
        Option<&'static CulletOccluder>,
        Has<ByMaterial>,
    ),
    (With<Mesh3d>, Without<NoCulletOccluder>, F),
>;

/// How the mesh under a material hides what is behind it; `None` where it may not.
fn occluder(material: &StandardMaterial) -> Option<CulletOccluder> {
    let is_opaque = material.alpha_mode == AlphaMode::Opaque
        && material.depth_bias == 0.0
        && material.specular_transmission <= 0.0
        && material.diffuse_transmission <= 0.0;
    match material.cull_mode {
        None => is_opaque.then_some(CulletOccluder { double_sided: true }),
        Some(Face::Back) => is_opaque.then_some(CulletOccluder { double_sided: false }),
        Some(Face::Front) => None,
    }
}

/// Gives [`CulletOccluder`] to what is opaque, and takes it from what is so no more.
pub(crate) fn by_material(
    mut commands: Commands,
    materials: Option<Res<Assets<StandardMaterial>>>,
    mut events: Option<MessageReader<AssetEvent<StandardMaterial>>>,
    views: Query<(), With<CulletOcclusion>>,
    changed: Meshes<Changed<MeshMaterial3d<StandardMaterial>>>,
    all: Meshes<()>,
    vetoed: Query<Entity, (With<ByMaterial>, With<CulletOccluder>, With<NoCulletOccluder>)>,
    mut is_on: Local<bool>,
) {
    let touched: Vec<AssetId<StandardMaterial>> = events
        .iter_mut()
        .flat_map(|events| events.read())
        .filter_map(|event| match event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } | AssetEvent::Removed { id } => {
                Some(*id)
            }
            _ => None,
        })
        .collect();
    // Where no camera asks, no entity is moved to another table.
    let Some(materials) = materials.filter(|_| *is_on || !views.is_empty()) else { return };
    let is_new = !std::mem::replace(&mut *is_on, true);
    for entity in &vetoed {
        commands.entity(entity).remove::<(CulletOccluder, ByMaterial)>();
    }
    let mut judge = |(entity, material, known, is_ours): (
        Entity,
        &MeshMaterial3d<StandardMaterial>,
        Option<&CulletOccluder>,
        bool,
    )| {
        if known.is_some() && !is_ours {
            return;
        }
        let wanted = materials.get(material.id()).and_then(occluder);
        match wanted {
            Some(wanted) if known != Some(&wanted) => {
                commands.entity(entity).try_insert((wanted, ByMaterial));
            }
            None if is_ours => {
                commands.entity(entity).try_remove::<(CulletOccluder, ByMaterial)>();
            }
            _ => {}
        }
    };
    if is_new {
        all.iter().for_each(judge);
        return;
    }
    changed.iter().for_each(&mut judge);
    if !touched.is_empty() {
        all.iter().filter(|(_, material, ..)| touched.contains(&material.id())).for_each(judge);
    }
}
