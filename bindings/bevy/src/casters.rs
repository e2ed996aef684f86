//! Casters: the lists of what each shadow map draws.
//!
//! Stands for Bevy's `check_dir_light_mesh_visibility` and `check_point_light_mesh_visibility`. The
//! order of a frame:
//!
//! 1. [`leave_out`](crate::lights::leave_out), in [`CulletSystems::Check`](crate::CulletSystems::Check):
//!    which lamps matter.
//! 2. Bevy clusters what is left, and makes the frusta of the shadow maps.
//! 3. [`cast`], in `SimulationLightSystems::CheckLightVisibility`: of each map ([`Map`]) whose inputs
//!    ([`Known`]) changed, the hierarchy is cut by the map's half-spaces ([`View`]), as by those of
//!    a camera; what straddles one is asked by Bevy's own tests. Of those, [`Map::allow`] keeps what
//!    can throw a shadow onto something that is drawn: for each [`Eye`] the region of casters
//!    ([`CasterRegion`]) of the box around what it sees in the map.
//! 4. [`Marks::cast`] marks what the maps list, in one pass over the tables.
//!
//! A list is what Bevy would list, or less.

use std::any::TypeId;

use bevy_camera::primitives::{CascadesFrusta, CubemapFrusta, Frustum};
use bevy_camera::visibility::{
    CascadesVisibleEntities, CubemapVisibleEntities, NoCpuCulling, RenderLayers, ViewVisibility,
    VisibleEntities, VisibleEntityRanges, VisibleMeshEntities,
};
use bevy_camera::{Camera, RenderTarget, ShadowLodOrigin};
use bevy_ecs::entity::EntityHashSet;
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use bevy_light::cluster::ClusterVisibilityClass;
use bevy_light::{
    Cascades, DirectionalLight, DirectionalLightShadowMap, PointLight, PointLightShadowMap,
    SpotLight, VolumetricLight, get_shadow_lod_origin,
};
use bevy_transform::components::GlobalTransform;
use engine::cull::shadow::Light;

use crate::bits;
use crate::lights::{CulletLight, NoCulletLight};
use crate::map::{Boxes, Frame, Map, Scratch, View, half_spaces};
use crate::marks::{Marked, Marks};
use crate::mirror::CulletScene;
use crate::private::has_soft_shadows;
use crate::receivers::{Eyes, Receivers};
use crate::seen::{OfMesh, Seen, mask};
use crate::view::CulletView;
use crate::volume::{Volume, WIDER, forward};
use crate::without::WithoutShadows;

/// The maps that are drawn, and what they list.
#[derive(Debug, Default)]
pub(crate) struct Drawn {
    frame: u64,
    /// Lights, eyes and numbers of the maps of this frame, and of the last.
    maps: [Vec<([Entity; 2], usize)>; 2],
    is_new: bool,
    /// One bit a slot: some map lists it.
    slots: Vec<u64>,
}

impl Drawn {
    fn is_empty(&self) -> bool {
        self.maps[0].is_empty()
    }

    fn begin(&mut self) {
        self.frame += 1;
        self.is_new = false;
        self.maps.swap(0, 1);
        self.maps[0].clear();
    }

    fn put(&mut self, map: &mut Map, of: [Entity; 2], number: usize, is_new: bool) {
        map.frame = self.frame;
        self.maps[0].push((of, number));
        self.is_new |= is_new;
    }

    fn is_changed(&self) -> bool {
        self.is_new || self.maps[0] != self.maps[1]
    }
}

/// A light, and where its maps list what they draw.
type Lights<'w, 's> = Query<
    'w,
    's,
    (
        Entity,
        &'static mut CulletLight,
        &'static GlobalTransform,
        Option<&'static RenderLayers>,
        (Has<VolumetricLight>, Has<NoCulletLight>),
        Option<(&'static PointLight, &'static CubemapFrusta, &'static mut CubemapVisibleEntities)>,
        Option<(&'static SpotLight, &'static Frustum, &'static mut VisibleMeshEntities)>,
        Option<(
            &'static DirectionalLight,
            &'static CascadesFrusta,
            &'static Cascades,
            &'static mut CascadesVisibleEntities,
        )>,
    ),
>;

/// Whose distance decides which level throws the shadows of lamps.
#[derive(SystemParam)]
pub(crate) struct LodOrigin<'w, 's> {
    cameras: Query<'w, 's, (Entity, &'static RenderTarget), With<Camera>>,
    origins: Query<'w, 's, Entity, With<ShadowLodOrigin>>,
    lamps: Query<'w, 's, Entity, Or<(With<PointLight>, With<SpotLight>)>>,
}

impl LodOrigin<'_, '_> {
    fn find(&mut self) -> Option<Entity> {
        get_shadow_lod_origin(
            self.cameras.transmute_lens_filtered(),
            self.origins.transmute_lens_filtered(),
            self.lamps.transmute_lens_filtered(),
        )
    }
}

/// Texels of a directional or a spot light's map that a pixel is shaded by, on each side.
const TEXELS: f64 = 6.0;

/// How far beside a receiver the maps of a lamp are read, `texel` being the size of a texel at a
/// distance of 1 and `filter` what the filter reads around it there. `None` where there is no
/// telling.
fn margin(range: f32, [depth, normal]: [f32; 2], texel: f64, filter: f64) -> Option<f64> {
    let range = f64::from(range);
    let beside = f64::from(normal.abs()) * texel * 1.5 + filter + TEXELS * texel + 1e-4;
    Some(range * beside + f64::from(depth.abs())).filter(|m| m.is_finite() && range > 0.0)
}

/// Maps of more texels than every device has may have fewer than they should.
fn texels(size: usize) -> f64 {
    size.min(2048) as f64
}

/// Inputs that the maps of a frame share.
struct Casting<'a, 'w, 's> {
    frame: Frame<'a, 'w, 's>,
    scratch: &'a mut Scratch,
    drawn: &'a mut Drawn,
    /// Size of a texel of a point light's map at a distance of 1.
    point_texel: f64,
    /// Texels across other maps, and how many times as many there should be.
    sun_texels: [f64; 2],
    /// Whose distance decides which level throws the shadows of lamps.
    origin: Option<Entity>,
}

/// A light whose maps are to be listed.
struct Caster<'a> {
    entity: Entity,
    at: &'a GlobalTransform,
    layers: &'a RenderLayers,
    /// Whether casters may be left out for want of receivers.
    restrict: bool,
}

impl Caster<'_> {
    fn sphere(&self, range: f32) -> Option<[f32; 4]> {
        Some(self.at.translation().extend(range).to_array())
    }
}

impl Casting<'_, '_, '_> {
    /// Brings the list of a map after what it shows. Tells whether it changed.
    fn list(&mut self, map: &mut Map, of: &Caster<'_>, number: usize, view: View) -> bool {
        let [eye, origin] = match view.eye {
            Some(eye) => [eye; 2].map(Some),
            None => [None, self.origin],
        };
        let is_new = map.list(self.scratch, &self.frame, view, origin, of.layers);
        self.drawn.put(map, [of.entity, eye.unwrap_or(of.entity)], number, is_new);
        is_new
    }

    /// Lists the six faces of a point light.
    fn point(
        &mut self,
        state: &mut CulletLight,
        of: &Caster<'_>,
        light: &PointLight,
        frusta: &CubemapFrusta,
        mut lists: Mut<CubemapVisibleEntities>,
    ) {
        let is_soft = has_soft_shadows(light);
        let is_known = of.restrict && !is_soft && Volume::of_point(light, of.at).is_some();
        let bias = [light.shadow_depth_bias, light.shadow_normal_bias];
        let margin = margin(light.range, bias, self.point_texel, 0.004).filter(|_| is_known);
        let position = of.at.translation().as_dvec3().to_array();
        let maps = &mut state.maps;
        let is_ours = maps.written[0] == Some(lists.last_changed());
        state.faces = !0x3f;
        for (number, (map, frustum)) in maps.faces.iter_mut().zip(&frusta.frusta).enumerate() {
            let view = View {
                half_spaces: half_spaces(frustum),
                has_near: true,
                sphere: of.sphere(light.range),
                layers: mask(of.layers),
                light: Light::Point { position, range: light.range.into() },
                margin,
                eye: None,
            };
            if self.list(map, of, number, view) || !is_ours {
                write(lists.get_mut(number), map);
            }
            state.faces |= u8::from(map.has_receivers) << number;
            state.casters += map.len();
        }
        // Bevy writes it in each frame, and its renderer drops what is not written.
        lists.set_changed();
        maps.written[0] = Some(lists.last_changed());
    }

    /// Lists the map of a spot light.
    fn spot(
        &mut self,
        state: &mut CulletLight,
        of: &Caster<'_>,
        light: &SpotLight,
        frustum: &Frustum,
        mut list: Mut<VisibleMeshEntities>,
    ) {
        let is_soft = has_soft_shadows(light);
        let angle = f64::from(light.outer_angle);
        // Wide maps are read in their corners as far out as there are numbers.
        let is_cone = angle < std::f64::consts::FRAC_PI_2 - 0.05;
        let is_known =
            of.restrict && !is_soft && is_cone && Volume::of_spot(light, of.at).is_some();
        let bias = [light.shadow_depth_bias, light.shadow_normal_bias];
        let texel = 2.0 * angle.tan() / self.sun_texels[0];
        let view = View {
            half_spaces: half_spaces(frustum),
            has_near: true,
            sphere: of.sphere(light.range),
            layers: mask(of.layers),
            light: Light::Spot {
                position: of.at.translation().as_dvec3().to_array(),
                direction: forward(of.at).to_array(),
                half_angle_radians: angle + WIDER,
                range: light.range.into(),
            },
            margin: margin(light.range, bias, texel, 0.002).filter(|_| is_known),
            eye: None,
        };
        let map = &mut state.maps.spot;
        let is_ours = state.maps.written[1] == Some(list.last_changed());
        if self.list(map, of, 6, view) || !is_ours {
            write(&mut list, map);
        }
        state.faces = state.faces & !1 | u8::from(map.has_receivers);
        state.casters += map.len();
        list.set_changed();
        state.maps.written[1] = Some(list.last_changed());
    }

    /// Lists the cascades of a directional light, for each camera.
    fn sun(
        &mut self,
        state: &mut CulletLight,
        of: &Caster<'_>,
        light: &DirectionalLight,
        (frusta, cascades): (&CascadesFrusta, &Cascades),
        mut lists: Mut<CascadesVisibleEntities>,
    ) {
        let is_ours = state.maps.written[2] == Some(lists.last_changed());
        lists.entities.retain(|view, _| frusta.frusta.contains_key(view));
        state.maps.cascades.retain(|view, _| frusta.frusta.contains_key(view));
        let is_soft = has_soft_shadows(light);
        let direction = forward(of.at).to_array();
        for (&eye, frusta) in &frusta.frusta {
            let lists = lists.entities.entry(eye).or_default();
            lists.resize(frusta.len(), VisibleMeshEntities::default());
            let maps = state.maps.cascades.entry(eye).or_default();
            maps.resize_with(frusta.len(), Map::default);
            let sizes = cascades.cascades.get(&eye);
            for (number, (map, frustum)) in maps.iter_mut().zip(frusta).enumerate() {
                let cascade = sizes.and_then(|sizes| sizes.get(number));
                let margin = cascade.map(|cascade| {
                    let texel = f64::from(cascade.texel_size) * self.sun_texels[1];
                    let beside = f64::from(light.shadow_normal_bias.abs()) * texel * 1.5;
                    beside + f64::from(light.shadow_depth_bias.abs()) + TEXELS * texel + 0.05
                });
                let view = View {
                    half_spaces: half_spaces(frustum),
                    has_near: false,
                    sphere: None,
                    layers: mask(of.layers),
                    light: Light::Directional { direction },
                    margin: margin.filter(|m| of.restrict && !is_soft && m.is_finite()),
                    eye: Some(eye),
                };
                if self.list(map, of, 7 + number, view) || !is_ours {
                    write(&mut lists[number], map);
                }
                state.casters += map.len();
            }
        }
        lists.set_changed();
        state.maps.written[2] = Some(lists.last_changed());
    }
}

/// Fills the lists of casters of all lights, and marks what they list.
pub(crate) fn cast(
    mirror: Res<CulletScene>,
    receivers: Res<Receivers>,
    mut marks: ResMut<Marks>,
    (eyes, mut without, mut lod_origin): (Eyes, WithoutShadows, LodOrigin),
    views: Query<(Ref<VisibleEntities>, Option<&CulletView>)>,
    mut lights: Lights,
    (boxes, all): (Boxes, Query<Seen, OfMesh>),
    mut marked: Marked,
    off_cpu: Query<&ViewVisibility, With<NoCpuCulling>>,
    ranges: Option<Res<VisibleEntityRanges>>,
    (point_size, sun_size): (
        Option<Res<PointLightShadowMap>>,
        Option<Res<DirectionalLightShadowMap>>,
    ),
    mut scratch: Local<Scratch>,
    (mut lamps, mut drawn): (Local<EntityHashSet>, Local<Drawn>),
) {
    let without = without.follow();
    if lights.is_empty() && drawn.is_empty() {
        return;
    }
    let gathered = eyes.gather(&mirror);
    let is_foreign = |(visible, state): (Ref<VisibleEntities>, Option<&CulletView>)| {
        state.and_then(|state| state.written).is_some_and(|at| at != visible.last_changed())
    };
    let sun_size = sun_size.map_or(0, |size| size.size);
    drawn.begin();
    let mut casting = Casting {
        frame: Frame {
            mirror: &mirror,
            eyes: &gathered,
            is_foreign: views.iter().any(is_foreign),
            receivers: receivers.step,
            without,
            boxes: &boxes,
            all: &all,
            ranges: ranges.as_deref(),
        },
        scratch: &mut scratch,
        drawn: &mut drawn,
        point_texel: 2.0 / texels(point_size.map_or(0, |size| size.size)),
        // The nominal size of a texel may be that of a larger map.
        sun_texels: [texels(sun_size), sun_size as f64 / texels(sun_size)],
        origin: if mirror.checked.is_empty() { None } else { lod_origin.find() },
    };
    let class = TypeId::of::<ClusterVisibilityClass>();
    lamps.clear();
    lamps.extend(views.iter().flat_map(|(visible, _)| visible.get(class).to_vec()));
    let restrict = eyes.restrict();
    for (entity, mut state, at, layers, (is_volumetric, is_exempt), point, spot, sun) in &mut lights
    {
        let state = state.bypass_change_detection();
        (state.faces, state.casters) = (u8::MAX, 0);
        let restrict = restrict && !is_volumetric && !is_exempt;
        let of = Caster { entity, at, layers: layers.unwrap_or_default(), restrict };
        let is_listed = lamps.contains(&entity);
        // As Bevy has it: what is both is no sun.
        let is_spot = spot.is_some();
        if let Some((light, frusta, lists)) = point
            && is_listed
            && light.shadow_maps_enabled
        {
            casting.point(state, &of, light, frusta, lists);
        }
        if let Some((light, frustum, list)) = spot
            && is_listed
            && light.shadow_maps_enabled
        {
            casting.spot(state, &of, light, frustum, list);
        }
        if let Some((light, frusta, cascades, mut lists)) = sun
            && !is_spot
        {
            let is_visible = match marked.get(entity) {
                Ok((_, mark)) => mark.get(),
                Err(_) => off_cpu.get(entity).is_ok_and(|mark| mark.get()),
            };
            if light.shadow_maps_enabled && is_visible {
                casting.sun(state, &of, light, (frusta, cascades), lists);
            } else {
                lists.entities.clear();
                state.maps.cascades.clear();
            }
        }
    }
    if drawn.is_changed() {
        let Drawn { frame, slots, .. } = &mut *drawn;
        let lists = lights.iter().flat_map(|(_, state, ..)| state.maps.all());
        let lists = lists.filter(|map| map.frame == *frame).map(Map::slots);
        slots.fill(0);
        slots.resize(mirror.scene.hierarchy().present().len(), 0);
        lists.for_each(|list| slots.iter_mut().zip(list).for_each(|(all, bits)| *all |= bits));
        let entity = |slot| Entity::from_bits(mirror.scene.user_data(slot));
        marks.list_casters(
            bits::slots(slots).map(entity),
            |index| mirror.of_index(index),
            &mut marked,
        );
    }
    marks.cast(|index| mirror.of_index(index), &mut marked);
}

/// Writes a list of Bevy's.
fn write(list: &mut VisibleMeshEntities, map: &Map) {
    list.entities.clear();
    list.entities.extend_from_slice(map.entities());
    list.shrink();
}
