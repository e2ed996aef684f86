//! Lights with shadows: which nodes that no camera sees must still be drawn into a shadow map.
//!
//! A sun's maps are drawn in each frame, and only a caster between the sun and something that a
//! camera sees matters. The map of a lamp is drawn when something in its reach changes, and kept:
//! a caster that is missing at that moment would be missing for good. So all in the reach of a lamp
//! stay.
//!
//! A caster that stands behind another, as the sun sees it, is kept. Leaving it out was tried: it
//! halves what is left, but Godot cuts or flattens casters that reach beyond the near side of a map,
//! and then shows what they hide.

use cullet::bounds::Aabb;
use cullet::cull::shadow::Light;
use cullet::{Scene, ShadowView, View, Visible};
use godot::classes::light_3d::Param;
use godot::classes::{DirectionalLight3D, Light3D, OmniLight3D, ProjectSettings, SpotLight3D};
use godot::obj::Singleton;
use godot::prelude::*;

use crate::convert;
use crate::views::{self, Eye};

/// Receivers of shadows that count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Receivers {
    /// Nodes that a camera was found to see.
    Seen,
    /// Any place in a camera's picture.
    Anywhere,
}

/// A sun.
#[derive(Clone, Copy, Debug)]
struct Sun {
    direction: [f64; 3],
    max_distance: f64,
    /// Texels of its map by which a shadow may be wide or off.
    texels: f64,
}

/// Lights of one frame.
#[derive(Debug, Default)]
pub(crate) struct Lights {
    suns: Vec<Sun>,
    /// Views of what each lamp reaches.
    pub(crate) lamps: Vec<View>,
    /// A light whose casters all matter, for all that is known.
    pub(crate) keeps_all: bool,
    texture: f64,
}

/// Number of lamps from which on all casters are kept: asking for each takes longer.
const MOST_LAMPS: usize = 64;
/// Depths at which a camera's picture is cut, as shares of a sun's largest distance: casters are
/// told for each slice by what is seen in it.
const SLICES: [f64; 4] = [0.07, 0.2, 0.5, 1.0];

impl Lights {
    /// Collects the lights of `world` that cast shadows.
    pub(crate) fn collect(&mut self, lights: &[Gd<Light3D>], world: Rid) {
        self.suns.clear();
        self.lamps.clear();
        self.keeps_all = false;
        for light in lights {
            let shines = light.has_shadow() && light.is_visible_in_tree();
            let own = || light.get_world_3d().map(|world| world.get_scenario());
            if !shines || own() != Some(world) {
                continue;
            }
            let at = light.get_global_transform();
            if light.clone().try_cast::<DirectionalLight3D>().is_ok() {
                match sun(light, &at) {
                    Some(sun) => self.suns.push(sun),
                    None => self.keeps_all = true,
                }
            } else {
                match lamp(light, &at) {
                    Some(view) => self.lamps.push(view),
                    None => self.keeps_all = true,
                }
            }
        }
        self.keeps_all |= self.lamps.len() > MOST_LAMPS;
        if self.texture == 0.0 && !self.suns.is_empty() {
            self.texture = texture();
        }
    }

    /// Appends the shadow views of all suns in the picture of a camera, whose answer is `visible`.
    /// Returns false where all casters are to be kept.
    pub(crate) fn shadows(
        &self,
        scene: &Scene,
        eye: &Eye,
        visible: &Visible,
        receivers: Receivers,
        shadows: &mut Vec<ShadowView>,
    ) -> bool {
        self.suns.iter().all(|sun| {
            let slices = self.of_sun(sun, scene, eye, visible, receivers);
            let is_known = slices.is_some();
            shadows.extend(slices.into_iter().flatten());
            is_known
        })
    }

    fn of_sun(
        &self,
        sun: &Sun,
        scene: &Scene,
        eye: &Eye,
        visible: &Visible,
        receivers: Receivers,
    ) -> Option<Vec<ShadowView>> {
        // Shadows fade out before their largest distance; a little more, for their blur.
        let deepest = (sun.max_distance * 1.02).min(eye.far);
        let mut splits = vec![eye.near];
        splits.extend(SLICES.iter().map(|s| s * deepest).filter(|&d| d > eye.near * 1.5));
        if splits.len() < 2 {
            splits.push(eye.near + deepest.max(1.0));
        }
        let light = Light::Directional { direction: sun.direction };
        let whole = eye.view.slice(eye.near, *splits.last()?).ok()?;
        let margin_world = self.margin(&whole, sun)?;
        let is_seen = receivers == Receivers::Seen && !eye.has_lit_fog;
        let finish = |view: ShadowView| {
            let view = ShadowView { margin_world, ..view };
            if is_seen { view.receiving(scene, visible).ok() } else { Some(view) }
        };
        let slices = ShadowView::cascades(&eye.view, light, &splits).ok()?;
        slices.into_iter().map(finish).collect()
    }

    /// Returns how far a shadow may fall from where a sharp one would.
    fn margin(&self, slice: &View, sun: &Sun) -> Option<f64> {
        let corners = slice.frustum().corners()?.map(|[x, y, z, w]| [x / w, y / w, z / w]);
        let span = |axis: usize| {
            let all = corners.iter().map(|c| c[axis]);
            all.clone().fold(f64::MIN, f64::max) - all.fold(f64::MAX, f64::min)
        };
        let radius = 0.5 * (0..3).map(|axis| span(axis).powi(2)).sum::<f64>().sqrt();
        if !radius.is_finite() {
            return None;
        }
        // Four cascades share the texture, two by two.
        Some(2.0 * radius / (self.texture * 0.5) * sun.texels)
    }
}

/// Returns the side of the texture of directional shadows that projects are set to. Scripts may
/// change it unseen, so that no more than 1,024 texels are counted on.
fn texture() -> f64 {
    let name = "rendering/lights_and_shadows/directional_shadow/size";
    let setting = ProjectSettings::singleton().get_setting(name).try_to::<i64>();
    setting.unwrap_or(1024).clamp(256, 1024) as f64
}

/// `None` for one whose shadows widen with distance, or whose direction is unknown.
fn sun(light: &Gd<Light3D>, at: &Transform3D) -> Option<Sun> {
    let widens = light.get_param(Param::SIZE) > 0.0;
    if widens || !convert::is_finite(at) {
        return None;
    }
    let number = |param| f64::from(light.get_param(param));
    let texels = 4.0 + 8.0 * number(Param::SHADOW_BLUR) + 4.0 * number(Param::SHADOW_NORMAL_BIAS);
    let max_distance = number(Param::SHADOW_MAX_DISTANCE);
    // Lights shine along −Z.
    let direction = convert::point(at.basis.col_c()).map(|c| -c);
    let sun = Sun { direction, max_distance, texels };
    (max_distance > 0.0 && texels.is_finite()).then_some(sun)
}

fn lamp(light: &Gd<Light3D>, at: &Transform3D) -> Option<View> {
    let is_lamp = light.clone().try_cast::<OmniLight3D>().is_ok()
        || light.clone().try_cast::<SpotLight3D>().is_ok();
    let reach = if is_lamp { reach(light, at) } else { None };
    views::of_world_box(&reach?, u32::MAX)
}

/// Returns a box around all that a lamp lights; `None` where its place or range is no number.
pub(crate) fn reach(light: &Gd<Light3D>, at: &Transform3D) -> Option<Aabb> {
    // A ball, of a spot too: its cone is asked for by Godot, not by what may change.
    let range = f64::from(light.get_param(Param::RANGE)) * 1.01;
    if !convert::is_finite(at) || !range.is_finite() {
        return None;
    }
    let centre = convert::point(at.origin);
    let scale = [at.basis.col_a(), at.basis.col_b(), at.basis.col_c()];
    let scale = scale.map(|c| f64::from(c.length())).into_iter().fold(1.0, f64::max);
    let reach = range * scale;
    Some(Aabb::rounded_out(centre.map(|c| c - reach), centre.map(|c| c + reach)))
}
