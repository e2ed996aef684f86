//! Receivers: what light and shadows can fall on, which is all that some camera draws.
//!
//! A receiver is known by its `Aabb`, as it is to Bevy. Where there may be others, receivers are
//! taken to stand anywhere in the camera's frustum, or in the world: of a camera whose list somebody
//! else wrote, that draws what the GPU culls or what has no bounds that can be relied on, that lights
//! its picture afterwards (`DeferredPrepass`), or that lists classes which are not known here.

use bevy_camera::primitives::Frustum;
use bevy_camera::visibility::{NoCpuCulling, RenderLayers};
use bevy_camera::{Camera, Camera2d, Projection};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use bevy_mesh::Mesh3d;
use bevy_transform::components::GlobalTransform;
use engine::bounds::Aabb as Bounds;
use engine::cull::occlusion::{OcclusionBuffer, Visibility};
use engine::view::Frustum as Region;

use crate::mirror::CulletScene;
use crate::occlusion::view as view_of;
use crate::seen::mask;
use crate::view::CulletView;

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

/// A camera, and what it draws of that on which light may fall.
#[derive(Debug)]
pub(crate) struct Eye<'a> {
    pub(crate) entity: Entity,
    /// One bit a slot.
    pub(crate) seen: &'a [u64],
    /// Receivers are in here.
    pub(crate) region: Region,
    /// Receivers are those of `seen`; else they are anywhere in `region`.
    pub(crate) is_known: bool,
    /// Occlusion buffer of its frame, which may hide a part of a receiver.
    buffer: Option<&'a OcclusionBuffer>,
    key: Key,
}

impl Eye<'_> {
    /// Whether the eye sees nothing of a box.
    pub(crate) fn is_hidden(&self, part: &Bounds, halvings: u32) -> bool {
        self.buffer.is_some_and(|buffer| is_hidden(buffer, part, halvings))
    }
}

/// How often a box is halved whose nearest corner and screen rectangle do not show that it is hidden, where a shadow
/// map depends on it. Large receivers, such as floors, seldom are as a whole; few leaves are tested where one is seen.
pub(crate) const HALVINGS: u32 = 6;

fn is_hidden(buffer: &OcclusionBuffer, part: &Bounds, halvings: u32) -> bool {
    if buffer.test_box(part) != Visibility::Visible {
        return true;
    }
    if halvings == 0 || !part.is_finite() {
        return false;
    }
    let size: [f32; 3] = std::array::from_fn(|axis| part.max[axis] - part.min[axis]);
    let axis = (0..3).max_by(|&a, &b| size[a].total_cmp(&size[b])).unwrap_or(0);
    let middle = part.min[axis] + size[axis] * 0.5;
    let (mut low, mut high) = (*part, *part);
    (low.max[axis], high.min[axis]) = (middle, middle);
    is_hidden(buffer, &low, halvings - 1) && is_hidden(buffer, &high, halvings - 1)
}

/// Inputs that an eye follows from.
#[derive(Clone, Debug, PartialEq)]
struct Key {
    entity: Entity,
    version: u64,
    is_known: bool,
    clip_from_world: Option<[f64; 16]>,
}

/// The eyes of the last frame.
#[derive(Debug, Default, Resource)]
pub(crate) struct Receivers {
    last: Vec<Key>,
    /// Rises with each frame in which one may see something else.
    pub(crate) step: u64,
}

impl Receivers {
    pub(crate) fn follow(&mut self, eyes: &[Eye<'_>]) {
        if !self.last.iter().eq(eyes.iter().map(|eye| &eye.key)) {
            self.last = eyes.iter().map(|eye| eye.key.clone()).collect();
            self.step += 1;
        }
    }
}

/// A `StandardMaterial` asks for light beside the surface: see [`transmits`](crate::pbr::transmits).
#[derive(Debug, Default, Resource)]
pub(crate) struct Transmits(pub(crate) bool);

/// The cameras, and what tells whether their lists are all that receives light.
#[derive(SystemParam)]
pub(crate) struct Eyes<'w, 's> {
    views: Query<
        'w,
        's,
        (
            Entity,
            &'static CulletView,
            &'static Frustum,
            &'static Camera,
            Option<&'static Projection>,
            Option<&'static GlobalTransform>,
            Option<&'static RenderLayers>,
            Has<NoCpuCulling>,
        ),
        Without<Camera2d>,
    >,
    settings: Res<'w, CulletLights>,
    transmits: Res<'w, Transmits>,
    off_cpu: Query<'w, 's, (), (With<Mesh3d>, With<NoCpuCulling>)>,
    #[cfg(feature = "pbr")]
    deferred: Query<'w, 's, (), With<bevy_core_pipeline::prepass::DeferredPrepass>>,
}

impl Eyes<'_, '_> {
    /// Whether anything may be left out for want of receivers.
    pub(crate) fn restrict(&self) -> bool {
        self.settings.receivers && !self.transmits.0
    }

    /// The active cameras.
    pub(crate) fn gather(&self, mirror: &CulletScene) -> Vec<Eye<'_>> {
        let off_cpu = !self.off_cpu.is_empty();
        let exempt = mirror.scene.exempt();
        let mut eyes = Vec::new();
        for (entity, state, frustum, camera, projection, at, layers, is_exempt) in &self.views {
            if !camera.is_active {
                continue;
            }
            #[cfg(feature = "pbr")]
            let is_deferred = self.deferred.contains(entity);
            #[cfg(not(feature = "pbr"))]
            let is_deferred = false;
            let seen = &state.listed.seen[..];
            // A pixel more on each side, for jitter; without a view of its own the frustum may show
            // anything.
            let layers = mask(layers.unwrap_or_default());
            let view = at.and_then(|at| view_of(camera, projection, at, frustum, layers));
            let view = view.filter(|_| !is_exempt && !is_deferred);
            let has_exempt = || seen.iter().zip(exempt).any(|(seen, exempt)| seen & exempt != 0);
            let is_known = !is_exempt
                && !is_deferred
                && !off_cpu
                && !state.is_foreign
                && !state.has_unknown
                && !has_exempt();
            let key = Key {
                entity,
                version: state.version,
                is_known,
                clip_from_world: view.as_ref().map(|view| view.clip_from_world()),
            };
            let region = view.map_or_else(Region::everything, |view| view.frustum());
            let buffer = state.hidden.buffer();
            eyes.push(Eye { entity, seen, region, is_known, buffer, key });
        }
        eyes
    }
}
