//! Lights: which of them matter to something that a camera draws.
//!
//! Bevy's own test lists the lights whose spheres touch a camera's frustum ([`check_others`], which
//! marks none of them). [`leave_out`] then takes those out again whose volume touches nothing that a
//! camera draws: Bevy clusters, extracts and renders nothing for them in this frame. Of a light that
//! is drawn nothing beyond its range, or beside its cone, is anything but zero in the shader, so no
//! pixel differs.
//!
//! [`check_others`]: crate::check::check_others

use std::any::TypeId;

use bevy_camera::Camera;
use bevy_camera::primitives::{Frustum, Sphere};
use bevy_camera::visibility::{
    NoCpuCulling, SetViewVisibility, ViewVisibility, VisibilityClass, VisibleEntities,
};
use bevy_ecs::entity::EntityHashSet;
use bevy_ecs::prelude::*;
use bevy_light::cluster::{ClusterVisibilityClass, GlobalClusterSettings};
use bevy_light::{
    ClusteredDecal, DirectionalLight, LightProbe, PointLight, RectLight, SpotLight, VolumetricLight,
};
use bevy_math::Mat4;
use bevy_mesh::Mesh3d;
use bevy_transform::components::GlobalTransform;
use engine::Simd;
use engine::bounds::Aabb as Bounds;
use engine::cull::frustum::batch::Planes;
use engine::cull::frustum::tree::Cut;
use engine::cull::shadow::CasterRegion;

use crate::bits::slots_of;
use crate::map::Maps;
use crate::mirror::CulletScene;
use crate::receivers::{Eye, Eyes, HALVINGS, Receivers};
use crate::volume::{Volume, is_near};

/// State and results of a light; required by `PointLight`, `SpotLight` and `DirectionalLight`, so that
/// each has one.
#[derive(Component, Debug, Default)]
pub struct CulletLight {
    /// Whether a camera lists the light by Bevy's rules, and it is left out all the same, in the
    /// last frame: it reaches nothing that is drawn.
    pub is_left_out: bool,
    /// One bit a face of a point light's shadow map: something that is drawn may receive a shadow
    /// by it. A spot light has the first bit alone; what has no shadow maps has all.
    pub faces: u8,
    /// How many casters its shadow maps list, all together.
    pub casters: u32,
    pub(crate) maps: Maps,
    /// Whether a camera lists it in this frame.
    pub(crate) is_listed: bool,
    known: Option<(Volume, [u64; 4], bool)>,
}

impl CulletLight {
    /// How many faces of its shadow map nothing that is drawn receives a shadow by; of a light that
    /// is drawn with one.
    #[must_use]
    pub fn faces_out(&self) -> u32 {
        (!self.faces).count_ones()
    }
}

/// A light that is drawn and lit by as Bevy says: never left out, and with all casters.
///
/// Put it where something else asks whether a light is visible, such as a halo that a system of yours
/// draws around it.
#[derive(Clone, Copy, Component, Debug, Default)]
pub struct NoCulletLight;

/// Lights that may be left out: those that end somewhere, and are nothing else beside.
pub(crate) type Lamp = (
    Or<(With<PointLight>, With<SpotLight>)>,
    Without<DirectionalLight>,
    Without<RectLight>,
    Without<LightProbe>,
    Without<ClusteredDecal>,
    Without<NoCulletLight>,
    Without<Mesh3d>,
    Without<NoCpuCulling>,
);

/// Whether something of what an eye sees may be in a volume. `halvings` is how hard parts of receivers are tried to be
/// shown hidden.
fn touches(
    volume: &Volume,
    halvings: u32,
    cut: &mut Cut,
    mirror: &CulletScene,
    eyes: &[Eye<'_>],
) -> bool {
    let scene = &mirror.scene;
    let hierarchy = scene.hierarchy();
    let planes = Planes::new(&volume.region());
    cut.cull(Simd::best(), &planes, hierarchy.nodes(), hierarchy.boxes());
    let reach = volume.bounds();
    eyes.iter().any(|eye| {
        if eye.is_hidden(&reach, halvings) {
            return false;
        }
        let mut all = Bounds::EMPTY;
        for word in cut.touched() {
            let bits = cut.visible()[word] & eye.seen.get(word).copied().unwrap_or(0);
            let boxes = hierarchy.boxes();
            let bounds = slots_of(word, bits).map(|slot| boxes.get(slot as usize));
            let near = bounds.filter(|bounds| is_near(volume.center, volume.radius, bounds));
            // Of a large receiver the part that is lit may be hidden.
            let lit = near.map(|bounds| bounds.intersection(&reach));
            let seen = lit.filter(|part| !eye.is_hidden(part, halvings));
            all = seen.fold(all, |all, part| all.union(&part));
        }
        // What reaches out of the picture may be lit out there alone.
        !CasterRegion::new(&eye.region, Some(&all), &volume.light).no_receiver()
    })
}

/// A light that may be left out.
type LampItem<'a> = (
    Entity,
    &'a CulletLight,
    &'a ViewVisibility,
    &'a GlobalTransform,
    Option<&'a PointLight>,
    Option<&'a SpotLight>,
    bool,
);

/// Shadow maps that every device has room for: with more of them Bevy gives some lights none, and
/// which depends on how many there are.
const POINT_MAPS: usize = 42;
const LAYERS: usize = 256;

/// Returns the lamp that reaches farthest into a view. Bevy's clusters of the next frame end there, for light that comes
/// farther away then as well: it stays listed, and its maps' faces go one by one.
fn farthest_lamp<'a>(
    lamps: impl Iterator<Item = LampItem<'a>>,
    frustum: &Frustum,
    eye: &GlobalTransform,
) -> Option<Entity> {
    // As Bevy has it, to the last bit.
    let view_from_world = Mat4::from(eye.affine().inverse());
    let (row, scale) = (view_from_world.row(2), eye.compute_transform().scale.recip().z);
    let reach = lamps.filter_map(|(entity, _, _, at, point, spot, _)| {
        let range = point.map(|light| light.range).or(spot.map(|light| light.range))?;
        let center = at.translation_vec3a();
        let is_in = frustum.intersects_sphere(&Sphere { center, radius: range }, true);
        is_in.then(|| (-row.dot(at.translation().extend(1.0)) + range * scale, entity))
    });
    reach.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, entity)| entity)
}

/// Marks the lights that cameras list, and takes those from the lists that reach nothing which is
/// drawn.
pub(crate) fn leave_out(
    mirror: Res<CulletScene>,
    mut receivers: ResMut<Receivers>,
    eyes: Eyes,
    mut views: Query<(&Camera, &mut VisibleEntities, &Frustum, &GlobalTransform)>,
    mut lights: Query<
        (
            Entity,
            &mut CulletLight,
            &mut ViewVisibility,
            &GlobalTransform,
            Option<&PointLight>,
            Option<&SpotLight>,
            Has<VolumetricLight>,
        ),
        Lamp,
    >,
    suns: Query<&DirectionalLight>,
    clusters: Option<Res<GlobalClusterSettings>>,
    mut cut: Local<Cut>,
    (mut out, mut farthest): (Local<EntityHashSet>, Local<EntityHashSet>),
) {
    out.clear();
    farthest.clear();
    let gathered = eyes.gather(&mirror);
    receivers.bypass_change_detection().follow(&gathered);
    let all_known = gathered.iter().all(|eye| eye.is_known);
    let has_room = clusters.is_none_or(|clusters| clusters.supports_storage_buffers);
    let may_leave_out = eyes.restrict() && all_known && has_room && !lights.is_empty();
    let mut shadows = [0, suns.iter().filter(|sun| sun.shadow_maps_enabled).count() * 4];
    for (_, state, _, _, point, spot, _) in &lights {
        if state.is_listed {
            shadows[0] += usize::from(point.is_some_and(|light| light.shadow_maps_enabled));
            shadows[1] += usize::from(spot.is_some_and(|light| light.shadow_maps_enabled));
        }
    }
    let class = TypeId::of::<ClusterVisibilityClass>();
    if may_leave_out {
        for (_, visible, frustum, at) in views.iter().filter(|(camera, ..)| camera.is_active) {
            let lamps = visible.get(class).iter().filter_map(|&entity| lights.get(entity).ok());
            farthest.extend(farthest_lamp(lamps, frustum, at));
        }
    }
    let has_maps = shadows[0] <= POINT_MAPS && shadows[1] <= LAYERS;
    let scene = &mirror.scene;
    let now = [scene.id(), scene.order_version(), mirror.step, receivers.step];
    for (entity, mut state, mut mark, at, point, spot, is_volumetric) in &mut lights {
        let state = state.bypass_change_detection();
        state.is_left_out = false;
        if !std::mem::take(&mut state.is_listed) {
            continue;
        }
        let has_shadows = point.is_some_and(|light| light.shadow_maps_enabled)
            || spot.is_some_and(|light| light.shadow_maps_enabled);
        let volume = match (point, spot) {
            _ if !may_leave_out || is_volumetric || has_shadows && !has_maps => None,
            (Some(light), None) => Volume::of_point(light, at),
            (None, Some(light)) => Volume::of_spot(light, at),
            _ => None,
        };
        if let Some(volume) = volume {
            let known = state.known.take().filter(|known| known.0 == volume && known.1 == now);
            let matters = known.map_or_else(
                // A lamp without a map costs little more than finding that out.
                || {
                    touches(
                        &volume,
                        if has_shadows { HALVINGS } else { 0 },
                        &mut cut,
                        &mirror,
                        &gathered,
                    )
                },
                |(_, _, matters)| matters,
            );
            state.known = Some((volume, now, matters));
            state.is_left_out = !matters && !farthest.contains(&entity);
        }
        if state.is_left_out {
            out.insert(entity);
        } else {
            mark.set_visible();
        }
    }
    if out.is_empty() {
        return;
    }
    for (camera, mut visible, ..) in &mut views {
        if camera.is_active {
            // The check that wrote it marked it as changed.
            let visible = visible.bypass_change_detection();
            visible.get_mut(class).retain(|entity| !out.contains(entity));
        }
    }
}

/// Whether a light is in the list of lights alone, where it may be left out.
pub(crate) fn is_plain(class: Option<&VisibilityClass>) -> bool {
    class.is_some_and(|class| class.0[..] == [TypeId::of::<ClusterVisibilityClass>()])
}
