//! The frame: everything that the stages derive from a view, derived once.

use super::{Backface, Culler, Output};
use crate::cull::frustum::batch::Planes;
use crate::scene::Scene;
use crate::view::{CullFace, Frustum, View};
use crate::visible::Visible;

/// One cull of one view, as all stages see it.
pub(super) struct Frame<'a> {
    pub(super) culler: &'a Culler,
    pub(super) scene: &'a Scene,
    pub(super) view: &'a View,
    /// In world space, and relative to the scene's origin, as its boxes are.
    pub(super) world_frustum: Frustum,
    pub(super) frustum: Frustum,
    /// Of `frustum`.
    pub(super) planes: Planes,
    /// The one instance that is culled, where an explanation is wanted.
    pub(super) only: Option<Alone<'a>>,
}

/// One instance by itself.
#[derive(Clone, Copy)]
pub(super) struct Alone<'a> {
    pub(super) slot: u32,
    /// The answer for the whole scene, by instances and with reasons: what hides one is everything else.
    pub(super) all: &'a Visible,
}

impl<'a> Frame<'a> {
    pub(super) fn new(
        culler: &'a Culler,
        scene: &'a Scene,
        view: &'a View,
        only: Option<Alone<'a>>,
    ) -> Self {
        let world_frustum = view.frustum();
        let frustum = world_frustum.relative_to(scene.origin());
        let planes = Planes::new(&frustum);
        Self { culler, scene, view, world_frustum, frustum, planes, only }
    }

    /// The slot of the one instance that is culled.
    pub(super) fn only_slot(&self) -> Option<u32> {
        self.only.map(|only| only.slot)
    }

    /// Whether back faces are culled by whole clusters.
    pub(super) fn culls_backs_by_cluster(&self) -> bool {
        matches!(self.culler.backface, Backface::Fast | Backface::Masks)
            && self.view.cull_face != CullFace::None
            && self.culler.output >= Output::Clusters
    }

    /// Whether back faces are culled by triangles.
    pub(super) fn culls_backs_by_triangle(&self) -> bool {
        self.culler.backface != Backface::Off && self.view.cull_face != CullFace::None
    }
}
