//! The frame: everything that the stages derive from a view, derived once.

use alloc::borrow::Cow;

use super::candidates::{Candidates, Look};
#[cfg(feature = "shadows")]
use super::shadow::ShadowView;
use super::{Backface, Culler, Output};
#[cfg(feature = "shadows")]
use crate::array::Each;
#[cfg(feature = "shadows")]
use crate::bounds::{Plane, ROUNDING};
use crate::cull::frustum::batch::{Planes, VISIBLE};
use crate::cull::shadow::{CasterReason, CasterRegion};
use crate::funnel::Stage;
use crate::jobs::{Jobs, OneThread};
use crate::scene::Scene;
#[cfg(feature = "shadows")]
use crate::view::FrustumPlane;
use crate::view::{CullFace, Frustum, View};
use crate::visible::Visible;

/// Who looks: a camera, or a light for the shadows that a camera sees.
#[derive(Clone, Copy)]
pub(super) enum Viewer<'a> {
    Camera(&'a View),
    /// A camera that sees these candidates alone.
    #[cfg(feature = "candidates")]
    Among(&'a View, &'a dyn Candidates),
    #[cfg(feature = "shadows")]
    Light(&'a ShadowView),
}

impl Viewer<'_> {
    /// The settings without the stages that this viewer has no use for.
    pub(super) fn settings<'c>(&self, culler: &'c Culler) -> Cow<'c, Culler> {
        match self {
            #[cfg(feature = "shadows")]
            Self::Light(shadows) => Cow::Owned(of_light(shadows, culler)),
            _ => Cow::Borrowed(culler),
        }
    }
}

#[cfg(feature = "shadows")]
fn of_light(shadows: &ShadowView, culler: &Culler) -> Culler {
    let mut own = match shadows.map {
        // What a shadow falls on may be in sight where the light is not.
        Some(_) => culler.without(Stage::Portal).without(Stage::Pvs),
        None => [Stage::Pvs, Stage::Portal, Stage::Detail, Stage::Occlusion, Stage::Backface]
            .into_iter()
            .fold(culler.clone(), |culler, stage| culler.without(stage)),
    };
    // The six first planes of a region are not the sides of a view.
    own.frustum_exact = false;
    own
}

/// One cull of one view, as all stages see it.
pub(super) struct Frame<'a> {
    pub(super) culler: &'a Culler,
    pub(super) scene: &'a Scene,
    /// View that is drawn: for a light, its map; its camera where it has none, and no stage looks
    /// through it.
    pub(super) view: &'a View,
    /// View whose pixels count for what may be simplified: of a light its camera's, or what casts a
    /// shadow and what is drawn would differ.
    pub(super) seen_by: &'a View,
    /// In world space, and relative to the scene's origin, as its boxes are: of a light, where
    /// casters matter.
    pub(super) world_frustum: Frustum,
    pub(super) frustum: Frustum,
    /// Planes of `frustum`, ready for tests of boxes.
    pub(super) planes: Planes,
    /// Region in which casters of the light matter, relative to the scene's origin; `None` for a
    /// camera.
    casters: Option<CasterRegion>,
    /// Instances that may be visible, where the caller says which.
    candidates: Option<&'a dyn Candidates>,
    /// Threads that stages may run on.
    pub(super) jobs: &'a dyn Jobs,
    /// The one instance that is culled, where an explanation is wanted.
    pub(super) only: Option<Alone<'a>>,
}

/// One instance by itself.
#[derive(Clone, Copy)]
pub(super) struct Alone<'a> {
    pub(super) slot: u32,
    /// The answer for the whole scene, by instances and with reasons: what hides one is everything
    /// else.
    pub(super) all: &'a Visible,
}

impl<'a> Frame<'a> {
    /// `culler` has the viewer's own [settings](Viewer::settings).
    pub(super) fn new(
        culler: &'a Culler,
        scene: &'a Scene,
        viewer: Viewer<'a>,
        only: Option<Alone<'a>>,
    ) -> Self {
        let origin = scene.origin();
        let of_camera = |view: &'a View| {
            let world = view.frustum();
            let frustum = world.relative_to(origin);
            (view, view, world, frustum, None)
        };
        let (view, seen_by, world_frustum, frustum, casters) = match viewer {
            Viewer::Camera(view) => of_camera(view),
            #[cfg(feature = "candidates")]
            Viewer::Among(view, _) => of_camera(view),
            #[cfg(feature = "shadows")]
            Viewer::Light(shadows) => {
                let region = region(shadows, origin);
                let frustum = region.frustum().clone();
                let world = in_world(&frustum, origin);
                (shadows.drawn(), &shadows.camera, world, frustum, Some(region))
            }
        };
        let planes = Planes::new(&frustum);
        let candidates = match viewer {
            #[cfg(feature = "candidates")]
            Viewer::Among(_, candidates) => Some(candidates),
            _ => None,
        };
        Self {
            culler,
            scene,
            view,
            seen_by,
            world_frustum,
            frustum,
            planes,
            casters,
            candidates,
            jobs: &OneThread,
            only,
        }
    }

    /// The candidates, where they and the culler have `stage`.
    pub(super) fn candidates_of(&self, stage: Stage) -> Option<&'a dyn Candidates> {
        let is_on = cfg!(feature = "candidates") && self.culler.runs(stage);
        let candidates = self.candidates.filter(|_| is_on)?;
        candidates.stages().contains(&stage).then_some(candidates)
    }

    /// The cull as candidates see it.
    pub(super) fn look(&self) -> Look<'a> {
        Look { culler: self.culler, scene: self.scene, view: self.view }
    }

    /// The slot of the one instance that is culled.
    pub(super) fn only_slot(&self) -> Option<u32> {
        self.only.map(|only| only.slot)
    }

    /// The region in which casters of the light matter; `None` for a camera.
    pub(super) fn casters(&self) -> Option<&CasterRegion> {
        self.casters.as_ref().filter(|_| cfg!(feature = "shadows"))
    }

    /// Whether there is nothing to be seen at all: a light that lights nothing which its camera
    /// sees.
    pub(super) fn sees_nothing(&self) -> bool {
        self.casters().is_some_and(CasterRegion::no_receiver)
    }

    /// The number of the first plane that an instance is outside of; of a light, its
    /// [`CasterReason`] as a number.
    pub(super) fn rejection(&self, slot: u32) -> u8 {
        let plane = self.planes.first_rejecting(self.scene.boxes(), slot as usize);
        let Some(casters) = self.casters() else { return plane };
        let plane = (plane != VISIBLE).then_some(plane);
        let bounds = self.scene.boxes().get(slot as usize);
        casters.reason(&bounds, plane).map_or(VISIBLE, CasterReason::detail)
    }

    /// Planes that an instance is not proved to be inside of, a bit for the number of each: no
    /// other can reject anything of it.
    pub(super) fn straddled(&self, slot: u32) -> u32 {
        self.planes.straddled(&self.scene.bounds(slot))
    }

    /// Whether back faces are culled by whole clusters.
    pub(super) fn culls_backs_by_cluster(&self) -> bool {
        self.culler.backface == Backface::Fast
            && self.view.cull_face != CullFace::None
            && self.culler.output != Output::Instances
    }

    /// Whether back faces are culled by triangles; not of two eyes, which share whole clusters
    /// alone.
    pub(super) fn culls_backs_by_triangle(&self) -> bool {
        self.culler.backface != Backface::Off
            && self.view.cull_face != CullFace::None
            && !self.is_stereo()
    }

    /// Whether the view is of both eyes of a headset.
    pub(super) fn is_stereo(&self) -> bool {
        self.view.eyes_apart() != [0.0; 3]
    }
}

#[cfg(feature = "shadows")]
/// Where casters matter, relative to an origin: near it, where f64 is finest, whatever its
/// distance.
fn region(shadows: &ShadowView, origin: [f64; 3]) -> CasterRegion {
    let mut light = shadows.light;
    let mut margin = shadows.margin_world.max(0.0);
    if let Some(map) = &shadows.map {
        let eye = map.eye();
        light = light.seen_from(eye);
        // The eye is off by the rounding of the matrix that it is found from.
        margin += eye.iter().map(|v| v.abs()).sum::<f64>() * (64.0 * ROUNDING);
    }
    let camera = shadows.camera.frustum().relative_to(origin);
    let light = light.relative_to(origin);
    let region = CasterRegion::new(&camera, shadows.receivers.as_ref(), &light);
    let region = region.with_margin(margin);
    match &shadows.map {
        Some(map) => region.within_map(&map.frustum().relative_to(origin)),
        None => region,
    }
}

#[cfg(feature = "shadows")]
/// Planes relative to an origin, in world space, moved out by more than that rounds.
fn in_world(frustum: &Frustum, origin: [f64; 3]) -> Frustum {
    let out = |plane: &Plane| {
        let moved = plane.relative_to(origin.each(|v| -v));
        Plane { d: moved.d + moved.d.abs() * ROUNDING, ..moved }
    };
    let mut world = Frustum::from_planes(FrustumPlane::ALL.each(|p| frustum.plane(p).map(out)));
    for (_, plane) in frustum.planes().filter(|(number, _)| *number >= FrustumPlane::ALL.len()) {
        // One that is refused is one fewer to reject by.
        let _ = world.push(out(plane));
    }
    world
}
