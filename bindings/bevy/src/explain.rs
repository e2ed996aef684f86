//! Why an entity is drawn or not.

use std::fmt;

use bevy_camera::primitives::Frustum;
use bevy_camera::visibility::{
    InheritedVisibility, NoCpuCulling, RenderLayers, VisibleEntityRanges,
};
use bevy_camera::{Camera, Projection};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use bevy_mesh::Mesh3d;
use bevy_transform::components::GlobalTransform;
use engine::explain::Explanation;
use engine::{CullError, Handle, Stage, View};

use crate::candidates::CulletCandidates;
use crate::mirror::CulletScene;
use crate::occlusion::{CulletOcclusion, view as view_of};
use crate::seen::{OfMesh, Seen, mask};
use crate::view::{half_spaces, is_outside};

/// Names of the half-spaces of a `Frustum`, in Bevy's order.
const HALF_SPACES: [&str; 5] = ["left", "right", "top", "bottom", "near"];

/// Why a camera draws an entity, or not: the first stage that drops it, in the order of
/// [`CulletFunnel`](crate::CulletFunnel).
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum CulletReason {
    /// It is drawn.
    Visible,
    /// The camera does not exist, or is not active.
    NoCamera,
    /// There is no such entity, or it has no `Mesh3d`: the plugin does not decide.
    NoMesh,
    /// It or the camera carries `NoCpuCulling`: it is decided on the GPU, if at all.
    NoCpuCulling,
    /// Its `Visibility`, or that of its parents, hides it.
    Hidden,
    /// It shares no layer with the camera.
    Layer,
    /// The camera's [`CulletCandidates`] leave it out.
    LeftOut,
    /// It is outside of its `VisibilityRange`.
    Range,
    /// It is outside of this half-space of the camera's `Frustum`.
    Frustum(&'static str),
    /// It lies behind these, the nearest first.
    Occluded(Vec<Entity>),
}

impl fmt::Display for CulletReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Visible => write!(f, "visible"),
            Self::NoCamera => write!(f, "not decided: no active camera"),
            Self::NoMesh => write!(f, "not decided: it has no Mesh3d"),
            Self::NoCpuCulling => write!(f, "not decided here: NoCpuCulling"),
            Self::Hidden => write!(f, "hidden by its Visibility or that of a parent"),
            Self::Layer => write!(f, "on none of the camera's layers"),
            Self::LeftOut => write!(f, "left out by the camera's CulletCandidates"),
            Self::Range => write!(f, "outside of its VisibilityRange"),
            Self::Frustum(plane) => write!(f, "outside of the frustum's {plane} half-space"),
            Self::Occluded(by) => {
                write!(f, "behind ")?;
                for (at, entity) in by.iter().enumerate() {
                    write!(f, "{}{entity}", if at == 0 { "" } else { ", " })?;
                }
                if by.is_empty() { write!(f, "others") } else { Ok(()) }
            }
        }
    }
}

/// Tells why an entity is drawn or not, as things stand now: a system parameter.
///
/// ```
/// use bevy_cullet::CulletExplain;
/// use bevy_ecs::prelude::*;
///
/// fn tell(cameras: Query<Entity, With<bevy_camera::Camera>>, explain: CulletExplain, picked: Res<Picked>) {
///     for camera in &cameras {
///         println!("{}: {}", picked.0, explain.why(camera, picked.0));
///     }
/// }
/// # #[derive(Resource)]
/// # struct Picked(Entity);
/// ```
#[derive(SystemParam)]
pub struct CulletExplain<'w, 's> {
    mirror: Res<'w, CulletScene>,
    ranges: Option<Res<'w, VisibleEntityRanges>>,
    cameras: Query<
        'w,
        's,
        (
            &'static Camera,
            &'static Frustum,
            &'static GlobalTransform,
            Option<&'static Projection>,
            Option<&'static RenderLayers>,
            Option<&'static CulletOcclusion>,
            Option<&'static CulletCandidates>,
            Has<NoCpuCulling>,
        ),
    >,
    all: Query<'w, 's, Seen, OfMesh>,
    off_cpu: Query<'w, 's, &'static InheritedVisibility, (With<Mesh3d>, With<NoCpuCulling>)>,
}

impl fmt::Debug for CulletExplain<'_, '_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("CulletExplain").finish_non_exhaustive()
    }
}

impl CulletExplain<'_, '_> {
    /// Why `camera` draws `entity`, or not. Its cost is that of a whole cull where the camera has
    /// occlusion.
    #[must_use]
    pub fn why(&self, camera: Entity, entity: Entity) -> CulletReason {
        let Ok((of, frustum, at, projection, layers, occlusion, candidates, is_exempt)) =
            self.cameras.get(camera)
        else {
            return CulletReason::NoCamera;
        };
        if !of.is_active {
            return CulletReason::NoCamera;
        }
        let Ok(seen) = self.all.get(entity) else {
            let is_off = self.off_cpu.contains(entity);
            return if is_off { CulletReason::NoCpuCulling } else { CulletReason::NoMesh };
        };
        let layers = layers.unwrap_or_default();
        if !seen.inherited.get() {
            return CulletReason::Hidden;
        }
        if !layers.intersects(seen.layers.unwrap_or_default()) {
            return CulletReason::Layer;
        }
        let is_tested = !is_exempt && !seen.no_frustum_culling;
        if let Some(aabb) = seen.aabb.filter(|_| is_tested) {
            let nothing = [0.0; 4];
            for (number, name) in HALF_SPACES.iter().enumerate() {
                let mut one = [nothing; 5];
                one[number] = half_spaces(frustum)[number];
                if is_outside(&one, aabb, &seen.transform.affine()) {
                    return CulletReason::Frustum(name);
                }
            }
        }
        if candidates.is_some_and(|candidates| candidates.is_left_out(entity)) {
            return CulletReason::LeftOut;
        }
        let ranges = self.ranges.as_deref().filter(|_| seen.ranged);
        if ranges.is_some_and(|ranges| !ranges.entity_is_in_range_of_view(entity, camera)) {
            return CulletReason::Range;
        }
        if !is_tested {
            return CulletReason::Visible;
        }
        let view =
            occlusion.and_then(|o| Some((o, view_of(of, projection, at, frustum, mask(layers))?)));
        let (Some((occlusion, view)), Some(handle)) = (view, self.mirror.handle(entity)) else {
            return CulletReason::Visible;
        };
        let explained = match candidates {
            None => occlusion.culler().explain(&self.mirror.scene, &view, handle),
            Some(candidates) => self.explain_among(*occlusion, &view, candidates, handle),
        };
        match explained {
            Ok(explanation) if explanation.reason.is_some_and(|r| r.stage == Stage::Occlusion) => {
                let by = explanation.hidden_by.iter().filter_map(|&slot| self.mirror.entity(slot));
                CulletReason::Occluded(by.collect())
            }
            _ => CulletReason::Visible,
        }
    }

    /// Explains an entity's instance where only candidates hide.
    fn explain_among(
        &self,
        occlusion: CulletOcclusion,
        view: &View,
        candidates: &CulletCandidates,
        handle: Handle,
    ) -> Result<Explanation, CullError> {
        let scene = &self.mirror.scene;
        let mut words = scene.hierarchy().present().to_vec();
        let mut culler = occlusion.culler().with_pvs(true);
        if candidates.take_out(&self.mirror, &mut words) {
            culler = culler.with_occlusion(None);
        }
        Ok(culler.explain_among(scene, view, &words, &[handle])?.remove(0))
    }
}
