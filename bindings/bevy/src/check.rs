//! The systems that fill each camera's list of visible entities.

use std::any::TypeId;

use bevy_camera::primitives::{Aabb, Frustum};
use bevy_camera::visibility::{
    NoCpuCulling, NoFrustumCulling, RenderLayers, SetViewVisibility, ViewVisibility,
    VisibleEntities, VisibleEntityRanges,
};
use bevy_camera::{Camera, Projection};
use bevy_ecs::prelude::*;
use bevy_light::cluster::ClusterVisibilityClass;
use bevy_math::Affine3A;
use bevy_mesh::Mesh3d;
use bevy_transform::components::GlobalTransform;

use crate::candidates::CulletCandidates;
use crate::lights::{CulletLight, Lamp, is_plain};
use crate::marks::{Marked, Marks};
use crate::mirror::CulletScene;
use crate::occlusion::{CulletOcclusion, view as view_of};
use crate::seen::{OfMesh, Seen, SeenItem, mask};
use crate::view::{CulletView, Known, half_spaces, is_outside};

/// Fills the lists of all classes but meshes, just as Bevy does: lights, probes, decals, sprites
/// and flat meshes are few, or change in each frame.
pub(crate) fn check_others(
    mut views: Query<(
        Entity,
        &mut VisibleEntities,
        &mut CulletView,
        &Frustum,
        Option<&RenderLayers>,
        &Camera,
        Has<NoCpuCulling>,
    )>,
    mut others: Query<
        (Seen, &mut ViewVisibility, Option<&mut CulletLight>),
        (Without<Mesh3d>, Without<NoCpuCulling>),
    >,
    lamps: Query<(), Lamp>,
    ranges: Option<Res<VisibleEntityRanges>>,
) {
    let mesh = TypeId::of::<Mesh3d>();
    let cluster = TypeId::of::<ClusterVisibilityClass>();
    for (view, mut visible, mut state, frustum, layers, camera, is_exempt) in &mut views {
        if !camera.is_active {
            continue;
        }
        let state = &mut *state;
        state.is_foreign = state.written.is_some_and(|tick| tick != visible.last_changed());
        state.is_listed &= state.written.is_some() && !state.is_foreign && state.strays.is_empty();
        state.strays.clear();
        state.has_unknown = false;
        let classes = visible.entities.iter_mut().filter(|(class, _)| **class != mesh);
        classes.for_each(|(_, list)| list.clear());
        let layers = layers.unwrap_or_default();
        for (seen, mut view_visibility, light) in &mut others {
            let is_in = seen.inherited.get()
                && layers.intersects(seen.layers.unwrap_or_default())
                && is_in_range(&seen, view, ranges.as_deref())
                && (is_exempt || seen.no_frustum_culling || is_in_frustum(&seen, frustum));
            if is_in {
                // A lamp is marked once it is known whether it matters.
                match light.filter(|_| lamps.contains(seen.entity) && is_plain(seen.class)) {
                    Some(mut light) => light.bypass_change_detection().is_listed = true,
                    None => view_visibility.set_visible(),
                }
                for &class in seen.class.iter().flat_map(|class| class.iter()) {
                    // What lost its mesh keeps the class.
                    let is_stray = class == mesh;
                    state.has_unknown |= !is_stray && class != cluster;
                    let list = if is_stray { &mut state.strays } else { visible.get_mut(class) };
                    list.push(seen.entity);
                }
            }
        }
        let classes = visible.entities.iter_mut().filter(|(class, _)| **class != mesh);
        classes.for_each(|(_, list)| list.sort_unstable());
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
    mut marks: ResMut<Marks>,
    mut views: Query<(
        Entity,
        &mut VisibleEntities,
        &mut CulletView,
        &Frustum,
        Option<&RenderLayers>,
        &Camera,
        Has<NoCpuCulling>,
        (Option<&CulletOcclusion>, Option<&Projection>, Option<&GlobalTransform>),
        Option<Ref<CulletCandidates>>,
    )>,
    all: Query<Seen, OfMesh>,
    boxes: Query<(Option<&Aabb>, &GlobalTransform, Has<NoFrustumCulling>), OfMesh>,
    mut marked: Marked,
    ranges: Option<Res<VisibleEntityRanges>>,
    mut active: Local<Vec<Entity>>,
) {
    let scene = &mirror.scene;
    let mut is_changed = false;
    let mut seeing = Vec::new();
    for (view, mut visible, mut state, frustum, layers, camera, is_exempt, occluded, candidates) in
        &mut views
    {
        if !camera.is_active {
            continue;
        }
        seeing.push(view);
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
            step: mirror.step,
            planes,
            layers: mask(layers),
            candidates: candidates.as_ref().map(|candidates| candidates.last_changed()),
        };
        let mut is_new = false;
        if state.known.as_ref() != Some(&now) || !mirror.checked.is_empty() {
            state.find(&mirror, &now, |entities| {
                // Read before any is tested: reads that miss the cache wait for each other the least
                // when nothing is between them.
                let mut near = [None; 64];
                for (near, &entity) in near.iter_mut().zip(entities) {
                    *near = match boxes.get(entity) {
                        Ok((Some(aabb), at, false)) => Some((*aabb, at.affine())),
                        _ => None,
                    };
                }
                let is_seen = |near: &Option<(Aabb, Affine3A)>| {
                    let both = near.as_ref().zip(planes.as_ref());
                    both.is_none_or(|((aabb, at), planes)| !is_outside(planes, aabb, at))
                };
                let near = near[..entities.len()].iter().enumerate();
                near.fold(0, |bits, (at, near)| bits | u64::from(is_seen(near)) << at)
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
            let may_hide =
                candidates.as_ref().is_some_and(|c| c.take_out(&mirror, &mut state.next));
            state.funnel.in_range = state.count();
            // What is left out and exempt from culling would be taken for an occluder.
            state.hidden.leave();
            if let Some((occlusion, view)) = occlusion.as_ref().filter(|_| !may_hide) {
                let is_among = candidates.is_some();
                state.hidden.take_out(occlusion, &mirror, view, is_among, &mut state.next);
            }
            let same = |known: &Known| (known.scene, known.order) == (now.scene, now.order);
            let same_order = state.known.as_ref().is_some_and(same);
            is_new = state.take(&mirror, same_order);
            let of_view = |known: &Known| (known.planes, known.layers, known.candidates);
            let is_same = |known: &Known| of_view(known) == of_view(&now);
            state.version += u64::from(is_new || !state.known.as_ref().is_some_and(is_same));
            state.known = Some(now);
            state.funnel.visible = state.listed.list.len() as u64;
        }
        is_changed |= is_new;
        if is_new || !state.is_listed || !state.strays.is_empty() || !mirror.checked.is_empty() {
            list(&mut visible, state, &mirror, &all);
        }
        // Bevy writes it in each frame, and whoever listens hears it.
        visible.set_changed();
        state.is_listed = mirror.checked.is_empty();
        state.written = Some(visible.last_changed());
    }
    let lists = || views.iter().filter(|view| view.5.is_active).map(|view| &view.2.listed.list[..]);
    if is_changed || *active != seeing {
        marks.list(lists(), |index| mirror.of_index(index), &mut marked);
        *active = seeing;
    }
    if !marks.set(&mut marked) {
        for &entity in lists().flatten() {
            if let Ok((_, mut mark)) = marked.get_mut(entity) {
                mark.set_visible();
            }
        }
    }
}

/// Writes the list of meshes of a camera.
fn list(
    visible: &mut VisibleEntities,
    state: &CulletView,
    mirror: &CulletScene,
    all: &Query<Seen, OfMesh>,
) {
    let mesh = TypeId::of::<Mesh3d>();
    let meshes = visible.get_mut(mesh);
    meshes.clear();
    meshes.extend_from_slice(&state.strays);
    if mirror.checked.is_empty() && state.strays.is_empty() {
        meshes.extend_from_slice(&state.listed.list);
        return;
    }
    for &entity in &state.listed.list {
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
