//! The overlay: the bounds of each culled entity in the colour of the reason, the funnel as text,
//! and a key that freezes what is drawn.

use std::any::TypeId;

use bevy_app::{App, Plugin, PostUpdate, PreUpdate};
use bevy_camera::primitives::{Aabb, CUBE_MAP_FACES, Frustum};
use bevy_camera::visibility::{
    InheritedVisibility, NoCpuCulling, RenderLayers, SetViewVisibility, ViewVisibility,
    VisibilityRange, VisibilitySystems, VisibleEntities, VisibleEntityRanges,
};
use bevy_camera::{Camera, Camera3d};
use bevy_color::Color;
use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;
use bevy_gizmos::AppGizmoBuilder;
use bevy_gizmos::config::{GizmoConfig, GizmoConfigGroup};
use bevy_gizmos::gizmos::Gizmos;
use bevy_input::ButtonInput;
use bevy_input::keyboard::KeyCode;
use bevy_light::{PointLight, SpotLight};
use bevy_math::{Isometry3d, Vec2, Vec3};
use bevy_mesh::Mesh3d;
use bevy_reflect::Reflect;
use bevy_transform::components::GlobalTransform;

use crate::candidates::CulletCandidates;
use crate::lights::CulletLight;
use crate::plugin::CulletSystems;
use crate::view::{half_spaces, is_outside};

/// Height of the text's capitals, in pixels.
const TEXT_PX: f32 = 12.0;

/// Fate of an entity with a mesh, for one camera in one frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum CulletFate {
    /// In the camera's list: drawn.
    Drawn,
    /// On none of the camera's layers.
    Layer,
    /// Left out by the camera's [`CulletCandidates`].
    LeftOut,
    /// Outside its [`VisibilityRange`].
    Range,
    /// Outside the frustum.
    Frustum,
    /// Behind others.
    Occluded,
}

impl CulletFate {
    /// All, in the order of the funnel.
    pub const ALL: [Self; 6] =
        [Self::Layer, Self::Frustum, Self::LeftOut, Self::Range, Self::Occluded, Self::Drawn];

    /// The colour of its bounds and its line of text, in sRGB: that of the reason in all pictures
    /// of cullet.
    #[must_use]
    pub const fn color(self) -> [u8; 3] {
        match self {
            Self::Drawn => [0xF6, 0xF2, 0xE8],
            Self::Layer => [0x8C, 0x93, 0x9B],
            Self::LeftOut => [0x7F, 0xE8, 0x2E],
            Self::Range => [0x7F, 0x8F, 0x2F],
            Self::Frustum => [0x56, 0xB4, 0xE9],
            Self::Occluded => [0xD5, 0x5E, 0x00],
        }
    }

    /// Its name in the text.
    #[must_use]
    pub const fn label(self) -> &'static str {
        match self {
            Self::Drawn => "drawn",
            Self::Layer => "on other layers",
            Self::LeftOut => "left out by the app",
            Self::Range => "out of range",
            Self::Frustum => "outside the view",
            Self::Occluded => "hidden behind others",
        }
    }
}

/// Settings of the overlay.
#[derive(Clone, Debug, Resource)]
pub struct CulletOverlay {
    /// Whether bounds are drawn. Default: true.
    pub bounds: bool,
    /// Whether the bounds of what is drawn are drawn too. Default: false.
    pub bounds_of_drawn: bool,
    /// Whether the funnel is written in the upper left corner of the camera. Default: true.
    pub text: bool,
    /// Whether what is drawn stays as it was found when this was set, for all cameras, wherever
    /// they go since. What came into the world later is not drawn until it is unset; shadows stay
    /// those of the moment. Default: false.
    pub frozen: bool,
    /// The key that shows and hides bounds and text. Default: F3.
    pub toggle_key: Option<KeyCode>,
    /// The key that freezes and unfreezes. Default: F4.
    pub freeze_key: Option<KeyCode>,
    /// The camera whose funnel is shown; `None` takes the active 3D camera of the lowest order.
    /// Default: `None`.
    pub camera: Option<Entity>,
}

impl Default for CulletOverlay {
    fn default() -> Self {
        Self {
            bounds: true,
            bounds_of_drawn: false,
            text: true,
            frozen: false,
            toggle_key: Some(KeyCode::F3),
            freeze_key: Some(KeyCode::F4),
            camera: None,
        }
    }
}

/// Shows what [`CulletPlugin`](crate::CulletPlugin) culls, and why.
///
/// It needs Bevy's gizmos (feature `bevy_gizmos_render`, in `DefaultPlugins` by default) and is
/// controlled by the resource [`CulletOverlay`]. Each frame costs a test of every entity that is
/// not drawn, for one camera; nothing while it is hidden and not frozen.
#[derive(Clone, Copy, Debug, Default)]
pub struct CulletOverlayPlugin;

impl Plugin for CulletOverlayPlugin {
    fn build(&self, app: &mut App) {
        // Through walls, or nobody would see the bounds of what is behind them; the text before all
        // bounds.
        let config = |depth_bias| GizmoConfig { depth_bias, ..GizmoConfig::default() };
        app.insert_gizmo_config(CulletGizmos, config(-0.98));
        app.insert_gizmo_config(CulletTextGizmos, config(-1.0));
        app.init_resource::<CulletOverlay>();
        app.add_systems(PreUpdate, read_keys);
        app.add_systems(
            PostUpdate,
            (
                hold.in_set(VisibilitySystems::CheckVisibility).after(CulletSystems::Check),
                show.after(VisibilitySystems::MarkNewlyHiddenEntitiesInvisible),
            ),
        );
    }
}

/// The bounds of the overlay as a group of gizmos, to change their line width or layers.
#[derive(Clone, Copy, Debug, Default, Reflect, GizmoConfigGroup)]
pub struct CulletGizmos;

/// The text of the overlay as a group of gizmos.
#[derive(Clone, Copy, Debug, Default, Reflect, GizmoConfigGroup)]
pub struct CulletTextGizmos;

fn read_keys(keys: Option<Res<ButtonInput<KeyCode>>>, mut overlay: ResMut<CulletOverlay>) {
    // An app without windows has no keys.
    let Some(keys) = keys else { return };
    let pressed = |key: Option<KeyCode>| key.is_some_and(|key| keys.just_pressed(key));
    if pressed(overlay.toggle_key) {
        let shown = !(overlay.bounds || overlay.text);
        (overlay.bounds, overlay.text) = (shown, shown);
    }
    if pressed(overlay.freeze_key) {
        overlay.frozen = !overlay.frozen;
    }
}

/// View of a camera when it was frozen.
#[derive(Component, Debug)]
struct Frozen {
    frustum: Frustum,
    /// The list of meshes.
    list: Vec<Entity>,
    /// All entities, sorted.
    fates: Vec<(Entity, CulletFate)>,
}

#[derive(QueryData)]
struct Subject {
    entity: Entity,
    inherited: &'static InheritedVisibility,
    layers: Option<&'static RenderLayers>,
    aabb: Option<&'static Aabb>,
    transform: &'static GlobalTransform,
    ranged: Has<VisibilityRange>,
}

#[derive(QueryData)]
struct Eye {
    entity: Entity,
    camera: &'static Camera,
    transform: &'static GlobalTransform,
    frustum: &'static Frustum,
    layers: Option<&'static RenderLayers>,
    visible: &'static VisibleEntities,
    candidates: Option<&'static CulletCandidates>,
}

type Lights<'w, 's> = Query<
    'w,
    's,
    (
        &'static CulletLight,
        &'static GlobalTransform,
        Option<&'static PointLight>,
        Option<&'static SpotLight>,
    ),
>;

/// The colour of what is left out of lights, in sRGB.
const LEFT_OUT: [u8; 3] = [0xCC, 0x79, 0xA7];

type Subjects<'w, 's> = Query<'w, 's, Subject, (With<Mesh3d>, Without<NoCpuCulling>)>;

impl EyeItem<'_, '_> {
    fn meshes(&self) -> &[Entity] {
        self.visible.get(TypeId::of::<Mesh3d>())
    }

    /// The first reason for which an entity is not drawn; `None` where the user hid it.
    fn fate(
        &self,
        e: &SubjectItem<'_, '_>,
        ranges: Option<&VisibleEntityRanges>,
    ) -> Option<CulletFate> {
        let layers = self.layers.unwrap_or_default();
        let planes = half_spaces(self.frustum);
        let is_outside = |aabb| is_outside(&planes, aabb, &e.transform.affine());
        let is_in_range = |ranges: &VisibleEntityRanges| {
            !e.ranged || ranges.entity_is_in_range_of_view(e.entity, self.entity)
        };
        Some(match () {
            () if self.meshes().binary_search(&e.entity).is_ok() => CulletFate::Drawn,
            () if !e.inherited.get() => return None,
            () if !layers.intersects(e.layers.unwrap_or_default()) => CulletFate::Layer,
            () if e.aabb.is_some_and(is_outside) => CulletFate::Frustum,
            () if self.candidates.is_some_and(|c| c.is_left_out(e.entity)) => CulletFate::LeftOut,
            () if !ranges.is_none_or(is_in_range) => CulletFate::Range,
            () => CulletFate::Occluded,
        })
    }

    fn fates(
        &self,
        all: &Subjects,
        ranges: Option<&VisibleEntityRanges>,
    ) -> Vec<(Entity, CulletFate)> {
        let mut fates: Vec<_> =
            all.iter().filter_map(|e| Some((e.entity, self.fate(&e, ranges)?))).collect();
        fates.sort_unstable();
        fates
    }
}

/// Puts what was visible when the cameras were frozen in the place of what is.
fn hold(
    overlay: Res<CulletOverlay>,
    mut commands: Commands,
    eyes: Query<Eye, Without<Frozen>>,
    mut frozen: Query<(Entity, &Frozen, &mut VisibleEntities)>,
    all: Subjects,
    mut view_visibilities: Query<&mut ViewVisibility>,
    ranges: Option<Res<VisibleEntityRanges>>,
) {
    if !overlay.frozen {
        for (camera, ..) in &frozen {
            commands.entity(camera).remove::<Frozen>();
        }
        return;
    }
    for eye in eyes.iter().filter(|eye| eye.camera.is_active) {
        let frustum = *eye.frustum;
        let fates = eye.fates(&all, ranges.as_deref());
        commands.entity(eye.entity).insert(Frozen { frustum, list: eye.meshes().to_vec(), fates });
    }
    for (_, frozen, mut visible) in &mut frozen {
        let list = visible.get_mut(TypeId::of::<Mesh3d>());
        list.clear();
        for &entity in &frozen.list {
            // Gone since, or hidden by the user.
            let is_there = all.get(entity).is_ok_and(|e| e.inherited.get());
            if let (true, Ok(mut view_visibility)) = (is_there, view_visibilities.get_mut(entity)) {
                view_visibility.set_visible();
                list.push(entity);
            }
        }
    }
}

/// Draws bounds and text for one camera.
fn show(
    overlay: Res<CulletOverlay>,
    eyes: Query<(Eye, Option<&Frozen>), With<Camera3d>>,
    all: Subjects,
    ranges: Option<Res<VisibleEntityRanges>>,
    lights: Lights,
    mut gizmos: Gizmos<CulletGizmos>,
    mut text: Gizmos<CulletTextGizmos>,
) {
    if !(overlay.bounds || overlay.text) {
        return;
    }
    let chosen = match overlay.camera {
        Some(camera) => eyes.get(camera).ok(),
        None => eyes
            .iter()
            .filter(|(eye, _)| eye.camera.is_active)
            .min_by_key(|(eye, _)| (eye.camera.order, eye.entity)),
    };
    let Some((eye, frozen)) = chosen else { return };
    let live;
    let fates = match frozen {
        Some(frozen) => &frozen.fates,
        None => {
            live = eye.fates(&all, ranges.as_deref());
            &live
        }
    };
    if overlay.bounds {
        for &(entity, fate) in fates {
            let is_shown = fate != CulletFate::Drawn || overlay.bounds_of_drawn;
            let Ok(SubjectItem { aabb: Some(aabb), transform, .. }) = all.get(entity) else {
                continue;
            };
            if is_shown {
                gizmos.aabb_3d(*aabb, *transform, color(fate));
            }
        }
        if let Some(frozen) = frozen {
            draw_frustum(&frozen.frustum, &mut gizmos);
        }
        lights.iter().for_each(|light| draw_light(light, &mut gizmos));
    }
    if overlay.text {
        let out = lights.iter().filter(|(light, ..)| light.is_left_out).count();
        let faces = lights.iter().map(|(light, ..)| light.faces_out()).sum::<u32>();
        write(&eye, fates, [out as u32, faces], frozen.is_some(), &mut text);
    }
}

/// Draws the reach of a light that is left out, and a line to each face of a shadow map that nothing
/// drawn is shaded by.
fn draw_light(
    (light, at, point, spot): (
        &CulletLight,
        &GlobalTransform,
        Option<&PointLight>,
        Option<&SpotLight>,
    ),
    gizmos: &mut Gizmos<CulletGizmos>,
) {
    let [r, g, b] = LEFT_OUT;
    let color = Color::srgb_u8(r, g, b);
    let center = at.translation();
    let range = point.map(|light| light.range).or(spot.map(|light| light.range));
    if let Some(range) = range.filter(|range| light.is_left_out && range.is_finite()) {
        gizmos.sphere(Isometry3d::from_translation(center), range, color);
    }
    if point.is_some() && !light.is_left_out {
        let out =
            CUBE_MAP_FACES.iter().enumerate().filter(|(face, _)| light.faces >> face & 1 == 0);
        out.for_each(|(_, face)| gizmos.line(center, center + face.target * 0.5, color));
    }
}

fn color(fate: CulletFate) -> Color {
    let [r, g, b] = fate.color();
    Color::srgb_u8(r, g, b)
}

fn draw_frustum(frustum: &Frustum, gizmos: &mut Gizmos<CulletGizmos>) {
    let Some(corners) = frustum.corners() else { return };
    let color = color(CulletFate::Drawn);
    for i in 0..4 {
        gizmos.line(corners[i], corners[(i + 1) % 4], color);
        gizmos.line(corners[i], corners[i + 4], color);
        gizmos.line(corners[i + 4], corners[(i + 1) % 4 + 4], color);
    }
}

/// Writes the funnel just behind the near plane of the camera.
fn write(
    eye: &EyeItem<'_, '_>,
    fates: &[(Entity, CulletFate)],
    [lights_out, faces_out]: [u32; 2],
    is_frozen: bool,
    gizmos: &mut Gizmos<CulletTextGizmos>,
) {
    let Some(size) = eye.camera.logical_viewport_size() else { return };
    let place = |px: Vec2| {
        let ndc = (px / size * 2.0 - 1.0) * Vec2::new(1.0, -1.0);
        eye.camera.ndc_to_world(eye.transform, ndc.extend(0.5))
    };
    let (Some(from), Some(to)) =
        (place(Vec2::splat(TEXT_PX)), place(TEXT_PX * Vec2::new(2.0, 1.0)))
    else {
        return;
    };
    let count = |fate| fates.iter().filter(|f| f.1 == fate).count();
    let head = format!("{} meshes{}\n", fates.len(), if is_frozen { ", frozen" } else { "" });
    let [r, g, b] = LEFT_OUT;
    let of_lights = [
        (lights_out, "lights left out: they reach nothing drawn"),
        (faces_out, "faces of shadow maps left out: they shade nothing drawn"),
    ];
    let of_lights = of_lights.into_iter().filter(|(n, _)| *n > 0);
    let of_lights = of_lights.map(|(n, label)| (format!("{n} {label}\n"), Color::srgb_u8(r, g, b)));
    let lines = CulletFate::ALL.map(|fate| (fate, count(fate)));
    let lines: Vec<_> = lines
        .into_iter()
        .filter(|&(fate, n)| n > 0 || fate == CulletFate::Drawn)
        .map(|(fate, n)| (format!("{n} {}\n", fate.label()), color(fate)))
        .chain(of_lights)
        .collect();
    let mut sections = vec![(head.as_str(), Color::WHITE)];
    sections.extend(lines.iter().map(|(text, color)| (text.as_str(), *color)));
    let rotation = eye.transform.rotation();
    let size = Vec3::distance(from, to);
    let anchor = Vec2::new(-0.5, 0.5);
    // In black, a little lower, first: a colour is lost before bounds of the same.
    let shadows: Vec<_> = sections.iter().map(|&(text, _)| (text, Color::BLACK)).collect();
    let below = rotation * Vec3::new(1.0, -1.0, 0.0) * (size * 1.5 / TEXT_PX);
    gizmos.text_sections(Isometry3d::new(from + below, rotation), &shadows, size, anchor);
    gizmos.text_sections(Isometry3d::new(from, rotation), &sections, size, anchor);
}
