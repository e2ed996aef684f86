//! Lights: which of many can change a picture, and which casters matter for those.

use alloc::vec::Vec;

use cullet::bounds::{Aabb, Side};
use cullet::cull::Indices;
use cullet::cull::detail::Detail;
use cullet::cull::frustum::batch::Planes;
use cullet::cull::frustum::tree::Cut;
use cullet::cull::occlusion::{OcclusionBuffer, Visibility};
use cullet::cull::shadow::{CasterRegion, Light};
use cullet::math;
use cullet::{Culler, Scene, ShadowView, Simd, View, ViewState, Visible, view::Frustum};
use glam::DVec3;

use crate::bits;

/// Why a light cannot change a picture, by the stage that found it out; in the order in which the
/// stages run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum LightReason {
    /// It lights nothing at all: its range or its cone is not above zero.
    Unlit,
    /// The light's reach lies outside the view's frustum.
    Frustum,
    /// The light's reach is too small on the screen. This stage is lossy, and off unless
    /// [`LightOptions::detail`] is set.
    Detail,
    /// The light's reach lies behind what the occlusion buffer has, or beyond the buffer's edges.
    Occlusion,
    /// It reaches nothing that the view was found to see.
    NoReceiver,
}

impl LightReason {
    /// All, in the order of their stages.
    pub const ALL: [Self; 5] =
        [Self::Unlit, Self::Frustum, Self::Detail, Self::Occlusion, Self::NoReceiver];

    /// A short name, as reports print it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Unlit => "unlit",
            Self::Frustum => "frustum",
            Self::Detail => "detail",
            Self::Occlusion => "occlusion",
            Self::NoReceiver => "no-receiver",
        }
    }
}

/// Settings of [`cull_lights`], and what is known of the view.
#[derive(Clone, Copy, Debug)]
pub struct LightOptions<'a> {
    /// SIMD level; the answer is the same at every level. Default: the best of the machine.
    pub simd: Simd,
    /// Drop lights whose reach is this small on the screen. Lossy. Default none.
    pub detail: Option<Detail>,
    /// The view's occlusion buffer, relative to the scene's origin, as a cull with occlusion leaves
    /// it in [`ViewState::occlusion_buffer`]. It must be that of this view. Default none: nothing
    /// is hidden.
    pub buffer: Option<&'a OcclusionBuffer>,
    /// The answer of the view's own cull: what it was found to see. Default none: any place may
    /// receive light.
    pub visible: Option<&'a Visible>,
}

impl Default for LightOptions<'_> {
    fn default() -> Self {
        Self { simd: Simd::best(), detail: None, buffer: None, visible: None }
    }
}

/// How many lights came to a stage, and how many it left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LightRow {
    /// The stage, by the reason that it gives.
    pub stage: LightReason,
    /// Lights that came to it.
    pub entered: u64,
    /// Lights that it left.
    pub left: u64,
}

/// Result of [`cull_lights`]: the lights that may matter. Reuse it from frame to frame.
#[derive(Clone, Debug, Default)]
pub struct LightAnswer {
    /// The numbers of the lights that may matter, ascending.
    pub kept: Vec<u32>,
    /// For each of those: a box around all that the view sees and the light reaches, relative to
    /// the scene's origin; `None` where what the view sees was not given.
    pub receivers: Vec<Option<Aabb>>,
    /// For each light: why it does not matter; `None` is kept.
    pub reasons: Vec<Option<LightReason>>,
    /// The stages that ran, in their order.
    pub rows: Vec<LightRow>,
    seen: Vec<u64>,
    reached: Indices,
    cut: Cut,
}

impl LightAnswer {
    /// The shadows of the `at`th light that was kept, in the picture of the view that the lights
    /// were culled for: what [`Culler::cull_shadow`] takes. Received by what the light was found to
    /// reach. Give it a [map](ShadowView::map) when there is one. `None` if fewer were kept, or
    /// `lights` has fewer.
    #[must_use]
    pub fn shadow_view(&self, view: &View, lights: &[Light], at: usize) -> Option<ShadowView> {
        let light = *lights.get(*self.kept.get(at)? as usize)?;
        let receivers = *self.receivers.get(at)?;
        Some(ShadowView { receivers, ..ShadowView::new(view.clone(), light) })
    }

    /// Takes the lights that a stage drops.
    fn stage(&mut self, stage: LightReason, mut drops: impl FnMut(u32) -> bool) {
        let entered = self.kept.len() as u64;
        let reasons = &mut self.reasons;
        self.kept.retain(|&light| {
            let dropped = drops(light);
            if dropped {
                reasons[light as usize] = Some(stage);
            }
            !dropped
        });
        self.rows.push(LightRow { stage, entered, left: self.kept.len() as u64 });
    }
}

/// Finds the lights that can change the picture of a view, stage by stage, cheapest first.
///
/// Conservative, but for [`detail`](LightOptions::detail): the light that is dropped lights no
/// point that the view sees. A light with a number that makes none (see [`Light`]) is kept, and a
/// directional one reaches everywhere. What is lit are points: light that is scattered on its way,
/// as in fog, reaches the eye from all over the frustum, so for that give neither a buffer nor what
/// is visible.
///
/// Stages: lights without reach; reaches outside the frustum; reaches too small on the screen, if
/// set; reaches that are hidden, where the view's buffer is given; reaches without anything that is
/// seen, where that is given. A reach is the ball of the light's range, cut by a spot's cone.
///
/// Cost: a few tests for each light, and for those in the frustum a region of planes; where what is
/// visible is given, a walk of the hierarchy for each that is left.
///
/// ```
/// use cullet::cull::shadow::Light;
/// use cullet_cells::query::{LightAnswer, LightOptions, LightReason, cull_lights};
/// use cullet::{Scene, View};
///
/// let lamp = |z: f64| Light::Point { position: [0.0, 0.0, z], range: 5.0 };
/// let view = View::perspective([0.0; 3], [0.0, 0.0, -1.0], 0.8, 0.1, 100.0, [640, 480])?;
/// let mut answer = LightAnswer::default();
/// let lights = [lamp(-20.0), lamp(20.0)];
/// cull_lights(&Scene::new(), &view, &lights, &LightOptions::default(), &mut answer);
/// assert_eq!(answer.kept, [0]);
/// assert_eq!(answer.reasons[1], Some(LightReason::Frustum));
/// # Ok::<(), cullet::view::ViewError>(())
/// ```
pub fn cull_lights(
    scene: &Scene,
    view: &View,
    lights: &[Light],
    options: &LightOptions<'_>,
    answer: &mut LightAnswer,
) {
    answer.kept.clear();
    answer.kept.extend(0..lights.len() as u32);
    answer.reasons.clear();
    answer.reasons.resize(lights.len(), None);
    answer.rows.clear();
    let origin = scene.origin();
    let light = |number: u32| lights[number as usize].relative_to(origin);
    let frustum = view.frustum().relative_to(origin);

    answer.stage(LightReason::Unlit, |number| is_unlit(&light(number)));
    answer.stage(LightReason::Frustum, |number| is_outside(&frustum, &light(number)));
    if let Some(detail) = options.detail {
        answer.stage(LightReason::Detail, |number| {
            let rect = view.project_box(&reach_of(&light(number)), origin);
            detail.is_small(rect.as_ref())
        });
    }
    if let Some(buffer) = options.buffer {
        answer.stage(LightReason::Occlusion, |number| {
            buffer.test_box(&reach_of(&light(number))) != Visibility::Visible
        });
    }
    answer.receivers.clear();
    if let Some(visible) = options.visible {
        find_receivers((scene, options.simd), &frustum, lights, visible, answer);
    } else {
        answer.receivers.resize(answer.kept.len(), None);
    }
}

/// [`Culler::cull_shadow`] for each light that [`cull_lights`] kept, in its order: which casters
/// matter for it, with the funnel and the reasons of that. There is one state and one result for
/// each afterwards. Whoever draws into shadow maps that are known by then makes the calls himself,
/// with [`LightAnswer::shadow_view`].
pub fn cull_light_casters(
    culler: &Culler,
    scene: &Scene,
    (view, lights, answer): (&View, &[Light], &LightAnswer),
    states: &mut Vec<ViewState>,
    results: &mut Vec<Visible>,
) {
    states.resize_with(answer.kept.len(), ViewState::default);
    results.resize_with(answer.kept.len(), Visible::default);
    for (at, (state, result)) in states.iter_mut().zip(results).enumerate() {
        if let Some(shadows) = answer.shadow_view(view, lights, at) {
            culler.cull_shadow(scene, &shadows, state, result);
        }
    }
}

/// The stage that tests what the view sees of what a light reaches.
fn find_receivers(
    (scene, simd): (&Scene, Simd),
    frustum: &Frustum,
    lights: &[Light],
    visible: &Visible,
    answer: &mut LightAnswer,
) {
    let mut seen = core::mem::take(&mut answer.seen);
    let (mut cut, mut reached) =
        (core::mem::take(&mut answer.cut), core::mem::take(&mut answer.reached));
    let mut receivers = core::mem::take(&mut answer.receivers);
    seen.clear();
    seen.resize((scene.slot_count() as usize).div_ceil(64), 0);
    for slot in visible.slots().filter(|&slot| slot < scene.slot_count()) {
        bits::set(&mut seen, slot as usize, true);
    }
    let hierarchy = scene.hierarchy();
    answer.stage(LightReason::NoReceiver, |number| {
        let light = lights[number as usize].relative_to(scene.origin());
        // The lit part of the view is within the region of its casters.
        let region = CasterRegion::new(frustum, None, &light);
        cut.cull(simd, &Planes::new(region.frustum()), hierarchy.nodes(), hierarchy.boxes());
        cut.list(simd, &mut reached);
        let lit = reached.iter().filter(|&&slot| bits::get(&seen, slot as usize));
        let boxes = lit.map(|&slot| scene.bounds(slot)).filter(|b| !region.is_beyond_range(b));
        let mut found = false;
        let around = boxes.fold(Aabb::EMPTY, |all, b| {
            found = true;
            all.union(&b)
        });
        if found {
            receivers.push(Some(around));
        }
        !found
    });
    (answer.seen, answer.cut, answer.reached, answer.receivers) = (seen, cut, reached, receivers);
}

/// Whether a light has no reach. NaN is no such proof.
fn is_unlit(light: &Light) -> bool {
    match *light {
        Light::Point { range, .. } => range <= 0.0,
        Light::Spot { range, half_angle_radians, .. } => range <= 0.0 || half_angle_radians <= 0.0,
        // A directional light, or one of a kind that is not known here.
        _ => false,
    }
}

/// Whether what a light reaches is proved to lie outside a frustum: by its box, then by cutting the
/// frustum.
fn is_outside(frustum: &Frustum, light: &Light) -> bool {
    let reach = reach_of(light);
    let beyond = frustum.planes().any(|(_, plane)| reach.side(plane) == Side::Outside);
    beyond || CasterRegion::new(frustum, None, light).no_receiver()
}

/// A box around all that a light reaches, rounded outward; everything, where that has no end or is
/// not known.
fn reach_of(light: &Light) -> Aabb {
    let (position, range, cone) = match *light {
        Light::Point { position, range } => (position, range, None),
        Light::Spot { position, direction, half_angle_radians, range } => {
            (position, range, Some((DVec3::from(direction), half_angle_radians)))
        }
        // A directional light, or one of a kind that is not known here.
        _ => return Aabb::EVERYTHING,
    };
    let tip = DVec3::from(position);
    if !tip.is_finite() || !range.is_finite() {
        return Aabb::EVERYTHING;
    }
    // How far along each axis, and against it, a point of the cone is at the most; a share of the
    // range.
    let mut shares = [DVec3::ONE; 2];
    if let Some((direction, half_angle)) = cone {
        let length = direction.length();
        if !(length > 0.0 && length.is_finite()) {
            return Aabb::EVERYTHING;
        }
        // A NaN is no cone.
        if half_angle < core::f64::consts::FRAC_PI_2 {
            let axis = direction / length;
            for (side, sign) in [-1.0, 1.0].into_iter().enumerate() {
                // The angle from the cone's axis to that of space, less what the cone spreads.
                let turned = |v: f64| math::acos((v * sign).clamp(-1.0, 1.0)) - half_angle;
                let share = |v: f64| math::cos(turned(v).max(0.0));
                shares[side] = DVec3::from(axis.to_array().map(share)).max(DVec3::ZERO);
            }
        }
    }
    let slack = (tip.abs() + range) * 1e-12;
    let (low, high) = (tip - shares[0] * range - slack, tip + shares[1] * range + slack);
    Aabb::rounded_out(low.into(), high.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet_testkit::Rng;

    /// Points of cones are in their boxes, and the boxes are as tight as points can show.
    #[test]
    fn the_box_of_a_cone_holds_it_and_no_more() {
        let mut rng = Rng(9);
        for _ in 0..60 {
            let (position, direction) = (rng.vector(30.0), rng.direction());
            let (range, half_angle_radians) = (rng.range(0.5, 20.0), rng.range(0.05, 2.0));
            let b = reach_of(&Light::Spot { position, direction, half_angle_radians, range });
            let mut around = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
            for _ in 0..200_000 {
                let way = rng.direction();
                let cosine: f64 = (0..3).map(|a| way[a] * direction[a]).sum();
                if half_angle_radians >= core::f64::consts::FRAC_PI_2
                    || cosine >= half_angle_radians.cos()
                {
                    for a in 0..3 {
                        for at in [position[a], position[a] + way[a] * range] {
                            assert!(f64::from(b.min[a]) <= at && at <= f64::from(b.max[a]));
                            around[0][a] = around[0][a].min(at);
                            around[1][a] = around[1][a].max(at);
                        }
                    }
                }
            }
            for a in 0..3 {
                let loose =
                    (around[0][a] - f64::from(b.min[a])).max(f64::from(b.max[a]) - around[1][a]);
                assert!(loose < range * 0.05 + 1e-3, "{loose} of {range}, {half_angle_radians}");
            }
        }
    }

    #[test]
    fn what_makes_no_light_reaches_everywhere() {
        let spot = |direction, half_angle_radians, range| Light::Spot {
            position: [1.0, 2.0, 3.0],
            direction,
            half_angle_radians,
            range,
        };
        for light in [
            spot([0.0; 3], 0.3, 5.0),
            spot([f64::NAN, 0.0, 1.0], 0.3, 5.0),
            spot([0.0, 0.0, 1.0], 0.3, f64::NAN),
            spot([0.0, 0.0, 1.0], 0.3, f64::INFINITY),
            Light::Point { position: [f64::NAN, 0.0, 0.0], range: 1.0 },
            Light::Directional { direction: [0.0, 1.0, 0.0] },
        ] {
            assert_eq!(reach_of(&light), Aabb::EVERYTHING, "{light:?}");
            assert!(!is_unlit(&light));
        }
        let ball = reach_of(&spot([0.0, 0.0, 1.0], f64::NAN, 5.0));
        assert!(ball.is_finite() && ball.min[2] < -1.9, "no cone is a ball: {ball:?}");
        assert!(is_unlit(&spot([0.0, 0.0, 1.0], 0.0, 5.0)));
        assert!(is_unlit(&spot([0.0, 0.0, 1.0], 0.3, -1.0)));
    }
}
