//! Occlusion: the cameras that ask for it, and what of their list lies behind others.

use bevy_camera::primitives::Frustum;
use bevy_camera::{Camera, Projection};
use bevy_ecs::prelude::*;
use bevy_transform::components::GlobalTransform;
use engine::cull::occlusion::{Occlusion, OcclusionBuffer};
use engine::{Backface, Culler, Depth, Output, View, ViewState, Visible};

use crate::mirror::CulletScene;

/// A camera that does not list what lies behind other meshes.
///
/// What hides are meshes that are opaque: with the feature `pbr` those whose `StandardMaterial` is,
/// found by themselves, and else the entities that carry [`CulletOccluder`](crate::CulletOccluder).
/// Nothing is dropped that could reach a pixel.
///
/// It does nothing for a camera whose `Frustum` is not that of its `Projection`, whose target has
/// no size yet, that carries `NoCpuCulling`, or that draws with `invert_culling`.
#[derive(Clone, Copy, Component, Debug, PartialEq)]
pub struct CulletOcclusion {
    /// Pixels across the occlusion buffer, from 1 to 4,096, never more than the camera has. More
    /// finds more, at a cost that grows by its square. Default: 640.
    pub width: u32,
    /// Budget for drawing occluders, in microseconds by a model, not a clock: from 0, which draws
    /// none. Default: 200.
    pub budget: f32,
}

impl Default for CulletOcclusion {
    fn default() -> Self {
        let Occlusion { width, budget, .. } = Occlusion::default();
        Self { width, budget }
    }
}

impl CulletOcclusion {
    /// The engine's settings: whole instances, since a list of Bevy knows no parts of one.
    pub(crate) fn culler(&self) -> Culler {
        // Without a risk: what an entity costs to draw is not known here, and its instance may have
        // one triangle.
        let occlusion =
            Occlusion::default().with_width(self.width).with_budget(self.budget).with_risk(None);
        Culler::default()
            .with_occlusion(occlusion)
            .with_pvs(false)
            .with_portal(false)
            .with_backface(Backface::Off)
            .with_degenerate(false)
            .with_output(Output::Instances)
    }
}

/// State that a camera with occlusion keeps.
#[derive(Debug, Default)]
pub(crate) struct Hidden {
    state: ViewState,
    visible: Visible,
    /// Whether the buffer of `state` is of the camera and the scene as they are.
    is_current: bool,
}

impl Hidden {
    /// Takes note that a frame is found without occlusion.
    pub(crate) fn leave(&mut self) {
        self.is_current = false;
    }

    /// Returns the buffer of what the camera draws, where it has occlusion.
    pub(crate) fn buffer(&self) -> Option<&OcclusionBuffer> {
        self.state.occlusion_buffer().filter(|_| self.is_current)
    }

    /// Takes out of `seen`, one bit a slot, what the view does not see; `is_among` where nothing but `seen`
    /// may hide.
    pub(crate) fn take_out(
        &mut self,
        settings: &CulletOcclusion,
        mirror: &CulletScene,
        view: &View,
        is_among: bool,
        seen: &mut [u64],
    ) {
        self.is_current = false;
        let (culler, scene) = (settings.culler(), &mirror.scene);
        let (state, visible) = (&mut self.state, &mut self.visible);
        if is_among {
            let candidates: &[u64] = seen;
            let among = culler.with_pvs(true);
            if among.cull_among(scene, view, &candidates, state, visible).is_err() {
                return;
            }
        } else {
            culler.cull_one(scene, view, state, visible);
        }
        self.is_current = true;
        let mut kept = vec![0u64; seen.len()];
        for slot in self.visible.slots() {
            kept[slot as usize / 64] |= 1 << (slot % 64);
        }
        let exempt = mirror.scene.exempt();
        for (word, seen) in seen.iter_mut().enumerate() {
            *seen &= kept[word] | exempt.get(word).copied().unwrap_or(0);
        }
    }
}

/// The view that a camera draws; `None` where nothing can be told to be hidden in it.
pub(crate) fn view(
    camera: &Camera,
    projection: Option<&Projection>,
    at: &GlobalTransform,
    frustum: &Frustum,
    layers: u32,
) -> Option<View> {
    let size = camera.physical_viewport_size()?;
    let own = projection?.compute_frustum(at);
    let is_own =
        own.half_spaces.iter().zip(&frustum.half_spaces).all(|(a, b)| a.normal_d() == b.normal_d());
    if !is_own || camera.invert_culling {
        return None;
    }
    let clip_from_world = camera.clip_from_view().as_dmat4() * at.to_matrix().as_dmat4().inverse();
    let mut matrix = clip_from_world.to_cols_array();
    // A pixel more on each side: `TemporalJitter` moves the picture by up to half of one.
    for (row, size) in size.to_array().into_iter().enumerate() {
        let scale = f64::from(size) / (f64::from(size) + 2.0);
        matrix.iter_mut().skip(row).step_by(4).for_each(|v| *v *= scale);
    }
    let size = size + 2;
    // A matrix that shows no volume hides nothing.
    Some(View::from_matrix(matrix, Depth::Reversed, size.to_array()).ok()?.with_layers(layers))
}
