//! The systems that fill each camera's list of visible entities.

use std::any::TypeId;

use bevy_camera::primitives::Frustum;
use bevy_camera::visibility::{
    NoCpuCulling, RenderLayers, SetViewVisibility, ViewVisibility, VisibleEntities,
    VisibleEntityRanges,
};
use bevy_camera::{Camera, Projection};
use bevy_ecs::prelude::*;
use bevy_mesh::Mesh3d;
use bevy_transform::components::GlobalTransform;

use crate::mirror::{CulletScene, OfMesh, Seen, SeenItem, mask};
use crate::occlusion::{CulletOcclusion, view as view_of};
use crate::view::{CulletView, Known, half_spaces, is_outside};

/// Fills the lists of all classes but meshes, just as Bevy does: lights, probes, decals, sprites and flat meshes are few, or
/// change in each frame.
pub(crate) fn check_others(
    mut views: Query<(
        Entity,
        &mut VisibleEntities,
        &Frustum,
        Option<&RenderLayers>,
        &Camera,
        Has<NoCpuCulling>,
    )>,
    mut others: Query<(Seen, &mut ViewVisibility), (Without<Mesh3d>, Without<NoCpuCulling>)>,
    ranges: Option<Res<VisibleEntityRanges>>,
) {
    for (view, mut visible, frustum, layers, camera, is_exempt) in &mut views {
        if !camera.is_active {
            continue;
        }
        visible.clear_all();
        let layers = layers.unwrap_or_default();
        for (seen, mut view_visibility) in &mut others {
            let is_in = seen.inherited.get()
                && layers.intersects(seen.layers.unwrap_or_default())
                && is_in_range(&seen, view, ranges.as_deref())
                && (is_exempt || seen.no_frustum_culling || is_in_frustum(&seen, frustum));
            if is_in {
                view_visibility.set_visible();
                for &class in seen.class.iter().flat_map(|class| class.iter()) {
                    visible.push(seen.entity, class);
                }
            }
        }
        visible.entities.values_mut().for_each(|list| list.sort_unstable());
    }
}

fn is_in_range(
    seen: &SeenItem<'_, '_>,
    view: Entity,
    ranges: Option<&VisibleEntityRanges>,
) -> bool {
    !seen.ranged || ranges.is_none_or(|ranges| ranges.entity_is_in_range_of_view(seen.entity, view))
}

/// Bevy's test: as it is, or its cameras would list other lights.
fn is_in_frustum(seen: &SeenItem<'_, '_>, frustum: &Frustum) -> bool {
    match (seen.aabb, seen.sphere) {
        (Some(aabb), _) => {
            let at = seen.transform.affine();
            let sphere = bevy_camera::primitives::Sphere {
                center: at.transform_point3a(aabb.center),
                radius: seen.transform.radius_vec3a(aabb.half_extents),
            };
            frustum.intersects_sphere(&sphere, false)
                && frustum.intersects_obb(aabb, &at, true, false)
        }
        (None, Some(sphere)) => frustum.intersects_sphere(sphere, false),
        (None, None) => true,
    }
}

/// Fills the lists of meshes, by the hierarchy.
pub(crate) fn check_meshes(
    mirror: Res<CulletScene>,
    mut views: Query<(
        Entity,
        &mut VisibleEntities,
        &mut CulletView,
        &Frustum,
        Option<&RenderLayers>,
        &Camera,
        Has<NoCpuCulling>,
        (Option<&CulletOcclusion>, Option<&Projection>, Option<&GlobalTransform>),
    )>,
    all: Query<Seen, OfMesh>,
    mut view_visibilities: Query<&mut ViewVisibility, OfMesh>,
    ranges: Option<Res<VisibleEntityRanges>>,
) {
    let scene = &mirror.scene;
    for (view, mut visible, mut state, frustum, layers, camera, is_exempt, occluded) in &mut views {
        if !camera.is_active {
            continue;
        }
        let state = &mut *state;
        let planes = (!is_exempt).then(|| half_spaces(frustum));
        let layers = layers.unwrap_or_default();
        let (occlusion, projection, at) = occluded;
        let occlusion = occlusion.filter(|_| !is_exempt).and_then(|occlusion| {
            Some((occlusion, view_of(camera, projection, at?, frustum, mask(layers))?))
        });
        let now = Known {
            occlusion: occlusion
                .as_ref()
                .map(|(o, view)| (view.clip_from_world(), view.viewport(), **o)),
            scene: scene.id(),
            order: scene.order_version(),
            change: scene.change_version(),
            planes,
            layers: mask(layers),
        };
        if state.known.as_ref() != Some(&now) || !mirror.checked.is_empty() {
            state.find(&mirror, planes.as_ref(), now.layers, |entity| {
                let Ok(seen) = all.get(entity) else { return true };
                if seen.no_frustum_culling {
                    return true;
                }
                let (Some(aabb), Some(planes)) = (seen.aabb, &planes) else { return true };
                !is_outside(planes, aabb, &seen.transform.affine())
            });
            for &entity in &mirror.checked {
                let slot = mirror.handle(entity).and_then(|handle| scene.slot(handle).ok());
                let (Some(slot), Ok(seen)) = (slot, all.get(entity)) else { continue };
                let (word, bit) = (slot as usize / 64, 1 << (slot % 64));
                let keep = layers.intersects(seen.layers.unwrap_or_default())
                    && is_in_range(&seen, view, ranges.as_deref())
                    && (is_exempt
                        || seen.no_frustum_culling
                        || seen.aabb.is_some()
                        || is_in_frustum(&seen, frustum));
                if !keep {
                    state.next[word] &= !bit;
                }
            }
            state.funnel.in_range = state.count();
            if let Some((occlusion, view)) = &occlusion {
                state.hidden.take_out(&occlusion.culler(), &mirror, view, &mut state.next);
            }
            let same = |known: &Known| (known.scene, known.order) == (now.scene, now.order);
            let same_order = state.known.as_ref().is_some_and(same);
            state.take(&mirror, same_order);
            state.known = Some(now);
            state.funnel.visible = state.list.len() as u64;
        }
        for &entity in &state.list {
            if let Ok(mut view_visibility) = view_visibilities.get_mut(entity) {
                view_visibility.set_visible();
            }
        }
        let mesh = TypeId::of::<Mesh3d>();
        if mirror.checked.is_empty() {
            visible.get_mut(mesh).extend_from_slice(&state.list);
            continue;
        }
        for &entity in &state.list {
            if !mirror.checked.contains(&entity) {
                visible.push(entity, mesh);
                continue;
            }
            let class = all.get(entity).ok().and_then(|seen| seen.class);
            for &class in class.iter().flat_map(|class| class.iter()) {
                visible.push(entity, class);
            }
        }
        visible.entities.values_mut().for_each(|list| list.sort_unstable());
    }
}
