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
use bevy_camera::visibility::{
    NoCpuCulling, SetViewVisibility, ViewVisibility, VisibilityClass, VisibleEntities,
};
use bevy_color::{Color, ColorToComponents};
use bevy_ecs::entity::EntityHashSet;
use bevy_ecs::prelude::*;
use bevy_light::cluster::{ClusterVisibilityClass, GlobalClusterSettings};
use bevy_light::{
    ClusteredDecal, DirectionalLight, LightProbe, PointLight, RectLight, SpotLight, VolumetricLight,
};
use bevy_math::DVec3;
use bevy_mesh::Mesh3d;
use bevy_transform::components::GlobalTransform;
use engine::Simd;
use engine::bounds::{Aabb as Bounds, Plane};
use engine::cull::frustum::batch::Planes;
use engine::cull::frustum::tree::Cut;
use engine::cull::shadow::{CasterRegion, Light};
use engine::view::Frustum as Region;

use crate::bits::slots_of;
use crate::casters::Maps;
use crate::mirror::CulletScene;
use crate::receivers::{Eye, Eyes, Receivers};

/// Settings of what is left out of lights and their shadows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Resource)]
pub struct CulletLights {
    /// Whether lights that reach nothing that a camera draws are left out, and casters that throw
    /// no shadow onto such a thing. Else lights and casters are those of Bevy, found by the
    /// hierarchy. Default: true with the feature `pbr`; without it nobody knows here how cameras
    /// light what they draw.
    pub receivers: bool,
}

impl Default for CulletLights {
    fn default() -> Self {
        Self { receivers: cfg!(feature = "pbr") }
    }
}

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

/// The part of space that a light reaches.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Volume {
    center: [f64; 3],
    radius: f64,
    planes: Vec<Plane>,
    light: Light,
}

/// How much farther light is taken to reach: the device places pixels by f32.
const REACH: f64 = 1.001;
/// Nearer near planes leave depth too few bits to tell what is before what.
const NEAREST: f32 = 1e-6;
/// How much wider, in radians: the shader knows a spot's direction by two of its coordinates.
pub(crate) const WIDER: f64 = 0.02;

impl Volume {
    /// The reach of a light around a place, with or without a cone. `None` where the numbers make
    /// no light that ends somewhere.
    fn new(at: &GlobalTransform, range: f32, outer_angle: Option<f32>) -> Option<Self> {
        let center = at.translation().as_dvec3();
        let radius = f64::from(range) * REACH + center.abs().max_element() * 1e-5;
        // The shader divides by the square of the range.
        let is_near = center.abs().cmplt(DVec3::splat(1e9)).all();
        if !((1e-9..1e9).contains(&range) && is_near) {
            return None;
        }
        let mut light = Light::Point { position: center.to_array(), range: radius };
        let mut planes = Vec::new();
        for axis in 0..3 {
            for sign in [-1.0, 1.0] {
                let mut normal = [0.0; 3];
                normal[axis] = sign;
                planes.push(Plane { normal, d: sign * center[axis] + radius });
            }
        }
        let angle = outer_angle.map(|angle| f64::from(angle) + WIDER);
        if let Some(angle) = angle.filter(|&angle| angle < std::f64::consts::FRAC_PI_2) {
            let axis = forward(at);
            light = Light::Spot {
                position: center.to_array(),
                direction: axis.to_array(),
                half_angle_radians: angle,
                range: radius,
            };
            let (sin, cos) = angle.sin_cos();
            let side = axis.any_orthonormal_vector();
            let up = axis.cross(side);
            for out in [side, -side, up, -up] {
                let normal = (out * cos - axis * sin).normalize();
                planes.push(Plane {
                    normal: normal.to_array(),
                    d: normal.dot(center) + radius * 1e-3,
                });
            }
        }
        Some(Self { center: center.to_array(), radius, planes, light })
    }

    pub(crate) fn of_point(light: &PointLight, at: &GlobalTransform) -> Option<Self> {
        let PointLight { color, intensity, range, radius, .. } = *light;
        let PointLight { shadow_depth_bias, shadow_normal_bias, shadow_map_near_z, .. } = *light;
        let numbers = [intensity, radius, shadow_depth_bias, shadow_normal_bias];
        let has_depth = (NEAREST..range).contains(&shadow_map_near_z);
        (has_depth && shines(color, &numbers)).then(|| Self::new(at, range, None))?
    }

    pub(crate) fn of_spot(light: &SpotLight, at: &GlobalTransform) -> Option<Self> {
        let SpotLight { color, intensity, range, radius, inner_angle, outer_angle, .. } = *light;
        let SpotLight { shadow_depth_bias, shadow_normal_bias, shadow_map_near_z, .. } = *light;
        let numbers = [intensity, radius, shadow_depth_bias, shadow_normal_bias];
        let is_cone = (NEAREST..range).contains(&shadow_map_near_z)
            && (1e-3..std::f32::consts::FRAC_PI_2).contains(&outer_angle)
            && inner_angle.is_finite()
            && forward(at) != DVec3::ZERO;
        (is_cone && shines(color, &numbers)).then(|| Self::new(at, range, Some(outer_angle)))?
    }

    fn region(&self) -> Region {
        let mut region = Region::from_planes(std::array::from_fn(|i| self.planes.get(i).copied()));
        for &plane in self.planes.iter().skip(6) {
            // One that is refused is one fewer to reject by.
            let _ = region.push(plane);
        }
        region
    }

    /// Whether something of what an eye sees may be in it.
    fn touches(&self, cut: &mut Cut, mirror: &CulletScene, eyes: &[Eye<'_>]) -> bool {
        let scene = &mirror.scene;
        let hierarchy = scene.hierarchy();
        let planes = Planes::new(&self.region());
        cut.cull(Simd::best(), &planes, hierarchy.nodes(), hierarchy.boxes());
        eyes.iter().any(|eye| {
            let mut all = Bounds::EMPTY;
            for word in cut.touched() {
                let bits = cut.visible()[word] & eye.seen.get(word).copied().unwrap_or(0);
                let bounds = slots_of(word, bits).map(|slot| scene.bounds(slot));
                let near = bounds.filter(|bounds| is_near(self.center, self.radius, bounds));
                all = near.fold(all, |all, bounds| all.union(&bounds));
            }
            // What reaches out of the picture may be lit out there alone.
            !CasterRegion::new(&eye.region, Some(&all), &self.light).no_receiver()
        })
    }
}

/// Whether a light is nothing where it ends. A number that is not one, or infinite, makes colours
/// that are not numbers wherever the light is asked, also where it is zero.
fn shines(color: Color, numbers: &[f32]) -> bool {
    let color = color.to_linear().to_f32_array();
    color.iter().chain(numbers).all(|number| number.abs() < 1e20)
}

/// The way that a light shines; zero where there is none.
pub(crate) fn forward(at: &GlobalTransform) -> DVec3 {
    (-at.affine().matrix3.z_axis.as_dvec3()).normalize_or_zero()
}

/// Whether a box comes as near to a point as this. NaN does.
pub(crate) fn is_near(center: [f64; 3], radius: f64, bounds: &engine::bounds::Aabb) -> bool {
    let mut square = 0.0;
    for axis in 0..3 {
        let [min, max] = [bounds.min[axis], bounds.max[axis]].map(f64::from);
        let apart = (min - center[axis]).max(center[axis] - max).max(0.0);
        square += apart * apart;
    }
    !(square > radius * radius)
}

/// Shadow maps that every device has room for: with more of them Bevy gives some lights none, and
/// which depends on how many there are.
const POINT_MAPS: usize = 42;
const LAYERS: usize = 256;

/// Marks the lights that cameras list, and takes those from the lists that reach nothing which is
/// drawn.
pub(crate) fn leave_out(
    mirror: Res<CulletScene>,
    mut receivers: ResMut<Receivers>,
    eyes: Eyes,
    mut views: Query<(&Camera, &mut VisibleEntities)>,
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
    mut out: Local<EntityHashSet>,
) {
    out.clear();
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
                || volume.touches(&mut cut, &mirror, &gathered),
                |(_, _, matters)| matters,
            );
            state.known = Some((volume, now, matters));
            state.is_left_out = !matters;
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
    let class = TypeId::of::<ClusterVisibilityClass>();
    for (camera, mut visible) in &mut views {
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
